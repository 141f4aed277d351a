//! Files that hold transfer functions: our own and those of other programs, read and written.
//!
//! | format | holds | on the way in | on the way out |
//! |---|---|---|---|
//! | TOML | everything | as it is | as it is; images become points (within 1/255, maps 2/255) |
//! | PNG | colours, or opacities | a strip (at least four times as wide as high): its first row, κ from left to right; any other: depth to the right, \|κ\| upwards | 16 bits, 256×1 or, for `….opacity.png`, 256×256 |
//! | ParaView JSON, XML | colours, opacity over \|κ\| | ranges mapped onto κ in [−1, 1] and \|κ\| in [0, 1] | straight pieces |
//! | Slicer `.vp` | colours, opacity over \|κ\| | the same; lighting and gradient opacity are left out | straight pieces |
//! | CSV | everything but images | as it is (three tables, described in `csv.rs`) | as it is; images become points |
//!
//! Straight pieces are within 5e-4 of the function. What a file does not say (a colour map without opacity) is taken
//! from the default functions. Whatever is mapped, approximated, repaired or left out is a notice; one begins with
//! `ignored:`, `approximated:`, `repaired:` or `computed:`, the importer's words.
//!
//! A file's name and its content must agree on the format; a name with another ending leaves it to the content.

mod csv;
mod fit;
mod paraview_json;
mod paraview_xml;
mod png;
mod scalar_map;
mod slicer_vp;
mod toml;

use std::path::Path;

use super::{
    ColorFunction, ColorMode, ColorShape, Interpolation, OpacityFunction, OpacityShape, TransferError,
    TransferFunction, TransferSource,
};
use fit::Fit;

/// Longer text is refused.
const LARGEST_TEXT: usize = 16 << 20;
/// More points in one file are refused.
const MOST_POINTS: usize = 65_536;

/// What a file gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The functions. Images that a TOML file names are not loaded; [`TransferSource::import`] does both.
    pub function: TransferFunction,
    /// What was mapped, approximated, repaired or left out, a line each.
    pub notices: Vec<String>,
}

/// What is to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the format cannot hold, a line each.
    pub notices: Vec<String>,
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Our own.
    Toml,
    /// Colours as an image of one row.
    PngStrip,
    /// Opacities as an image.
    PngMap,
    /// ParaView's colour maps as it writes them today.
    ParaviewJson,
    /// ParaView's older colour maps.
    ParaviewXml,
    /// 3D Slicer's volume property.
    SlicerVp,
    /// Tables of numbers.
    Csv,
}

impl Format {
    /// Every format.
    pub const ALL: [Format; 7] = [
        Format::Toml,
        Format::PngStrip,
        Format::PngMap,
        Format::ParaviewJson,
        Format::ParaviewXml,
        Format::SlicerVp,
        Format::Csv,
    ];

    /// What files of it end with.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Toml => "toml",
            Format::PngStrip => "png",
            Format::PngMap => "opacity.png",
            Format::ParaviewJson => "json",
            Format::ParaviewXml => "xml",
            Format::SlicerVp => "vp",
            Format::Csv => "csv",
        }
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Format::Toml => "TOML",
            Format::PngStrip | Format::PngMap => "PNG",
            Format::ParaviewJson => "ParaView JSON",
            Format::ParaviewXml => "ParaView XML",
            Format::SlicerVp => "3D Slicer volume property",
            Format::Csv => "CSV",
        }
    }

    /// The format that a file's name ends with, if it is one of ours.
    pub fn of_path(path: &Path) -> Option<Format> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let ends = |f: &Format| name.strip_suffix(f.extension()).is_some_and(|stem| stem.ends_with('.'));
        // The longer ending first.
        Format::ALL.into_iter().filter(ends).max_by_key(|f| f.extension().len())
    }

    /// The format that content looks like.
    fn of_content(bytes: &[u8]) -> Option<Format> {
        if bytes.starts_with(b"\x89PNG") {
            return Some(Format::PngStrip);
        }
        let text = std::str::from_utf8(bytes).ok()?.trim_start_matches('\u{feff}').trim_start();
        let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
        let first = lines.next()?;
        let after_bracket = first.strip_prefix('[').map(|r| r.trim_start_matches(['[', ' ', '\t']));
        let array = |rest: &str| rest.is_empty() || rest.starts_with(|c: char| "{]\"-0123456789".contains(c));
        let number = |l: &str| l.split_whitespace().all(|w| w.parse::<f64>().is_ok());
        if first.starts_with('<') {
            Some(Format::ParaviewXml)
        } else if first.starts_with('{') || after_bracket.is_some_and(array) {
            Some(Format::ParaviewJson)
        } else if after_bracket.is_some() || first.contains('=') {
            Some(Format::Toml)
        } else if first.contains(',') {
            Some(Format::Csv)
        } else if number(first) && lines.next().is_some_and(number) {
            Some(Format::SlicerVp)
        } else {
            None
        }
    }
}

