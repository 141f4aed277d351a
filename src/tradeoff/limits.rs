//! Limits on errors, for continuous integration: a file that says how wrong which configuration may be.
//!
//! ```toml
//! ["as asked"]            # a configuration by its name, or * for all
//! maximum_steps = 1       # a column of the CSV; larger is a failure
//! ["key=packed32, k=16"]  # what its axes need may be left out
//! merged_percent = 2
//! ```
//!
//! Times are no errors: their columns are refused, so that a busy machine fails nothing.

use super::axis::Configuration;
use super::sweep::Sweep;
use super::table::{COLUMNS, Table};

/// Columns that may be limited.
const ERRORS: &[&str] = &[
    "maximum_steps",
    "mean_steps",
    "over_1_step_percent",
    "over_8_steps_percent",
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
    /// There is nothing to judge by.
    #[error("no limit is given")]
    Empty,
    /// A limit on an error that none of its configurations has.
    #[error("['{configuration}'] {column}: none of its configurations has this error")]
    NotApplicable {
        /// The table it stands in.
        configuration: String,
        /// The name.
        column: &'static str,
    },
    /// A limit for a configuration that the sweep does not have.
    #[error("no configuration is called '{name}'; there are '*', {known}")]
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
        if limits.is_empty() { Err(LimitsError::Empty) } else { Ok(Limits(limits)) }
    }

    /// Checks before any work that every configuration that is named will be measured.
    ///
    /// # Errors
    /// [`LimitsError::Configuration`].
    pub fn check_names(&self, configurations: &[Configuration]) -> Result<(), LimitsError> {
        for Limit { configuration: name, .. } in &self.0 {
            if name != "*" && !configurations.iter().any(|c| c.name == *name || c.short == *name) {
                let known: Vec<String> = configurations.iter().map(|c| format!("'{}'", c.name)).collect();
                return Err(LimitsError::Configuration { name: name.clone(), known: known.join(", ") });
            }
        }
        Ok(())
    }

    /// Judges a sweep. `*` passes over configurations that the adapter refuses, or that do not have the error.
    ///
    /// # Errors
    /// [`LimitsError::NotApplicable`] for a limit that judges nothing, [`LimitsError::Configuration`].
    pub fn judge(&self, sweep: &Sweep) -> Result<Judgement, LimitsError> {
        debug_assert!(ERRORS.iter().all(|e| COLUMNS.iter().any(|(name, _)| name == e)));
        self.check_names(&sweep.rows.iter().map(|r| r.configuration.clone()).collect::<Vec<_>>())?;
        let table = Table::of(sweep);
        let mut judgement = Judgement::default();
        for limit in &self.0 {
            let all = limit.configuration == "*";
            let is_meant = |row: &super::sweep::Row| {
                all || row.configuration.name == limit.configuration || row.configuration.short == limit.configuration
            };
            let mut applied = false;
            for (i, row) in sweep.rows.iter().enumerate().filter(|(_, row)| is_meant(row)) {
                let name = &row.configuration.name;
                match (&row.outcome, table.number(i, limit.column)) {
                    (Ok(_), Some(value)) => {
                        applied = true;
                        judgement.checked += 1;
                        if value > limit.most {
                            let cell = table.cell(i, limit.column);
                            judgement
                                .violations
                                .push(format!("{name}: {} = {cell}, limit {}", limit.column, limit.most));
                        }
                    }
                    (Err(reason), _) if !all => {
                        applied = true;
                        judgement.violations.push(format!("{name}: {} is not known: {reason}", limit.column));
                    }
                    _ => {}
                }
            }
            if !applied {
                let Limit { configuration, column, .. } = limit.clone();
                return Err(LimitsError::NotApplicable { configuration, column });
            }
        }
        Ok(judgement)
    }
}

/// What came of limits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// Figures that were compared with a limit.
    pub checked: usize,
    /// What is over its limit, or could not be judged because its configuration was named and not measured, a sentence each.
    pub violations: Vec<String>,
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
            ("", "no limit is given"),
            ("['*']", "no limit is given"),
        ] {
            let e = Limits::from_toml(text).unwrap_err().to_string();
            assert!(e.contains(words), "{e}");
        }
    }

    #[test]
    fn what_is_over_its_limit_is_named() {
        let sweep = hand_made();
        let judge = |text: &str| Limits::from_toml(text).unwrap().judge(&sweep);
        let check = |text: &str| judge(text).map(|j| j.violations);
        assert_eq!(check("['as asked']\nmaximum_steps = 0\nlost = 0").unwrap(), [] as [&str; 0]);
        let over = check("['key=packed32, k=16']\nmerged_percent = 0.5\nmean_steps = 200").unwrap();
        assert_eq!(over.len(), 1, "{over:?}");
        assert!(over[0].contains("merged_percent = 0.8, limit 0.5"), "{over:?}");
        assert!(!check("['*']\nmean_steps = 0.001").unwrap().is_empty());
        let refused = check("['k=64']\nlost = 0").unwrap();
        assert!(refused[0].contains("does not fit"), "{refused:?}");
        assert_eq!(check("['*']\nmaximum_steps = 255").unwrap(), [] as [&str; 0], "what is refused is passed over");
        assert!(judge("['*']\nmean_steps = 255").unwrap().checked > 2, "what was compared is counted");
        let e = check("['k=65']\nlost = 0").unwrap_err().to_string();
        assert!(e.contains("k=65") && e.contains("as asked"), "{e}");
    }
}
