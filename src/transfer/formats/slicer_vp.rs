//! 3D Slicer's volume property, `.vp`.
//!
//! Nine lines of text: interpolation, shading, diffuse, ambient, specular, specular power; then three rows that begin
//! with how many *numbers* follow: opacity over the scalar (x, opacity), over the gradient (x, opacity), colour
//! (x, r, g, b). Midpoint and sharpness have no place in it: Slicer writes and reads points without them. Blank rows
//! are rows that say nothing.

use std::fmt::Write;

use super::scalar_map::{OpacityNode, ScalarMap};
use super::{Format, Imported, MOST_POINTS, one_dimensional};
use crate::transfer::{TransferError, TransferFunction};

/// The first six rows, and what Slicer would use: linear, shaded, and its default light.
const LIGHTING: [(&str, &str); 6] = [
    ("interpolation", "1"),
    ("shading", "1"),
    ("diffuse", "0.9"),
    ("ambient", "0.1"),
    ("specular", "0.2"),
    ("specular power", "10"),
];

/// Reads it.
pub(super) fn read(text: &str, path: &str) -> Result<Imported, TransferError> {
    let at = |line: usize, reason: String| TransferError::at_line(path, line, reason);
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    for (what, _) in LIGHTING {
        match lines.next() {
            Some((_, row)) if row.trim().is_empty() || number(row.trim()).is_some() => {}
            Some((line, row)) => return Err(at(line, format!("{what}: expected one number, found '{}'", short(row)))),
            None => return Err(at(text.lines().count().max(1), format!("the file ends before its {what}"))),
        }
    }
    let mut notices = vec!["ignored: lighting; materials of the model have their own".to_owned()];
    let mut rows = Vec::new();
    let mut last = LIGHTING.len();
    for (what, size) in [("opacity", 2), ("gradient opacity", 2), ("colour", 4)] {
        let Some((line, row)) = lines.next() else {
            return Err(at(last, format!("the file ends before its {what} row")));
        };
        last = line;
        rows.push(numbers(row, what, size).map_err(|reason| at(line, reason))?);
    }
    let [opacity, gradient, color] = <[Vec<f64>; 3]>::try_from(rows).unwrap_or_default();
    let flat = gradient.chunks(2).all(|p| p.get(1) == Some(&1.0));
    if !gradient.is_empty() && !flat {
        notices.push(format!("ignored: gradient opacity, {} points", gradient.len() / 2));
    }
    if let Some((line, _)) = lines.find(|(_, row)| !row.trim().is_empty()) {
        notices.push(format!("ignored: what stands behind the colour row, from line {line}"));
    }
    let mut map = ScalarMap::new();
    map.opacities =
        opacity.chunks_exact(2).map(|p| OpacityNode { x: p[0], alpha: p[1], midpoint: 0.5, sharpness: 0.0 }).collect();
    map.colors = color.chunks_exact(4).map(|p| (p[0], [p[1], p[2], p[3]])).collect();
    map.import(notices, |reason| at(last, reason))
}

fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|v| v.is_finite())
}

fn short(text: &str) -> String {
    text.trim().chars().take(24).collect()
}

/// A row: how many numbers, then so many.
fn numbers(row: &str, what: &str, size: usize) -> Result<Vec<f64>, String> {
    let mut words = row.split_whitespace();
    let Some(first) = words.next() else {
        return Ok(Vec::new());
    };
    let count = first
        .parse::<usize>()
        .map_err(|_| format!("{what}: expected how many numbers follow, found '{}'", short(first)))?;
    if count > size * MOST_POINTS {
        return Err(format!("{what}: {count} numbers are more than {MOST_POINTS} points"));
    }
    let numbers = words
        .map(|w| number(w).ok_or_else(|| format!("{what}: '{}' is not a number", short(w))))
        .collect::<Result<Vec<f64>, String>>()?;
    if numbers.len() != count {
        return Err(format!("{what}: {count} numbers are announced, {} follow", numbers.len()));
    }
    if count % size != 0 {
        return Err(format!("{what}: {count} numbers are no whole points of {size}"));
    }
    Ok(numbers)
}

/// Writes it: colours over κ in [−1, 1], opacity over |κ| in [0, 1], gradient opacity 1, Slicer's default light.
pub(super) fn write(function: &TransferFunction, notices: &mut Vec<String>) -> String {
    let (color, opacity) = one_dimensional(function, Format::SlicerVp, notices);
    let mut text: String = LIGHTING.iter().map(|(_, value)| format!("{value}\n")).collect();
    let mut row = |numbers: Vec<f64>| {
        let _ = write!(text, "{}", numbers.len());
        for v in numbers {
            let _ = write!(text, " {v}");
        }
        text.push('\n');
    };
    row(opacity.points.iter().flat_map(|(x, [a])| [*x, *a]).collect());
    row(vec![0.0, 1.0, 255.0, 1.0]);
    row(color.points.iter().flat_map(|(x, [r, g, b])| [*x, *r, *g, *b]).collect());
    text
}
