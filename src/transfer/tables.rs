//! Baked tables: what the GPU samples, and what the planner decides by.

use super::raster::span;
use super::{ColorFunction, ColorMode, OpacityFunction, TransferFunction};

/// Entries of the colour table, and of the opacity table along either axis.
pub const TABLE_SIZE: usize = 256;

/// A transfer function as tables. Entry 0 stands at the lower end of the range and entry 255 at the upper; between
/// entries values are interpolated linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTables {
    /// How a colour value acts on lit colour.
    pub mode: ColorMode,
    /// 256 values over κ from −1 to 1, each channel in [0, 1] with 0.5 neutral.
    pub color: Vec<[f32; 3]>,
    /// 256×256 opacities in [0, 1]: entry `y · 256 + x`, x over depth, y over |κ|, both from 0 to 1.
    pub opacity: Vec<f32>,
}

impl ColorFunction {
    /// 256 values over κ from −1 to 1.
    pub fn bake(&self) -> Vec<[f32; 3]> {
        let value = self.sampler();
        (0..TABLE_SIZE).map(|i| value(2.0 * place(i) - 1.0).map(|v| v as f32)).collect()
    }

    /// The one value that the baked table has everywhere, if it has only one.
    pub fn constant(&self) -> Option<[f32; 3]> {
        only(&self.bake())
    }

    /// Whether the baked table varies.
    pub fn depends_on_curvature(&self) -> bool {
        self.constant().is_none()
    }
}

impl OpacityFunction {
    /// 256×256 opacities: entry `y · 256 + x`, x over depth, y over |κ|.
    pub fn bake(&self) -> Vec<f32> {
        let sampler = self.sampler();
        (0..TABLE_SIZE)
            .flat_map(|y| {
                let row = sampler.row(place(y));
                (0..TABLE_SIZE).map(|x| row(place(x)) as f32).collect::<Vec<_>>()
            })
            .collect()
    }

    /// The one opacity that the baked table has everywhere, if it has only one.
    pub fn constant(&self) -> Option<f32> {
        only(&self.bake())
    }

    /// Whether any entry of the baked table differs from its neighbour along |κ|.
    pub fn depends_on_curvature(&self) -> bool {
        varies_along_kappa(&self.bake())
    }

    /// Whether any entry of the baked table differs from its neighbour along depth.
    pub fn depends_on_depth(&self) -> bool {
        varies_along_depth(&self.bake())
    }
}

impl TransferFunction {
    /// Both tables.
    pub fn bake(&self) -> TransferTables {
        TransferTables { mode: self.color.mode, color: self.color.bake(), opacity: self.opacity.bake() }
    }

    /// Whether colour or opacity vary with curvature, judged by the baked tables.
    pub fn depends_on_curvature(&self) -> bool {
        self.color.depends_on_curvature() || self.opacity.depends_on_curvature()
    }

    /// Whether opacity varies with depth, judged by the baked table.
    pub fn depends_on_depth(&self) -> bool {
        self.opacity.depends_on_depth()
    }

    /// Colour value and opacity if neither varies, judged by the baked tables.
    pub fn constant(&self) -> Option<([f32; 3], f32)> {
        self.color.constant().zip(self.opacity.constant())
    }
}

impl TransferTables {
    /// Whether any table varies with curvature.
    pub fn depends_on_curvature(&self) -> bool {
        only(&self.color).is_none() || varies_along_kappa(&self.opacity)
    }

    /// Whether opacity varies with depth.
    pub fn depends_on_depth(&self) -> bool {
        varies_along_depth(&self.opacity)
    }

    /// Colour value and opacity if neither varies.
    pub fn constant(&self) -> Option<([f32; 3], f32)> {
        only(&self.color).zip(only(&self.opacity))
    }

    /// Colour value at κ, interpolated between entries.
    pub fn sample_color(&self, kappa: f64) -> [f64; 3] {
        let (a, b, t) = span(kappa * 0.5 + 0.5, self.color.len());
        std::array::from_fn(|c| lerp(f64::from(self.color[a][c]), f64::from(self.color[b][c]), t))
    }

    /// Opacity at (depth, |κ|), interpolated between entries.
    pub fn sample_opacity(&self, depth01: f64, abs_kappa: f64) -> f64 {
        let (x0, x1, tx) = span(depth01, TABLE_SIZE);
        let (y0, y1, ty) = span(abs_kappa, TABLE_SIZE);
        let at = |x: usize, y: usize| f64::from(self.opacity[y * TABLE_SIZE + x]);
        lerp(lerp(at(x0, y0), at(x1, y0), tx), lerp(at(x0, y1), at(x1, y1), tx), ty)
    }
}

/// Where entry `i` stands in [0, 1].
fn place(i: usize) -> f64 {
    i as f64 / (TABLE_SIZE - 1) as f64
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn only<T: Copy + PartialEq>(values: &[T]) -> Option<T> {
    values.first().copied().filter(|first| values.iter().all(|v| v == first))
}

fn varies_along_kappa(opacity: &[f32]) -> bool {
    opacity.iter().zip(opacity.iter().skip(TABLE_SIZE)).any(|(a, b)| a != b)
}

fn varies_along_depth(opacity: &[f32]) -> bool {
    opacity.chunks(TABLE_SIZE).any(|row| only(row).is_none())
}
