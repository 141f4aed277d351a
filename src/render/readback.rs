//! The store of the last frame, read back: what the oracle, the tests and the reports compare.
//!
//! Valid until the next frame, for frames of one band and one sample (of several, the last band's store is left).

use glam::{Vec2, Vec3};
use half::f16;

use super::{FrameReport, RenderError, Renderer};
use crate::gpu::GpuError;
use crate::math::Camera;
use crate::math::color::linear_from_srgb;
use crate::oracle::{Ends, Link, StoreData, Surfaces};
use crate::passes::{PartFacts, operators};
use crate::plan::{Capture, FramePlan};
use crate::settings::{DepthQuantization, NormalEncoding};

/// What later stages wrote beside the captured columns, by fragment in the order of the store.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoreReadback {
    /// The captured layers, decoded.
    pub layers: StoreData,
    /// The captured columns as they lie in memory, gaps left out: key, normal, colour, material. For exact comparison.
    pub words: Vec<[u32; 9]>,
    /// Neighbours in the four directions; empty if none were searched.
    pub links: Vec<[Link; 4]>,
    /// Where surfaces end; empty without illustrative transparency.
    pub ends: Ends,
    /// κ; empty if it was not computed.
    pub kappa: Vec<f32>,
    /// α, β, γ of illustrative transparency after diffusion, and what is fixed (1 β, 2 γ); empty without.
    pub fields: Vec<[f32; 4]>,
    /// Linear rgb and straight alpha after light and stylization.
    pub lit: Vec<[f32; 4]>,
    /// For each pixel its layers in (part, depth) order and its bucket table (part, first, end); empty without buckets.
    pub buckets: Vec<PixelBuckets>,
}

/// Buckets of one pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PixelBuckets {
    /// Layer indices in (part, depth) order.
    pub by_part: Vec<u32>,
    /// Slots of the hash table: part and positions from first to before end.
    pub table: Vec<Option<(u32, u32, u32)>>,
}

