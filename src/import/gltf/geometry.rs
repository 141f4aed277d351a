//! Meshes: triangles with the attributes that are drawn, cleaned of what cannot be.

use glam::DVec3;
use gltf_json::Root;
use gltf_json::mesh::{Mode, Primitive as Source};
use gltf_json::validation::Checked;
use rayon::prelude::*;

use super::accessor::{Data, missing};
use super::attributes::{self, Attributes};
use super::steps::{Steps, settle};
use super::{Fallible, Fault, ImportOptions, Notices};
use crate::import::triangles::{UNIT, clean, compact, given_normals};
use crate::import::{Phase, tangents};
use crate::scene::{Material, Mesh, NoticeKind, Primitive};

/// The meshes, with a default material added if a primitive needs it.
pub(super) struct Geometry {
    pub(super) meshes: Vec<Mesh>,
    pub(super) materials: Vec<Material>,
}

struct Context<'a> {
    data: &'a Data<'a>,
    materials: &'a [Material],
    default_material: usize,
    quantized: bool,
    options: &'a ImportOptions,
}

/// Reads all meshes, shown or not. Of the phase the share `begin` is already done.
pub(super) fn read<'a>(
    root: &Root,
    data: &'a Data<'a>,
    mut materials: Vec<Material>,
    begin: f32,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Geometry> {
    let primitives: Vec<(usize, String, &Source)> = root
        .meshes
        .iter()
        .enumerate()
        .flat_map(|(m, mesh)| {
            mesh.primitives.iter().enumerate().map(move |(p, s)| (m, format!("meshes[{m}].primitives[{p}]"), s))
        })
        .collect();
    budget(&primitives, data, options)?;
    let default_material = materials.len();
    if primitives.iter().any(|(_, _, source)| source.material.is_none()) {
        materials.push(Material::default());
    }
    let context = Context {
        data,
        materials: &materials,
        default_material,
        quantized: root.extensions_used.iter().chain(&root.extensions_required).any(|e| e == "KHR_mesh_quantization"),
        options,
    };
    let steps = Steps::new(options, Phase::Geometry, [begin, 1.0], primitives.len());
    let read: Vec<Fallible<(usize, Option<Primitive>, Notices)>> = primitives
        .into_par_iter()
        .map(|(mesh, place, source)| {
            steps.each(|| {
                let mut notices = Notices::default();
                context.primitive(source, &place, &mut notices).map(|p| (mesh, p, notices))
            })
        })
        .collect();
    let names = root.meshes.iter().map(|m| m.name.clone().unwrap_or_default());
    let mut meshes: Vec<Mesh> = names.map(|name| Mesh { name, primitives: Vec::new() }).collect();
    for (mesh, primitive, told) in settle(read)? {
        notices.append(told);
        meshes[mesh].primitives.extend(primitive);
    }
    Ok(Geometry { meshes, materials })
}

/// Checks how much all primitives take together, before any is read: several may read the same accessor.
fn budget(primitives: &[(usize, String, &Source)], data: &Data, options: &ImportOptions) -> Fallible<()> {
    let (mut vertices, mut triangles) = (0_u64, 0_u64);
    for (_, place, source) in primitives {
        let Some(found) = attributes::find(source, data, place, true, &mut Notices::default())? else { continue };
        let corners = attributes::indices(source, data, place)?.map_or(found.positions.count, |i| i.count);
        vertices = vertices.saturating_add(corners.min(found.positions.count));
        triangles = triangles.saturating_add(match source.mode {
            Checked::Valid(Mode::Triangles) => corners / 3,
            _ => corners,
        });
        let limits = &options.limits;
        if vertices > limits.vertices {
            return Err(Fault::limit(place, "vertices of all primitives so far", vertices, limits.vertices));
        }
        if triangles > limits.triangles {
            return Err(Fault::limit(place, "triangles of all primitives so far", triangles, limits.triangles));
        }
    }
    Ok(())
}

/// Replaces the values that are not `good`; says how many there were.
fn mended<T: Copy + Send>(values: &mut [T], good: impl Fn(&T) -> bool + Sync, instead: impl Fn(T) -> T + Sync) -> u64 {
    let mend = |value: &mut T| {
        let bad = !good(value);
        if bad {
            *value = instead(*value);
        }
        u64::from(bad)
    };
    values.par_iter_mut().map(mend).sum()
}

