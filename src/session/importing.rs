//! How a model is read, as far as it can be chosen: in names and numbers that a command line, a configuration file and a
//! session share.
//!
//! Three choices change what is seen and are therefore part of a session: what becomes a part, which material variant, and
//! beyond which angle an edge is sharp where a file has no normals. Limits only decide whether a file is taken at all.

use serde::{Deserialize, Serialize};

use crate::import::{ImportOptions, Limits, PartsBy};
use crate::settings::nearest;

/// What becomes a part, by the names that users write; `auto` is what suits the format.
pub const PARTS: [(&str, Option<PartsBy>); 5] = [
    ("auto", None),
    ("node", Some(PartsBy::Node)),
    ("material", Some(PartsBy::Material)),
    ("component", Some(PartsBy::Component)),
    ("file", Some(PartsBy::File)),
];

/// The name of what becomes a part.
pub fn parts_name(by: Option<PartsBy>) -> &'static str {
    PARTS.iter().find(|(_, p)| *p == by).map_or(PARTS[0].0, |(name, _)| name)
}

/// Reads what becomes a part.
///
/// # Errors
/// A sentence with the names that there are, and the nearest.
pub fn parts_named(text: &str) -> Result<Option<PartsBy>, String> {
    let found = PARTS.iter().find(|(name, _)| *name == text).map(|(_, by)| *by);
    found.ok_or_else(|| {
        let names = PARTS.map(|(name, _)| name);
        let hint = nearest(text, names).map(|n| format!("; did you mean '{n}'?")).unwrap_or_default();
        format!("'{text}': expected one of {}{hint}", names.join(", "))
    })
}

/// What of an import a picture depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Importing {
    /// What becomes a part; `None` is what suits the format.
    #[serde(with = "parts_text", skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartsBy>,
    /// The material variant by name; `None` is the file's default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
    /// Missing normals are smoothed over edges that turn by at most this angle, degrees.
    #[serde(skip_serializing_if = "is_usual")]
    pub crease_angle: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_usual(crease_angle: &f64) -> bool {
    *crease_angle == Importing::default().crease_angle
}

mod parts_text {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    use super::{PartsBy, parts_name, parts_named};

    #[expect(clippy::ref_option, reason = "serde asks with a reference")]
    pub(super) fn serialize<S: Serializer>(by: &Option<PartsBy>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(parts_name(*by))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<PartsBy>, D::Error> {
        parts_named(&String::deserialize(from)?).map_err(D::Error::custom)
    }
}

impl Default for Importing {
    fn default() -> Importing {
        let ImportOptions { parts, variant, crease_angle, .. } = ImportOptions::default();
        Importing { parts, variant, crease_angle }
    }
}

impl Importing {
    /// Import options with these choices, everything else as in `base`.
    #[must_use]
    pub fn options(&self, base: &ImportOptions) -> ImportOptions {
        ImportOptions {
            parts: self.parts,
            variant: self.variant.clone(),
            crease_angle: self.crease_angle,
            ..base.clone()
        }
    }

    /// The choices in import options.
    pub fn of(options: &ImportOptions) -> Importing {
        Importing { parts: options.parts, variant: options.variant.clone(), crease_angle: options.crease_angle }
    }

    /// The choices as options of the command line, name and value. Left out is what they are without any option, whether a
    /// configuration says `configured` or there is none.
    pub fn words(&self, configured: &Importing) -> Vec<(&'static str, String)> {
        let usual = Importing::default();
        let said = |differs: bool, word: &'static str, value: String| differs.then_some((word, value));
        let parts = self.parts != usual.parts || self.parts != configured.parts;
        let parts = said(parts, "parts", parts_name(self.parts).to_owned());
        let variant = self.variant.clone().map(|name| ("variant", name));
        let angle = self.crease_angle != usual.crease_angle || self.crease_angle != configured.crease_angle;
        let angle = said(angle, "crease-angle", self.crease_angle.to_string());
        [parts, variant, angle].into_iter().flatten().collect()
    }
}

/// Reads a crease angle, degrees.
///
/// # Errors
/// A sentence with the range.
pub fn crease_angle(text: &str) -> Result<f64, String> {
    let angle = text.parse::<f64>().ok().filter(|a| (0.0..=180.0).contains(a));
    angle.ok_or_else(|| "expected degrees from 0 to 180".to_owned())
}

/// One of the [`Limits`], by name.
pub struct Limit {
    /// As the field is called.
    pub name: &'static str,
    /// What it is.
    pub help: &'static str,
    get: fn(&Limits) -> u64,
    set: fn(&mut Limits, u64) -> Option<()>,
}

macro_rules! limits {
    ($($name:ident: $help:literal,)*) => {
        [$(Limit {
            name: stringify!($name),
            help: $help,
            get: |l| u64::from(l.$name),
            set: |l, value| {
                l.$name = value.try_into().ok()?;
                Some(())
            },
        }),*]
    };
}

/// All limits.
pub const LIMITS: &[Limit] = &limits! {
    bytes: "bytes of one file, and of all buffers of a model together",
    vertices: "elements of one accessor, and vertices of all primitives together",
    triangles: "triangles of all meshes together",
    image_side: "width and height of an image, pixels",
    image_pixels: "pixels of all images together",
    node_depth: "levels of the node hierarchy",
    instances: "instances that EXT_mesh_gpu_instancing makes, all nodes together",
    parts: "parts into which materials or connected components divide a model",
    converter_seconds: "seconds that a converter may take",
};

impl Limit {
    /// Its value.
    pub fn get(&self, limits: &Limits) -> u64 {
        (self.get)(limits)
    }

