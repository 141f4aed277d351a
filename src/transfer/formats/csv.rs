//! Tables of numbers, which any spreadsheet reads and writes.
//!
//! A file holds up to three tables, each begun by its header row, in any order and with columns in any order:
//!
//! ```csv
//! # everything behind a # is a comment; spaces and empty rows do not count
//! setting, value
//! mode, tint                        # or multiply
//! color_interpolation, monotone     # or linear, step; linear if it is not said
//! opacity_interpolation, monotone
//! depth_interpolation, linear
//!
//! kappa, r, g, b
//! -1, 0.66, 0.66, 0.66
//! 1, 0.06, 0.06, 0.06
//!
//! depth, kappa, opacity             # without depth: one curve for all depths
//! 0, 0, 0.02
//! 0, 1, 0.7
//! 1, 0, 0.12
//! 1, 1, 1
//! ```
//!
//! κ and depth are taken as they are where they lie in our ranges, −1 to 1 for colours and 0 to 1 for |κ| and depth; if
//! one does not, the range of its column is mapped onto ours. So control points come back bit for bit.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::scalar_map::{arrange, clamp, unit_colors};
use super::{Imported, MOST_POINTS, assemble};
use crate::transfer::{
    ColorFunction, ColorMode, ColorPoint, ColorShape, ColorValue, Interpolation, OpacityCurve, OpacityFunction,
    OpacityPoint, OpacityShape, Points, TransferError, TransferFunction,
};

/// The tables by their columns; those in brackets may be missing.
const COLOR: [&str; 4] = ["kappa", "r", "g", "b"];
const OPACITY: [&str; 3] = ["depth", "kappa", "opacity"];
const SETTINGS: [&str; 2] = ["setting", "value"];

#[derive(Clone, Copy, PartialEq)]
enum Table {
    Color,
    Opacity,
    Settings,
}

/// A table being read: which, and where each of its columns stands.
struct Header {
    table: Table,
    columns: Vec<Option<usize>>,
    width: usize,
}

#[derive(Default)]
struct Settings {
    mode: ColorMode,
    color: Option<Interpolation>,
    opacity: Option<Interpolation>,
    depth: Option<Interpolation>,
}

/// Reads the tables.
pub(super) fn read(text: &str, path: &str) -> Result<Imported, TransferError> {
    let mut notices = Vec::new();
    let mut header: Option<Header> = None;
    let mut settings = Settings::default();
    let mut colors: Vec<(f64, [f64; 3])> = Vec::new();
    let mut opacities: Vec<[f64; 3]> = Vec::new();
    let mut last = 1;
    for (line, row) in text.lines().enumerate().map(|(i, row)| (i + 1, row)) {
        let at = |reason: String| TransferError::at_line(path, line, reason);
        let row = row.split('#').next().unwrap_or_default().trim();
        if row.is_empty() || row.bytes().all(|b| b == b',' || b == b' ') {
            continue;
        }
        last = line;
        // Spreadsheets may put every word into quotes.
        let cells: Vec<&str> = row.split(',').map(|c| c.trim().trim_matches('"').trim()).collect();
        if let Some(new) = self::header(&cells, &mut notices) {
            header = Some(new);
            continue;
        }
        let Some(Header { table, columns, width }) = &header else {
            return Err(at(format!(
                "expected a header row, as in '{}' or '{}', found '{}'",
                COLOR.join(","),
                OPACITY.join(","),
                short(row)
            )));
        };
        if cells.len() > *width && cells[*width..].iter().any(|c| !c.is_empty()) {
            return Err(at(format!("{} cells under a header of {width}", cells.len())));
        }
        let cell = |i: usize| columns[i].map(|c| cells.get(c).copied().unwrap_or_default());
        let number = |i: usize, name: &str| match cell(i) {
            None => Ok(0.0),
            Some(text) => text
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| at(format!("{name} = '{}': expected a number", short(text)))),
        };
        match table {
            Table::Settings => {
                let word = |i| cell(i).unwrap_or_default();
                set(&mut settings, word(0), word(1)).map_err(at)?;
            }
            Table::Color => {
                let [kappa, r, g, b] = COLOR;
                colors.push((number(0, kappa)?, [number(1, r)?, number(2, g)?, number(3, b)?]));
            }
            Table::Opacity => {
                let [depth, kappa, opacity] = OPACITY;
                opacities.push([number(0, depth)?, number(1, kappa)?, number(2, opacity)?]);
            }
        }
        if colors.len().max(opacities.len()) > MOST_POINTS {
            return Err(at(format!("more than {MOST_POINTS} points")));
        }
    }
    let end = |reason: String| TransferError::at_line(path, last, reason);
    let color = color(colors, &settings, &mut notices).map_err(end)?;
    let opacity = opacity(opacities, &settings, &mut notices).map_err(end)?;
    assemble(color, opacity, notices).map_err(end)
}