fn unpack_octahedral(word: u32) -> Vec3 {
    let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let p = Vec2::new(snorm(word & 0xFFFF), snorm(word >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let t = (-z).max(0.0);
    let fold = |v: f32| v - if v >= 0.0 { t } else { -t };
    Vec3::new(fold(p.x), fold(p.y), z).normalize()
}

fn unpack_xy15(word: u32) -> Vec3 {
    let q = |bits: u32| (bits & 0x7FFF) as f32 / 32767.0 * 2.0 - 1.0;
    let (x, y) = (q(word), q(word >> 15));
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    Vec3::new(x, y, if word >> 30 != 0 { -z } else { z }).normalize()
}

fn unpack_rgb9e5(word: u32) -> [f32; 3] {
    let scale = ((word >> 27) as f32 - 24.0).exp2();
    [word & 511, (word >> 9) & 511, (word >> 18) & 511].map(|m| m as f32 * scale)
}

fn unpack_half4(words: &[u32]) -> [f32; 4] {
    let half = |word: u32| f16::from_bits(word as u16).to_f32();
    [half(words[0]), half(words[0] >> 16), half(words[1]), half(words[1] >> 16)]
}

/// Depth along the view from a captured key's depth, as the shaders compute it but in f64.
pub(super) struct DepthDecoder {
    near: f64,
    far: f64,
    orthographic: bool,
    depth_min: f64,
    depth_max: f64,
}

impl DepthDecoder {
    /// From 0 to 1 over the scene's bounding sphere, and beyond outside of it.
    pub(super) fn depth01(&self, depth: f64) -> f64 {
        (depth - self.depth_min) / (self.depth_max - self.depth_min)
    }

    pub(super) fn of_z(&self, z: f64) -> f64 {
        if self.orthographic { self.far - z * (self.far - self.near) } else { self.near / z.max(1e-30) }
    }

    pub(super) fn of_packed(&self, bits: u32, quantization: DepthQuantization) -> f64 {
        let t = f64::from(bits) / 65534.0;
        match quantization {
            DepthQuantization::Linear => self.depth_min + t * (self.depth_max - self.depth_min),
            DepthQuantization::ZOverW if !self.orthographic => self.of_z(1.0 - t * (1.0 - self.near / self.far)),
            _ => self.of_z(1.0 - t),
        }
    }
}

impl StoreReadback {
    /// What is known of the surfaces, for the oracle's illustrative transparency.
    pub fn surfaces(&self) -> Surfaces<'_> {
        Surfaces { store: &self.layers, links: &self.links, ends: &self.ends, bare: false }
    }
}

impl Renderer {
    /// Reads back a buffer of the last frame by the name of its shader variable.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if there is no such buffer or the device failed.
    pub fn read_words(&self, name: &str) -> Result<Vec<u32>, RenderError> {
        let buffer = self.resources.require("read-back", name)?;
        let bytes = self.gpu.read_buffer(buffer, buffer.size())?;
        Ok(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
    }

    fn read_optional(&self, name: &str) -> Result<Vec<u32>, RenderError> {
        if self.resources.buffer(name).is_none() {
            return Ok(Vec::new());
        }
        self.read_words(name)
    }

    /// Reads back the store of the last frame, which `report` and `camera` belong to.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] if the frame captured nothing, took several bands, or the device failed.
    pub fn read_store(
        &self,
        report: &FrameReport,
        scene: &super::GpuScene,
        camera: &Camera,
    ) -> Result<StoreReadback, RenderError> {
        let plan = &report.plan;
        if report.bands != 1 || plan.capture == Capture::None || plan.samples != 1 {
            let why = "the store can be read back only after a frame of one band and one sample that captured layers";
            return Err(GpuError::Device(why.to_owned()).into());
        }
        self.decode(plan, scene, camera, 0..plan.size[0] as usize * plan.size[1] as usize)
    }

    /// Reads back some pixels of the band that is in the buffers, numbered from its first row.
    pub(super) fn decode(
        &self,
        plan: &FramePlan,
        scene: &super::GpuScene,
        camera: &Camera,
        pixels: std::ops::Range<usize>,
    ) -> Result<StoreReadback, RenderError> {
        let decoder = self.decoder(scene, camera);
        let wide = plan.capture.is_wide();
        let table = self.read_words("pixel_table")?;
        let keys = self.read_words("keys")?;
        let shapes = self.read_words("shapes")?;
        let colors = self.read_words("colors")?;
        let materials = self.read_words("materials")?;
        let lit = self.read_words("lit")?;
        let parts = self.read_optional("parts")?;
        let ahead = self.read_optional("links_ahead")?;
        let behind = self.read_optional("links_behind")?;
        let layer_ends = if plan.illustration.is_some() { self.read_words("layer_ends")? } else { Vec::new() };
        let parameters = self.read_optional("parameters")?;
        let kappas = self.read_optional("kappas")?;
        let fields = match plan.illustration {
            Some(i) => self.read_words(operators::column_after(i.most_steps))?,
            None => Vec::new(),
        };
        let by_part = self.read_optional("by_part")?;
        let buckets = self.read_optional("buckets")?;
        let part_table: Vec<u32> = {
            let bytes = self.gpu.read_buffer(&scene.part_table, scene.part_table.size())?;
            bytes.chunks_exact(size_of::<PartFacts>()).map(|c| bytemuck::pod_read_unaligned(&c[..4])).collect()
        };

        let mut out = StoreReadback::default();
        let store = &mut out.layers;
        (store.width, store.height) = (plan.size[0], plan.size[1]);
        for pixel in pixels {
            let (base, count, overflowed, slots) = match plan.capture {
                Capture::BucketedKBuffer { k, .. } => {
                    let word = table[pixel];
                    (pixel * k as usize, (word & 0x7FFF_FFFF) as usize, word >> 31 != 0, k as usize)
                }
                _ => {
                    let (from, to) = (table[pixel] as usize, table[pixel + 1] as usize);
                    (from, to - from, false, to - from)
                }
            };
            store.offsets.push(store.depth_key.len());
            store.counts.push(count as u32);
            store.overflowed.push(overflowed);
            for i in base..base + count {
                let (depth_key, triangle, part, depth) = if wide {
                    let (triangle, depth_key) = (keys[2 * i], keys[2 * i + 1]);
                    let z = f64::from(f32::from_bits(0x3F80_0000_u32.wrapping_sub(depth_key)));
                    // A fault on the device may leave an empty slot among the layers: it is read, and comparisons see it.
                    let part = (part_table.partition_point(|&first| first <= triangle) as u32).saturating_sub(1);
                    (depth_key, triangle, part, decoder.of_z(z))
                } else {
                    let Capture::BucketedKBuffer { depth, .. } = plan.capture else { continue };
                    (keys[i] >> 16, 0, keys[i] & 0xFFFF, decoder.of_packed(keys[i] >> 16, depth))
                };
                store.depth_key.push(depth_key);
                store.triangle.push(triangle);
                store.part.push(parts.get(i).copied().unwrap_or(part));
                store.depth.push(depth);
                let normal = match plan.normals {
                    NormalEncoding::Octahedral | NormalEncoding::Xy15 => [shapes[2 * i + 1], 0, 0],
                    NormalEncoding::Full => [shapes[4 * i + 1], shapes[4 * i + 2], shapes[4 * i + 3]],
                };
                store.normal.push(
                    match plan.normals {
                        NormalEncoding::Octahedral => unpack_octahedral(normal[0]),
                        NormalEncoding::Xy15 => unpack_xy15(normal[0]),
                        NormalEncoding::Full => Vec3::from(normal.map(f32::from_bits)),
                    }
                    .to_array(),
                );
                let (color, color_words) = if wide {
                    (unpack_half4(&colors[2 * i..]), [colors[2 * i], colors[2 * i + 1]])
                } else {
                    let byte = |shift: u32| f64::from(colors[i] >> shift & 255) / 255.0;
                    let linear = |shift| linear_from_srgb(byte(shift)) as f32;
                    ([linear(0), linear(8), linear(16), byte(24) as f32], [colors[i], 0])
                };
                store.base_color.push(color);
                let word = materials[2 * i];
                let byte = |shift: u32| (word >> shift & 255) as f32 / 255.0;
                store.metallic.push(byte(0));
                store.roughness.push(byte(8));
                store.occlusion.push(byte(16));
                store.unlit.push(word >> 24 & 1 != 0);
                store.side.push(word >> 25 & 1 == 0);
                if let Some(p) = parameters.get(4 * i..4 * i + 4) {
                    store.parameters.push([0, 1, 2, 3].map(|c| f32::from_bits(p[c])));
                }
                store.emissive.push(unpack_rgb9e5(materials[2 * i + 1]));
                out.words.push([
                    depth_key,
                    triangle,
                    normal[0],
                    normal[1],
                    normal[2],
                    color_words[0],
                    color_words[1],
                    word,
                    materials[2 * i + 1],
                ]);
                if !ahead.is_empty() {
                    let l = [ahead[i], behind[2 * i], ahead[i] >> 16, behind[2 * i + 1]];
                    out.links.push(l.map(|v| match v & 0xFFFF {
                        0xFFFF => Link::Missing,
                        0xFFFE => Link::Unknown,
                        layer => Link::To(layer),
                    }));
                }
                if let Some(flags) = layer_ends.get(i) {
                    let four = |first: u32| [0, 1, 2, 3].map(|d| flags >> (first + d) & 1 != 0);
                    out.ends.surface.push(four(4));
                    out.ends.open.push(four(8));
                    out.ends.behind.push(four(12));
                }
                if !fields.is_empty() {
                    out.fields.push([0, 1, 2, 3].map(|c| f32::from_bits(fields[4 * i + c])));
                }
                if !kappas.is_empty() {
                    out.kappa.push(f32::from_bits(kappas[i]));
                }
                out.lit.push(unpack_half4(&lit[2 * i..]));
            }
            if !by_part.is_empty() {
                let slot = |s: usize| {
                    let (part, range) = (buckets[2 * s], buckets[2 * s + 1]);
                    (part != u32::MAX).then_some((part, range & 0xFFFF, range >> 16))
                };
                out.buckets.push(PixelBuckets {
                    by_part: by_part[base..base + count].to_vec(),
                    table: if count == 0 { Vec::new() } else { (base..base + slots).map(slot).collect() },
                });
            }
        }
        Ok(out)
    }

    pub(super) fn decoder(&self, scene: &super::GpuScene, camera: &Camera) -> DepthDecoder {
        let frustum = camera.frustum(&scene.stats.bounds);
        let sphere = scene.stats.bounds.bounding_sphere();
        let center = -camera.view_from_world().transform_point3(sphere.center).z;
        // As the uniform holds them, in f32.
        let single = |v: f64| f64::from(v as f32);
        DepthDecoder {
            near: single(frustum.near),
            far: single(frustum.far),
            orthographic: matches!(camera.projection, crate::math::Projection::Orthographic { .. }),
            depth_min: single(center - sphere.radius),
            depth_max: single(center + sphere.radius),
        }
    }
}
