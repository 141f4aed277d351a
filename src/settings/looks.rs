//! Looks: presets that set more than a transfer function. The transfer functions inside the program count as presets too.

use super::{OpacityModel, Settings, SettingsError, nearest};
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
        name: "pellucid",
        description: "Shape by curvature, depth order by silhouettes and halos that narrow on what is small. What is drawn \
                      unless something else is asked for.",
        toml: "opacity = { model = 'illustrative', gain = 1.0, transfer = 'pellucid', illustrative = { base = 'curvature', \
               base_gain = 0.6, unit = 'view', iterations = 20, feature_size = 24, printed = 'none', \
               alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.05, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.2, profile = 'none', p = 1.0, strength = 1.0 } } }",
    },
    Look {
        name: "curvature",
        description: "Shape alone: colour and opacity by curvature.",
        toml: "opacity = { model = 'curvature', gain = 1.0, transfer = 'pellucid' }",
    },
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
    Look {
        name: "figure-9-heat",
        description: "Carnecky 2013, figure 9: silhouettes and halos that spread as heat (equation 8), 50 iterations.",
        toml: "opacity = { model = 'illustrative', adaptive = 0.7, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 50, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'heat', lambda = 0.9, profile = 'none', strength = 1.0 }, \
               gamma = { diffusion = 'heat', lambda = 0.9, profile = 'none', strength = 1.0 } } }",
    },
    Look {
        name: "figure-9-max",
        description: "Figure 9: by max-propagation (equation 9), falling off evenly.",
        toml: "opacity = { model = 'illustrative', adaptive = 0.7, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 20, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.05, profile = 'none', strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.1, profile = 'none', strength = 1.0 } } }",
    },
    Look {
        name: "figure-9-bell",
        description: "Figure 9: by max-propagation, then a bell (equation 10).",
        toml: "opacity = { model = 'illustrative', adaptive = 0.7, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 20, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.05, profile = 'bell', p = 4.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.1, profile = 'bell', p = 4.0, strength = 1.0 } } }",
    },
    Look {
        name: "figure-9-power",
        description: "Figure 9: by max-propagation, then a power (equation 11).",
        toml: "opacity = { model = 'illustrative', adaptive = 0.7, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 20, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.05, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.1, profile = 'power', p = 2.0, strength = 1.0 } } }",
    },
    Look {
        name: "figure-10",
        description: "Figure 10: wide halos on white, for a close look.",
        toml: "image = { background = '#ffffff' }
               opacity = { model = 'illustrative', constant = 0.3, illustrative = { base = 'constant', base_gain = 1.0, unit = 'pixel', \
               iterations = 30, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.03, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.06, profile = 'bell', p = 2.0, strength = 1.0 } } }",
    },
    Look {
        name: "figure-11",
        description: "Figure 11(e): on white, over a constant opacity.",
        toml: "image = { background = '#ffffff' }
               opacity = { model = 'illustrative', constant = 0.3, illustrative = { base = 'constant', base_gain = 1.0, unit = 'pixel', \
               iterations = 20, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.03, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.1, profile = 'none', strength = 1.0 } } }",
    },
    Look {
        name: "figure-12",
        description: "Figure 12: flow surfaces on white; where many sheets lie over each other each is clearer.",
        toml: "image = { background = '#ffffff' }
               opacity = { model = 'illustrative', adaptive = 0.8, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 50, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.04, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'max', lambda = 0.12, profile = 'bell', p = 2.0, strength = 1.0 } } }",
    },
    Look {
        name: "figure-13",
        description: "Figure 13(c): an engine on white; so many silhouettes want no halos.",
        toml: "image = { background = '#ffffff' }
               opacity = { model = 'illustrative', adaptive = 0.6, illustrative = { base = 'adaptive', base_gain = 1.0, unit = 'pixel', \
               iterations = 20, feature_size = 0, alpha = { diffusion = 'heat', lambda = 0.9 }, \
               beta = { diffusion = 'max', lambda = 0.08, profile = 'power', p = 2.0, strength = 1.0 }, \
               gamma = { diffusion = 'none', strength = 0.0 } } }",
    },
];

/// Why a preset could not be applied.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// There is none of that name.
    #[error("no preset is called '{name}'; there are {known}{}", nearest.map(|n| format!("; did you mean '{n}'?")).unwrap_or_default())]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names that exist, separated by commas.
        known: String,
        /// The closest of them.
        nearest: Option<&'static str>,
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
    let is_look = |name: &str| LOOKS.iter().any(|l| l.name == name);
    let functions = transfer::presets().into_iter().map(|p| (p.name, p.description)).filter(move |(n, _)| !is_look(n));
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
        let nearest = nearest(name, known.iter().copied());
        return Err(LookError::Unknown { name: name.to_owned(), known: known.join(", "), nearest });
    }
    settings.opacity.model = OpacityModel::Curvature;
    settings.opacity.transfer = TransferSource::Named(name.to_owned());
    Ok(())
}

/// The five opacity models of Carnecky 2013, Figure 11, everything else as it is: name and settings. The last is illustrative
/// transparency as it is set.
pub fn opacity_models(settings: &Settings) -> [(&'static str, Settings); 5] {
    [
        ("opaque", OpacityModel::Opaque),
        ("constant", OpacityModel::Constant),
        ("angle-based", OpacityModel::AngleBased),
        ("normal variation", OpacityModel::NormalVariation),
        ("illustrative", OpacityModel::Illustrative),
    ]
    .map(|(name, model)| {
        let mut settings = settings.clone();
        settings.opacity.model = model;
        (name, settings)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pellucid_is_what_is_drawn_unless_something_else_is_asked_for() {
        let mut settings = Settings::default();
        for figure in ["figure-9-bell", "figure-12", "figure-13"] {
            apply(&mut settings, figure).unwrap();
        }
        settings.image = Default::default();
        settings.opacity.adaptive = Settings::default().opacity.adaptive;
        apply(&mut settings, "pellucid").unwrap();
        assert_eq!(settings, Settings::default());
    }

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