fn short(text: &str) -> String {
    text.chars().take(24).collect()
}

/// Reads a row as a header, if every column of one of the tables is in it. A row that begins with a number is none.
fn header(cells: &[&str], notices: &mut Vec<String>) -> Option<Header> {
    let lower: Vec<String> = cells.iter().map(|c| c.to_ascii_lowercase()).collect();
    let place = |name: &str| lower.iter().position(|c| c == name);
    let all = |names: &[&str]| names.iter().all(|n| place(n).is_some());
    let (table, names): (Table, &[&str]) = if all(&COLOR) {
        (Table::Color, &COLOR)
    } else if all(&OPACITY[1..]) {
        (Table::Opacity, &OPACITY)
    } else if all(&SETTINGS) {
        (Table::Settings, &SETTINGS)
    } else {
        return None;
    };
    let others: Vec<String> = lower
        .iter()
        .filter(|c| !c.is_empty() && !names.contains(&c.as_str()))
        .map(|c| format!("'{}'", short(c)))
        .collect();
    if !others.is_empty() {
        notices.push(format!("ignored: columns {}", others.join(", ")));
    }
    Some(Header { table, columns: names.iter().map(|n| place(n)).collect(), width: cells.len() })
}

fn set(settings: &mut Settings, name: &str, value: &str) -> Result<(), String> {
    let interpolation = || match value {
        "step" => Ok(Some(Interpolation::Step)),
        "linear" => Ok(Some(Interpolation::Linear)),
        "monotone" => Ok(Some(Interpolation::Monotone)),
        _ => Err(format!("{} = '{}': expected step, linear or monotone", short(name), short(value))),
    };
    match name {
        "mode" => {
            settings.mode = match value {
                "tint" => ColorMode::Tint,
                "multiply" => ColorMode::Multiply,
                _ => return Err(format!("mode = '{}': expected tint or multiply", short(value))),
            }
        }
        "color_interpolation" => settings.color = interpolation()?,
        "opacity_interpolation" => settings.opacity = interpolation()?,
        "depth_interpolation" => settings.depth = interpolation()?,
        _ => {
            let names = "mode, color_interpolation, opacity_interpolation and depth_interpolation";
            return Err(format!("'{}' is no setting; there are {names}", short(name)));
        }
    }
    Ok(())
}

/// The range onto which positions are mapped: their own if it lies inside ours, and so nothing is changed.
fn range(values: impl Iterator<Item = f64> + Clone, ours: [f64; 2]) -> [f64; 2] {
    let [least, most] = ours;
    if values.clone().all(|v| (least..=most).contains(&v)) {
        [values.clone().fold(most, f64::min), values.fold(least, f64::max)]
    } else {
        ours
    }
}

fn color(
    mut points: Vec<(f64, [f64; 3])>,
    settings: &Settings,
    notices: &mut Vec<String>,
) -> Result<Option<ColorFunction>, String> {
    if points.is_empty() {
        return Ok(None);
    }
    unit_colors(points.iter_mut().map(|p| &mut p.1), notices)?;
    let ends = range(points.iter().map(|p| p.0), [-1.0, 1.0]);
    let points = arrange(&mut points, |p| &mut p.0, ends, "colour", "kappa", notices)?;
    let point = |(kappa, rgb)| ColorPoint { kappa, color: ColorValue(rgb) };
    let points = Points::new(points.into_iter().map(point).collect())?;
    let interpolation = settings.color.unwrap_or(Interpolation::Linear);
    Ok(Some(ColorFunction { mode: settings.mode, shape: ColorShape::Points { interpolation, points } }))
}

