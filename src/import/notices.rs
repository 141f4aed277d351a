//! Collects what a user should know. What happens to many objects alike is counted and told once.

use std::collections::{BTreeMap, HashSet};

use crate::scene::{Notice, NoticeKind};

/// More single notices than this are only counted: a bad file must not bury its reader.
const MOST: usize = 200;

/// Notices in the making.
#[derive(Debug, Default)]
pub(super) struct Notices {
    single: Vec<Notice>,
    seen: HashSet<(NoticeKind, String)>,
    left_out: u64,
    /// Per kind and sentence: how many, in how many places, the first place.
    counted: BTreeMap<(NoticeKind, &'static str), (u64, u64, String)>,
}

impl Notices {
    pub(super) fn push(&mut self, kind: NoticeKind, message: String) {
        let message = message.replace(|c: char| c.is_control(), " ");
        if self.single.len() >= MOST {
            self.left_out += 1;
        } else if self.seen.insert((kind, message.clone())) {
            self.single.push(Notice { kind, message });
        }
    }

    pub(super) fn ignored(&mut self, message: String) {
        self.push(NoticeKind::Ignored, message);
    }

    pub(super) fn approximated(&mut self, message: String) {
        self.push(NoticeKind::Approximated, message);
    }

    pub(super) fn computed(&mut self, message: String) {
        self.push(NoticeKind::Computed, message);
    }

    pub(super) fn repaired(&mut self, message: String) {
        self.push(NoticeKind::Repaired, message);
    }

    /// `count` things at `place` to which `what` happened; `what` goes after the number ("… triangles were dropped").
    pub(super) fn count(&mut self, kind: NoticeKind, what: &'static str, count: u64, place: &str) {
        if count > 0 {
            let entry = self.counted.entry((kind, what)).or_insert_with(|| (0, 0, place.to_owned()));
            entry.0 += count;
            entry.1 += 1;
        }
    }

    /// Takes over what was collected elsewhere.
    pub(super) fn append(&mut self, other: Notices) {
        for notice in other.single {
            self.push(notice.kind, notice.message);
        }
        self.left_out += other.left_out;
        for (key, (count, places, first)) in other.counted {
            let entry = self.counted.entry(key).or_insert_with(|| (0, 0, first));
            entry.0 += count;
            entry.1 += places;
        }
    }

    /// All notices: single ones in order of appearance, then the counted ones.
    pub(super) fn into_vec(self) -> Vec<Notice> {
        let mut all = self.single;
        for ((kind, what), (count, places, first)) in self.counted {
            let places = if places > 1 { format!("{places} places, the first {first}") } else { first };
            all.push(Notice { kind, message: format!("{count} {what} ({places})") });
        }
        if self.left_out > 0 {
            all.push(Notice { kind: NoticeKind::Ignored, message: format!("{} more notices", self.left_out) });
        }
        all
    }
}
