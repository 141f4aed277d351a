//! Measurements of the illustration buffer.

use super::measure::{Stand, share};
use super::{CaseError, Figure};
use crate::oracle::{Link, compare, continuity, illustration};

impl Stand<'_> {
    /// Links whose neighbour is linked elsewhere.
    pub(super) fn links_one_way(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let links = store.links.iter().flatten().filter(|l| matches!(l, Link::To(_))).count();
        Ok(share(continuity::one_way(&store.layers, &store.links), links))
    }

    /// Fields against the oracle's over the same links and base opacity.
    pub(super) fn field_error(&mut self) -> Result<Figure, CaseError> {
        let mut plain = self.settings.clone();
        plain.opacity.model = plain.opacity.base_model();
        let scene = self.scene.clone();
        let base = self.unchanged(&scene, &plain)?;
        let base: Vec<f64> = base.colors().iter().map(|c| c[3]).collect();
        let store = self.shot()?.store;
        let settings = &self.settings.opacity.illustrative;
        let (exact, _) = compare::illustrated(&store.layers, &store.links, &base, settings);
        let off = |(f, e): (&[f32; 4], &[f64; 3])| (0..3).map(|c| (f64::from(f[c]) - e[c]).abs()).fold(0.0, worse);
        let value = store.fields.iter().zip(&exact.values).map(off).fold(0.0, worse);
        Ok(Figure { value, samples: store.fields.len(), ambiguous: 0 })
    }

    /// Opacity against what the oracle makes of the same fields.
    pub(super) fn field_opacity_error(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let values = store.fields.iter().map(|f| [0, 1, 2].map(|c| f64::from(f[c]))).collect();
        let fields = illustration::Fields { values, fixed: vec![[false; 2]; store.fields.len()] };
        let exact = illustration::opacities(&fields, &self.settings.opacity.illustrative);
        let value = store.lit.iter().zip(&exact).map(|(l, e)| (f64::from(l[3]) - e).abs()).fold(0.0, worse);
        Ok(Figure { value: 255.0 * value, samples: exact.len(), ambiguous: 0 })
    }

    /// Layers at which a halo begins or a highlight is stopped, though they do not end themselves.
    pub(super) fn halos(&mut self) -> Result<Figure, CaseError> {
        let store = self.shot()?.store;
        let pairs = store.fields.iter().zip(&store.links);
        let is_one = |(f, links): &(&[f32; 4], &[Link; 4])| f[3] != 0.0 && !links.contains(&Link::Missing);
        Ok(share(pairs.filter(is_one).count(), store.fields.len()))
    }
}

/// The greater, or NaN.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
