//! Settings of the opacity models that come from the illustration buffer (Carnecky 2013, section 5).

use serde::{Deserialize, Serialize};

use super::declare::{choice, settings};
use super::{Declaration, OpacityModel, Range};

choice! {
    /// The opacity with which illustrative transparency begins.
    pub enum BaseOpacity {
        /// As under `adaptive`.
        Adaptive = "adaptive",
        /// As under `constant`.
        Constant = "constant",
        /// As under `angle_based`.
        AngleBased = "angle_based",
        /// As under `normal_variation`.
        NormalVariation = "normal_variation",
        /// As under `equal_share`.
        EqualShare = "equal_share",
        /// As under `curvature`. The default.
        #[default]
        Curvature = "curvature",
    }
}

impl BaseOpacity {
    /// The model that gives it.
    pub fn model(self) -> OpacityModel {
        match self {
            BaseOpacity::Adaptive => OpacityModel::Adaptive,
            BaseOpacity::Constant => OpacityModel::Constant,
            BaseOpacity::AngleBased => OpacityModel::AngleBased,
            BaseOpacity::NormalVariation => OpacityModel::NormalVariation,
            BaseOpacity::EqualShare => OpacityModel::EqualShare,
            BaseOpacity::Curvature => OpacityModel::Curvature,
        }
    }
}

choice! {
    /// How a field spreads along the surface.
    pub enum Diffusion {
        /// Heat (Carnecky 2013, equation 8), over the neighbours that there are (T12).
        #[default]
        Heat = "heat",
        /// The greatest of the neighbours, less λ (equation 9), until nothing changes (T16).
        Max = "max",
        /// Not at all.
        None = "none",
    }
}

choice! {
    /// What lengths of illustrative transparency are measured in.
    pub enum LengthUnit {
        /// Thousandths of the image's shorter side, so that a picture looks the same at any resolution. The default.
        #[default]
        View = "view",
        /// Pixels, as in the paper.
        Pixel = "pixel",
    }
}

choice! {
    /// What is made of a field after it has spread.
    pub enum Profile {
        /// Nothing: it falls off evenly.
        #[default]
        None = "none",
        /// A bell (Carnecky 2013, equation 10).
        Bell = "bell",
        /// A power (equation 11).
        Power = "power",
    }
}

choice! {
    /// Which of the paper's forms is followed to the letter. For comparison: each of them fails.
    pub enum PrintedForm {
        /// None.
        #[default]
        None = "none",
        /// The 5-point Laplacian with λ = 1, which explodes (T12).
        Laplacian = "laplacian",
        /// Algorithm 3, line 6: what passes a layer is 1 − α (T14).
        Transmittance = "transmittance",
        /// Equation 9 without its flag: what is fixed is overwritten (T16).
        Propagation = "propagation",
        /// Every missing neighbour is an end, and every step of the layer index counts, also where faces touch (T19).
        IndexSteps = "index_steps",
    }
}

settings! {
    /// Opacity by the angle between normal and sight line.
    pub struct AngleSettings {
        /// Opacity where a surface faces the viewer.
        pub low: f64 = 0.1, Range::Real(0.0, 1.0);
        /// Opacity where it is seen edge-on.
        pub high: f64 = 0.9, Range::Real(0.0, 1.0);
    }
}

settings! {
    /// Opacity by how fast the normal turns, between real neighbours.
    pub struct VariationSettings {
        /// Opacity where a surface is flat.
        pub low: f64 = 0.1, Range::Real(0.0, 1.0);
        /// Opacity where its normal turns fast.
        pub high: f64 = 0.95, Range::Real(0.0, 1.0);
        /// Sensitivity: times the turn over the image's shorter side.
        pub scale: f64 = 0.1, Range::Real(0.0, 100.0);
    }
}