impl Context<'_> {
    /// One primitive; `None` if nothing of it is drawn.
    fn primitive(&self, source: &Source, place: &str, notices: &mut Notices) -> Fallible<Option<Primitive>> {
        let Checked::Valid(mode) = source.mode else {
            return Err(Fault::invalid(format!("{place}.mode"), "is not one of glTF's primitive modes"));
        };
        let material = match source.material.map(|m| m.value()) {
            None => self.default_material,
            Some(material) if material < self.materials.len() => material,
            Some(material) => {
                return Err(missing(format!("{place}.material"), "material", material, self.materials.len()));
            }
        };
        let Some(found) = attributes::find(source, self.data, place, self.quantized, notices)? else {
            notices.count(NoticeKind::Ignored, "primitives have no positions and are not shown", 1, place);
            return Ok(None);
        };
        let indices = attributes::indices(source, self.data, place)?;
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            notices.count(NoticeKind::Ignored, "primitives of points or lines are not shown", 1, place);
            return Ok(None);
        }
        let corners = attributes::corners(indices, found.positions.count, place, notices)?;
        let (mut triangles, left_over) = attributes::triangles(&corners, mode);
        drop(corners);
        let what = "indices at the end of a primitive do not make a triangle and were dropped";
        notices.count(NoticeKind::Repaired, what, left_over as u64, place);

        // Positions first: they decide which triangles, and so which vertices, are there.
        let used = compact(&mut triangles, found.positions.count);
        let mut positions: Vec<[f32; 3]> = used.par_iter().map(|&v| found.positions.numbers(v)).collect();
        let mut vertices = used;
        let count = triangles.len();
        clean(&mut triangles, &positions, place, notices);
        if triangles.len() < count {
            let kept = compact(&mut triangles, positions.len() as u64);
            positions = kept.par_iter().map(|&k| positions[k as usize]).collect();
            vertices = kept.par_iter().map(|&k| vertices[k as usize]).collect();
        }
        if triangles.is_empty() {
            return Ok(None);
        }
        let mut primitive = Primitive { positions, triangles, material, ..Primitive::default() };
        self.uvs_and_colors(&mut primitive, &found, &vertices, place, notices);
        let own_normals = self.normals(&mut primitive, &found, &vertices, place, notices);
        self.tangents(&mut primitive, &found, &vertices, own_normals, place, notices);
        Ok(Some(primitive))
    }

    fn uvs_and_colors(
        &self,
        p: &mut Primitive,
        found: &Attributes,
        vertices: &[u32],
        place: &str,
        notices: &mut Notices,
    ) {
        for (set, accessor) in found.uvs.iter().enumerate() {
            let Some(accessor) = accessor else { continue };
            let mut uvs: Vec<[f32; 2]> = vertices.par_iter().map(|&v| accessor.numbers(v)).collect();
            let bad = mended(&mut uvs, |uv| uv.iter().all(|c| c.is_finite()), |_| [0.0; 2]);
            p.uvs[set] = uvs;
            notices.count(NoticeKind::Repaired, "texture coordinates were not finite and became 0", bad, place);
        }
        if let Some(accessor) = found.colors {
            let opaque = accessor.shape == gltf_json::accessor::Type::Vec3;
            let whole = accessor.component != gltf_json::accessor::ComponentType::F32 && !accessor.normalized;
            let what = "primitives have integer vertex colours that are not marked as normalized; read as if they were";
            notices.count(NoticeKind::Repaired, what, whole.into(), place);
            let read = |&v: &u32| {
                let [r, g, b, a]: [f32; 4] = accessor.numbers_as(v, true);
                [r, g, b, if opaque { 1.0 } else { a }]
            };
            let mut colors: Vec<[f32; 4]> = vertices.par_iter().map(read).collect();
            let clamped = |color: [f32; 4]| color.map(|c| if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) });
            let bad = mended(&mut colors, |color| color.iter().all(|c| (0.0..=1.0).contains(c)), clamped);
            p.colors = colors;
            notices.count(NoticeKind::Repaired, "vertex colours were outside 0 to 1 and were clamped", bad, place);
        }
        let material = &self.materials[p.material];
        let lacking = material.texture_refs().any(|r| p.uvs.get(r.uv_set as usize).is_none_or(Vec::is_empty));
        let what = "primitives lack the texture coordinates of their material's textures, which are sampled at (0, 0)";
        notices.count(NoticeKind::Approximated, what, lacking.into(), place);
    }

    /// Fills in the normals; says whether they are the file's (and so the vertices still the file's).
    fn normals(
        &self,
        p: &mut Primitive,
        found: &Attributes,
        vertices: &[u32],
        place: &str,
        notices: &mut Notices,
    ) -> bool {
        let stored = found.normals.map(|accessor| vertices.par_iter().map(|&v| accessor.numbers(v)).collect());
        given_normals(p, stored, self.options, place, notices)
    }

    fn tangents(
        &self,
        p: &mut Primitive,
        found: &Attributes,
        vertices: &[u32],
        own_normals: bool,
        place: &str,
        notices: &mut Notices,
    ) {
        let alone = found.tangents.is_some() && found.normals.is_none();
        let what = "primitives have tangents but no normals; the tangents were not used";
        notices.count(NoticeKind::Repaired, what, alone.into(), place);
        let Some(map) = self.materials[p.material].normal_texture else { return };
        // Tangents of a file go with its own normals only.
        if let Some(accessor) = found.tangents.filter(|_| own_normals) {
            let (mut bad, mut odd) = (0, 0);
            let read = |(&v, &normal): (&u32, &[f32; 3])| {
                let [x, y, z, w]: [f32; 4] = accessor.numbers(v);
                let direction = DVec3::new(x.into(), y.into(), z.into());
                let length = direction.length();
                odd += u64::from((length - 1.0).abs() > UNIT || (f64::from(w).abs() - 1.0).abs() > UNIT);
                if !length.is_finite() || length < 1e-12 || w.is_nan() {
                    bad += 1;
                    return tangents::any(normal);
                }
                let [x, y, z] = (direction / length).as_vec3().to_array();
                [x, y, z, if w < 0.0 { -1.0 } else { 1.0 }]
            };
            p.tangents = vertices.iter().zip(&p.normals).map(read).collect();
            notices.count(NoticeKind::Repaired, "tangents were zero or not finite and were replaced", bad, place);
            let what = "tangents were not of unit length or had another handedness than 1 or -1; both were set right";
            notices.count(NoticeKind::Repaired, what, odd - bad.min(odd), place);
            return;
        }
        tangents::generate(p, map.uv_set as usize);
        notices.count(NoticeKind::Computed, "primitives with a normal map were given tangents", 1, place);
    }
}
