//! What a sweep leaves behind: `sweep.csv`, `sweep.json` and `index.html`.
//!
//! The JSON has everything: adapter and driver, versions, settings, and every sample unrounded. The CSV has a line for each
//! configuration with figures of three digits, and the page, which needs no other file and no network, quotes those.

use serde_json::{Value, json};

use super::page;
use super::sweep::{Row, Sweep};
use super::table::Table;
use crate::gpu::AdapterFacts;

/// Commit of the sources, where the build was told: `PELLUCID_COMMIT` in its environment.
pub const COMMIT: Option<&str> = option_env!("PELLUCID_COMMIT");

/// What was looked at, and on what.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The model, as on the command line.
    pub model: String,
    /// The camera, in words.
    pub camera: String,
    /// Who drew it; `None` in tests without an adapter.
    pub adapter: Option<AdapterFacts>,
    /// The time limit, seconds.
    pub limit_seconds: Option<u64>,
}

/// A file of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// Its name in the folder.
    pub name: &'static str,
    /// What is in it.
    pub content: String,
}

/// Names of the files of a report.
pub const NAMES: [&str; 3] = ["sweep.csv", "sweep.json", "index.html"];

/// The files of a report.
pub fn files(sweep: &Sweep, subject: &Subject) -> Vec<File> {
    let table = Table::of(sweep);
    let json = serde_json::to_string_pretty(&json_of(sweep, subject)).unwrap_or_default() + "\n";
    let contents = [table.csv(), json, page::page(sweep, &table, subject)];
    NAMES.into_iter().zip(contents).map(|(name, content)| File { name, content }).collect()
}

fn json_of(sweep: &Sweep, subject: &Subject) -> Value {
    json!({
        "model": subject.model,
        "camera": subject.camera,
        "size": sweep.size,
        "layer_size": sweep.layer_size,
        "adapter": subject.adapter,
        "pass_timing": subject.adapter.as_ref().map(|a| a.pass_timing()),
        "version": env!("CARGO_PKG_VERSION"),
        "commit": COMMIT,
        "limit_seconds": subject.limit_seconds,
        "seconds": sweep.seconds,
        "reference": sweep.reference,
        "reference_samples": sweep.reference_samples,
        "baseline_samples": sweep.baseline_samples,
        "rows": sweep.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

fn row(row: &Row) -> Value {
    let c = &row.configuration;
    let mut value = json!({
        "configuration": c.name,
        "axis": c.axis,
        "judged_by": c.judge,
        "scale": c.scale,
        "settings": c.settings,
    });
    match &row.outcome {
        Ok(measured) => value["measured"] = json!(measured),
        Err(reason) => value["failed"] = json!(reason),
    }
    value
}

#[cfg(test)]
#[path = "report_tests.rs"]
pub mod tests;
