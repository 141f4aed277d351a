//! The settings of a preview: what is meant in pixels of the screen, in its fewer and larger pixels.
//!
//! Most lengths are fractions of the picture and stay what they are. Others are not: the width of the outline, and, if they are
//! measured in pixels, how far the fields of illustrative transparency spread ([`IllustrativeSettings::scaled`]). That also makes
//! previews faster where it is needed, because steps are what illustration costs.
//!
//! [`IllustrativeSettings::scaled`]: crate::settings::IllustrativeSettings::scaled
//! The paper's forms that fail stay as they are: one looks at them to see them fail.

use crate::settings::{LengthUnit, PrintedForm, Settings};

/// The settings with which 1/`divisor` of the pixels look as `settings` will.
pub fn lowered(settings: &Settings, divisor: f64) -> Settings {
    let mut lowered = settings.clone();
    lowered.image.samples = 1;
    if divisor.is_nan() || divisor <= 1.0 {
        return lowered;
    }
    lowered.outline.width = (settings.outline.width / divisor).max(1.0);
    let fields = &settings.opacity.illustrative;
    if fields.unit == LengthUnit::Pixel && fields.printed == PrintedForm::None {
        lowered.opacity.illustrative = fields.scaled(divisor);
    }
    lowered
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn no_steps_stay_none() {
        let settings = Settings::from_pairs(
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.iterations=0",
        )
        .unwrap();
        assert_eq!(lowered(&settings, 3.0).opacity.illustrative.iterations, 0);
    }
}
