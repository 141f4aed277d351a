//! OBJ and its material file.

use std::fmt::Write;

use super::placed;
use crate::math::color::srgb_from_linear;
use crate::scene::{AlphaMode, Scene};

/// Writes `scene` as an OBJ that names the material file `library` (see [`write_mtl`]): an object for each part, coordinates
/// with as many digits as they have. Vertex colours stand behind the positions, in sRGB.
pub fn write_obj(scene: &Scene, library: &str) -> Vec<u8> {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_all(scene, library, &mut out);
    out.into_bytes()
}

fn write_all(scene: &Scene, library: &str, out: &mut String) -> std::fmt::Result {
    writeln!(out, "mtllib {library}")?;
    // OBJ counts from 1, through the whole file.
    let (mut first, mut first_uv) = (1, 1);
    for part in &scene.parts {
        writeln!(out, "o {}", line(&part.name))?;
        for p in placed(scene, part) {
            let count = p.source.positions.len();
            for v in 0..count {
                let [x, y, z] = p.position(v).to_array();
                write!(out, "v {x} {y} {z}")?;
                if let Some(&[r, g, b, _]) = p.source.colors.get(v) {
                    let [r, g, b] = [r, g, b].map(|c| srgb_from_linear(c.into()));
                    write!(out, " {r} {g} {b}")?;
                }
                writeln!(out)?;
            }
            for v in 0..count {
                let [x, y, z] = p.normal(v).as_vec3().to_array();
                writeln!(out, "vn {x} {y} {z}")?;
            }
            for [u, v] in &p.source.uvs[0] {
                writeln!(out, "vt {u} {}", 1.0 - v)?;
            }
            writeln!(out, "usemtl {}", material_name(scene, p.source.material))?;
            let uvs = !p.source.uvs[0].is_empty();
            for triangle in p.triangles() {
                write!(out, "f")?;
                for v in triangle {
                    let (at, uv) = (first + v, first_uv + v);
                    if uvs { write!(out, " {at}/{uv}/{at}")? } else { write!(out, " {at}//{at}")? }
                }
                writeln!(out)?;
            }
            first += count;
            first_uv += p.source.uvs[0].len();
        }
    }
    Ok(())
}

/// Writes the materials of `scene` for [`write_obj`].
pub fn write_mtl(scene: &Scene) -> Vec<u8> {
    let mut out = String::new();
    for (i, m) in scene.materials.iter().enumerate() {
        let [r, g, b, a] = m.base_color;
        let [r, g, b] = [r, g, b].map(|c| srgb_from_linear(c.into()));
        let [er, eg, eb] = m.emissive.map(|c| if c > 1.0 { c.into() } else { srgb_from_linear(c.into()) });
        let alpha = if m.alpha_mode == AlphaMode::Blend { a } else { 1.0 };
        let _ = writeln!(
            out,
            "newmtl {}\nKd {r} {g} {b}\nKe {er} {eg} {eb}\nPm {}\nPr {}\nd {alpha}",
            material_name(scene, i),
            m.metallic,
            m.roughness
        );
    }
    out.into_bytes()
}

/// Materials are told apart by name only, so the number belongs to it.
fn material_name(scene: &Scene, material: usize) -> String {
    let name = scene.materials.get(material).map(|m| line(&m.name)).unwrap_or_default();
    let unique = !name.is_empty() && scene.materials.iter().filter(|m| line(&m.name) == name).count() == 1;
    if unique { name } else { format!("{name} {material}").trim().to_owned() }
}

/// A name on a line of its own.
fn line(name: &str) -> String {
    name.replace(|c: char| c.is_control(), " ").trim().to_owned()
}
