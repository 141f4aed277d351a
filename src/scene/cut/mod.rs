//! Section planes applied to a scene: the planes in scene space, and the caps that close what they cut.
//!
//! A plane cuts parts where the arrangement puts them. What lies on the side of its normal is cut away, fragment by fragment,
//! by the shaders (`scene/clip_planes.wgsl`); nothing here changes a mesh. Where caps are wanted, the inside of every part
//! that is drawn is filled in the plane: `contours` of the part's triangles, then triangles between them. A cap is a part
//! of its own, numbered after the scene's, with triangle numbers after the scene's, and belongs to the part that it closes;
//! other planes cut it as they cut everything, its own does not.
//!
//! A part is closed if its contours are. One that is not has no cap, and is told by name. Where parts overlap, the smaller
//! one's cap is taken out of the larger one's (`fill`), so that no two lie in one place.
//!
//! Triangles come from the crate `i_triangle`: contours are snapped to a grid of about 2⁻³⁰ of their box and intersected
//! exactly there, so that contours that touch, cross or overlap cannot break it.

mod contours;
mod fill;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::OnceLock;

use glam::{DMat4, DVec2, DVec3};
use rayon::prelude::*;

use contours::{Contours, Solid};
use fill::{Filled, PlaneFrame, Region};

use super::{AlphaMode, Arrangement, Material, Presence, Scene, SceneStats, Section};
use crate::math::Bounds;
use crate::math::color::linear_from_srgb;

/// The colour that cut faces are drawn towards, so that they read as cut: linear, a dull red.
pub const CAP_TINT: [f32; 3] = [0.55, 0.16, 0.08];
/// How far.
const CAP_SHARE: f32 = 0.25;

/// A plane that cuts, in scene space.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPlane {
    /// Unit vector towards what is cut away.
    pub normal: DVec3,
    /// `normal · x` of its points.
    pub offset: f64,
    /// Index in [`Arrangement::sections`].
    pub section: usize,
    /// The parts that are its caps: it does not cut them.
    pub caps: Range<u32>,
}

/// The inside of one part in one plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Cap {
    /// The part that it closes.
    pub part: u32,
    /// Index in [`Cut::planes`].
    pub plane: usize,
    /// Number of its first triangle.
    pub first_triangle: u32,
    /// Scene space from its own, in which it lies in z = 0 and z points to what is cut away.
    pub world_from_cap: DMat4,
    /// Vertices.
    pub positions: Vec<[f32; 2]>,
    /// Counterclockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Its box in scene space.
    pub bounds: Bounds,
}

impl Cap {
    /// Its area, in square scene units.
    pub fn area(&self) -> f64 {
        let at = |i: u32| DVec2::from(self.positions[i as usize].map(f64::from));
        self.triangles.iter().map(|&[a, b, c]| 0.5 * (at(b) - at(a)).perp_dot(at(c) - at(a))).sum()
    }
}

/// A part that a plane cuts and that has no cap there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenPart {
    /// The part.
    pub part: u32,
    /// Index in [`Arrangement::sections`].
    pub section: usize,
    /// Ends of its contours; 0 if the numbers of triangles ran out.
    pub ends: usize,
}

/// What the section planes of an arrangement do to a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// The planes that cut.
    pub planes: Vec<CutPlane>,
    /// By plane, then by part.
    pub caps: Vec<Cap>,
    /// Parts without the caps that they should have.
    pub open: Vec<OpenPart>,
    /// Parts of the scene: a cap's number as a part is its index plus this.
    pub scene_parts: u32,
}

/// Welded meshes of a scene, made when they are first cut and kept while planes are dragged.
#[derive(Debug, Default)]
pub struct Solids(Vec<OnceLock<Solid>>);

impl Solids {
    /// None made yet.
    pub fn of(scene: &Scene) -> Solids {
        Solids(scene.meshes.iter().map(|_| Default::default()).collect())
    }

    fn contours(&self, scene: &Scene, mesh: usize, place: &DMat4, normal: DVec3, offset: f64) -> Contours {
        let Some(solid) = self.0.get(mesh) else { return Contours::default() };
        solid.get_or_init(|| Solid::new(&scene.meshes[mesh])).contours(place, normal, offset)
    }
}

