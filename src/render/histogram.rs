//! How many layers of the last frame have which depth and curvature: what stands behind the transfer-function editors.
//!
//! Only the table of pixels, the keys and κ are read back, 12 bytes a layer instead of all columns.

use super::{FrameReport, GpuScene, RenderError, Renderer};
use crate::math::Camera;
use crate::plan::Capture;
use crate::transfer::Histogram2d;

/// Columns over depth and rows over |κ|.
const SIZE: [usize; 2] = [64, 64];
/// Bars over κ.
const BARS: usize = 96;

/// Layers by depth and curvature.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerHistogram {
    /// Another one has another number.
    pub serial: u64,
    /// Over (depth, |κ|).
    pub map: Histogram2d,
    /// Over κ from −1 to 1.
    pub kappa: Vec<u64>,
}

impl LayerHistogram {
    /// Nothing counted.
    pub fn empty() -> LayerHistogram {
        LayerHistogram { serial: 0, map: Histogram2d::new(SIZE), kappa: vec![0; BARS] }
    }

    /// Counts a layer: depth from 0 to 1, κ from −1 to 1.
    pub fn add(&mut self, depth01: f64, kappa: f64) {
        self.map.add(depth01, kappa);
        if !depth01.is_nan() && !kappa.is_nan() {
            let bar = (kappa.clamp(-1.0, 1.0) * 0.5 + 0.5) * BARS as f64;
            self.kappa[(bar as usize).min(BARS - 1)] += 1;
        }
    }
}

impl Renderer {
    /// Counts the layers of the last frame, which `report` and `camera` belong to. Of several samples the last is counted.
    ///
    /// Returns `None` where there is nothing to count: no curvature was computed, or the store is gone because the frame took
    /// several bands.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if the device failed.
    pub fn layer_histogram(
        &self,
        report: &FrameReport,
        scene: &GpuScene,
        camera: &Camera,
    ) -> Result<Option<LayerHistogram>, RenderError> {
        let plan = &report.plan;
        if report.bands != 1 || plan.capture == Capture::None || self.resources.buffer("kappas").is_none() {
            return Ok(None);
        }
        let decoder = self.decoder(scene, camera);
        let (table, keys, kappas) =
            (self.read_words("pixel_table")?, self.read_words("keys")?, self.read_words("kappas")?);
        let mut counted = LayerHistogram::empty();
        let wide = plan.capture.is_wide();
        let depth = |i: usize| match plan.capture {
            Capture::BucketedKBuffer { depth, .. } if !wide => Some(decoder.of_packed(keys.get(i)? >> 16, depth)),
            _ => {
                let key = keys.get(2 * i + 1)?;
                Some(decoder.of_z(f64::from(f32::from_bits(0x3F80_0000_u32.wrapping_sub(*key)))))
            }
        };
        let pixels = plan.size[0] as usize * plan.size[1] as usize;
        for pixel in 0..pixels.min(table.len()) {
            let layers = match plan.capture {
                Capture::BucketedKBuffer { k, .. } => {
                    let base = pixel * k as usize;
                    base..base + (table[pixel] & 0x7FFF_FFFF) as usize
                }
                _ => table[pixel] as usize..table.get(pixel + 1).copied().unwrap_or(0) as usize,
            };
            for i in layers {
                if let (Some(depth), Some(kappa)) = (depth(i), kappas.get(i)) {
                    counted.add(decoder.depth01(depth), f64::from(f32::from_bits(*kappa)));
                }
            }
        }
        Ok(Some(counted))
    }
}
