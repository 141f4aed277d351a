//! The sweep as a table of text: the one source of every figure in the CSV, the page, its diagrams and its words.
//!
//! Figures have three significant digits, as many as anyone reads; the JSON has them whole.

use super::axis::Judge;
use super::statistics::{ENOUGH, Estimate};
use super::sweep::{Measured, Row, Sweep};
use crate::plan::Pass;

/// The columns before those of the passes, with what is in them.
pub const COLUMNS: &[(&str, &str)] = &[
    ("configuration", "what differs from what was asked for"),
    ("axis", "the axis that is varied"),
    ("reference", "exact: the same samples; supersampled: many samples a pixel"),
    ("status", "measured, or why not"),
    ("time_ms", "median wall time of a frame"),
    ("time_low_ms", "lower end of its 95 % interval; empty for fewer than six frames"),
    ("time_high_ms", "upper end"),
    ("frames", "frames timed"),
    ("relative_time", "median of the time over that of what was asked for, drawn in turn"),
    ("relative_low", "lower end of its 95 % interval; empty for fewer than six frames"),
    ("relative_high", "upper end"),
    ("maximum_steps", "largest error of a channel, 8-bit steps"),
    ("mean_steps", "mean error of all channels, 8-bit steps"),
    ("over_1_step_percent", "pixels more than one step off"),
    ("over_8_steps_percent", "pixels more than eight steps off"),
    ("flip_mean", "FLIP, mean"),
    ("flip_p99", "FLIP, 99th percentile"),
    ("layers", "layers of the reference"),
    ("lost", "layers left out behind full pixels"),
    ("merged", "layers that became one with another"),
    ("out_of_order", "layers in the wrong place"),
    ("extra", "layers that the reference does not have"),
    ("lost_percent", "lost, of all layers"),
    ("merged_percent", "merged, of all layers"),
    ("out_of_order_percent", "out of order, of all layers"),
    ("neighbours_different_percent", "links that lead elsewhere"),
    ("kappa_p95", "error of curvature, 95th percentile"),
    ("opacity_p95", "error of opacity, 95th percentile"),
    ("counted_stored", "layers stored, as the GPU counted"),
    ("counted_merged", "fragments merged, as the GPU counted"),
    ("counted_dropped", "fragments dropped, as the GPU counted"),
    ("buffer_mib", "buffers of the frame, MiB"),
];

/// A figure with three significant digits, without trailing zeros.
pub fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { String::new() };
    }
    let digits_before = value.abs().log10().floor() as i32;
    if digits_before < -5 {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", usize::try_from(2 - digits_before).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Cells by row and column; empty where there is nothing.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The table of a sweep.
    pub fn of(sweep: &Sweep) -> Table {
        let ran: Vec<Pass> =
            Pass::ALL.into_iter().filter(|pass| sweep.rows.iter().any(|row| pass_time(row, *pass).is_some())).collect();
        let columns = COLUMNS
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .chain(ran.iter().map(|p| format!("pass_{}_ms", p.name().replace(' ', "_"))))
            .collect();
        let rows = sweep.rows.iter().map(|row| cells(row, &ran)).collect();
        Table { columns, rows }
    }

    /// A cell by row and name of its column; empty if there is none.
    pub fn cell(&self, row: usize, column: &str) -> &str {
        let at = self.columns.iter().position(|c| c == column);
        at.and_then(|at| self.rows.get(row)?.get(at)).map_or("", String::as_str)
    }

    /// A cell as a number.
    pub fn number(&self, row: usize, column: &str) -> Option<f64> {
        self.cell(row, column).parse().ok()
    }

    /// Comma-separated values with a line of names, as RFC 4180 has it.
    pub fn csv(&self) -> String {
        let quoted = |cell: &String| {
            if cell.contains([',', '"', '\n', '\r']) {
                format!("\"{}\"", cell.replace('"', "\"\""))
            } else {
                cell.clone()
            }
        };
        let line = |cells: &Vec<String>| cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\r\n";
        std::iter::once(&self.columns).chain(&self.rows).map(line).collect()
    }
}