fn opacity(
    mut rows: Vec<[f64; 3]>,
    settings: &Settings,
    notices: &mut Vec<String>,
) -> Result<Option<OpacityFunction>, String> {
    if rows.is_empty() {
        return Ok(None);
    }
    clamp(rows.iter_mut().map(|r| &mut r[2]), "opacities", notices)?;
    // Rows of one depth are one curve; finite numbers in the order of their bits, −0 with 0.
    let mut by_depth: BTreeMap<u64, (f64, Vec<OpacityPoint>)> = BTreeMap::new();
    // One mapping for all curves.
    let outside = rows.iter().any(|r| !(0.0..=1.0).contains(&r[1]));
    let (low, high) = rows.iter().fold((f64::MAX, f64::MIN), |(l, h), r| (l.min(r[1]), h.max(r[1])));
    if outside {
        if !(high - low).is_finite() {
            return Err(format!("|kappa| from {low} to {high} is too wide a range"));
        }
        notices.push(format!("approximated: opacity over {low} to {high} mapped onto |kappa| from 0 to 1"));
    }
    for [depth, kappa, opacity] in rows {
        let depth = depth + 0.0;
        let kappa = match outside {
            true if high > low => ((kappa - low) / (high - low)).clamp(0.0, 1.0),
            true => 0.0,
            false => kappa,
        };
        by_depth.entry(depth.to_bits()).or_insert((depth, Vec::new())).1.push(OpacityPoint { kappa, opacity });
    }
    let mut curves: Vec<(f64, Vec<OpacityPoint>)> = by_depth.into_values().collect();
    curves.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut places: Vec<(f64, usize)> = curves.iter().enumerate().map(|(i, c)| (c.0, i)).collect();
    let ends = range(places.iter().map(|p| p.0), [0.0, 1.0]);
    let places = arrange(&mut places, |p| &mut p.0, ends, "curves", "depth", notices)?;
    let mut made = Vec::with_capacity(places.len());
    for (depth, i) in places {
        let mut points = std::mem::take(&mut curves[i].1);
        let ends = range(points.iter().map(|p| p.kappa), [0.0, 1.0]);
        let points = arrange(&mut points, |p| &mut p.kappa, ends, "opacity", "|kappa|", notices)?;
        made.push(OpacityCurve { depth, points: Points::new(points)? });
    }
    notices.dedup();
    let shape = OpacityShape::Curves {
        interpolation: settings.opacity.unwrap_or(Interpolation::Linear),
        depth_interpolation: settings.depth.unwrap_or(Interpolation::Linear),
        curves: Points::new(made)?,
    };
    Ok(Some(OpacityFunction { shape }))
}

/// Writes all three tables. Images become points.
pub(super) fn write(function: &TransferFunction, notices: &mut Vec<String>) -> String {
    let (alone, error) = function.without_images();
    if alone != *function {
        notices.push(format!("approximated: images as control points; largest error {error:.5}"));
    }
    let word = |mode: &Interpolation| match mode {
        Interpolation::Step => "step",
        Interpolation::Linear => "linear",
        Interpolation::Monotone => "monotone",
    };
    let mode = match alone.color.mode {
        ColorMode::Tint => "tint",
        ColorMode::Multiply => "multiply",
    };
    let mut text = format!("{}\nmode,{mode}\n", SETTINGS.join(","));
    let mut tables = String::new();
    if let ColorShape::Points { interpolation, points } = &alone.color.shape {
        let _ = writeln!(text, "color_interpolation,{}", word(interpolation));
        let _ = writeln!(tables, "\n{}", COLOR.join(","));
        for ColorPoint { kappa, color: ColorValue([r, g, b]) } in points.as_slice() {
            let _ = writeln!(tables, "{kappa},{r},{g},{b}");
        }
    }
    if let OpacityShape::Curves { interpolation, depth_interpolation, curves } = &alone.opacity.shape {
        let _ = writeln!(text, "opacity_interpolation,{}", word(interpolation));
        let _ = writeln!(text, "depth_interpolation,{}", word(depth_interpolation));
        let _ = writeln!(tables, "\n{}", OPACITY.join(","));
        for OpacityCurve { depth, points } in curves.as_slice() {
            for OpacityPoint { kappa, opacity } in points.as_slice() {
                let _ = writeln!(tables, "{depth},{kappa},{opacity}");
            }
        }
    }
    text + &tables
}
