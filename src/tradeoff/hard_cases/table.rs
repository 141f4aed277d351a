//! Outcomes as text: a table for the terminal and one for documents.

use super::{ContrastOutcome, Outcome};

/// A figure with three significant digits and its unit: `17.1 %`, `0.53°`, `0`.
pub fn figure_text(figure: f64, unit: &str) -> String {
    let number = if figure == 0.0 {
        "0".to_owned()
    } else if !figure.is_finite() {
        "not finite".to_owned()
    } else if figure.abs() < 0.001 || figure.abs() >= 1e6 {
        format!("{figure:.1e}")
    } else {
        let digits = (2 - figure.abs().log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{figure:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    };
    format!("{number}{unit}")
}

/// The contrast's figure; a planted error is marked by a star.
fn contrast_text(contrast: Option<&ContrastOutcome>, unit: &str) -> String {
    let Some(contrast) = contrast else { return "–".to_owned() };
    let star = if contrast.printed { "" } else { "*" };
    match (contrast.figure, &contrast.reason) {
        (Some(figure), _) => format!("{}{star}", figure_text(figure, unit)),
        (None, Some(reason)) if reason.contains("asked for") => format!("refused{star}"),
        _ => format!("broken{star}"),
    }
}

fn cells(o: &Outcome) -> [String; 6] {
    let name = o.name.to_owned();
    let ours = o.ours.map_or_else(|| "–".to_owned(), |f| figure_text(f, o.unit));
    let printed = contrast_text(o.contrast.as_ref(), o.unit);
    [name, o.measured.to_owned(), printed, ours, figure_text(o.bound, o.unit), o.verdict.word().to_owned()]
}

const HEAD: [&str; 6] = ["case", "measured", "printed", "ours", "bound", "verdict"];

/// Pads to a width counted in characters.
fn padded(cell: &str, width: usize, right: bool) -> String {
    let space = " ".repeat(width.saturating_sub(cell.chars().count()));
    if right { format!("{space}{cell}") } else { format!("{cell}{space}") }
}

/// A table for a terminal, with reasons below the rows that have one.
pub fn text(outcomes: &[Outcome]) -> String {
    let rows: Vec<[String; 6]> = outcomes.iter().map(cells).collect();
    let head = HEAD.map(str::to_owned);
    let width = |i: usize| rows.iter().chain([&head]).map(|r| r[i].chars().count()).fold(0, usize::max);
    let widths: [usize; 6] = std::array::from_fn(width);
    let line = |row: &[String; 6]| {
        let cells = row.iter().enumerate().map(|(i, c)| padded(c, widths[i], (2..5).contains(&i)));
        format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    let mut text = line(&head);
    for (row, outcome) in rows.iter().zip(outcomes) {
        text += &line(row);
        if let Some(reason) = &outcome.reason {
            text += &format!("    {reason}\n");
        }
    }
    text
}

/// The same as a table of Markdown.
pub fn markdown(outcomes: &[Outcome]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(&HEAD.map(str::to_owned));
    text += "|---|---|--:|--:|--:|---|\n";
    outcomes.iter().for_each(|o| text += &line(&cells(o)));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::hard_cases::Verdict;

    #[test]
    fn figures_have_three_digits() {
        let texts = [0.0, 17.1234, 0.5, 0.05312, 1234.6, 2.0e-6, f64::NAN].map(|f| figure_text(f, " %"));
        assert_eq!(texts, ["0 %", "17.1 %", "0.5 %", "0.0531 %", "1235 %", "2.0e-6 %", "not finite %"]);
    }

    #[test]
    fn rows_line_up_and_planted_errors_have_a_star() {
        let outcome = Outcome {
            name: "t99-test",
            trap: "T99",
            technique: "passes/none",
            why: "",
            measured: "layers wrong",
            unit: " %",
            bound: 0.0,
            ours: Some(0.0),
            samples: 9,
            ambiguous: 0,
            contrast: Some(ContrastOutcome { printed: false, label: "", figure: Some(50.0), reason: None }),
            verdict: Verdict::Skipped,
            reason: Some("no such thing".to_owned()),
        };
        let text = text(std::slice::from_ref(&outcome));
        assert!(text.contains("50 %*") && text.contains("skipped\n    no such thing\n"), "{text}");
        assert!(markdown(&[outcome]).ends_with("| t99-test | layers wrong | 50 %* | 0 % | 0 % | skipped |\n"));
    }
}
