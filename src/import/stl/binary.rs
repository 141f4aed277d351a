//! The binary form: 80 bytes of anything, a count, and 50 bytes a triangle (normal, three corners, two bytes).

use glam::DVec3;
use rayon::prelude::*;

use super::Solid;
use crate::import::format::stl_count;
use crate::import::steps::Steps;
use crate::import::triangles::welded;
use crate::import::{Fallible, Fault, ImportOptions, Notices, Phase};

const HEADER: usize = 84;
const RECORD: usize = 50;
/// Triangles that one thread reads at a time.
const AT_ONCE: usize = 1 << 14;

pub(super) fn read(bytes: &[u8], options: &ImportOptions, notices: &mut Notices) -> Fallible<Vec<Solid>> {
    let Some(count) = stl_count(bytes) else {
        return Err(Fault::invalid("file", format!("a binary STL has at least 84 bytes, this has {}", bytes.len())));
    };
    let records = &bytes[HEADER..];
    let whole = (records.len() / RECORD) as u64;
    if u64::from(count) > whole {
        let cause = format!("says {count} triangles, and there are bytes for {whole}");
        return Err(Fault::invalid("triangle count", cause));
    }
    if u64::from(count) > options.limits.most_triangles() {
        return Err(Fault::limit("triangle count", "triangles", count.into(), options.limits.most_triangles()));
    }
    // Checked: not more than there are bytes.
    let (records, surplus) = records.split_at(count as usize * RECORD);
    if !surplus.is_empty() {
        notices.repaired(format!("{} bytes after the last triangle were skipped", surplus.len()));
    }
    let mut corners = vec![[0.0_f32; 3]; 3 * count as usize];
    // Of a mapped file this is also when its bytes come from the disk.
    let steps = Steps::new(options, Phase::Parsing, [0.0, 1.0], (count as usize).div_ceil(AT_ONCE));
    let read = |corners: &mut [[f32; 3]], records: &[u8]| {
        let mut colored = 0_u64;
        for (corners, record) in corners.chunks_exact_mut(3).zip(records.chunks_exact(RECORD)) {
            let float = |at: usize| f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
            for (c, corner) in corners.iter_mut().enumerate() {
                *corner = std::array::from_fn(|axis| float(12 + 12 * c + 4 * axis));
            }
            colored += u64::from(record[48..50] != [0, 0]);
        }
        colored
    };
    let colored = corners
        .par_chunks_mut(3 * AT_ONCE)
        .zip(records.par_chunks(RECORD * AT_ONCE))
        .map(|(corners, records)| steps.each(|| Ok(read(corners, records))))
        .try_reduce(|| 0, |a, b| Ok(a + b))?;
    options.cancel.go_on()?;
    options.progress.tell(Phase::Geometry, 0.0);
    if colored > 0 {
        notices.ignored(format!(
            "{colored} triangles have attribute bytes, which may be colours (VisCAM, Magics); they are not shown"
        ));
    }
    let primitive = welded(&corners, "file", notices);
    let vertices = primitive.positions.len() as u64;
    if vertices > options.limits.vertices {
        return Err(Fault::limit("file", "vertices", vertices, options.limits.vertices));
    }
    // The name is not read: the 80 bytes hold dates, units, colours.
    Ok(vec![Solid { name: String::new(), origin: DVec3::ZERO, primitive }])
}
