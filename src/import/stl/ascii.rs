//! The ASCII form: `solid`, then `facet normal … outer loop vertex … vertex … vertex … endloop endfacet`, then `endsolid`,
//! and perhaps the next solid. Words may stand on any line; only the names behind `solid` and `endsolid` end with theirs.

use glam::DVec3;

use super::Solid;
use crate::import::format::without_mark;
use crate::import::polygon::Polygons;
use crate::import::text::{first_word, lines, name, number};
use crate::import::triangles::{origin_of, relative, welded};
use crate::import::{Fallible, Fault, ImportOptions, Notices, Phase};
use crate::scene::NoticeKind;

/// How many lines pass between two looks at whether it has been called off.
const LINES_AT_ONCE: u64 = 1 << 16;

/// A solid as it is read: the corners of its triangles.
#[derive(Default)]
struct Raw {
    name: String,
    corners: Vec<[f64; 3]>,
}

#[derive(Default)]
struct Reader {
    solids: Vec<Raw>,
    /// Whether a solid has begun and not ended.
    open: bool,
    /// The corners of the facet that is being read; `None` between facets.
    facet: Option<Vec<[f64; 3]>>,
    polygons: Polygons,
    large: u64,
    small: u64,
    unknown: u64,
}

pub(super) fn read(bytes: &[u8], options: &ImportOptions, notices: &mut Notices) -> Fallible<Vec<Solid>> {
    let text = without_mark(bytes);
    let mut reader = Reader::default();
    let mut last = 0;
    let (mut triangles, mut read) = (0_u64, 0_usize);
    for (line, content) in lines(text) {
        last = line;
        read += content.len() + 1;
        if line % LINES_AT_ONCE == 0 {
            options.cancel.go_on()?;
            options.progress.tell(Phase::Parsing, read as f32 / text.len() as f32);
        }
        triangles += reader.line(content, line)?;
        if triangles > options.limits.most_triangles() {
            return Err(Fault::limit(format!("line {line}"), "triangles", triangles, options.limits.most_triangles()));
        }
    }
    if reader.facet.is_some() {
        return Err(Fault::invalid(format!("line {last}"), "the file ends inside a facet"));
    }
    if reader.open {
        notices.repaired("the file ends without 'endsolid'".to_owned());
    }
    notices.count(NoticeKind::Repaired, "facets with fewer than three vertices were dropped", reader.small, "file");
    notices.count(NoticeKind::Repaired, "facets with more than three vertices were triangulated", reader.large, "file");
    notices.count(NoticeKind::Ignored, "words are none of STL's and were skipped", reader.unknown, "file");
    let mut solids = Vec::new();
    let mut vertices = 0;
    options.cancel.go_on()?;
    options.progress.tell(Phase::Geometry, 0.0);
    for (i, raw) in reader.solids.into_iter().enumerate() {
        options.cancel.go_on()?;
        let origin = origin_of(&raw.corners);
        let corners: Vec<[f32; 3]> = raw.corners.iter().map(|&c| relative(c, origin)).collect();
        let primitive = welded(&corners, &format!("solid {}", i + 1), notices);
        vertices += primitive.positions.len() as u64;
        solids.push(Solid { name: raw.name, origin, primitive });
    }
    if vertices > options.limits.vertices {
        return Err(Fault::limit("file", "vertices", vertices, options.limits.vertices));
    }
    Ok(solids)
}

impl Reader {
    /// Takes one line; gives the number of triangles that it finished.
    fn line(&mut self, line: &[u8], number_of_line: u64) -> Fallible<u64> {
        let place = || format!("line {number_of_line}");
        let mut rest = line;
        let mut finished = 0;
        while let Some((word, after)) = first_word(rest) {
            rest = after;
            if word.eq_ignore_ascii_case(b"vertex") {
                let corner = self.numbers(&mut rest, number_of_line)?;
                match &mut self.facet {
                    Some(facet) => facet.push(corner),
                    None => return Err(Fault::invalid(place(), "a vertex outside a facet")),
                }
            } else if word.eq_ignore_ascii_case(b"facet") {
                if self.facet.is_some() {
                    return Err(Fault::invalid(place(), "a facet begins inside another"));
                }
                self.facet = Some(Vec::new());
                self.solid();
            } else if word.eq_ignore_ascii_case(b"endfacet") {
                let Some(facet) = self.facet.take() else {
                    return Err(Fault::invalid(place(), "'endfacet' without a facet"));
                };
                finished += self.finish(&facet);
            } else if word.eq_ignore_ascii_case(b"normal") {
                // Three numbers, which are not needed: the winding says the same.
                while let Some((_, after)) = first_word(rest).filter(|(word, _)| number(word).is_some()) {
                    rest = after;
                }
            } else if word.eq_ignore_ascii_case(b"solid") {
                if self.facet.is_some() {
                    return Err(Fault::invalid(place(), "a solid begins inside a facet"));
                }
                self.solids.push(Raw { name: name(rest), corners: Vec::new() });
                self.open = true;
                break;
            } else if word.eq_ignore_ascii_case(b"endsolid") {
                self.open = false;
                break;
            } else if ![&b"outer"[..], b"loop", b"endloop"].iter().any(|w| word.eq_ignore_ascii_case(w)) {
                self.unknown += 1;
            }
        }
        Ok(finished)
    }

    fn numbers(&self, rest: &mut &[u8], line: u64) -> Fallible<[f64; 3]> {
        let mut values = [0.0; 3];
        for value in &mut values {
            let place = || format!("line {line}");
            let Some((word, after)) = first_word(rest) else {
                return Err(Fault::invalid(place(), "a vertex has three coordinates"));
            };
            *value = number(word).ok_or_else(|| Fault::invalid(place(), format!("'{}' is no number", name(word))))?;
            *rest = after;
        }
        Ok(values)
    }

    /// The solid that is being read; facets before any 'solid' have one too.
    fn solid(&mut self) -> usize {
        if self.solids.is_empty() {
            self.solids.push(Raw::default());
        }
        self.solids.len() - 1
    }

    fn finish(&mut self, facet: &[[f64; 3]]) -> u64 {
        let solid = self.solid();
        self.small += u64::from(facet.len() < 3);
        self.large += u64::from(facet.len() > 3);
        let corners = &mut self.solids[solid].corners;
        let before = corners.len();
        self.polygons.triangulate(facet.len(), |i| DVec3::from(facet[i]), |t| corners.extend(t.map(|i| facet[i])));
        (corners.len() - before) as u64 / 3
    }
}