settings! {
    /// Every layer index seen as much as any other, over the whole image.
    pub struct EqualShareSettings {
        /// Opacity of all layers together, where there are many.
        pub share: f64 = 0.9, Range::Real(0.0, 1.0);
        /// Share of the pixels that must have a layer index for it to count as one of its own.
        pub least: f64 = 0.1, Range::Real(0.0, 1.0);
    }
}

settings! {
    /// The field α: base opacity, smoothed.
    pub struct AlphaSettings {
        /// How it spreads.
        pub diffusion: Diffusion = Diffusion::Heat, Range::Choice(Diffusion::NAMES);
        /// λ_α: how fast.
        pub lambda: f64 = 0.9, Range::Real(0.01, 0.9);
    }
}

settings! {
    /// The field β: opaque at silhouettes.
    pub struct BetaSettings {
        /// How it spreads.
        pub diffusion: Diffusion = Diffusion::Max, Range::Choice(Diffusion::NAMES);
        /// λ_β: under `max`, one over its width in pixels.
        pub lambda: f64 = 0.05, Range::Real(0.01, 0.9);
        /// What is made of it then.
        pub profile: Profile = Profile::Power, Range::Choice(Profile::NAMES);
        /// The profile's parameter.
        pub p: f64 = 2.0, Range::Real(0.0, 50.0);
        /// How opaque silhouettes are; 0 for none.
        pub strength: f64 = 1.0, Range::Real(0.0, 1.0);
    }
}

settings! {
    /// The field γ: clear behind silhouettes, the halo.
    pub struct GammaSettings {
        /// How it spreads.
        pub diffusion: Diffusion = Diffusion::Max, Range::Choice(Diffusion::NAMES);
        /// λ_γ: under `max`, one over the halo's width in pixels.
        pub lambda: f64 = 0.2, Range::Real(0.01, 0.9);
        /// What is made of it then.
        pub profile: Profile = Profile::None, Range::Choice(Profile::NAMES);
        /// The profile's parameter.
        pub p: f64 = 1.0, Range::Real(0.0, 50.0);
        /// How clear halos are; 0 for none.
        pub strength: f64 = 1.0, Range::Real(0.0, 1.0);
    }
}

settings! {
    /// Illustrative transparency.
    pub struct IllustrativeSettings {
        /// The opacity with which it begins.
        pub base: BaseOpacity = BaseOpacity::Curvature, Range::Choice(BaseOpacity::NAMES);
        /// Multiplies it.
        pub base_gain: f64 = 0.6, Range::Real(0.0, 8.0);
        /// What the widths below are in: 1/λ under `max`, how far heat gets, and the feature size.
        pub unit: LengthUnit = LengthUnit::View, Range::Choice(LengthUnit::NAMES);
        /// Length below which a surface counts as small: silhouettes and halos on it get narrower with it; 0 for no such limit.
        pub feature_size: u32 = 24, Range::Integer(0, 255);
        /// Steps of fields that spread as heat.
        pub iterations: u32 = 20, Range::Integer(0, 100);
        /// Base opacity.
        pub group alpha: AlphaSettings;
        /// Silhouettes.
        pub group beta: BetaSettings;
        /// Halos.
        pub group gamma: GammaSettings;
        /// Whether fields that spread by `max` stop when nothing changes; the picture is the same.
        pub early_stop: bool = true, Range::Switch;
        /// Which of the paper's forms is followed to the letter, to see it fail.
        pub printed: PrintedForm = PrintedForm::None, Range::Choice(PrintedForm::NAMES);
    }
}

/// Most steps of heat, however large the picture is.
const MOST_HEAT_STEPS: f64 = 100.0;

impl IllustrativeSettings {
    /// The same with all lengths in pixels of an image of `size`.
    pub fn in_pixels(&self, size: [u32; 2]) -> IllustrativeSettings {
        match self.unit {
            LengthUnit::Pixel => self.clone(),
            LengthUnit::View => {
                let side = f64::from(size[0].min(size[1]).max(1));
                IllustrativeSettings { unit: LengthUnit::Pixel, ..self.scaled(1000.0 / side) }
            }
        }
    }

