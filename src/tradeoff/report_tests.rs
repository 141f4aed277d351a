//! Reports of a sweep made by hand.

use std::collections::HashSet;

use super::*;
use crate::gpu::PassTime;
use crate::math::LinearImage;
use crate::passes::capture::LayerCounts;
use crate::plan::Pass;
use crate::settings::Settings;
use crate::tradeoff::axis;
use crate::tradeoff::axis::configurations;
use crate::tradeoff::image_error::{ErrorMap, ImageError};
use crate::tradeoff::layer_error::LayerError;
use crate::tradeoff::picture::Thumbnails;
use crate::tradeoff::statistics::estimate;
use crate::tradeoff::sweep::{Measured, Row, Sweep, Times};

/// A sweep over all axes with invented figures: the paper's key merges 0.8 %, and k=64 is refused.
pub fn hand_made() -> Sweep {
    let base = Settings::default();
    let mut rows = Vec::new();
    let image = LinearImage { width: 4, height: 2, pixels: vec![[0.25, 0.5, 0.75, 1.0]; 8] };
    for (i, configuration) in configurations(&base, &axis::all()).unwrap().into_iter().enumerate() {
        let packed = configuration.name.contains("packed32");
        let few = configuration.name.contains("k=4") || configuration.name.contains("k=8");
        let samples: Vec<f64> = (0..9).map(|n| 20.0 + i as f64 * 1.37 + f64::from(n % 4) * 0.31).collect();
        let ratios: Vec<f64> = samples.iter().map(|s| s / 20.4).collect();
        let error = if i == 0 { 0.0 } else { 0.37 * i as f64 };
        let measured = Measured {
            image: ImageError {
                maximum: 9.0 * error,
                mean: error,
                above_1: 0.011 * error,
                above_8: 0.001 * error,
                flip_mean: 0.0123 * error,
                flip_p99: 0.07 * error,
            },
            layers: Some(LayerError {
                layers: 1000,
                lost: if few { 121 } else { 0 },
                merged: if packed { 8 } else { 0 },
                out_of_order: if packed { 3 } else { 0 },
                extra: 0,
                neighbours_different: Some(0.001 * i as f64),
                kappa_p95: Some(0.002),
                opacity_p95: None,
            }),
            counts: LayerCounts::default(),
            buffer_bytes: 3 << 20,
            times: Some(Times {
                whole: estimate(&samples, 1),
                ratio: estimate(&ratios, 1),
                passes: vec![PassTime { pass: Pass::Shade, milliseconds: 1.25 }],
                pass_frames: vec![],
                baseline_samples: vec![20.4; 9],
                samples,
            }),
            thumbnails: Some(Thumbnails::new(
                &image,
                &image,
                &ErrorMap { error: ImageError::default(), steps: vec![0.0; 8], flip: vec![0.0; 8] },
                None,
                4,
            )),
        };
        rows.push(Row { configuration, outcome: Ok(measured) });
    }
    let mut refused = rows[1].configuration.clone();
    (refused.name, refused.short) = ("capture=bucketed_k_buffer, k=64".to_owned(), "k=64".to_owned());
    rows.push(Row { configuration: refused, outcome: Err("k=64 does not fit <here>".to_owned()) });
    Sweep {
        rows,
        size: [4, 2],
        layer_size: [4, 2],
        reference: base,
        reference_thumbnail: Some("data:,".to_owned()),
        reference_samples: 32,
        baseline_samples: vec![20.4],
        seconds: 12.0,
    }
}

fn subject() -> Subject {
    Subject { model: "a<b>.glb".to_owned(), camera: "front".to_owned(), adapter: None, limit_seconds: Some(60) }
}

/// The numbers in a text.
fn numbers(text: &str) -> HashSet<String> {
    let mut found = HashSet::new();
    let mut current = String::new();
    let characters: Vec<char> = text.chars().chain([' ']).collect();
    for (i, &c) in characters.iter().enumerate() {
        let next_is_digit = characters.get(i + 1).is_some_and(char::is_ascii_digit);
        let continues =
            !current.is_empty() && ((c == '.' && next_is_digit) || c == 'e' && characters.get(i + 1) == Some(&'-'));
        let exponent = c == '-' && current.ends_with('e');
        if c.is_ascii_digit() || continues || exponent {
            current.push(c);
        } else if !current.is_empty() {
            found.insert(std::mem::take(&mut current));
        }
    }
    found
}

