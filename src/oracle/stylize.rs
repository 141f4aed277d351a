//! Colour and opacity of every fragment by transfer functions (Murray 2016, section 5.2).
//!
//! Takes baked tables, as the GPU does: entry 0 stands for the lower end of the range, the last entry for the upper end,
//! linear between entries. `colour' = C(κ)` applied to lit colour, `alpha = gain · O(depth, |κ|) · material alpha`.
//!
//! # Choices
//! - `Constant` leaves colour as it is; its alpha is the constant times the material's. `Opaque` leaves colour as it is
//!   and has alpha 1 everywhere: material alpha does not act, so that no capture is needed.
//! - Models that look at a pixel's layers, at angles or at neighbours leave colour and the material's alpha as they are here;
//!   [`super::models`] has the opacity by which they multiply it. Of illustrative transparency this is the base.

use super::store::StoreData;
use super::view::Extents;
use crate::settings::{OpacityModel, OpacitySettings};
use crate::transfer::{self, TransferFunction};

/// How a colour function acts on lit colour; 0.5 changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMode {
    /// Below 0.5 it darkens, above it mixes towards white.
    Tint,
    /// It multiplies by twice its value.
    Multiply,
}

/// Baked transfer functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// Colour over κ from −1 to 1; at least one entry.
    pub color: Vec<[f64; 3]>,
    /// How it acts.
    pub mode: ColorMode,
    /// Opacity in rows of `opacity_width`: x is depth from 0 to 1, y is |κ| from 0 to 1.
    pub opacity: Vec<f64>,
    /// Entries in a row.
    pub opacity_width: usize,
}

impl Tables {
    /// The tables that a transfer function is baked into.
    pub fn of(transfer: &TransferFunction) -> Tables {
        let baked = transfer.bake();
        Tables {
            color: baked.color.iter().map(|c| c.map(f64::from)).collect(),
            mode: match baked.mode {
                transfer::ColorMode::Tint => ColorMode::Tint,
                transfer::ColorMode::Multiply => ColorMode::Multiply,
            },
            opacity: baked.opacity.iter().map(|&o| f64::from(o)).collect(),
            opacity_width: transfer::TABLE_SIZE,
        }
    }

    /// The colour function at κ, clamped to [−1, 1]; neutral if the table is empty.
    pub fn color_at(&self, kappa: f64) -> [f64; 3] {
        let (low, high, t) = between((kappa + 1.0) * 0.5, self.color.len());
        match (self.color.get(low), self.color.get(high)) {
            (Some(a), Some(b)) => std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t),
            _ => [0.5; 3],
        }
    }

    /// The opacity function at a depth and a |κ|, both clamped to [0, 1]; 1 if the table is empty.
    pub fn opacity_at(&self, depth01: f64, abs_kappa: f64) -> f64 {
        let width = self.opacity_width.max(1);
        let (x0, x1, u) = between(depth01, width);
        let (y0, y1, v) = between(abs_kappa, self.opacity.len() / width);
        let at = |x: usize, y: usize| self.opacity.get(y * width + x).copied().unwrap_or(1.0);
        let near = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * u;
        let far = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * u;
        near + (far - near) * v
    }
}

/// The two entries around a position in [0, 1], and the weight of the second.
fn between(position: f64, entries: usize) -> (usize, usize, f64) {
    let last = entries.saturating_sub(1);
    let at = position.clamp(0.0, 1.0) * last as f64;
    let low = (at as usize).min(last);
    (low, (low + 1).min(last), at - low as f64)
}

/// A colour function's value applied to lit colour.
pub fn apply_color(mode: ColorMode, lit: [f64; 3], value: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (l, c) = (lit[i], value[i]);
        if mode == ColorMode::Multiply || c < 0.5 { l * 2.0 * c } else { l + (1.0 - l) * (2.0 * c - 1.0) }
    })
}