    /// Sets it.
    ///
    /// # Errors
    /// A sentence for a number that it cannot hold.
    pub fn set(&self, limits: &mut Limits, value: u64) -> Result<(), String> {
        (self.set)(limits, value).ok_or_else(|| format!("{} = {value}: at most {} is held", self.name, u32::MAX))
    }

    /// The limit of a name.
    ///
    /// # Errors
    /// A sentence with the names that there are, and the nearest.
    pub fn named(name: &str) -> Result<&'static Limit, String> {
        LIMITS.iter().find(|l| l.name == name).ok_or_else(|| {
            let names: Vec<&str> = LIMITS.iter().map(|l| l.name).collect();
            let hint = nearest(name, names.iter().copied()).map(|n| format!("; did you mean '{n}'?"));
            format!("no limit is called '{name}'; there are {}{}", names.join(", "), hint.unwrap_or_default())
        })
    }
}

/// Reads a count: a whole number, with k, M, G or T behind it for steps of 1024.
///
/// # Errors
/// A sentence with the form.
pub fn count(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'M')) => (&text[..at], 20),
        Some((at, 'G')) => (&text[..at], 30),
        Some((at, 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let whole = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse::<u64>().ok()).flatten();
    whole
        .and_then(|n| n.checked_mul(1 << shift))
        .ok_or_else(|| format!("'{text}': expected a whole number, as in 4096, 512M or 4G (steps of 1024)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit that is added to the importer but not here would have no name on the command line.
    #[test]
    fn every_limit_has_a_name() {
        let text = format!("{:?}", Limits::default());
        let fields: Vec<&str> = text
            .trim_start_matches("Limits {")
            .trim_end_matches('}')
            .split(',')
            .filter_map(|pair| Some(pair.split_once(':')?.0.trim()))
            .collect();
        assert!(fields.len() >= 6, "{text}");
        assert_eq!(LIMITS.iter().map(|l| l.name).collect::<Vec<_>>(), fields);
        for limit in LIMITS {
            let mut limits = Limits::default();
            limit.set(&mut limits, 7).unwrap();
            assert_eq!(limit.get(&limits), 7, "{}", limit.name);
            assert_ne!(limits, Limits::default());
        }
        assert!(Limit::named("image_side").unwrap().set(&mut Limits::default(), 1 << 40).is_err());
        let said = Limit::named("bites").err().unwrap();
        assert!(said.contains("did you mean 'bytes'") && said.contains("node_depth"), "{said}");
    }

    #[test]
    fn counts_have_steps_of_1024_and_nothing_else() {
        for (text, number) in
            [("0", 0), ("512M", 512 << 20), ("4G", 4 << 30), ("16k", 16 << 10), ("1T", 1 << 40), ("77", 77)]
        {
            assert_eq!(count(text), Ok(number), "{text}");
        }
        for bad in ["", "M", "-1", "+1", "1.5G", "4 G", "4g", "99999999999T", "1MM", "é"] {
            assert!(count(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn choices_are_written_where_they_are_not_as_usual() {
        let usual = Importing::default();
        assert_eq!(toml::to_string(&usual).unwrap(), "");
        assert!(usual.words(&usual).is_empty());
        let other = Importing {
            parts: Some(PartsBy::Component),
            variant: Some("midnight blue".to_owned()),
            crease_angle: 1.0 / 3.0,
        };
        let text = toml::to_string(&other).unwrap();
        assert!(text.contains("parts = \"component\""), "{text}");
        assert_eq!(toml::from_str::<Importing>(&text).unwrap(), other);
        assert_eq!(Importing::of(&other.options(&ImportOptions::default())), other);
        let names: Vec<&str> = other.words(&usual).iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["parts", "variant", "crease-angle"]);
        // Under a configuration that says something else, what is as usual has to be said too.
        assert_eq!(usual.words(&other)[0], ("parts", "auto".to_owned()));
        let said = toml::from_str::<Importing>("parts = 'nodes'").unwrap_err().to_string();
        assert!(said.contains("did you mean 'node'"), "{said}");
        for (name, by) in PARTS {
            assert_eq!((parts_name(by), parts_named(name)), (name, Ok(by)));
        }
    }
}
