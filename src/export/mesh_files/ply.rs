//! PLY, all three encodings.

use std::fmt::Write;

use super::placed;
use crate::math::color::srgb_from_linear;
use crate::scene::Scene;

/// How the values of a PLY file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    /// As text.
    Ascii,
    /// Least significant byte first.
    LittleEndian,
    /// Most significant byte first.
    BigEndian,
}

/// Writes `scene` as one mesh: positions as `double`, normals, colours in sRGB (those of the vertices times their material's)
/// and texture coordinates where every vertex has some.
pub fn write_ply(scene: &Scene, encoding: PlyEncoding) -> Vec<u8> {
    let all: Vec<_> = scene.parts.iter().flat_map(|part| placed(scene, part)).collect();
    let vertices: usize = all.iter().map(|p| p.source.positions.len()).sum();
    let uvs = all.iter().all(|p| !p.source.uvs[0].is_empty());
    let mut header = String::from("ply\nformat ");
    header.push_str(match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::LittleEndian => "binary_little_endian",
        PlyEncoding::BigEndian => "binary_big_endian",
    });
    // Writing to a string cannot fail.
    let _ = write!(header, " 1.0\nelement vertex {vertices}\n");
    for (kind, names) in [("double", "x y z"), ("float", "nx ny nz"), ("uchar", "red green blue alpha")] {
        names.split(' ').for_each(|name| header.push_str(&format!("property {kind} {name}\n")));
    }
    if uvs {
        header.push_str("property float s\nproperty float t\n");
    }
    let _ = writeln!(header, "element face {}", scene.triangle_count());
    header.push_str("property list uchar uint vertex_indices\nend_header\n");
    let mut out = Values { bytes: header.into_bytes(), encoding };
    for p in &all {
        let material = scene.materials.get(p.source.material).map_or([1.0; 4], |m| m.base_color);
        for v in 0..p.source.positions.len() {
            p.position(v).to_array().into_iter().for_each(|c| out.double(c));
            p.normal(v).as_vec3().to_array().into_iter().for_each(|c| out.float(c));
            let color = p.source.colors.get(v).copied().unwrap_or([1.0; 4]);
            for channel in 0..4 {
                let value = f64::from(color[channel] * material[channel]);
                let value = if channel < 3 { srgb_from_linear(value) } else { value.clamp(0.0, 1.0) };
                out.byte((value * 255.0).round() as u8);
            }
            if uvs {
                let [s, t] = p.source.uvs[0][v];
                out.float(s);
                out.float(1.0 - t);
            }
            out.end();
        }
    }
    let mut first = 0;
    for p in &all {
        for triangle in p.triangles() {
            out.byte(3);
            triangle.into_iter().for_each(|v| out.index((first + v) as u32));
            out.end();
        }
        first += p.source.positions.len();
    }
    out.bytes
}

struct Values {
    bytes: Vec<u8>,
    encoding: PlyEncoding,
}

impl Values {
    fn write<const N: usize>(&mut self, text: impl std::fmt::Display, little: [u8; N]) {
        match self.encoding {
            PlyEncoding::Ascii => self.bytes.extend(format!("{text} ").into_bytes()),
            PlyEncoding::LittleEndian => self.bytes.extend(little),
            PlyEncoding::BigEndian => self.bytes.extend(little.iter().rev()),
        }
    }

    fn double(&mut self, value: f64) {
        self.write(value, value.to_le_bytes());
    }

    fn float(&mut self, value: f32) {
        self.write(value, value.to_le_bytes());
    }

    fn index(&mut self, value: u32) {
        self.write(value, value.to_le_bytes());
    }

    fn byte(&mut self, value: u8) {
        self.write(value, [value]);
    }

    /// The end of an element: of a line of text.
    fn end(&mut self) {
        if self.encoding == PlyEncoding::Ascii {
            self.bytes.push(b'\n');
        }
    }
}
