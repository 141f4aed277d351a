//! Lines to numbers: vertices, and triangles of indices sorted by part, material and how they get their normals.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;

use crate::import::format::without_mark;
use crate::import::polygon::Polygons;
use crate::import::text::{first_word, integer, lines, name, number, words};
use crate::import::{Fallible, Fault, ImportOptions, Notices, Phase};
use crate::scene::NoticeKind;

/// How many lines pass between two looks at whether it has been called off.
const LINES_AT_ONCE: u64 = 1 << 16;
/// A corner without texture coordinates or normal.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a face: which position, texture coordinates, normal; from 0, or [`NONE`].
pub(super) type Corner = [u32; 3];

/// Where the normals of faces come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shading {
    /// All corners have one.
    Given,
    /// Smooth over every edge between two faces of this smoothing group.
    Smooth(i64),
    /// Smooth up to the crease angle.
    Crease,
}

/// Triangles that are alike.
pub(super) struct Bucket {
    pub(super) part: usize,
    pub(super) material: usize,
    pub(super) shading: Shading,
    pub(super) triangles: Vec<[Corner; 3]>,
}

/// A part by its names, which may be empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct PartName {
    pub(super) object: String,
    pub(super) group: String,
}

/// The whole file.
#[derive(Default)]
pub(super) struct Model {
    pub(super) positions: Vec<[f64; 3]>,
    /// As many as positions, or none if no vertex has a colour. sRGB.
    pub(super) colors: Vec<[f32; 3]>,
    /// With v up, as in the file.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// In order of their first face.
    pub(super) parts: Vec<PartName>,
    /// The names of used materials, in order; an empty one stands for none.
    pub(super) materials: Vec<String>,
    /// What stands behind `mtllib`, in order.
    pub(super) libraries: Vec<Vec<u8>>,
    pub(super) buckets: Vec<Bucket>,
}

impl Model {
    /// Whether the file tells more than one part.
    pub(super) fn names_parts(&self) -> bool {
        self.parts.len() > 1
    }
}

struct Reader<'a> {
    model: Model,
    options: &'a ImportOptions,
    part: PartName,
    material: String,
    smoothing: i64,
    /// The bucket of (part, material, shading), so that faces need no look-up of names.
    known: HashMap<(usize, usize, Shading), usize>,
    part_numbers: HashMap<PartName, usize>,
    material_numbers: HashMap<String, usize>,
    /// Part and material of the current face, if names have not changed since.
    current: Option<(usize, usize)>,
    polygons: Polygons,
    face: Vec<Corner>,
    triangles: u64,
    counts: Counts,
}

/// What is told once.
#[derive(Default)]
struct Counts {
    points_and_lines: u64,
    curves: u64,
    small: u64,
    weights: u64,
    unknown: u64,
    bad_colors: u64,
    bad_uvs: u64,
}

/// Reads all statements.
pub(super) fn read(bytes: &[u8], options: &ImportOptions, notices: &mut Notices) -> Fallible<Model> {
    let text = without_mark(bytes);
    let mut reader = Reader {
        model: Model::default(),
        options,
        part: PartName::default(),
        material: String::new(),
        smoothing: 0,
        known: HashMap::new(),
        part_numbers: HashMap::new(),
        material_numbers: HashMap::new(),
        current: None,
        polygons: Polygons::default(),
        face: Vec::new(),
        triangles: 0,
        counts: Counts::default(),
    };
    let mut lines = lines(text);
    let (mut read, mut told) = (0_usize, 0);
    while let Some((line, first)) = lines.next() {
        let mut content = Cow::Borrowed(first);
        let mut last = line;
        // A comment that ends with a backslash, like a path, is not continued.
        while let Some(before) = continued(&content) {
            let mut joined = content[..before].to_vec();
            joined.push(b' ');
            let Some((number, next)) = lines.next() else {
                content = Cow::Owned(joined);
                break;
            };
            joined.extend_from_slice(next);
            last = number;
            content = Cow::Owned(joined);
        }
        read += content.len() + 1;
        if last >= told {
            told = last + LINES_AT_ONCE;
            options.cancel.go_on()?;
            options.progress.tell(Phase::Parsing, read as f32 / text.len() as f32);
        }
        reader.statement(&content, line)?;
    }
    reader.tell(notices);
    Ok(reader.model)
}

