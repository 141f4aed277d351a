//! The sweep in words. Every figure is a cell of the table, so nothing is said that the CSV does not have.

use super::axis::{self, AS_ASKED, Judge};
use super::sweep::{Row, Sweep};
use super::table::Table;
use crate::settings::text_at;

/// A piece of a sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Words.
    Text(String),
    /// A cell of the table, as it stands there.
    Figure(String),
}

/// A paragraph.
pub type Paragraph = Vec<Piece>;

/// Puts a sentence together: text with `{column}` where a cell belongs. `None` if one of the cells is empty.
fn sentence(table: &Table, row: usize, pattern: &str) -> Option<Paragraph> {
    let mut pieces = Vec::new();
    let mut rest = pattern;
    while let Some((text, after)) = rest.split_once('{') {
        let (column, after) = after.split_once('}')?;
        let cell = table.cell(row, column);
        if cell.is_empty() {
            return None;
        }
        pieces.push(Piece::Text(text.to_owned()));
        pieces.push(Piece::Figure(cell.to_owned()));
        rest = after;
    }
    pieces.push(Piece::Text(rest.to_owned()));
    Some(pieces)
}

/// The values of k that are measured, ascending.
fn k_values() -> &'static [&'static str] {
    axis::all().into_iter().find(|a| a.name == "k").map_or(&[], |a| a.values)
}

struct Words<'a> {
    sweep: &'a Sweep,
    table: &'a Table,
    paragraphs: Vec<Paragraph>,
}