/// Reads a file's bytes. `path` decides the format together with the content, and is what errors call the file; `map`
/// chooses among several in one file, by default the first.
///
/// # Errors
/// [`TransferError`] with file, line and cause for anything that cannot be used.
pub fn read(bytes: &[u8], path: &str, map: Option<&str>) -> Result<Imported, TransferError> {
    let by_name = Format::of_path(Path::new(path));
    let by_content = Format::of_content(bytes);
    let family = |f: Format| if f == Format::PngMap { Format::PngStrip } else { f };
    let format = match (by_name.map(family), by_content) {
        (Some(name), Some(content)) if name != content => {
            let reason = format!("the name says {}, the content looks like {}", name.name(), content.name());
            return Err(TransferError::at_line(path, 1, reason));
        }
        (Some(Format::PngStrip), None) => Format::PngStrip,
        (_, None) if std::str::from_utf8(bytes).is_err() => {
            let kinds = "a transfer function is text (TOML, JSON, XML, vp or CSV) or a PNG";
            return Err(TransferError::at_line(path, 1, format!("neither text nor an image; {kinds}")));
        }
        // An empty TOML file, for one, looks like nothing; its own reader says what is missing.
        (Some(name), _) => name,
        (None, Some(content)) => content,
        (None, None) => {
            let reason = "not a transfer function: expected TOML, PNG, ParaView JSON or XML, Slicer vp or CSV";
            return Err(TransferError::at_line(path, 1, reason));
        }
    };
    if format == Format::PngStrip {
        return png::read(bytes, path, map);
    }
    if bytes.len() > LARGEST_TEXT {
        return Err(TransferError::file(path, format!("larger than {} MiB", LARGEST_TEXT >> 20)));
    }
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        TransferError::at_line(path, line, "not UTF-8 text")
    })?;
    let text = text.trim_start_matches('\u{feff}');
    let imported = match format {
        Format::Toml => toml::read(text, path),
        Format::ParaviewJson => paraview_json::read(text, path, map),
        Format::ParaviewXml => paraview_xml::read(text, path, map),
        Format::SlicerVp => slicer_vp::read(text, path),
        Format::Csv | Format::PngStrip | Format::PngMap => csv::read(text, path),
    }?;
    if map.is_some() && !matches!(format, Format::ParaviewJson | Format::ParaviewXml) {
        let reason = format!("{} holds one transfer function and no names to choose from", format.name());
        return Err(TransferError::file(path, reason));
    }
    Ok(imported)
}

/// Writes functions. `name` is what a map is called where a format has names.
///
/// # Errors
/// [`TransferError::File`] if the file cannot be made: an image that has not been loaded.
pub fn write(function: &TransferFunction, format: Format, name: &str) -> Result<Exported, TransferError> {
    if let Some(path) = function.not_loaded() {
        return Err(TransferError::file(path, "the image has not been loaded"));
    }
    let mut notices = Vec::new();
    let bytes = match format {
        Format::Toml => toml::write(function, &mut notices)?.into_bytes(),
        Format::PngStrip => png::write_strip(function, &mut notices)?,
        Format::PngMap => png::write_map(function, &mut notices)?,
        Format::ParaviewJson => paraview_json::write(function, name, &mut notices)?.into_bytes(),
        Format::ParaviewXml => paraview_xml::write(function, name, &mut notices).into_bytes(),
        Format::SlicerVp => slicer_vp::write(function, &mut notices).into_bytes(),
        Format::Csv => csv::write(function, &mut notices).into_bytes(),
    };
    Ok(Exported { bytes, notices })
}