/// Where the line ends if the next one continues it.
fn continued(line: &[u8]) -> Option<usize> {
    let trimmed = line.trim_ascii_end();
    (trimmed.ends_with(b"\\") && !line.trim_ascii_start().starts_with(b"#")).then(|| trimmed.len() - 1)
}

impl Reader<'_> {
    fn statement(&mut self, line: &[u8], number_of_line: u64) -> Fallible<()> {
        let Some((word, rest)) = first_word(line) else { return Ok(()) };
        match word {
            b"v" => self.vertex(rest, number_of_line)?,
            b"vt" => {
                let [u, v] = numbers::<2>(rest, 1, number_of_line)?;
                let uv = [u as f32, v as f32];
                let finite = uv.iter().all(|c| c.is_finite());
                self.counts.bad_uvs += u64::from(!finite);
                self.model.uvs.push(if finite { uv } else { [0.0; 2] });
                self.room(self.model.uvs.len(), number_of_line)?;
            }
            b"vn" => {
                let normal = numbers::<3>(rest, 3, number_of_line)?;
                self.model.normals.push(normal.map(|c| c as f32));
                self.room(self.model.normals.len(), number_of_line)?;
            }
            b"f" | b"fo" => self.face(rest, number_of_line)?,
            b"o" => {
                self.part = PartName { object: name(rest), group: String::new() };
                self.current = None;
            }
            b"g" => {
                self.part.group = name(rest);
                self.current = None;
            }
            b"usemtl" => {
                self.material = name(rest);
                self.current = None;
            }
            b"s" => {
                self.smoothing = words(rest).next().and_then(integer).unwrap_or(0);
            }
            b"mtllib" => self.model.libraries.push(rest.to_vec()),
            b"p" | b"l" => self.counts.points_and_lines += 1,
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => self.counts.curves += 1,
            _ if word.starts_with(b"#") => {}
            _ => self.counts.unknown += 1,
        }
        Ok(())
    }

    fn room(&self, count: usize, line: u64) -> Fallible<()> {
        let allowed = self.options.limits.vertices.min(u64::from(u32::MAX - 1));
        if count as u64 > allowed {
            return Err(Fault::limit(format!("line {line}"), "vertices", count as u64, allowed));
        }
        Ok(())
    }

    /// `v x y z`, `v x y z w`, `v x y z r g b`, and the last with an alpha behind it.
    fn vertex(&mut self, rest: &[u8], line: u64) -> Fallible<()> {
        let mut values = [0.0; 7];
        let mut count = 0;
        for (value, word) in values.iter_mut().zip(words(rest)) {
            if word.starts_with(b"#") {
                break;
            }
            *value = parse(word, line)?;
            count += 1;
        }
        if count < 3 {
            return Err(Fault::invalid(format!("line {line}"), format!("a vertex with {count} of 3 coordinates")));
        }
        let [x, y, z, r, g, b, _] = values;
        self.counts.weights += u64::from(count == 4 && r != 1.0);
        self.model.positions.push([x, y, z]);
        self.room(self.model.positions.len(), line)?;
        if count >= 6 {
            let color = [r, g, b];
            let possible = color.iter().all(|c| (0.0..=1.0).contains(c));
            self.counts.bad_colors += u64::from(!possible);
            self.model.colors.resize(self.model.positions.len() - 1, [1.0; 3]);
            let mend = |c: f64| if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) as f32 };
            self.model.colors.push(color.map(mend));
        } else if !self.model.colors.is_empty() {
            self.model.colors.push([1.0; 3]);
        }
        Ok(())
    }

    fn face(&mut self, rest: &[u8], line: u64) -> Fallible<()> {
        self.face.clear();
        let counts = [self.model.positions.len(), self.model.uvs.len(), self.model.normals.len()];
        for word in words(rest) {
            if word.starts_with(b"#") {
                break;
            }
            self.face.push(corner(word, counts, line)?);
        }
        if self.face.len() < 3 {
            self.counts.small += 1;
            return Ok(());
        }
        let given = self.face.iter().all(|c| c[2] != NONE);
        let shading = match self.smoothing {
            _ if given => Shading::Given,
            group if group > 0 => Shading::Smooth(group),
            _ => Shading::Crease,
        };
        let bucket = self.bucket(shading);
        let Reader { model, face, polygons, .. } = self;
        let Model { positions, buckets, .. } = model;
        let triangles = &mut buckets[bucket].triangles;
        let before = triangles.len();
        let position = |i: usize| DVec3::from(positions[face[i][0] as usize]);
        polygons.triangulate(face.len(), position, |t| triangles.push(t.map(|i| face[i])));
        self.triangles += (triangles.len() - before) as u64;
        if self.triangles > self.options.limits.most_triangles() {
            let allowed = self.options.limits.most_triangles();
            return Err(Fault::limit(format!("line {line}"), "triangles", self.triangles, allowed));
        }
        Ok(())
    }

    /// The bucket for a face that comes now.
    fn bucket(&mut self, shading: Shading) -> usize {
        let (part, material) = match self.current {
            Some(current) => current,
            None => {
                let part = *self.part_numbers.entry(self.part.clone()).or_insert_with(|| {
                    self.model.parts.push(self.part.clone());
                    self.model.parts.len() - 1
                });
                let material = *self.material_numbers.entry(self.material.clone()).or_insert_with(|| {
                    self.model.materials.push(self.material.clone());
                    self.model.materials.len() - 1
                });
                *self.current.insert((part, material))
            }
        };
        *self.known.entry((part, material, shading)).or_insert_with(|| {
            self.model.buckets.push(Bucket { part, material, shading, triangles: Vec::new() });
            self.model.buckets.len() - 1
        })
    }

    fn tell(&self, notices: &mut Notices) {
        use NoticeKind::{Approximated, Ignored, Repaired};
        let counts = &self.counts;
        for (kind, what, count) in [
            (Ignored, "statements of points or lines are not shown", counts.points_and_lines),
            (Ignored, "statements of free-form curves and surfaces are not shown", counts.curves),
            (Ignored, "statements are none that is known and were skipped", counts.unknown),
            (Ignored, "vertices have a weight, which only curves use", counts.weights),
            (Repaired, "faces with fewer than three corners were dropped", counts.small),
            (Repaired, "vertex colours were outside 0 to 1 and were clamped", counts.bad_colors),
            (Repaired, "texture coordinates were not finite and became 0", counts.bad_uvs),
            (Approximated, "faces have so many corners that they may be filled wrongly", self.polygons.unfinished),
        ] {
            notices.count(kind, what, count, "file");
        }
    }
}