fn cells(csv: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut cell) = (Vec::new(), Vec::new(), String::new());
    let mut quoted = false;
    let mut characters = csv.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                cell.push('"');
                characters.next();
            }
            '"' => quoted = !quoted,
            ',' if !quoted => row.push(std::mem::take(&mut cell)),
            '\n' if !quoted => {
                row.push(std::mem::take(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            '\r' if !quoted => {}
            c => cell.push(c),
        }
    }
    rows
}

/// The words of a page, its marked figures, and whatever number stands in them, against the CSV.
fn check_words(html: &str, csv: &str) -> Result<usize, String> {
    let words = html.split("<section class=\"words\">").nth(1).unwrap().split("</section>").next().unwrap();
    let table = cells(csv);
    assert!(table.iter().all(|row| row.len() == table[0].len()), "every line has every column");
    let all: HashSet<&str> = table.iter().flatten().map(String::as_str).collect();
    let figures: Vec<&str> = words.split("<b>").skip(1).filter_map(|s| s.split("</b>").next()).collect();
    for figure in &figures {
        if !all.contains(figure) {
            return Err(format!("{figure} is no cell"));
        }
    }
    let known = numbers(&table.iter().flatten().map(|c| format!("{c} ; ")).collect::<String>());
    let text: String = words.split('<').map(|s| s.split_once('>').map_or(s, |(_, t)| t)).collect::<Vec<_>>().join("");
    for number in numbers(&text) {
        if !known.contains(&number) {
            return Err(format!("{number} does not occur in the CSV"));
        }
    }
    Ok(figures.len())
}

#[test]
fn every_figure_of_the_text_occurs_in_the_csv() {
    let sweep = hand_made();
    let files = files(&sweep, &subject());
    let [csv, _, html] = &files[..] else { panic!() };
    assert!(check_words(&html.content, &csv.content).unwrap() > 50);
    let planted = html.content.replacen("merges <b>0.8</b>", "merges <b>0.8765</b>", 1);
    assert_ne!(planted, html.content, "the sentence about the paper's key is there");
    assert_eq!(check_words(&planted, &csv.content), Err("0.8765 is no cell".to_owned()));
}

#[test]
fn the_csv_has_a_line_for_every_configuration() {
    let sweep = hand_made();
    let table = Table::of(&sweep);
    let parsed = cells(&table.csv());
    assert_eq!(parsed.len(), 1 + sweep.rows.len());
    assert_eq!(parsed[0], table.columns);
    assert_eq!(parsed[1..], table.rows[..]);
    assert!(parsed.last().unwrap()[3].contains("k=64 does not fit"), "a refusal is a row");
    assert_eq!(table.cell(1, "pass_shade_ms"), "1.25");
}

#[test]
fn the_json_has_every_sample_and_says_where_it_is_from() {
    let sweep = hand_made();
    let json: Value = serde_json::from_str(&files(&sweep, &subject())[1].content).unwrap();
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&json["model"], &json["limit_seconds"]), (&json!("a<b>.glb"), &json!(60)));
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), sweep.rows.len());
    assert_eq!(rows[3]["measured"]["times"]["samples"].as_array().unwrap().len(), 9);
    assert_eq!(rows[0]["settings"]["capture"]["kind"], "compacted");
    assert!(rows.last().unwrap()["failed"].as_str().is_some());
}

#[test]
fn the_page_stands_alone_and_escapes() {
    let html = &files(&hand_made(), &subject())[2].content;
    assert!(html.contains("a&lt;b&gt;.glb") && html.contains("does not fit &lt;here&gt;"));
    for outside in ["http://", "https://", "<script", "<link", "url("] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert_eq!(html.matches("<svg").count(), 4);
    assert_eq!(html.matches("<section").count(), html.matches("</section>").count());
    assert!(html.matches("<figure>").count() > 20);
}
