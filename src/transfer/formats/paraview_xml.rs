//! ParaView's older colour maps in XML: `<ColorMaps>` of `<ColorMap name= space= indexedLookup=>`, each of
//! `<Point x= o= r= g= b=/>`. A lone `<ColorMap>` is read too.
//!
//! Colour and opacity share x, so x from −1 to 1 is κ for the colour and 2|κ| − 1 for the opacity, in both directions.

use std::fmt::Write;

use roxmltree::{Document, Node, ParsingOptions};

use super::scalar_map::{OpacityNode, ScalarMap, Space};
use super::{Format, Imported, MOST_POINTS, choose, one_dimensional};
use crate::transfer::{TransferError, TransferFunction};

/// Reads a file of maps.
pub(super) fn read(text: &str, path: &str, map: Option<&str>) -> Result<Imported, TransferError> {
    let place = |pos: roxmltree::TextPos, reason: String| {
        let (line, column) = (pos.row as usize, pos.col as usize);
        TransferError::Text { path: path.to_owned(), line, column, reason }
    };
    let options = ParsingOptions { nodes_limit: 16 * MOST_POINTS as u32, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| {
        // roxmltree ends its message with the place, which stands in front here.
        let whole = e.to_string();
        let reason = whole.rsplit_once(" at ").map_or(whole.as_str(), |(reason, _)| reason).to_owned();
        place(e.pos(), reason)
    })?;
    let at = |node: Node, reason: String| place(document.text_pos_at(node.range().start), reason);
    let root = document.root_element();
    let maps: Vec<Node> = match root.tag_name().name() {
        "ColorMap" => vec![root],
        "ColorMaps" => root.children().filter(|n| n.has_tag_name("ColorMap")).collect(),
        other => return Err(at(root, format!("<{other}>: expected <ColorMaps> or <ColorMap>"))),
    };
    let mut notices = Vec::new();
    let names: Vec<String> = maps.iter().map(|m| m.attribute("name").unwrap_or_default().to_owned()).collect();
    let index = choose(&names, map, &mut notices).map_err(|reason| at(root, reason))?;
    let chosen = maps[index];
    let mut scalar = ScalarMap::new();
    if let Some(space) = chosen.attribute("space") {
        scalar.space = Space::named(space).map_err(|reason| at(chosen, reason))?;
    }
    let indexed = chosen.attribute("indexedLookup").is_some_and(|v| ["1", "true"].contains(&v));
    let mut without_opacity = 0_usize;
    let mut others: Vec<&str> = Vec::new();
    for node in chosen.children().filter(Node::is_element) {
        if !node.has_tag_name("Point") {
            let name = node.tag_name().name();
            if !others.contains(&name) && others.len() < 20 {
                others.push(name);
            }
            continue;
        }
        if scalar.colors.len().max(scalar.indexed.len()) == MOST_POINTS {
            return Err(at(node, format!("more than {MOST_POINTS} points")));
        }
        let number = |name: &str| match node.attribute(name).map(str::trim) {
            None => Ok(None),
            Some(value) => value.parse::<f64>().ok().filter(|v| v.is_finite()).map(Some).ok_or_else(|| {
                at(node, format!("{name}=\"{}\" is not a number", value.chars().take(24).collect::<String>()))
            }),
        };
        let needed = |name: &str| number(name)?.ok_or_else(|| at(node, format!("the point has no {name}")));
        let color = [needed("r")?, needed("g")?, needed("b")?];
        if indexed {
            scalar.indexed.push(color);
            continue;
        }
        let x = needed("x")?;
        scalar.colors.push((x, color));
        match number("o")? {
            Some(alpha) => scalar.opacities.push(OpacityNode { x, alpha, midpoint: 0.5, sharpness: 0.0 }),
            None => without_opacity += 1,
        }
    }
    if without_opacity > 0 && !scalar.opacities.is_empty() {
        notices.push(format!("ignored: opacity, because {without_opacity} points have none"));
        scalar.opacities.clear();
    }
    if !others.is_empty() {
        notices.push(format!("ignored: {}", others.join(", ")));
    }
    scalar.import(notices, |reason| at(chosen, reason))
}

/// Writes a file of one map.
pub(super) fn write(function: &TransferFunction, name: &str, notices: &mut Vec<String>) -> String {
    let (color, opacity) = one_dimensional(function, Format::ParaviewXml, notices);
    let mut places: Vec<f64> = color.points.iter().map(|p| p.0).collect();
    places.extend(opacity.points.iter().map(|p| 2.0 * p.0 - 1.0));
    places.sort_by(f64::total_cmp);
    places.dedup();
    let name: String = name
        .chars()
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '"' => "&quot;".to_owned(),
            c if c.is_control() => " ".to_owned(),
            c => c.to_string(),
        })
        .collect();
    let mut text = format!("<ColorMaps>\n  <ColorMap name=\"{name}\" space=\"RGB\" indexedLookup=\"false\">\n");
    for x in places {
        let ([r, g, b], [o]) = (color.sample(x), opacity.sample(x * 0.5 + 0.5));
        let _ = writeln!(text, "    <Point x=\"{x}\" o=\"{o}\" r=\"{r}\" g=\"{g}\" b=\"{b}\"/>");
    }
    text + "  </ColorMap>\n</ColorMaps>\n"
}
