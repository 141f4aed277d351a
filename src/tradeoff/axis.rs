//! From axes to configurations: one axis varied at a time around what the user asked for, and the crosses that techniques
//! declare.

use crate::passes::TECHNIQUES;
use crate::settings::{Axis, Effect, Knob, Settings, SettingsError, holds, text_at};

/// Name of the configuration that the user asked for.
pub const AS_ASKED: &str = "as asked";

/// What a configuration is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judge {
    /// The reference with the same samples.
    Exact,
    /// The reference with many samples.
    Supersampled,
}

/// One thing to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// What differs from what was asked for, as `axis=value`, by commas; [`AS_ASKED`] if nothing does.
    pub name: String,
    /// The name without what the varied axes need to matter.
    pub short: String,
    /// The axis that is varied; those of a cross joined by ` × `.
    pub axis: String,
    /// The settings.
    pub settings: Settings,
    /// Factor of the size of the picture.
    pub scale: f64,
    /// What it is compared with.
    pub judge: Judge,
}

/// All axes of all techniques.
pub fn all() -> Vec<Axis> {
    TECHNIQUES.iter().flat_map(|t| t.axes.iter().copied()).collect()
}

/// An axis was asked for that no technique declares.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    /// No axis has this name.
    #[error("no axis is called '{name}'; there are {known}")]
    Unknown {
        /// The name that was given.
        name: String,
        /// All names.
        known: String,
    },
    /// An axis names a value that its setting does not have.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}

/// The axes with these names, all if there are none.
///
/// # Errors
/// [`AxisError::Unknown`].
pub fn named(names: &[String]) -> Result<Vec<Axis>, AxisError> {
    let all = all();
    let known = || all.iter().map(|a| a.name).collect::<Vec<_>>().join(", ");
    if let Some(name) = names.iter().find(|n| all.iter().all(|a| a.name != n.as_str())) {
        return Err(AxisError::Unknown { name: name.clone(), known: known() });
    }
    Ok(all.iter().copied().filter(|a| names.is_empty() || names.iter().any(|n| n == a.name)).collect())
}

/// A configuration in the making: settings, scale and what was chosen by name.
#[derive(Clone)]
struct Draft {
    settings: Settings,
    scale: f64,
    chosen: Vec<Choice>,
}

/// A value that a draft took.
#[derive(Clone)]
struct Choice {
    axis: &'static str,
    value: String,
    /// Whether another axis needed it.
    implied: bool,
}

impl Draft {
    /// Takes a value, after what it needs to matter; `None` if that is no technical choice but one of look.
    fn take(mut self, axis: &Axis, value: &str) -> Result<Option<Draft>, SettingsError> {
        for (path, needed) in axis.matters_if {
            if holds(&self.settings, path, needed) {
                continue;
            }
            let Some(other) = all().into_iter().find(|a| a.path() == Some(path)) else { return Ok(None) };
            self.settings.set(path, needed)?;
            self.chosen.retain(|c| c.axis != other.name);
            self.chosen.push(Choice { axis: other.name, value: (*needed).to_owned(), implied: true });
        }
        match axis.knob {
            Knob::Setting(path) => self.settings.set(path, value)?,
            Knob::Resolution => self.scale = value.parse().unwrap_or(1.0),
        }
        self.chosen.retain(|c| c.axis != axis.name);
        self.chosen.push(Choice { axis: axis.name, value: value.to_owned(), implied: false });
        Ok(Some(self))
    }

    fn finish(self, axis: String, judge: Judge) -> Configuration {
        let text = |with_implied: bool| {
            let chosen = self.chosen.iter().filter(|c| with_implied || !c.implied);
            chosen.map(|c| format!("{}={}", c.axis, c.value)).collect::<Vec<_>>().join(", ")
        };
        Configuration { name: text(true), short: text(false), axis, settings: self.settings, scale: self.scale, judge }
    }
}

