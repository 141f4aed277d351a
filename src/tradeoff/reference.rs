//! What a configuration is compared with.
//!
//! The reference of a scene and view is the picture that the user asked for, with every axis that trades accuracy
//! ([`Effect::Accuracy`]) at its exact value: all fragments (`compacted`: nothing overflows), in exact order (32-bit depth over
//! the triangle's number), neighbours by the tangent plane and checked both ways. What decides the look (transfer functions,
//! light, kind and radius of curvature) stays as asked.
//!
//! # Its own precision
//! - Depth: the rasterizer's 32-bit floating point, reversed: a relative step of at most 2⁻²³ of the distance.
//! - Normals: three 32-bit floats, as interpolated (T9).
//! - κ: single precision. Lit colour and opacity: half floats, 2⁻¹¹ relative, an eighth of an 8-bit step at most.
//! - The picture: single precision.
//!
//! It is checked against the `f64` oracle by tests, on scenes small enough for it.
//!
//! Axes that change how densely the scene is sampled have a reference of their own, [`supersampled`]: the same with many
//! jittered samples. Against it even the exact picture with one sample has an error: aliasing.

use crate::settings::{Axis, Effect, Settings, SettingsError};

/// Samples a pixel of the supersampled reference, unless the settings or the axis have more than half as many: then twice
/// those. The samples of a configuration are among them, so errors come out a little small: by a factor of √(1 − n/16) for n.
pub const REFERENCE_SAMPLES: u32 = 16;

/// The settings of the reference for what a user asked for.
///
/// # Errors
/// [`SettingsError`] if an axis names a value that its setting does not have.
pub fn reference(base: &Settings, axes: &[Axis]) -> Result<Settings, SettingsError> {
    let mut settings = base.clone();
    for axis in axes {
        if let (Effect::Accuracy { exact }, Some(path)) = (axis.effect, axis.path()) {
            settings.set(path, exact)?;
        }
    }
    Ok(settings)
}

/// The settings of the reference of axes that change the sampling.
///
/// # Errors
/// As [`reference()`].
pub fn supersampled(base: &Settings, axes: &[Axis]) -> Result<Settings, SettingsError> {
    let mut settings = reference(base, axes)?;
    let most = axes
        .iter()
        .filter(|a| a.path() == Some("image.samples"))
        .flat_map(|a| a.values.iter().filter_map(|v| v.parse::<u32>().ok()))
        .fold(settings.image.samples, u32::max);
    settings.set("image.samples", &REFERENCE_SAMPLES.max(2 * most).min(1024).to_string())?;
    Ok(settings)
}

/// Both references of what a user asked for, along every axis there is, varied or not.
///
/// # Errors
/// As [`reference`].
pub fn both(base: &Settings) -> Result<[Settings; 2], SettingsError> {
    let all = super::axis::all();
    Ok([reference(base, &all)?, supersampled(base, &all)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{CaptureKind, CurvatureKind, NormalEncoding};
    use crate::tradeoff::axis;

    #[test]
    fn the_reference_is_exact_and_keeps_the_look() {
        let axes = axis::all();
        let mut precise = Settings::default();
        precise.capture.normals = NormalEncoding::Full;
        assert_eq!(
            reference(&Settings::default(), &axes).unwrap(),
            precise,
            "the default is exact but for its normals"
        );
        let mut asked = Settings::default();
        for (path, value) in [
            ("capture.kind", "bucketed_k_buffer"),
            ("capture.bucketed_k_buffer.key", "packed32"),
            ("capture.normals", "xy15"),
            ("features.depth_term", "printed"),
            ("features.curvature.kind", "view_centred"),
            ("features.curvature.radius", "0.01"),
            ("image.samples", "20"),
        ] {
            asked.set(path, value).unwrap();
        }
        let exact = reference(&asked, &axes).unwrap();
        assert_eq!(exact.capture.kind, CaptureKind::Compacted);
        assert_eq!(exact.capture.normals, NormalEncoding::Full);
        assert_eq!(exact.features.depth_term, Settings::default().features.depth_term);
        assert_eq!(exact.features.curvature.kind, CurvatureKind::ViewCentred);
        assert_eq!((exact.features.curvature.radius, exact.image.samples), (0.01, 20));
        assert_eq!(supersampled(&asked, &axes).unwrap().image.samples, 40);
        assert_eq!(supersampled(&Settings::default(), &axes).unwrap().image.samples, REFERENCE_SAMPLES);
    }
}