/// Both functions; what a file does not have is the default's.
fn assemble(
    color: Option<ColorFunction>,
    opacity: Option<OpacityFunction>,
    mut notices: Vec<String>,
) -> Result<Imported, String> {
    if color.is_none() && opacity.is_none() {
        return Err("there is neither colour nor opacity".to_owned());
    }
    let mut function = TransferSource::default().resolve(None).map_err(|e| e.to_string())?;
    if color.is_none() {
        notices.push("computed: there is no colour; 'pellucid' gives it".to_owned());
    }
    if opacity.is_none() {
        notices.push("computed: there is no opacity; 'pellucid' gives it".to_owned());
    }
    function.color = color.unwrap_or(function.color);
    function.opacity = opacity.unwrap_or(function.opacity);
    Ok(Imported { function, notices })
}

/// Chooses a map by name, or the first.
///
/// # Errors
/// A sentence for the user that names those there are.
fn choose(names: &[String], map: Option<&str>, notices: &mut Vec<String>) -> Result<usize, String> {
    // A file may hold thousands.
    let listed = |names: &[&String]| {
        let shown: Vec<String> = names.iter().take(20).map(|n| format!("'{n}'")).collect();
        let more = names.len() - shown.len();
        shown.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
    };
    let index = match map {
        None => 0,
        Some(wanted) => names.iter().position(|n| n == wanted).ok_or_else(|| {
            format!("no map is called '{wanted}'; there are {}", listed(&names.iter().collect::<Vec<_>>()))
        })?,
    };
    let Some(taken) = names.get(index) else {
        return Err("there is no colour map".to_owned());
    };
    let others: Vec<&String> = names.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, n)| n).collect();
    if map.is_none() && !others.is_empty() {
        notices.push(format!("ignored: '{taken}' is the first of several maps; the others are {}", listed(&others)));
    }
    Ok(index)
}

/// The functions as the straight pieces of a format over one scalar, which has no tint mode and no depth.
fn one_dimensional(function: &TransferFunction, format: Format, notices: &mut Vec<String>) -> (Fit<3>, Fit<1>) {
    not_written_mode(function, format, notices);
    if function.opacity.depends_on_depth() {
        notices.push(format!("approximated: {} has no depth: the opacity is written as at depth 0.5", format.name()));
    }
    let (color, opacity) = (fit::color(&function.color), fit::opacity(&function.opacity, 0.5));
    for (what, error) in [("colours", color.error), ("opacity", opacity.error)] {
        if error > 0.0 {
            notices.push(format!("approximated: {what} as straight pieces; largest error {error:.5}"));
        }
    }
    if let ColorShape::Points { interpolation: Interpolation::Step, .. } = function.color.shape {
        notices.push("approximated: steps of the colour as two points each, 1e-9 apart".to_owned());
    }
    if let OpacityShape::Curves { interpolation: Interpolation::Step, .. } = function.opacity.shape {
        notices.push("approximated: steps of the opacity as two points each, 1e-9 apart".to_owned());
    }
    (color, opacity)
}

/// Says that a format has no place for the way in which colours act.
fn not_written_mode(function: &TransferFunction, format: Format, notices: &mut Vec<String>) {
    let what = match function.color.mode {
        ColorMode::Tint => "tint",
        ColorMode::Multiply => "multiply, and will be read as tint",
    };
    notices.push(format!("ignored: {} cannot say how colours act on the material; here they {what}", format.name()));
}

#[cfg(test)]
mod tests;
