//! Looks: presets that set more than a transfer function. The transfer functions inside the program count as presets too.

use super::{OpacityModel, Settings, SettingsError};
use crate::transfer::{self, TransferSource};

/// A preset that is more than a transfer function.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Its name.
    pub name: &'static str,
    /// What it is for.
    pub description: &'static str,
    /// What it sets, as a settings file.
    toml: &'static str,
}

/// Presets of the program itself.
pub const LOOKS: &[Look] = &[
    Look {
        name: "plain",
        description: "Plain transparency: every layer 0.3 opaque, exactly sorted. Needs no curvature.",
        toml: "opacity = { model = 'constant', constant = 0.3 }",
    },
    Look { name: "opaque", description: "Only what is in front.", toml: "opacity = { model = 'opaque' }" },
    Look {
        name: "paper",
        description: "Murray 2016 as printed: 16 layers under 32-bit keys, depth's curvature over the next pixels, \
                      figures 6(a) and 7(a).",
        toml: "
            capture = { kind = 'bucketed_k_buffer', normals = 'xy15', bucketed_k_buffer = { k = 16, key = 'packed32' } }
            features.curvature = { kind = 'view_centred', radius = 0.0, crease_angle = 180.0, line_width = 0.0 }
            opacity = { model = 'curvature', transfer = 'murray-6a-7a' }",
    },
];

/// Why a preset could not be applied.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// There is none of that name.
    #[error("no preset is called '{name}'; there are {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names that exist, separated by commas.
        known: String,
    },
    /// The preset does not fit the settings; a test keeps this from happening.
    #[error("{name}: {source}")]
    Broken {
        /// Which one.
        name: &'static str,
        /// What is wrong with it.
        source: SettingsError,
    },
}

/// Names and descriptions of all presets: looks, then transfer functions.
pub fn presets() -> impl Iterator<Item = (&'static str, &'static str)> {
    let functions = transfer::presets().into_iter().map(|p| (p.name, p.description));
    LOOKS.iter().map(|l| (l.name, l.description)).chain(functions)
}

/// Sets what the preset `name` says; everything else stays.
///
/// # Errors
/// [`LookError`] for an unknown name.
pub fn apply(settings: &mut Settings, name: &str) -> Result<(), LookError> {
    if let Some(look) = LOOKS.iter().find(|l| l.name == name) {
        let broken = |source| LookError::Broken { name: look.name, source };
        let table = toml::from_str(look.toml).map_err(|e| broken(SettingsError::Syntax(e.to_string())))?;
        return settings.merge(&table).map_err(broken);
    }
    if !transfer::names().contains(&name) {
        let known: Vec<&str> = presets().map(|(name, _)| name).collect();
        return Err(LookError::Unknown { name: name.to_owned(), known: known.join(", ") });
    }
    settings.opacity.model = OpacityModel::Curvature;
    settings.opacity.transfer = TransferSource::Named(name.to_owned());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_applies_and_strangers_are_refused() {
        let names: Vec<&str> = presets().map(|(name, _)| name).collect();
        assert!(names.len() > LOOKS.len() && names.contains(&"x-ray"), "{names:?}");
        for name in names {
            let mut settings = Settings::default();
            apply(&mut settings, name).unwrap_or_else(|e| panic!("{e}"));
        }
        let error = apply(&mut Settings::default(), "glass").unwrap_err().to_string();
        assert!(error.contains("'glass'") && error.contains("paper") && error.contains("x-ray"), "{error}");
    }
}
