//! Colour over curvature: 1D.

use std::fmt;

use serde::de::{Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::points::{ControlPoint, Interpolant, Interpolation, Points, check_range};
use super::raster::Raster;

/// How a value of the colour function acts on a lit colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ColorMode {
    /// Below 0.5 towards black (`colour · 2c`), above it towards white (`mix(colour, 1, 2c − 1)`). The default: dark
    /// materials can be brightened too.
    #[default]
    Tint,
    /// `colour · 2c`: up to twice as bright.
    Multiply,
}

impl ColorMode {
    /// `lit` (linear light) as modulated by a value `c` of the colour function; 0.5 leaves it as it is.
    pub fn apply(self, lit: [f32; 3], c: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|i| match self {
            ColorMode::Tint if c[i] >= 0.5 => lit[i] + (1.0 - lit[i]) * (2.0 * c[i] - 1.0),
            _ => lit[i] * (2.0 * c[i]),
        })
    }
}

/// A colour at a curvature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorPoint {
    /// Curvature κ in [−1, 1], −1 convex, +1 concave.
    pub kappa: f64,
    /// The value there, each channel in [0, 1], 0.5 neutral.
    pub color: ColorValue,
}

/// A value of the colour function. In text `0.5` (grey), `[r, g, b]`, or `"#rrggbb"` (each byte over 255, not decoded).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorValue(pub [f64; 3]);

/// Where the values come from.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorShape {
    /// Control points over κ.
    Points {
        /// What lies between them.
        interpolation: Interpolation,
        /// The points.
        points: Points<ColorPoint>,
    },
    /// The first row of an image, from κ = −1 at its left to +1 at its right.
    Strip(Raster),
}

/// Colour over κ. Values lie in [0, 1] with 0.5 neutral; `mode` says how they act on lit colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Text", into = "Text")]
pub struct ColorFunction {
    /// How a value acts.
    pub mode: ColorMode,
    /// Where the values come from.
    pub shape: ColorShape,
}

impl ColorFunction {
    /// Leaves every colour as it is.
    pub fn neutral() -> ColorFunction {
        ColorFunction::uniform([0.5; 3])
    }

    /// The same value everywhere, clamped to [0, 1].
    pub fn uniform(value: [f64; 3]) -> ColorFunction {
        let color = ColorValue(value.map(|v| if v.is_nan() { 0.5 } else { v.clamp(0.0, 1.0) }));
        let points = Points::one(ColorPoint { kappa: 0.0, color });
        ColorFunction {
            mode: ColorMode::Tint,
            shape: ColorShape::Points { interpolation: Interpolation::Step, points },
        }
    }

    /// The value at `kappa`, clamped to [−1, 1]. Neutral for a strip that has not been loaded.
    pub fn sample(&self, kappa: f64) -> [f64; 3] {
        self.sampler()(kappa)
    }

    /// [`ColorFunction::sample`] for many places: what they have in common is computed once.
    pub fn sampler(&self) -> Box<dyn Fn(f64) -> [f64; 3] + '_> {
        match &self.shape {
            ColorShape::Points { interpolation, points } => {
                let channels: [Interpolant; 3] = std::array::from_fn(|c| {
                    let values = points.as_slice().iter().map(|p| p.color.0[c]).collect();
                    Interpolant::new(points.positions(), values, *interpolation)
                });
                Box::new(move |kappa| std::array::from_fn(|c| channels[c].at(kappa)))
            }
            ColorShape::Strip(raster) => {
                Box::new(move |kappa| raster.sample([kappa * 0.5 + 0.5, 1.0]).unwrap_or([0.5; 3]))
            }
        }
    }
}

impl ControlPoint for ColorPoint {
    const AXIS: &'static str = "kappa";
    fn position(&self) -> f64 {
        self.kappa
    }
    fn check(&self) -> Result<(), String> {
        check_range("kappa", self.kappa, -1.0, 1.0)?;
        self.color.0.iter().try_for_each(|&c| check_range("color", c, 0.0, 1.0))
    }
}

