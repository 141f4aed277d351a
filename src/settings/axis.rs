//! Axes along which accuracy is traded for time: declared beside each technique's code, read by the sweep.
//!
//! An axis names a setting and the values worth comparing. A technique that declares its axes joins every accuracy-time
//! report; nothing else has to know of it.

use super::Settings;

/// What an axis turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// A setting, by its path.
    Setting(&'static str),
    /// The size of the picture: values are factors of the size asked for, and the picture is enlarged to that size again
    /// before it is judged.
    Resolution,
}

/// What the values of an axis differ in, and so what their pictures are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// In time alone: every value gives the same picture.
    Cost,
    /// In accuracy. The reference takes this value.
    Accuracy {
        /// The most accurate of the values.
        exact: &'static str,
    },
    /// In how much of what the reference has is kept; the reference needs none of the values.
    Limit,
    /// In what is shown: the reference keeps what the user asked for, and the error is the distance from that.
    Look,
    /// In how densely the scene is sampled: compared with a reference of many samples a pixel.
    Sampling,
}

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name on the command line and in reports; no two axes share one.
    pub name: &'static str,
    /// What it turns.
    pub knob: Knob,
    /// The values compared, as text for [`Settings::set`].
    pub values: &'static [&'static str],
    /// Settings, path and value, without which the axis changes nothing. An opacity model counts as the base of another too.
    pub matters_if: &'static [(&'static str, &'static str)],
    /// What the values differ in.
    pub effect: Effect,
}

impl Axis {
    /// The path of its setting, if it turns one.
    pub fn path(&self) -> Option<&'static str> {
        match self.knob {
            Knob::Setting(path) => Some(path),
            Knob::Resolution => None,
        }
    }

    /// Whether a change along the axis changes anything under these settings.
    pub fn matters(&self, settings: &Settings) -> bool {
        self.matters_if.iter().all(|(path, value)| holds(settings, path, value))
    }
}

/// The axes of one technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Technique {
    /// Its room below `src/passes/`.
    pub room: &'static str,
    /// Its axes.
    pub axes: &'static [Axis],
    /// Names of axes whose values are all combined with each other, besides being varied alone.
    pub crosses: &'static [&'static [&'static str]],
}

/// Whether a setting has a value; the opacity model has that of the base of illustrative transparency too.
pub fn holds(settings: &Settings, path: &str, value: &str) -> bool {
    text_at(settings, path).as_deref() == Some(value)
        || (path == "opacity.model" && settings.opacity.base_model().name() == value)
}

/// The value at a path, as [`Settings::set`] takes it.
pub fn text_at(settings: &Settings, path: &str) -> Option<String> {
    settings.get(path).map(|value| match value {
        toml::Value::String(text) => text,
        other => other.to_string(),
    })
}
