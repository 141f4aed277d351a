//! ParaView's colour maps in JSON: an array of maps, each `Name`, `ColorSpace`, `RGBPoints` (x, r, g, b), `Points`
//! (x, opacity, midpoint, sharpness) and `IndexedColors` (r, g, b). A lone map is read too.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::scalar_map::{OpacityNode, ScalarMap, Space};
use super::{Format, Imported, MOST_POINTS, choose, one_dimensional};
use crate::transfer::{TransferError, TransferFunction};

/// Numbers in groups of `N`.
#[derive(Deserialize)]
#[serde(try_from = "Vec<f64>")]
struct Groups<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> TryFrom<Vec<f64>> for Groups<N> {
    type Error = String;
    fn try_from(numbers: Vec<f64>) -> Result<Groups<N>, String> {
        let (groups, rest) = numbers.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(format!("{} numbers are no whole groups of {N}", numbers.len()));
        }
        if groups.len() > MOST_POINTS {
            return Err(format!("{} points are more than {MOST_POINTS}", groups.len()));
        }
        Ok(Groups(groups.to_vec()))
    }
}

#[derive(Deserialize)]
#[serde(try_from = "String")]
struct NamedSpace(Space);

impl TryFrom<String> for NamedSpace {
    type Error = String;
    fn try_from(name: String) -> Result<NamedSpace, String> {
        Space::named(&name).map(NamedSpace)
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(f64),
}

#[derive(Deserialize)]
struct Map {
    #[serde(rename = "Name", default)]
    name: String,
    #[serde(rename = "ColorSpace", default)]
    space: Option<NamedSpace>,
    #[serde(rename = "HSVWrap", default)]
    wrap: Option<Flag>,
    #[serde(rename = "RGBPoints", default)]
    colors: Option<Groups<4>>,
    #[serde(rename = "Points", default)]
    opacities: Option<Groups<4>>,
    #[serde(rename = "IndexedColors", default)]
    indexed: Option<Groups<3>>,
}

/// Keys that are read above, or say nothing about the look.
const KNOWN: [&str; 13] = [
    "Name",
    "ColorSpace",
    "HSVWrap",
    "RGBPoints",
    "Points",
    "IndexedColors",
    "Creator",
    "DefaultMap",
    "License",
    "Source",
    "Category",
    "Groups",
    "Description",
];

/// Reads a file of maps.
pub(super) fn read(text: &str, path: &str, map: Option<&str>) -> Result<Imported, TransferError> {
    let at = |e: serde_json::Error| {
        // serde_json ends its message with the place, which stands in front here.
        let whole = e.to_string();
        let reason = whole.split(" at line ").next().unwrap_or(&whole).to_owned();
        TransferError::Text { path: path.to_owned(), line: e.line().max(1), column: e.column().max(1), reason }
    };
    let alone = text.trim_start().starts_with('{');
    let mut maps: Vec<Map> =
        if alone { vec![serde_json::from_str(text).map_err(at)?] } else { serde_json::from_str(text).map_err(at)? };
    let mut notices = Vec::new();
    let names: Vec<String> = maps.iter().map(|m| m.name.clone()).collect();
    let index = choose(&names, map, &mut notices).map_err(|reason| TransferError::at_line(path, 1, reason))?;
    let ignored = if alone {
        vec![serde_json::from_str::<BTreeMap<String, Value>>(text).map_err(at)?]
    } else {
        serde_json::from_str::<Vec<BTreeMap<String, Value>>>(text).map_err(at)?
    };
    let off = |v: &Value| matches!(v, Value::Null | Value::Bool(false)) || v.as_f64() == Some(0.0);
    let keys: Vec<&str> = ignored
        .get(index)
        .into_iter()
        .flatten()
        .filter(|(key, value)| !KNOWN.contains(&key.as_str()) && !off(value))
        .map(|(key, _)| key.as_str())
        .take(20)
        .collect();
    if !keys.is_empty() {
        notices.push(format!("ignored: {}", keys.join(", ")));
    }
    let chosen = maps.swap_remove(index);
    let mut scalar = ScalarMap::new();
    scalar.space = chosen.space.map_or(Space::Rgb, |s| s.0);
    let wrap = chosen.wrap.is_some_and(|w| match w {
        Flag::Bool(on) => on,
        Flag::Number(v) => v != 0.0,
    });
    if wrap && scalar.space == (Space::Hsv { wrap: false }) {
        scalar.space = Space::Hsv { wrap: true };
    }
    let colors = chosen.colors.map_or(Vec::new(), |g| g.0);
    scalar.colors = colors.into_iter().map(|[x, r, g, b]| (x, [r, g, b])).collect();
    scalar.indexed = chosen.indexed.map_or(Vec::new(), |g| g.0);
    let opacities = chosen.opacities.map_or(Vec::new(), |g| g.0);
    scalar.opacities = opacities
        .into_iter()
        .map(|[x, alpha, midpoint, sharpness]| OpacityNode { x, alpha, midpoint, sharpness })
        .collect();
    let what = if chosen.name.is_empty() { "the map".to_owned() } else { format!("'{}'", chosen.name) };
    // The place of the map's name, where it is written as it reads.
    let line = text.find(&format!("\"{}\"", chosen.name)).map_or(1, |i| text[..i].matches('\n').count() + 1);
    scalar.import(notices, |reason| TransferError::at_line(path, line, format!("{what}: {reason}")))
}

/// What we write.
#[derive(Serialize)]
#[serde(rename_all = "PascalCase")]
struct Written<'a> {
    color_space: &'static str,
    name: &'a str,
    points: Vec<f64>,
    #[serde(rename = "RGBPoints")]
    rgb_points: Vec<f64>,
}

/// Writes a file of one map: colours over κ in [−1, 1], opacity over |κ| in [0, 1].
pub(super) fn write(
    function: &TransferFunction,
    name: &str,
    notices: &mut Vec<String>,
) -> Result<String, TransferError> {
    let (color, opacity) = one_dimensional(function, Format::ParaviewJson, notices);
    let map = Written {
        color_space: "RGB",
        name,
        points: opacity.points.iter().flat_map(|(x, [a])| [*x, *a, 0.5, 0.0]).collect(),
        rgb_points: color.points.iter().flat_map(|(x, [r, g, b])| [*x, *r, *g, *b]).collect(),
    };
    serde_json::to_string_pretty(&[map]).map(|text| text + "\n").map_err(|e| TransferError::file(name, e))
}