impl Section {
    /// Whether the plane meets a box; `shift` brings the box into the file's coordinates.
    fn meets(&self, bounds: &Bounds, shift: DVec3) -> bool {
        let middle = self.normal.dot(bounds.center() + shift) - self.offset;
        let reach = 0.5 * self.normal.abs().dot(bounds.size());
        !bounds.is_empty() && middle.abs() <= reach * (1.0 + 1e-6) + 1e-12 * self.offset.abs()
    }
}

impl Cut {
    /// Applies the enabled planes of an arrangement that fits the scene. `solids` are those of the same scene.
    pub fn new(scene: &Scene, arrangement: &Arrangement, solids: &Solids) -> Cut {
        let mut cut = Cut { scene_parts: scene.parts.len() as u32, ..Cut::default() };
        let mut planes: Vec<(usize, &Section)> = Vec::new();
        for (index, section) in arrangement.sections.iter().enumerate().filter(|(_, s)| s.enabled) {
            // A plane that is there twice would cut its twin's caps.
            match planes.iter().position(|(_, p)| (p.normal, p.offset) == (section.normal, section.offset)) {
                Some(twin) if section.caps => planes[twin] = (index, section),
                Some(_) => {}
                None => planes.push((index, section)),
            }
        }
        if planes.is_empty() {
            return cut;
        }
        let placed = arrangement.placed(scene);
        let offset_of = |section: &Section| section.offset - section.normal.dot(scene.origin);
        let middle = placed.parts.iter().fold(Bounds::EMPTY, |all, p| all.union(p.bounds)).center();
        let frames: Vec<PlaneFrame> =
            planes.iter().map(|(_, s)| PlaneFrame::new(s.normal, offset_of(s), middle)).collect();
        let mut asked = Vec::new();
        for (plane, (_, section)) in planes.iter().enumerate().filter(|(_, (_, s))| s.caps) {
            let met = placed.parts.iter().enumerate().filter(|(_, p)| section.meets(&p.bounds, scene.origin));
            asked.extend(met.map(|(part, _)| (plane, part)));
        }
        let traced: Vec<Result<Option<Region>, usize>> = asked
            .par_iter()
            .map(|&(plane, part)| {
                let ((_, section), place) = (planes[plane], &placed.parts[part]);
                let (mesh, offset) = (scene.parts[part].mesh, offset_of(section));
                let contours = solids.contours(scene, mesh, &place.world_from_part, section.normal, offset);
                let ghosted = arrangement.look(part as u32).presence == Presence::Ghosted;
                let rank = (ghosted, place.bounds.size().element_product(), part as u32);
                match contours.open_ends {
                    0 => Ok(Region::new(&contours, plane, rank, frames[plane])),
                    ends => Err(ends),
                }
            })
            .collect();
        let mut regions = Vec::new();
        for ((plane, part), traced) in asked.into_iter().zip(traced) {
            match traced {
                Ok(region) => regions.extend(region),
                Err(ends) => cut.open.push(OpenPart { part: part as u32, section: planes[plane].0, ends }),
            }
        }
        let filled = fill::fill(&regions);
        let mut triangle = scene.triangle_count();
        let mut found = regions.iter().zip(filled).peekable();
        for (plane, (index, section)) in planes.into_iter().enumerate() {
            let first = cut.scene_parts + cut.caps.len() as u32;
            while let Some((region, filled)) = found.next_if(|(region, _)| region.plane == plane) {
                let Some(Filled { positions, triangles, world_from_cap, bounds }) = filled else { continue };
                let (part, count) = (region.rank.2, triangles.len() as u64);
                // The last number is the empty slot's.
                if triangle + count > u64::from(u32::MAX) {
                    cut.open.push(OpenPart { part, section: index, ends: 0 });
                    continue;
                }
                let first_triangle = triangle as u32;
                cut.caps.push(Cap { part, plane, first_triangle, world_from_cap, positions, triangles, bounds });
                triangle += count;
            }
            cut.planes.push(CutPlane {
                normal: section.normal,
                offset: offset_of(section),
                section: index,
                caps: first..cut.scene_parts + cut.caps.len() as u32,
            });
        }
        cut.open.sort_by_key(|o| (o.section, o.part));
        cut
    }

