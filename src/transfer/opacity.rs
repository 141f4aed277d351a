//! Opacity over depth and absolute curvature: 2D.

use serde::{Deserialize, Serialize};

use super::points::{ControlPoint, Interpolant, Interpolation, Points, check_range};
use super::raster::Raster;

/// An opacity at an absolute curvature; in text `[kappa, opacity]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "(f64, f64)", into = "(f64, f64)")]
pub struct OpacityPoint {
    /// |κ| in [0, 1].
    pub kappa: f64,
    /// Opacity there, in [0, 1].
    pub opacity: f64,
}

/// Opacity over |κ| at one depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpacityCurve {
    /// Depth in [0, 1]: 0 nearest, 1 farthest point of the scene's bounding sphere.
    pub depth: f64,
    /// Opacity over |κ|.
    pub points: Points<OpacityPoint>,
}

/// Where the values come from.
#[derive(Clone, Debug, PartialEq)]
pub enum OpacityShape {
    /// Curves over |κ| at several depths.
    Curves {
        /// What lies between the points of a curve.
        interpolation: Interpolation,
        /// What lies between the curves.
        depth_interpolation: Interpolation,
        /// The curves.
        curves: Points<OpacityCurve>,
    },
    /// An image: depth to the right, |κ| upwards, grey is opacity.
    Image(Raster),
}

/// Opacity over (depth, |κ|), both in [0, 1].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Text", into = "Text")]
pub struct OpacityFunction {
    /// Where the values come from.
    pub shape: OpacityShape,
}

impl OpacityFunction {
    /// The same opacity everywhere, clamped to [0, 1].
    pub fn uniform(opacity: f64) -> OpacityFunction {
        let opacity = if opacity.is_nan() { 0.0 } else { opacity.clamp(0.0, 1.0) };
        let points = Points::one(OpacityPoint { kappa: 0.0, opacity });
        let curves = Points::one(OpacityCurve { depth: 0.0, points });
        OpacityFunction {
            shape: OpacityShape::Curves {
                interpolation: Interpolation::Step,
                depth_interpolation: Interpolation::Step,
                curves,
            },
        }
    }

    /// Opacity at `depth01` and `abs_kappa`, both clamped to [0, 1]. Clear for an image that has not been loaded.
    pub fn sample(&self, depth01: f64, abs_kappa: f64) -> f64 {
        self.sampler().at(depth01, abs_kappa)
    }

    /// For many samples: what they have in common is computed once.
    pub fn sampler(&self) -> OpacitySampler<'_> {
        OpacitySampler(match &self.shape {
            OpacityShape::Curves { interpolation, depth_interpolation, curves } => Sampled::Curves {
                depths: curves.positions(),
                over_depth: *depth_interpolation,
                curves: curves.as_slice().iter().map(|c| c.interpolant(*interpolation)).collect(),
            },
            OpacityShape::Image(raster) => Sampled::Image(raster),
        })
    }
}

/// Samples an opacity function.
pub struct OpacitySampler<'a>(Sampled<'a>);

enum Sampled<'a> {
    Curves { depths: Vec<f64>, over_depth: Interpolation, curves: Vec<Interpolant> },
    Image(&'a Raster),
}

impl OpacitySampler<'_> {
    /// Opacity, see [`OpacityFunction::sample`].
    pub fn at(&self, depth01: f64, abs_kappa: f64) -> f64 {
        self.row(abs_kappa)(depth01)
    }

    /// Opacity over depth at one |κ|.
    pub fn row(&self, abs_kappa: f64) -> Box<dyn Fn(f64) -> f64 + '_> {
        match &self.0 {
            Sampled::Curves { depths, over_depth, curves } => {
                let values = curves.iter().map(|c| c.at(abs_kappa)).collect();
                let row = Interpolant::new(depths.clone(), values, *over_depth);
                Box::new(move |depth| row.at(depth))
            }
            Sampled::Image(raster) => {
                Box::new(move |depth| raster.sample([depth, abs_kappa]).map_or(0.0, |[grey, ..]| grey))
            }
        }
    }

    /// Opacity of the curve with this number, which is the function's at that curve's depth; clear if there is none.
    pub fn on_curve(&self, number: usize, abs_kappa: f64) -> f64 {
        match &self.0 {
            Sampled::Curves { curves, .. } => curves.get(number).map_or(0.0, |c| c.at(abs_kappa)),
            Sampled::Image(_) => 0.0,
        }
    }
}

impl OpacityCurve {
    fn interpolant(&self, interpolation: Interpolation) -> Interpolant {
        let opacities = self.points.as_slice().iter().map(|p| p.opacity).collect();
        Interpolant::new(self.points.positions(), opacities, interpolation)
    }
}

impl ControlPoint for OpacityPoint {
    const AXIS: &'static str = "|kappa|";
    fn position(&self) -> f64 {
        self.kappa
    }
    fn check(&self) -> Result<(), String> {
        check_range("|kappa|", self.kappa, 0.0, 1.0)?;
        check_range("opacity", self.opacity, 0.0, 1.0)
    }
}

impl ControlPoint for OpacityCurve {
    const AXIS: &'static str = "depth";
    fn position(&self) -> f64 {
        self.depth
    }
    fn check(&self) -> Result<(), String> {
        check_range("depth", self.depth, 0.0, 1.0)
    }
}

impl From<(f64, f64)> for OpacityPoint {
    fn from((kappa, opacity): (f64, f64)) -> OpacityPoint {
        OpacityPoint { kappa, opacity }
    }
}

impl From<OpacityPoint> for (f64, f64) {
    fn from(point: OpacityPoint) -> (f64, f64) {
        (point.kappa, point.opacity)
    }
}

/// The form in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interpolation: Option<Interpolation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    depth_interpolation: Option<Interpolation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    image: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    curves: Option<Points<OpacityCurve>>,
}

impl TryFrom<Text> for OpacityFunction {
    type Error = &'static str;
    fn try_from(text: Text) -> Result<OpacityFunction, &'static str> {
        let shape = match (text.curves, text.image) {
            (Some(curves), None) => OpacityShape::Curves {
                interpolation: text.interpolation.unwrap_or_default(),
                depth_interpolation: text.depth_interpolation.unwrap_or(Interpolation::Linear),
                curves,
            },
            (None, Some(path)) => {
                if text.interpolation.or(text.depth_interpolation).is_some() {
                    return Err("opacity: an image takes no interpolation");
                }
                OpacityShape::Image(Raster::named(path))
            }
            _ => return Err("opacity needs either curves or an image"),
        };
        Ok(OpacityFunction { shape })
    }
}

impl From<OpacityFunction> for Text {
    fn from(function: OpacityFunction) -> Text {
        match function.shape {
            OpacityShape::Curves { interpolation, depth_interpolation, curves } => Text {
                interpolation: Some(interpolation),
                depth_interpolation: Some(depth_interpolation),
                image: None,
                curves: Some(curves),
            },
            OpacityShape::Image(raster) => Text {
                interpolation: None,
                depth_interpolation: None,
                image: Some(raster.path().to_owned()),
                curves: None,
            },
        }
    }
}