/// Linear rgb and straight alpha of every fragment.
pub fn stylize(
    store: &StoreData,
    lit: &[[f64; 3]],
    kappa: &[f64],
    extents: &Extents,
    settings: &OpacitySettings,
    tables: &Tables,
) -> Vec<[f64; 4]> {
    (0..store.len())
        .map(|i| {
            let material_alpha = f64::from(store.base_color[i][3]);
            let (rgb, alpha) = match settings.base_model() {
                OpacityModel::Opaque => (lit[i], 1.0),
                OpacityModel::Constant => (lit[i], settings.constant * material_alpha),
                OpacityModel::Adaptive
                | OpacityModel::AngleBased
                | OpacityModel::NormalVariation
                | OpacityModel::EqualShare => (lit[i], material_alpha),
                OpacityModel::Curvature | OpacityModel::Illustrative => {
                    let opacity = tables.opacity_at(extents.depth01(store.depth[i]), kappa[i].abs());
                    let rgb = apply_color(tables.mode, lit[i], tables.color_at(kappa[i]));
                    (rgb, settings.gain * opacity * material_alpha)
                }
            };
            [rgb[0], rgb[1], rgb[2], alpha.clamp(0.0, 1.0)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables() -> Tables {
        Tables {
            color: vec![[1.0; 3], [0.5; 3], [0.0; 3]],
            mode: ColorMode::Tint,
            // Rows are |κ| = 0 and 1, columns depth 0, 0.5 and 1.
            opacity: vec![0.0, 0.2, 0.4, 0.5, 0.75, 1.0],
            opacity_width: 3,
        }
    }

    #[test]
    fn tables_are_linear_between_their_entries() {
        let t = tables();
        assert_eq!(t.color_at(-1.0), [1.0; 3]);
        assert_eq!(t.color_at(-0.5), [0.75; 3]);
        assert_eq!(t.color_at(9.0), [0.0; 3]);
        assert!((t.opacity_at(0.25, 0.0) - 0.1).abs() < 1e-12);
        assert!((t.opacity_at(0.25, 0.5) - 0.3625).abs() < 1e-12);
        assert_eq!(t.opacity_at(1.0, 1.0), 1.0);
        let empty = Tables { color: vec![], opacity: vec![], ..t };
        assert_eq!((empty.color_at(0.3), empty.opacity_at(0.3, 0.3)), ([0.5; 3], 1.0));
    }

    #[test]
    fn colour_modes_by_hand() {
        let lit = [0.2, 0.4, 0.8];
        assert_eq!(apply_color(ColorMode::Tint, lit, [0.5; 3]), lit);
        assert_eq!(apply_color(ColorMode::Tint, lit, [0.25; 3]), [0.1, 0.2, 0.4]);
        assert_eq!(apply_color(ColorMode::Tint, lit, [1.0; 3]), [1.0; 3]);
        assert_eq!(apply_color(ColorMode::Multiply, lit, [0.75; 3]), [0.2 * 1.5, 0.4 * 1.5, 0.8 * 1.5]);
    }

    #[test]
    fn models_by_hand() {
        let store = StoreData {
            width: 1,
            height: 1,
            counts: vec![1],
            overflowed: vec![false],
            offsets: vec![0],
            depth: vec![4.0],
            base_color: vec![[0.3, 0.3, 0.3, 0.5]],
            ..StoreData::default()
        };
        let extents =
            Extents { part_radii: vec![1.0], scene_radius: 1.0, visible_height: 2.0, depth_range: [3.0, 5.0] };
        let mut settings = OpacitySettings { gain: 2.0, constant: 0.4, ..OpacitySettings::default() };
        let run = |settings: &OpacitySettings, kappa: f64| {
            stylize(&store, &[[0.2, 0.2, 0.2]], &[kappa], &extents, settings, &tables())[0]
        };
        // depth01 = 0.5: O(0.5, 0.5) = 0.475, twice that, half of it for the material. Convex: mixed halfway to white.
        let [r, _, _, a] = run(&settings, -0.5);
        assert!((r - 0.6).abs() < 1e-12 && (a - 0.475).abs() < 1e-12);
        // Concave: colour 0.25 halves; opacity is that of the same |κ|.
        let [r, _, _, a] = run(&settings, 0.5);
        assert!((r - 0.1).abs() < 1e-12 && (a - 0.475).abs() < 1e-12);
        settings.gain = 8.0;
        assert_eq!(run(&settings, 1.0)[3], 1.0, "clamped");
        settings.model = OpacityModel::Constant;
        assert_eq!(run(&settings, 1.0), [0.2, 0.2, 0.2, 0.2]);
        settings.model = OpacityModel::Opaque;
        assert_eq!(run(&settings, 1.0), [0.2, 0.2, 0.2, 1.0]);
    }
}
