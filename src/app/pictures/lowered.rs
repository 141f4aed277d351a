//! The settings of a preview: what is meant in pixels of the screen, in its fewer and larger pixels.
//!
//! Most lengths are fractions of the picture and stay what they are. Others are not: the width of the outline, and, if they are
//! measured in pixels, how far the fields of illustrative transparency spread ([`IllustrativeSettings::scaled`]). That also makes
//! previews faster where it is needed, because steps are what illustration costs. The pixel at a silhouette itself cannot become
//! narrower: it is as opaque as the line covers it, or small parts would be solid and full of holes.
//!
//! [`IllustrativeSettings::scaled`]: crate::settings::IllustrativeSettings::scaled
//! The paper's forms that fail stay as they are: one looks at them to see them fail.

use crate::settings::{BaseOpacity, LengthUnit, OpacityModel, PrintedForm, Settings};
use crate::transfer::TransferFunction;

/// How wide the opaque line at a silhouette and the clear one behind it are, about, pixels of the exact picture.
const LINE: f64 = 2.0;

/// The settings with which 1/`divisor` of the pixels look as `settings` will.
pub fn lowered(settings: &Settings, divisor: f64) -> Settings {
    let mut lowered = settings.clone();
    lowered.image.samples = 1;
    if divisor.is_nan() || divisor <= 1.0 {
        return lowered;
    }
    lowered.outline.width = (settings.outline.width / divisor).max(1.0);
    let fields = &settings.opacity.illustrative;
    if fields.printed == PrintedForm::None {
        if fields.unit == LengthUnit::Pixel {
            lowered.opacity.illustrative = fields.scaled(divisor);
        }
        let covered = (LINE / divisor).min(1.0);
        lowered.opacity.illustrative.beta.strength *= covered;
        lowered.opacity.illustrative.gamma.strength *= covered;
    }
    lowered
}

/// The opacity that stands in for one by curvature, at least: what is seen is to be turned.
const LEAST_SHELL: f64 = 0.06;
/// At most: what lies behind is to be seen.
const MOST_SHELL: f64 = 0.45;

/// The settings with which a simpler model lets through about as much as the model itself. Its facets are sharp where the model
/// is smooth, so that opacity by curvature would make it solid; it is given that of flat surfaces everywhere.
pub fn see_through(settings: &Settings, transfer: &TransferFunction) -> Settings {
    let mut lowered = settings.clone();
    let opacity = &mut lowered.opacity;
    if opacity.base_model() != OpacityModel::Curvature {
        return lowered;
    }
    let sampler = transfer.opacity.sampler();
    // Over all depths, of what is nearly flat.
    let depths = 8;
    let mean =
        (0..depths).map(|i| sampler.at((f64::from(i) + 0.5) / f64::from(depths), 0.1)).sum::<f64>() / f64::from(depths);
    opacity.constant = (mean * opacity.gain).clamp(LEAST_SHELL, MOST_SHELL);
    match opacity.model {
        OpacityModel::Illustrative => opacity.illustrative.base = BaseOpacity::Constant,
        _ => opacity.model = OpacityModel::Constant,
    }
    lowered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simpler_model_is_seen_through_where_curvature_decided() {
        let transfer = TransferFunction::uniform(0.2);
        let usual = Settings::default();
        assert_eq!(usual.opacity.base_model(), OpacityModel::Curvature);
        let shell = see_through(&usual, &transfer);
        assert_eq!((shell.opacity.base_model(), shell.opacity.model), (OpacityModel::Constant, usual.opacity.model));
        assert!((shell.opacity.constant - 0.2).abs() < 1e-9, "{}", shell.opacity.constant);
        assert_eq!(see_through(&usual, &TransferFunction::uniform(1.0)).opacity.constant, MOST_SHELL);
        let bare = Settings::from_pairs("opacity.model=curvature opacity.gain=2").unwrap();
        let shell = see_through(&bare, &transfer);
        assert_eq!(shell.opacity.model, OpacityModel::Constant);
        assert!((shell.opacity.constant - 0.4).abs() < 1e-9);
        let other = Settings::from_pairs("opacity.model=angle_based").unwrap();
        assert_eq!(see_through(&other, &transfer), other);
    }

    #[test]
    fn widths_on_the_screen_are_those_of_the_picture() {
        let settings = Settings::from_pairs(
            "opacity.model=illustrative opacity.illustrative.unit=pixel image.samples=4 outline.width=6",
        )
        .unwrap();
        let exact = &settings.opacity.illustrative;
        for divisor in [1.0, 1.25, 2.0, 3.0, 6.0] {
            let lowered = lowered(&settings, divisor);
            let fields = &lowered.opacity.illustrative;
            assert_eq!(lowered.image.samples, 1);
            assert!((lowered.outline.width * divisor - 6.0).abs() < 1e-9);
            // Pixels of the preview times their size on the screen.
            let width = |lambda: f64| 1.0 / lambda;
            assert!((width(fields.beta.lambda) * divisor - width(exact.beta.lambda)).abs() < 1e-9, "{divisor}");
            if divisor <= 5.0 {
                assert!((width(fields.gamma.lambda) * divisor - width(exact.gamma.lambda)).abs() < 1e-9, "{divisor}");
            }
            let variance = |n: u32, lambda: f64| f64::from(n) * lambda;
            let spread = variance(fields.iterations, fields.alpha.lambda) * divisor * divisor;
            assert!((spread - variance(exact.iterations, exact.alpha.lambda)).abs() < 1e-9, "{divisor}");
            assert!(fields.alpha.lambda <= exact.alpha.lambda + 1e-12, "as stable");
            assert_eq!(fields.beta.strength, exact.beta.strength * (LINE / divisor).min(1.0));
            assert_eq!(fields.gamma.strength, exact.gamma.strength * (LINE / divisor).min(1.0));
            assert!(fields.steps().most <= exact.steps().most, "{divisor}");
            let mut rest = lowered.clone();
            rest.opacity.illustrative = exact.clone();
            (rest.image.samples, rest.outline.width) = (4, 6.0);
            assert_eq!(rest, settings, "nothing else changes");
        }
        let coarse = lowered(&settings, 6.0).opacity.illustrative.steps();
        assert!(coarse.most <= 5, "{coarse:?}");
    }

    #[test]
    fn forms_that_are_looked_at_for_failing_still_fail() {
        let settings = Settings::from_pairs(
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.printed=laplacian",
        )
        .unwrap();
        assert_eq!(lowered(&settings, 4.0).opacity.illustrative, settings.opacity.illustrative);
    }

    #[test]
    fn lines_are_as_opaque_as_they_cover_a_pixel_in_every_unit() {
        let settings = Settings::from_pairs("opacity.model=illustrative opacity.illustrative.unit=view").unwrap();
        let (exact, coarse) = (&settings.opacity.illustrative, lowered(&settings, 8.0).opacity.illustrative);
        assert_eq!(coarse.beta.strength, 0.25 * exact.beta.strength);
        assert_eq!(coarse.beta.lambda, exact.beta.lambda, "lengths are shares of the view");
        assert_eq!(lowered(&settings, 1.5).opacity.illustrative.beta.strength, exact.beta.strength);
    }

    #[test]
    fn no_steps_stay_none() {
        let settings = Settings::from_pairs(
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.iterations=0",
        )
        .unwrap();
        assert_eq!(lowered(&settings, 3.0).opacity.illustrative.iterations, 0);
    }
}