fn parse(word: &[u8], line: u64) -> Fallible<f64> {
    number(word).ok_or_else(|| Fault::invalid(format!("line {line}"), format!("'{}' is no number", name(word))))
}

/// The first `N` numbers of a line, of which `needed` must be there; the others are 0.
fn numbers<const N: usize>(rest: &[u8], needed: usize, line: u64) -> Fallible<[f64; N]> {
    let mut values = [0.0; N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(words(rest)) {
        *value = parse(word, line)?;
        count += 1;
    }
    if count < needed {
        return Err(Fault::invalid(format!("line {line}"), format!("{count} of {needed} numbers")));
    }
    Ok(values)
}

/// `7`, `7/2`, `7//3` or `7/2/3`, where negative numbers count from the last.
fn corner(word: &[u8], counts: [usize; 3], line: u64) -> Fallible<Corner> {
    const WHAT: [&str; 3] = ["vertex", "texture coordinate", "normal"];
    let mut corner = [NONE; 3];
    for (i, field) in word.split(|&b| b == b'/').enumerate() {
        if field.is_empty() && i > 0 {
            continue;
        }
        let bad = |cause: String| Fault::invalid(format!("line {line}"), cause);
        let index = integer(field).filter(|_| i < 3);
        let index = index.ok_or_else(|| bad(format!("'{}' is no corner of a face", name(word))))?;
        let count = counts[i] as i64;
        let found = match index {
            1.. => index - 1,
            0 => return Err(bad(format!("{} 0: they are counted from 1", WHAT[i]))),
            _ => count.saturating_add(index),
        };
        if found < 0 || found >= count {
            return Err(bad(format!("{} {index} does not exist: {count} come before this line", WHAT[i])));
        }
        // Checked: less than a count, which `room` keeps below u32::MAX.
        corner[i] = found as u32;
    }
    Ok(corner)
}
