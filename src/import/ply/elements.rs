//! Elements to columns: what a mesh is made of is kept, all else is read over.

use super::header::{Element, Encoding, Header, Property};
use super::values::Values;
use crate::import::{Fallible, Fault, ImportOptions, Notices, Phase};

/// Elements between two looks at whether it has been called off.
const AT_ONCE: u64 = 1 << 16;

/// The mesh as the file has it. Columns are empty or as long as `positions`.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// sRGB and alpha, from 0 to 1.
    pub(super) colors: Vec<[f32; 4]>,
    /// With v up, as in the file.
    pub(super) uvs: Vec<[f32; 2]>,
    /// The corners of all polygons, one after the other.
    pub(super) corners: Vec<i64>,
    /// Where in `corners` each polygon ends.
    pub(super) ends: Vec<usize>,
    /// One for each polygon, or none.
    pub(super) face_colors: Vec<[f32; 4]>,
    /// As `corners` and `ends`, of triangle strips; −1 begins anew.
    pub(super) strips: Vec<i64>,
    pub(super) strip_ends: Vec<usize>,
}

impl Raw {
    /// How many polygons and strips there are.
    pub(super) fn polygons(&self) -> usize {
        self.ends.len() + self.strip_ends.len()
    }
}

/// What a property is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
    Corners,
    Other,
}

fn role(element: &str, property: &Property) -> Role {
    let single = property.length.is_none();
    match (element, property.name.as_str()) {
        ("face" | "tristrips", "vertex_indices" | "vertex_index") if !single => Role::Corners,
        _ if !single => Role::Other,
        ("vertex", "x") => Role::Position(0),
        ("vertex", "y") => Role::Position(1),
        ("vertex", "z") => Role::Position(2),
        ("vertex", "nx" | "normal_x") => Role::Normal(0),
        ("vertex", "ny" | "normal_y") => Role::Normal(1),
        ("vertex", "nz" | "normal_z") => Role::Normal(2),
        ("vertex" | "face", "red" | "r" | "diffuse_red") => Role::Color(0),
        ("vertex" | "face", "green" | "g" | "diffuse_green") => Role::Color(1),
        ("vertex" | "face", "blue" | "b" | "diffuse_blue") => Role::Color(2),
        ("vertex" | "face", "alpha" | "a" | "diffuse_alpha") => Role::Color(3),
        ("vertex", "s" | "u" | "texture_u" | "texture_s" | "s0" | "u0") => Role::Uv(0),
        ("vertex", "t" | "v" | "texture_v" | "texture_t" | "t0" | "v0") => Role::Uv(1),
        _ => Role::Other,
    }
}

/// Reads all elements. What is left behind the last is told.
pub(super) fn read(header: &Header, body: &[u8], options: &ImportOptions, notices: &mut Notices) -> Fallible<Raw> {
    let mut raw = Raw::default();
    let mut values = Values::new(body, header.encoding);
    let mut seen: Vec<&str> = Vec::new();
    for element in &header.elements {
        let place = |n: u64| format!("{} {n}", element.name);
        let smallest = element.smallest(header.encoding);
        // An ASCII file need not end with white space.
        let room = values.left() + u64::from(header.encoding == Encoding::Ascii);
        if element.count.saturating_mul(smallest) > room {
            let cause = format!("the header says {}, and there are {} bytes left", element.count, values.left());
            return Err(Fault::invalid(format!("element {}", element.name), cause));
        }
        if smallest == 0 {
            continue;
        }
        let again = seen.contains(&element.name.as_str());
        let known = matches!(element.name.as_str(), "vertex" | "face" | "tristrips") && !again;
        seen.push(&element.name);
        if !known {
            notices.ignored(format!("elements '{}' are not shown ({} of them)", element.name, element.count));
        }
        if element.name == "vertex" && known && element.count > options.limits.vertices.min(u64::from(u32::MAX - 1)) {
            return Err(Fault::limit("element vertex", "vertices", element.count, options.limits.vertices));
        }
        let kept: Vec<(Property, Role)> = element
            .properties
            .iter()
            .map(|p| (p.clone(), if known { role(&element.name, p) } else { Role::Other }))
            .collect();
        if known {
            tell(element, &kept, notices)?;
        }
        for n in 0..element.count {
            if n % AT_ONCE == 0 {
                options.cancel.go_on()?;
                options.progress.tell(Phase::Parsing, 1.0 - values.left() as f32 / body.len().max(1) as f32);
            }
            one(&mut raw, element, &kept, &mut values, options).map_err(|cause| match cause {
                Stop::Bad(cause) => Fault::invalid(place(n), cause),
                Stop::Limit(needed) => Fault::limit(place(n), "corners", needed, 8 * options.limits.triangles),
            })?;
        }
    }
    let rest = match header.encoding {
        Encoding::Ascii => body[body.len() - values.left() as usize..].trim_ascii().len() as u64,
        _ => values.left(),
    };
    if rest > 0 {
        notices.repaired(format!("{rest} bytes after the last element were skipped"));
    }
    Ok(raw)
}