impl Words<'_> {
    /// Adds the sentences whose figures are all there as a paragraph.
    fn paragraph(&mut self, sentences: &[Option<Paragraph>]) {
        let mut all = Paragraph::new();
        for sentence in sentences.iter().flatten() {
            if !all.is_empty() {
                all.push(Piece::Text(" ".to_owned()));
            }
            all.extend(sentence.iter().cloned());
        }
        if !all.is_empty() {
            self.paragraphs.push(all);
        }
    }

    fn say(&self, row: usize, pattern: &str) -> Option<Paragraph> {
        sentence(self.table, row, pattern)
    }

    /// The row with this short name.
    fn row(&self, short: &str) -> Option<usize> {
        self.sweep.rows.iter().position(|r| r.configuration.short == short && r.outcome.is_ok())
    }

    /// Whether there are frames enough for an interval.
    fn sure(&self, row: usize) -> bool {
        !self.table.cell(row, "relative_low").is_empty()
    }

    /// The row with the same settings but for the row's own axis, if that is not what was asked for.
    fn without(&self, row: usize) -> Option<usize> {
        let configuration = &self.sweep.rows[row].configuration;
        let asked = &self.sweep.rows.first()?.configuration.settings;
        let axis = axis::all().into_iter().find(|a| a.name == configuration.axis)?;
        let path = axis.path()?;
        let mut settings = configuration.settings.clone();
        settings.set(path, &text_at(asked, path)?).ok()?;
        let same = |r: &Row| r.configuration.judge == Judge::Exact && r.configuration.settings == settings;
        let found = self.sweep.rows.iter().position(|r| same(r) && r.outcome.is_ok())?;
        (found != 0 && found != row).then_some(found)
    }

    fn number(&self, row: usize, column: &str) -> f64 {
        self.table.number(row, column).unwrap_or(0.0)
    }

    /// How far a row is from its reference, after what names it.
    fn wrong(&self, row: usize, subject: &str) -> Option<Paragraph> {
        if self.number(row, "maximum_steps") == 0.0 {
            return Some(vec![Piece::Text(format!("{subject} gives the reference's picture exactly."))]);
        }
        let pattern = format!(
            "{subject} is {{mean_steps}} 8-bit steps off on average and {{maximum_steps}} at most; {{over_1_step_percent}} % of \
             the pixels are visibly wrong, FLIP is {{flip_mean}}."
        );
        self.say(row, &pattern)
    }

    fn time(&self, row: usize) -> Option<Paragraph> {
        let interval =
            if self.sure(row) { " ({relative_low} to {relative_high})" } else { " (too few frames for an interval)" };
        self.say(row, &format!("It takes {{relative_time}}× the time of what was asked for{interval}."))
    }

    fn baseline(&mut self) {
        let Some(row) = self.row(AS_ASKED) else { return };
        let interval = if self.sure(row) { " ({time_low_ms} to {time_high_ms})" } else { "" };
        let sentences = [
            self.say(row, &format!("What was asked for takes {{time_ms}} ms a frame here{interval}.")),
            self.wrong(row, "It"),
            self.say(row, "Its view has {layers} layers."),
        ];
        self.paragraph(&sentences);
    }

    /// The paper's key against the wide one, at the largest k that both were measured with.
    fn keys(&mut self) {
        let largest = k_values()
            .iter()
            .rev()
            .find_map(|k| Some((k, self.row(&format!("key=packed32, k={k}"))?, self.wide_row(k)?)));
        let Some((k, packed, wide)) = largest else { return };
        let timed = [packed, wide].map(|row| !self.table.cell(row, "relative_time").is_empty());
        let kept = if self.number(wide, "lost") + self.number(wide, "merged") == 0.0 {
            "loses none"
        } else {
            "merges none and drops {lost_percent} %"
        };
        let lost = format!(
            "With k={k}, the paper's packed32 key merges {{merged_percent}} % of this view's layers, drops {{lost_percent}} % \
             behind full pixels and puts {{out_of_order_percent}} % out of order."
        );
        let mut sentences = vec![self.say(packed, &lost)];
        if timed == [true; 2] {
            sentences.push(self.say(packed, "It takes {relative_time}× the time of what was asked for;"));
            sentences.push(self.say(wide, &format!("the wide key takes {{relative_time}}× and {kept}.")));
        } else {
            sentences.push(self.say(wide, &format!("The wide key {kept}.")));
        }
        self.paragraph(&sentences);
    }

    /// Ends a sentence with the time, if there is one.
    fn in_time(&self, row: usize) -> &'static str {
        let timed = !self.table.cell(row, "relative_time").is_empty();
        if timed { ", in {relative_time}× the time" } else { "" }
    }

    fn wide_row(&self, k: &str) -> Option<usize> {
        [format!("k={k}"), format!("key=wide64, k={k}")].iter().find_map(|n| self.row(n))
    }

    /// What each k keeps.
    fn layers_kept(&mut self) {
        let mut sentences: Vec<Option<Paragraph>> = Vec::new();
        for k in k_values() {
            let Some(row) = self.wide_row(k) else { continue };
            let time = self.in_time(row);
            let pattern = if self.number(row, "lost") == 0.0 {
                format!("With wide keys, k={k} keeps every layer{time}.")
            } else {
                format!(
                    "With wide keys, k={k} drops {{lost_percent}} % of the layers, which makes {{over_1_step_percent}} % of the pixels visibly \
                     wrong{time}."
                )
            };
            sentences.push(self.say(row, &pattern));
        }
        self.paragraph(&sentences);
    }

    /// A paragraph for each other axis.
    fn axes(&mut self) {
        let mut seen: Vec<&str> = vec!["", "k", "key", "key × k"];
        for first in &self.sweep.rows {
            let axis = first.configuration.axis.as_str();
            if seen.contains(&axis) || first.configuration.judge == Judge::Supersampled {
                continue;
            }
            seen.push(axis);
            let rows =
                self.sweep.rows.iter().enumerate().filter(|(_, r)| r.configuration.axis == axis && r.outcome.is_ok());
            let rows: Vec<usize> = rows.map(|(i, _)| i).collect();
            let mut sentences = Vec::new();
            for row in rows {
                let name = &self.sweep.rows[row].configuration.name;
                sentences.push(self.wrong(row, name));
                // What an axis needs to matter has errors of its own.
                if let Some(without) = self.without(row) {
                    let other = &self.sweep.rows[without].configuration.name;
                    sentences.push(
                        self.say(without, &format!("Of that, {{mean_steps}} on average are those of '{other}'.")),
                    );
                }
                sentences.push(self.time(row));
                if self.number(row, "neighbours_different_percent") > 0.0 {
                    sentences.push(self.say(row, "{neighbours_different_percent} % of the links lead elsewhere."));
                }
            }
            self.paragraph(&sentences);
        }
    }

    fn sampling(&mut self) {
        let rows: Vec<usize> = (0..self.sweep.rows.len())
            .filter(|&i| {
                let row = &self.sweep.rows[i];
                row.configuration.judge == Judge::Supersampled && row.outcome.is_ok()
            })
            .collect();
        let mut sentences = vec![(!rows.is_empty()).then(|| {
            vec![Piece::Text("Against the supersampled reference, where aliasing counts as an error:".to_owned())]
        })];
        for row in rows {
            let name = &self.sweep.rows[row].configuration.short;
            let pattern =
                format!("{name} is {{mean_steps}} steps off on average, FLIP {{flip_mean}}{}.", self.in_time(row));
            sentences.push(self.say(row, &pattern));
        }
        self.paragraph(&sentences);
    }

    /// The fastest configuration whose error nobody sees, if it is faster beyond doubt.
    fn advice(&mut self) {
        let invisible = |i: &usize| {
            let row = &self.sweep.rows[*i];
            row.configuration.judge == Judge::Exact
                && row.outcome.is_ok()
                && self.table.number(*i, "over_1_step_percent") == Some(0.0)
        };
        let surely_faster = |i: &usize| self.table.number(*i, "relative_high").is_some_and(|h| h < 1.0);
        let rows: Vec<usize> = (0..self.sweep.rows.len()).filter(invisible).collect();
        let time = |i: &usize| self.number(*i, "relative_time");
        let fastest = rows.iter().copied().filter(surely_faster).min_by(|a, b| time(a).total_cmp(&time(b)));
        let paragraph = match fastest {
            Some(row) => {
                let name = &self.sweep.rows[row].configuration.name;
                let pattern = format!(
                    "Of the pictures without a visibly wrong pixel the fastest is '{name}', {{relative_time}}× the time of what \
                     was asked for ({{relative_low}} to {{relative_high}})."
                );
                self.say(row, &pattern)
            }
            None => rows.first().filter(|i| self.sweep.rows[**i].outcome.as_ref().is_ok_and(|m| m.times.is_some())).map(|_| {
                let text = "No picture without a visibly wrong pixel was found to be faster than what was asked for beyond doubt.";
                vec![Piece::Text(text.to_owned())]
            }),
        };
        self.paragraph(&[paragraph]);
    }

    fn failures(&mut self) {
        for row in &self.sweep.rows {
            if let Err(reason) = &row.outcome {
                let text = format!("'{}' has no figures: {reason}.", row.configuration.name);
                self.paragraphs.push(vec![Piece::Text(text)]);
            }
        }
    }
}

/// The sweep in words.
pub fn paragraphs(sweep: &Sweep, table: &Table) -> Vec<Paragraph> {
    let mut words = Words { sweep, table, paragraphs: Vec::new() };
    words.baseline();
    words.keys();
    words.layers_kept();
    words.axes();
    words.sampling();
    words.advice();
    words.failures();
    words.paragraphs
}
