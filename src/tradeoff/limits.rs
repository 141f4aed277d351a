//! Limits on errors, for continuous integration: a file that says how wrong which configuration may be.
//!
//! ```toml
//! ["as asked"]            # a configuration by its name, or * for all
//! maximum_steps = 0       # a column of the CSV; larger is a failure
//! ["key=packed32, k=16"]  # what its axes need may be left out
//! merged_percent = 2
//! ```
//!
//! Times are no errors: their columns are refused, so that a busy machine fails nothing.

use super::sweep::Sweep;
use super::table::{COLUMNS, Table};

/// Columns that may be limited.
const ERRORS: &[&str] = &[
    "maximum_steps",
    "mean_steps",
    "above_1_percent",
    "above_8_percent",
    "flip_mean",
    "flip_p99",
    "lost",
    "merged",
    "out_of_order",
    "extra",
    "lost_percent",
    "merged_percent",
    "out_of_order_percent",
    "neighbours_different_percent",
    "kappa_p95",
    "opacity_p95",
];

/// One limit.
#[derive(Clone, Debug, PartialEq)]
struct Limit {
    configuration: String,
    column: &'static str,
    most: f64,
}

/// The limits of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits(Vec<Limit>);

/// Why a file of limits cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LimitsError {
    /// It is no TOML, or not tables of numbers.
    #[error("{0}")]
    Syntax(String),
    /// A limit on something that is no error.
    #[error("['{configuration}'] {column}: no error is called that; there are {}", ERRORS.join(", "))]
    Column {
        /// The table it stands in.
        configuration: String,
        /// The name.
        column: String,
    },
    /// A limit for a configuration that the sweep does not have.
    #[error("no configuration is called '{name}'; there are *, {known}")]
    Configuration {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
}

impl Limits {
    /// Reads a file.
    ///
    /// # Errors
    /// [`LimitsError`] for bad syntax and unknown columns.
    pub fn from_toml(text: &str) -> Result<Limits, LimitsError> {
        let tables: toml::Table = toml::from_str(text).map_err(|e| LimitsError::Syntax(e.to_string()))?;
        let mut limits = Vec::new();
        for (configuration, table) in tables {
            let toml::Value::Table(table) = table else {
                return Err(LimitsError::Syntax(format!("'{configuration}': expected a table of limits")));
            };
            for (column, value) in table {
                let Some(known) = ERRORS.iter().copied().find(|e| *e == column) else {
                    return Err(LimitsError::Column { configuration, column });
                };
                let most = value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
                let most = most.filter(|m| *m >= 0.0).ok_or_else(|| {
                    LimitsError::Syntax(format!(
                        "['{configuration}'] {column} = {value}: expected a number, at least 0"
                    ))
                })?;
                limits.push(Limit { configuration: configuration.clone(), column: known, most });
            }
        }
        Ok(Limits(limits))
    }

    /// What is over its limit, or could not be judged because its configuration was named and not measured, a sentence each.
    /// `*` passes over configurations that the adapter refuses.
    ///
    /// # Errors
    /// [`LimitsError::Configuration`].
    pub fn violations(&self, sweep: &Sweep) -> Result<Vec<String>, LimitsError> {
        debug_assert!(ERRORS.iter().all(|e| COLUMNS.iter().any(|(name, _)| name == e)));
        let table = Table::of(sweep);
        let mut found = Vec::new();
        for limit in &self.0 {
            let all = limit.configuration == "*";
            let is_meant = |row: &super::sweep::Row| {
                all || row.configuration.name == limit.configuration || row.configuration.short == limit.configuration
            };
            let mut any = false;
            for (i, row) in sweep.rows.iter().enumerate().filter(|(_, row)| is_meant(row)) {
                any = true;
                let name = &row.configuration.name;
                match (&row.outcome, table.number(i, limit.column)) {
                    (_, Some(value)) if value > limit.most => {
                        found.push(format!(
                            "{name}: {} = {}, limit {}",
                            limit.column,
                            table.cell(i, limit.column),
                            limit.most
                        ));
                    }
                    (Err(reason), _) if !all => found.push(format!("{name}: {} is not known: {reason}", limit.column)),
                    (Ok(_), None) if !all => found.push(format!("{name}: {} does not apply to it", limit.column)),
                    _ => {}
                }
            }
            if !any {
                let known = sweep.rows.iter().map(|r| r.configuration.name.as_str()).collect::<Vec<_>>().join("; ");
                return Err(LimitsError::Configuration { name: limit.configuration.clone(), known });
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::report::tests::hand_made;

    #[test]
    fn limits_are_on_errors_and_never_on_time() {
        assert!(ERRORS.iter().all(|e| COLUMNS.iter().any(|(name, _)| name == e)));
        for (text, words) in [
            ("['*']\ntime_ms = 3", "time_ms"),
            ("['*']\nlost = -1", "at least 0"),
            ("lost = 1", "expected a table"),
            ("['*", ""),
        ] {
            let e = Limits::from_toml(text).unwrap_err().to_string();
            assert!(e.contains(words), "{e}");
        }
    }

    #[test]
    fn what_is_over_its_limit_is_named() {
        let sweep = hand_made();
        let check = |text: &str| Limits::from_toml(text).unwrap().violations(&sweep);
        assert_eq!(check("['as asked']\nmaximum_steps = 0\nlost = 0").unwrap(), [] as [&str; 0]);
        let over = check("['key=packed32, k=16']\nmerged_percent = 0.5\nmean_steps = 200").unwrap();
        assert_eq!(over.len(), 1, "{over:?}");
        assert!(over[0].contains("merged_percent = 0.8, limit 0.5"), "{over:?}");
        assert!(!check("['*']\nmean_steps = 0.001").unwrap().is_empty());
        let refused = check("['k=64']\nlost = 0").unwrap();
        assert!(refused[0].contains("does not fit"), "{refused:?}");
        assert_eq!(check("['*']\nmaximum_steps = 255").unwrap(), [] as [&str; 0], "what is refused is passed over");
        let e = check("['k=65']\nlost = 0").unwrap_err().to_string();
        assert!(e.contains("k=65") && e.contains("as asked"), "{e}");
    }
}