impl Serialize for ColorValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            [r, g, b] if r == g && g == b => serializer.serialize_f64(r),
            rgb => rgb.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for ColorValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ColorValue, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = ColorValue;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a colour: a grey number, [r, g, b] or \"#rrggbb\"")
            }
            fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<ColorValue, E> {
                Ok(ColorValue([v; 3]))
            }
            fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<ColorValue, E> {
                Ok(ColorValue([v as f64; 3]))
            }
            fn visit_u64<E: serde::de::Error>(self, v: u64) -> Result<ColorValue, E> {
                Ok(ColorValue([v as f64; 3]))
            }
            fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<ColorValue, E> {
                hex(v).map(ColorValue).ok_or_else(|| E::custom(format!("colour '{v}': expected the form \"#rrggbb\"")))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut array: A) -> Result<ColorValue, A::Error> {
                let mut rgb = Vec::with_capacity(3);
                while let Some(v) = array.next_element::<f64>()? {
                    rgb.push(v);
                }
                <[f64; 3]>::try_from(rgb)
                    .map(ColorValue)
                    .map_err(|rgb| serde::de::Error::invalid_length(rgb.len(), &self))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// The bytes of `#rrggbb`, each over 255.
pub(crate) fn hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| f64::from((number >> shift) & 0xff) / 255.0))
}

/// The form in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    #[serde(default)]
    mode: ColorMode,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interpolation: Option<Interpolation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    image: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    points: Option<Points<ColorPoint>>,
}

impl TryFrom<Text> for ColorFunction {
    type Error = &'static str;
    fn try_from(text: Text) -> Result<ColorFunction, &'static str> {
        let shape = match (text.points, text.image, text.interpolation) {
            (Some(points), None, interpolation) => {
                ColorShape::Points { interpolation: interpolation.unwrap_or_default(), points }
            }
            (None, Some(path), None) => ColorShape::Strip(Raster::named(path)),
            (None, Some(_), Some(_)) => return Err("color: an image takes no interpolation"),
            _ => return Err("color needs either points or an image"),
        };
        Ok(ColorFunction { mode: text.mode, shape })
    }
}

impl From<ColorFunction> for Text {
    fn from(function: ColorFunction) -> Text {
        let empty = Text { mode: function.mode, interpolation: None, image: None, points: None };
        match function.shape {
            ColorShape::Points { interpolation, points } => {
                Text { interpolation: Some(interpolation), points: Some(points), ..empty }
            }
            ColorShape::Strip(raster) => Text { image: Some(raster.path().to_owned()), ..empty },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_is_neutral_and_the_ends_are_black_and_white() {
        let lit = [0.2, 0.4, 0.8];
        for mode in [ColorMode::Tint, ColorMode::Multiply] {
            assert_eq!(mode.apply(lit, [0.5; 3]), lit);
            assert_eq!(mode.apply(lit, [0.0; 3]), [0.0; 3]);
        }
        assert_eq!(ColorMode::Tint.apply(lit, [1.0; 3]), [1.0; 3]);
        assert_eq!(ColorMode::Multiply.apply(lit, [1.0; 3]), [0.4, 0.8, 1.6]);
    }

    #[test]
    fn a_value_reads_in_three_forms() {
        let read = |text: &str| toml::from_str::<ColorPoint>(&format!("kappa = 0\ncolor = {text}"));
        assert_eq!(read("1").unwrap().color.0, [1.0; 3]);
        assert_eq!(read("0.25").unwrap().color.0, [0.25; 3]);
        assert_eq!(read("[0, 0.5, 1]").unwrap().color.0, [0.0, 0.5, 1.0]);
        assert_eq!(read("\"#ff0033\"").unwrap().color.0, [1.0, 0.0, 0.2]);
        for bad in ["[0, 1]", "[0, 1, 1, 1]", "\"#ff003\"", "\"#+f0033\"", "\"red\"", "true"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