    /// What looks the same where a pixel is `divisor` times as large. Under `max` a field falls by λ a pixel, so that λ is one
    /// over a width and grows with the divisor d. As heat, n steps of λ spread as far as the root of n λ pixels: n/d² steps are
    /// taken, rounded up, each so much weaker that n λ / d² holds; at most a hundred, so that in very large pictures the base is
    /// smoothed less far.
    pub fn scaled(&self, divisor: f64) -> IllustrativeSettings {
        let mut scaled = self.clone();
        if !divisor.is_finite() || divisor <= 0.0 {
            return scaled;
        }
        let spread = f64::from(self.iterations) / (divisor * divisor);
        let steps = spread.ceil().min(MOST_HEAT_STEPS.max(f64::from(self.iterations)));
        scaled.iterations = steps as u32;
        let each = if steps > 0.0 { (spread / steps).min(1.0) } else { 0.0 };
        let ways = [
            (self.alpha.diffusion, &mut scaled.alpha.lambda),
            (self.beta.diffusion, &mut scaled.beta.lambda),
            (self.gamma.diffusion, &mut scaled.gamma.lambda),
        ];
        for (diffusion, lambda) in ways {
            match diffusion {
                Diffusion::Heat => *lambda *= each,
                // A field narrower than a pixel stays where it is.
                Diffusion::Max => *lambda = (*lambda * divisor).min(1.0),
                Diffusion::None => {}
            }
        }
        if self.feature_size > 0 {
            scaled.feature_size = (f64::from(self.feature_size) / divisor).round().clamp(1.0, 255.0) as u32;
        }
        scaled
    }

    /// Steps that all fields together need: those of heat, and those in which `max` reaches its end (T16).
    pub fn steps(&self) -> Steps {
        let fields = [
            (self.alpha.diffusion, self.alpha.lambda),
            (self.beta.diffusion, self.beta.lambda),
            (self.gamma.diffusion, self.gamma.lambda),
        ];
        let heat = if fields.iter().any(|(d, _)| *d == Diffusion::Heat) { self.iterations } else { 0 };
        let ends = fields.iter().filter(|(d, _)| *d == Diffusion::Max).map(|(_, lambda)| (1.0 / lambda).ceil() as u32);
        Steps { heat, most: ends.fold(heat, u32::max) }
    }
}

/// How often the fields of illustrative transparency take a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// Steps that are always taken.
    pub heat: u32,
    /// Most steps.
    pub most: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_follow_the_resolution() {
        let asked = IllustrativeSettings::default();
        let at = |side| asked.in_pixels([2 * side, side]);
        assert_eq!(at(1000), IllustrativeSettings { unit: LengthUnit::Pixel, ..asked.clone() });
        assert_eq!(at(1000).in_pixels([5, 5]), at(1000), "pixels stay what they are");
        for side in [250, 500, 2000] {
            let (scaled, times) = (at(side), f64::from(side) / 1000.0);
            assert!((scaled.beta.lambda * times - asked.beta.lambda).abs() < 1e-12, "{side}");
            assert!((scaled.gamma.lambda * times - asked.gamma.lambda).abs() < 1e-12, "{side}");
            assert_eq!(scaled.feature_size, (24.0 * times) as u32);
            let spread = |s: &IllustrativeSettings| f64::from(s.iterations) * s.alpha.lambda;
            assert!((spread(&scaled) - spread(&asked) * times * times).abs() < 1e-9, "{side}");
            assert!(scaled.alpha.lambda <= asked.alpha.lambda, "as stable");
        }
        assert_eq!((at(8000).iterations, at(8000).feature_size), (100, 192));
        assert_eq!(at(20).gamma.lambda, 1.0);
        assert_eq!(IllustrativeSettings { feature_size: 0, ..asked.clone() }.in_pixels([9, 9]).feature_size, 0);
    }
}
