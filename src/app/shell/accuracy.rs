//! The threads behind the accuracy panel: told what to do after every order, listened to with everybody else.

use super::Shell;
use crate::app::accuracy::Wanted;
use crate::app::accuracy::measuring::{Found, Measuring, Task};
use crate::app::accuracy::reference::{Job, References};
use crate::app::workspace::Gravity;

/// Started when they are first wanted.
#[derive(Default)]
pub(super) struct Threads {
    references: Option<References>,
    measuring: Option<Measuring>,
}

impl Threads {
    /// Calls off what is measured.
    pub(super) fn stop(&self) {
        if let Some(measuring) = &self.measuring {
            measuring.stop();
        }
    }
}

impl Shell {
    /// Begins to measure, unless something is measured.
    pub(super) fn measure(&mut self, wanted: Wanted) {
        if self.accuracy.measuring.is_some() {
            return;
        }
        if let Some(task) = Task::of(&self.workspace, wanted) {
            if !self.workspace.shaders.is_empty() {
                let text = "Shaders have been edited: what is measured are the program's own.";
                self.workspace.say(Gravity::Notice, text);
            }
            let measuring = Measuring::begin(task, self.waker());
            self.workspace.accuracy.underway = Some(measuring.underway());
            if wanted == Wanted::Sweep {
                self.workspace.accuracy.swept = Some(measuring.empty());
            }
            self.accuracy.measuring = Some(measuring);
            self.follow_accuracy();
        }
    }

    /// Asks for the reference of an exact picture, gives up that of another, and lets measurements go on when the window rests.
    pub(super) fn follow_accuracy(&mut self) {
        let workspace = &mut self.workspace;
        if workspace.accuracy.drawing.is_some_and(|number| number != workspace.order) {
            workspace.accuracy.drawing = None;
            if let Some(references) = &self.accuracy.references {
                references.clear();
            }
        }
        if workspace.wants_reference()
            && workspace.accuracy.drawing.is_none()
            && let Some(job) = Job::of(workspace)
        {
            workspace.accuracy.drawing = Some(job.number);
            let waker = self.waker();
            self.accuracy.references.get_or_insert_with(|| References::start(waker)).post(job);
        }
        if let Some(measuring) = &self.accuracy.measuring {
            measuring.let_pass(self.workspace.is_at_rest());
        }
    }

    /// Takes what these threads have found; says whether anything is to be shown.
    pub(super) fn collect_accuracy(&mut self) -> bool {
        let mut changed = false;
        for outcome in self.accuracy.references.as_ref().map(References::take).unwrap_or_default() {
            self.workspace.take_referenced(outcome);
            changed = true;
        }
        let Some(measuring) = &self.accuracy.measuring else {
            return changed;
        };
        let accuracy = &mut self.workspace.accuracy;
        let rows = measuring.rows();
        if let Some(swept) = accuracy.swept.as_mut().filter(|_| measuring.task.wanted == Wanted::Sweep) {
            changed |= !rows.is_empty();
            swept.entries.extend(rows.into_iter().map(Into::into));
        }
        let underway = Some(measuring.underway());
        changed |= accuracy.underway != underway;
        accuracy.underway = underway;
        let Some(result) = measuring.take() else {
            return changed;
        };
        let task = measuring.task.clone();
        self.accuracy.measuring = None;
        self.workspace.accuracy.underway = None;
        match result {
            Ok(Found::Sweep(rows, seconds)) => {
                if let Some(swept) = &mut self.workspace.accuracy.swept {
                    swept.entries = rows.into_iter().map(Into::into).collect();
                }
                tracing::debug!("swept in {seconds:.1} s");
            }
            Ok(Found::Chosen(chosen)) => self.workspace.take_chosen(*chosen, task.scene_number, task.seen.clone()),
            Ok(Found::CalledOff) => {}
            Err(reason) => self.workspace.say(Gravity::Error, format!("Nothing could be measured: {reason}")),
        }
        true
    }
}