/// Says which properties are left out, and refuses vertices without a place.
fn tell(element: &Element, kept: &[(Property, Role)], notices: &mut Notices) -> Fallible<()> {
    let has = |role: Role| kept.iter().any(|(_, r)| *r == role);
    if element.name == "vertex" && !(0..3).all(|axis| has(Role::Position(axis))) {
        return Err(Fault::invalid("element vertex", "has no x, y and z"));
    }
    if element.name != "vertex" && !has(Role::Corners) && element.count > 0 {
        return Err(Fault::invalid(format!("element {}", element.name), "has no list 'vertex_indices'"));
    }
    let others: Vec<&str> = kept.iter().filter(|(_, r)| *r == Role::Other).map(|(p, _)| p.name.as_str()).collect();
    if !others.is_empty() {
        let listed = others.iter().take(20).copied().collect::<Vec<_>>().join(", ");
        notices.ignored(format!("properties of '{}' are not shown: {listed}", element.name));
    }
    Ok(())
}

enum Stop {
    Bad(String),
    Limit(u64),
}

impl From<String> for Stop {
    fn from(cause: String) -> Stop {
        Stop::Bad(cause)
    }
}

/// Reads one element.
fn one(
    raw: &mut Raw,
    element: &Element,
    kept: &[(Property, Role)],
    values: &mut Values,
    options: &ImportOptions,
) -> Result<(), Stop> {
    let (mut position, mut normal, mut color, mut uv) = ([0.0; 3], [0.0_f32; 3], [1.0_f32; 4], [0.0_f32; 2]);
    let (mut normals, mut colors, mut uvs) = (0, 0, 0);
    let strips = element.name == "tristrips";
    for (property, role) in kept {
        if let Some(length) = property.length {
            let count = values.length(length, property.scalar)?;
            if *role != Role::Corners {
                values.skip(property.scalar, count)?;
                continue;
            }
            let (corners, ends) =
                if strips { (&mut raw.strips, &mut raw.strip_ends) } else { (&mut raw.corners, &mut raw.ends) };
            // Polygons of n corners give n − 2 triangles; those of one or two must not fill the memory.
            let needed = corners.len() as u64 + count;
            if needed > options.limits.triangles.saturating_mul(8) {
                return Err(Stop::Limit(needed));
            }
            for _ in 0..count {
                let value = values.next(property.scalar)?;
                // Saturates; what is no index is refused where it is used.
                corners.push(if value.fract() == 0.0 { value as i64 } else { i64::MIN });
            }
            ends.push(corners.len());
            continue;
        }
        match *role {
            Role::Position(axis) => position[axis] = values.next(property.scalar)?,
            Role::Normal(axis) => {
                normal[axis] = values.next(property.scalar)? as f32;
                normals += 1;
            }
            Role::Color(channel) => {
                color[channel] = (values.next(property.scalar)? / property.scalar.full()) as f32;
                colors += usize::from(channel < 3);
            }
            Role::Uv(axis) => {
                uv[axis] = values.next(property.scalar)? as f32;
                uvs += 1;
            }
            Role::Corners | Role::Other => values.skip(property.scalar, 1)?,
        }
    }
    match element.name.as_str() {
        "vertex" => {
            raw.positions.push(position);
            // Each at least as often as it has axes; a property that is declared twice counts last.
            if normals >= 3 {
                raw.normals.push(normal);
            }
            if colors >= 3 {
                raw.colors.push(color);
            }
            if uvs >= 2 {
                raw.uvs.push(uv);
            }
        }
        "face" if colors >= 3 => raw.face_colors.push(color),
        _ => {}
    }
    Ok(())
}