fn pass_time(row: &Row, pass: Pass) -> Option<f64> {
    let times = row.outcome.as_ref().ok()?.times.as_ref()?;
    times.passes.iter().find(|t| t.pass == pass).map(|t| t.milliseconds)
}

fn cells(row: &Row, passes: &[Pass]) -> Vec<String> {
    let reference = match row.configuration.judge {
        Judge::Exact => "exact",
        Judge::Supersampled => "supersampled",
    };
    let status = match &row.outcome {
        Ok(Measured { times: Some(_), .. }) => "measured".to_owned(),
        Ok(_) => "errors measured, times not".to_owned(),
        Err(reason) => reason.clone(),
    };
    let mut cells = vec![row.configuration.name.clone(), row.configuration.axis.clone(), reference.to_owned(), status];
    if let Ok(measured) = &row.outcome {
        cells.extend(figures(measured));
        cells.extend(passes.iter().map(|p| pass_time(row, *p).map(figure).unwrap_or_default()));
    }
    cells.resize(COLUMNS.len() + passes.len(), String::new());
    cells
}

fn figures(measured: &Measured) -> Vec<String> {
    let optional = |value: Option<f64>| value.map(figure).unwrap_or_default();
    let times = measured.times.as_ref();
    let [whole, ratio] = [times.and_then(|t| t.whole), times.and_then(|t| t.ratio)];
    let e = &measured.image;
    // An interval of few frames is none.
    let end =
        |estimate: Option<Estimate>, of: fn(Estimate) -> f64| optional(estimate.filter(|e| e.count >= ENOUGH).map(of));
    let mut out = vec![
        optional(whole.map(|w| w.median)),
        end(whole, |w| w.low),
        end(whole, |w| w.high),
        whole.map(|w| w.count.to_string()).unwrap_or_default(),
        optional(ratio.map(|r| r.median)),
        end(ratio, |r| r.low),
        end(ratio, |r| r.high),
    ];
    out.extend([e.maximum, e.mean, 100.0 * e.above_1, 100.0 * e.above_8, e.flip_mean, e.flip_p99].map(figure));
    match &measured.layers {
        Some(l) => {
            let percent = |n: u64| figure(100.0 * n as f64 / l.layers.max(1) as f64);
            out.extend([l.layers, l.lost, l.merged, l.out_of_order, l.extra].map(|n| n.to_string()));
            out.extend([l.lost, l.merged, l.out_of_order].map(percent));
            out.push(optional(l.neighbours_different.map(|s| 100.0 * s)));
            out.extend([l.kappa_p95, l.opacity_p95].map(optional));
        }
        None => out.extend(std::iter::repeat_n(String::new(), 11)),
    }
    let c = &measured.counts;
    out.extend([c.stored, c.merged, c.dropped].map(|n| n.to_string()));
    out.push(figure(measured.buffer_bytes as f64 / f64::from(1 << 20)));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (1.1, "1.1"),
            (0.8, "0.8"),
            (2.468, "2.47"),
            (0.012_345, "0.0123"),
            (123.4, "123"),
            (123_456.7, "123457"),
            (-3.25159, "-3.25"),
            (0.000_000_123, "1.23e-7"),
            (9.999, "10"),
            (f64::NAN, ""),
        ] {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn csv_quotes_what_it_must() {
        let table = Table {
            columns: vec!["a".to_owned(), "b".to_owned()],
            rows: vec![vec!["x, y".to_owned(), "say \"no\"".to_owned()]],
        };
        assert_eq!(table.csv(), "a,b\r\n\"x, y\",\"say \"\"no\"\"\"\r\n");
        assert_eq!((table.cell(0, "b"), table.cell(1, "b"), table.cell(0, "c")), ("say \"no\"", "", ""));
    }
}