    /// The part of the scene that a part belongs to: itself, or the one that it is a cap of.
    pub fn owner(&self, part: u32) -> u32 {
        let cap = part.checked_sub(self.scene_parts).and_then(|i| self.caps.get(i as usize));
        cap.map_or(part, |cap| cap.part)
    }

    /// What the planner needs to know of the scene, arranged and cut.
    pub fn stats(&self, scene: &Scene, arrangement: &Arrangement) -> SceneStats {
        let mut stats = arrangement.stats(scene);
        self.count_into(&mut stats);
        stats
    }

    /// Adds planes and caps to what the planner knows of the arranged scene.
    pub fn count_into(&self, stats: &mut SceneStats) {
        stats.section_planes = self.planes.len() as u64;
        stats.caps = self.caps.len() as u64;
        stats.parts += stats.caps;
        for cap in &self.caps {
            stats.triangles += cap.triangles.len() as u64;
            stats.vertices += cap.positions.len() as u64;
            stats.bounds = stats.bounds.union(cap.bounds);
        }
    }

    /// One sentence for each section with parts that could not be closed.
    pub fn notices(&self, scene: &Scene) -> Vec<String> {
        const NAMED: usize = 5;
        let sentence = |section: usize| {
            let open: Vec<&OpenPart> = self.open.iter().filter(|o| o.section == section).collect();
            let name = |o: &&OpenPart| format!("'{}'", scene.parts[o.part as usize].name);
            let names: Vec<String> = open.iter().take(NAMED).map(name).collect();
            let more = match open.len().saturating_sub(NAMED) {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            let one = open.len() == 1;
            let (are, get) = if one { ("is", "gets no cap") } else { ("are", "get no caps") };
            format!("section {}: {}{more} {are} not closed there and {get}", section + 1, names.join(", "))
        };
        let mut sections: Vec<usize> = self.open.iter().map(|o| o.section).collect();
        sections.dedup();
        sections.into_iter().map(sentence).collect()
    }
}

/// A linear base colour as a cut through it has it: a quarter of the way to [`CAP_TINT`].
pub fn tinted(color: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| color[i] + CAP_SHARE * (CAP_TINT[i] - color[i]))
}

/// The material of the caps of a mesh's parts: that of its largest primitive, with the mean colour of its vertices and
/// texture, tinted, dull and without light of its own.
pub fn cap_material(scene: &Scene, mesh: usize) -> Material {
    let largest = scene.meshes[mesh].primitives.iter().max_by_key(|p| p.triangles.len());
    let Some(primitive) = largest else { return Material::default() };
    let material = &scene.materials[primitive.material];
    let mut color = material.base_color;
    let mean = |sum: [f64; 4], count: usize| sum.map(|v| (v / count.max(1) as f64) as f32);
    let mut times = |factor: [f32; 4]| color.iter_mut().zip(factor).for_each(|(c, f)| *c *= f);
    if !primitive.colors.is_empty() {
        let sum = primitive.colors.iter().fold([0.0; 4], |sum, c| std::array::from_fn(|i| sum[i] + f64::from(c[i])));
        times(mean(sum, primitive.colors.len()));
    }
    let texture = material.base_color_texture.as_ref().and_then(|t| scene.textures.get(t.texture));
    if let Some(image) = texture.and_then(|t| scene.images.get(t.image)) {
        let linear: [f64; 256] = std::array::from_fn(|v| linear_from_srgb(v as f64 / 255.0));
        let sum = image.rgba.chunks_exact(4).fold([0.0; 4], |[r, g, b, a], t| {
            let color = |i: usize| linear[usize::from(t[i])];
            [r + color(0), g + color(1), b + color(2), a + f64::from(t[3]) / 255.0]
        });
        times(mean(sum, image.rgba.len() / 4));
    }
    let [r, g, b] = tinted([color[0], color[1], color[2]]);
    let alpha = if material.alpha_mode == AlphaMode::Blend { color[3] } else { 1.0 };
    Material {
        name: format!("{} (cut)", material.name),
        base_color: [r, g, b, alpha],
        metallic: 0.0,
        roughness: 0.9,
        alpha_mode: if material.alpha_mode == AlphaMode::Blend { AlphaMode::Blend } else { AlphaMode::Opaque },
        unlit: material.unlit,
        ..Material::default()
    }
}