/// The configurations of a sweep around `base` along `axes`, the baseline first, none twice.
///
/// # Errors
/// [`AxisError::Settings`] if a declaration is wrong; a test excludes that.
pub fn configurations(base: &Settings, axes: &[Axis]) -> Result<Vec<Configuration>, AxisError> {
    let start = || Draft { settings: base.clone(), scale: 1.0, chosen: Vec::new() };
    let baseline = Configuration {
        name: AS_ASKED.to_owned(),
        short: AS_ASKED.to_owned(),
        ..start().finish(String::new(), Judge::Exact)
    };
    let mut found = vec![baseline];
    let mut add = |configuration: Configuration| {
        let same = |c: &Configuration| {
            c.judge == configuration.judge && c.scale == configuration.scale && c.settings == configuration.settings
        };
        if !found.iter().any(same) {
            found.push(configuration);
        }
    };
    // First, so that what a cross and a single axis both make has the fuller name.
    for cross in TECHNIQUES.iter().flat_map(|t| t.crosses) {
        let members: Vec<&Axis> = cross.iter().filter_map(|n| axes.iter().find(|a| a.name == *n)).collect();
        if members.len() < cross.len() {
            continue;
        }
        let mut drafts = vec![start()];
        for axis in members {
            let mut next = Vec::new();
            for draft in drafts {
                for value in axis.values {
                    next.extend(draft.clone().take(axis, value)?);
                }
            }
            drafts = next;
        }
        drafts.into_iter().for_each(|d| add(d.finish(cross.join(" × "), Judge::Exact)));
    }
    for axis in axes {
        let judge = if axis.effect == Effect::Sampling { Judge::Supersampled } else { Judge::Exact };
        let own = axis.path().and_then(|path| text_at(base, path)).filter(|_| judge == Judge::Supersampled);
        for value in own.iter().map(String::as_str).chain(axis.values.iter().copied()) {
            if let Some(draft) = start().take(axis, value)? {
                add(draft.finish(axis.name.to_owned(), judge));
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_names_settings_and_values_that_exist() {
        for axis in all() {
            assert!(!axis.values.is_empty() && !axis.name.contains([' ', ',', '=']), "{}", axis.name);
            for value in axis.values {
                match axis.knob {
                    Knob::Setting(path) => Settings::default().set(path, value).unwrap_or_else(|e| panic!("{e}")),
                    Knob::Resolution => assert!(value.parse::<f64>().is_ok_and(|s| s > 0.0 && s <= 1.0), "{value}"),
                }
            }
            for (path, value) in axis.matters_if {
                Settings::default().set(path, value).unwrap_or_else(|e| panic!("{}: {e}", axis.name));
            }
            if let Effect::Accuracy { exact } = axis.effect {
                assert!(axis.values.contains(&exact), "{}", axis.name);
            }
        }
        let mut names: Vec<&str> = all().iter().map(|a| a.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all().len(), "two axes share a name");
    }

    #[test]
    fn every_technique_declares_axes_and_every_declaration_is_listed() {
        let rooms = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/passes");
        for technique in TECHNIQUES {
            assert!(!technique.axes.is_empty(), "{}", technique.room);
            let text = std::fs::read_to_string(rooms.join(format!("{}.rs", technique.room))).unwrap();
            assert!(text.contains("pub const AXES"), "{} does not declare its axes itself", technique.room);
            for name in technique.crosses.iter().copied().flatten() {
                assert!(technique.axes.iter().any(|a| a.name == *name), "{}: {name}", technique.room);
            }
        }
        let mut declared = 0;
        let mut folders = vec![rooms];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap().flatten() {
                if entry.path().is_dir() {
                    folders.push(entry.path());
                } else if std::fs::read_to_string(entry.path()).unwrap().contains("pub const AXES: &[Axis]") {
                    declared += 1;
                }
            }
        }
        assert_eq!(declared, TECHNIQUES.len(), "an axis is declared that passes::TECHNIQUES does not list");
    }

    #[test]
    fn configurations_vary_one_axis_at_a_time_and_crosses() {
        let base = Settings::default();
        let found = configurations(&base, &all()).unwrap();
        let names: Vec<&str> = found.iter().map(|c| c.name.as_str()).collect();
        println!("{names:#?}");
        assert_eq!(names[0], AS_ASKED);
        assert!(names.contains(&"normals=xy15") && names.contains(&"capture=bucketed_k_buffer, key=wide64, k=4"));
        assert!(names.contains(&"capture=bucketed_k_buffer, key=packed32, k=32"));
        assert!(names.contains(&"capture=bucketed_k_buffer, key=packed32, depth=z_over_w"));
        assert!(names.contains(&"samples=1") && names.contains(&"resolution=0.5"), "judged by the supersampled one");
        assert!(!names.iter().any(|n| n.contains("normals=octahedral")), "that is as asked");
        for (i, c) in found.iter().enumerate() {
            assert_eq!(names.iter().position(|n| *n == c.name), Some(i), "{} twice", c.name);
        }
        // Without curvature its axes change nothing.
        let mut plain = base;
        plain.set("opacity.model", "constant").unwrap();
        assert!(!configurations(&plain, &all()).unwrap().iter().any(|c| c.axis == "radius" || c.axis == "neighbours"));
    }

    #[test]
    fn axes_are_chosen_by_name() {
        let names = |list: &[&str]| {
            let list: Vec<String> = list.iter().map(|s| (*s).to_owned()).collect();
            named(&list).map(|axes| axes.iter().map(|a| a.name).collect::<Vec<_>>())
        };
        assert_eq!(names(&["key", "k"]).unwrap(), ["k", "key"]);
        assert_eq!(names(&[]).unwrap().len(), all().len());
        let e = names(&["colour"]).unwrap_err().to_string();
        assert!(e.contains("colour") && e.contains("normals"), "{e}");
    }
}
