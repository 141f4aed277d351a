//! Memory of a plan: buffers with their bytes, and the bands that keep every buffer within a binding.

use serde::Serialize;

use super::{Capabilities, Capture, FramePlan, Pass, Refusal, ViewStats};
use crate::settings::{KeyFormat, NormalEncoding};

/// A buffer that the frame needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedBuffer {
    /// Name of the variable that the shaders bind it to.
    pub name: &'static str,
    /// Size in bytes.
    pub bytes: u64,
    /// Whether the size is known; otherwise the GPU counts and this is an estimate.
    pub exact: bool,
}

/// Rows of the image that are made in one go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Band {
    /// First row whose layers are captured (with apron).
    pub first_row: u32,
    /// One past the last captured row.
    pub end_row: u32,
    /// First row written to the image.
    pub first_output_row: u32,
    /// One past the last row written to the image.
    pub end_output_row: u32,
}

impl FramePlan {
    /// The store's columns: name and bytes of an element.
    pub fn columns(&self) -> Vec<(&'static str, u64)> {
        columns(self)
    }

    /// Bytes of the largest element of any column: what limits the fragments of a band.
    pub fn widest_column(&self) -> u64 {
        columns(self).into_iter().map(|(_, bytes)| bytes).fold(8, u64::max)
    }
}

/// Bytes of a column's element, by name, for the columns that a plan can have.
fn columns(plan: &FramePlan) -> Vec<(&'static str, u64)> {
    let (wide, whole) = match plan.capture {
        Capture::None => return Vec::new(),
        Capture::Compacted | Capture::LinkedList { .. } => (true, true),
        Capture::BucketedKBuffer { key, .. } => (key == KeyFormat::Wide64, false),
    };
    let shape = shape_bytes(plan.normals);
    let mut all = vec![
        ("keys", if wide { 8 } else { 4 }),
        ("shapes", shape),
        ("colors", if wide { 8 } else { 4 }),
        ("materials", 8),
        ("lit", 8),
    ];
    if whole {
        all.extend([
            ("arrival_keys", 8),
            ("arrival_colors", 8),
            ("arrival_surfaces", shape),
            ("arrival_emissive", 4),
            ("sources", 4),
        ]);
    }
    if plan.runs(Pass::Fill) {
        all.push(("list_next", 4));
    }
    if plan.features.is_some() || plan.runs(Pass::PartLookup) {
        all.push(("parts", 4));
    }
    if plan.runs(Pass::ZReordering) {
        all.extend([("by_part", 4), ("buckets", 8)]);
    }
    if plan.runs(Pass::Parametrize) {
        all.push(("parameters", 16));
    }
    if plan.runs(Pass::NeighbourCandidates) {
        all.extend([("candidates_ahead", 4), ("candidates_behind", 8)]);
    }
    if plan.runs(Pass::NeighbourLinks) {
        all.extend([("links_ahead", 4), ("links_behind", 8)]);
    }
    if plan.runs(Pass::Curvature) {
        all.push(("kappas", 4));
    }
    if plan.runs(Pass::Boundary) {
        all.extend([("fields_even", 16), ("layer_ends", 4)]);
    }
    if plan.runs(Pass::FeatureSize) {
        all.push(("chords", 4));
    }
    if plan.runs(Pass::Diffuse) {
        all.extend([("fields_odd", 16), ("around_slots", 16)]);
        if !whole {
            all.push(("listed_slots", 4));
        }
    }
    all
}

/// Bytes of depth and normal of a layer.
fn shape_bytes(normals: NormalEncoding) -> u64 {
    match normals {
        NormalEncoding::Octahedral | NormalEncoding::Xy15 => 8,
        NormalEncoding::Full => 16,
    }
}

impl FramePlan {
    /// Most fragments that a band may have in buffers of at most `largest` bytes and, for linked lists, in their memory.
    pub fn most_fragments(&self, largest: u64) -> u64 {
        let by_buffer = largest / self.widest_column();
        match self.capture {
            Capture::LinkedList { memory, .. } => {
                by_buffer.min(memory / columns(self).into_iter().map(|(_, bytes)| bytes).sum::<u64>().max(1))
            }
            _ => by_buffer,
        }
    }

    /// Fragments for which room is made before they are counted, in an image of so many pixels.
    pub fn first_capacity(&self, pixels: u64) -> u64 {
        match self.capture {
            Capture::LinkedList { capacity, .. } if capacity > 0 => u64::from(capacity),
            _ => LAYERS_EXPECTED * pixels,
        }
    }
}

/// Layers a pixel that an estimate assumes when nothing is known: what the measured assemblies have over covered pixels.
const LAYERS_EXPECTED: u64 = 9;

/// Fills in buffers and bands: those of the whole image, or of a picked row and its apron.
pub(super) fn fill(
    plan: &mut FramePlan,
    picked: Option<u32>,
    view: &ViewStats,
    capabilities: &Capabilities,
) -> Result<(), Refusal> {
    let [width, height] = plan.size;
    let limit = capabilities.largest_buffer();
    let widest = plan.widest_column();
    let pixels = u64::from(width) * u64::from(height);
    // Rows are read back with a length that is a multiple of 256 bytes.
    let row_bytes = (16 * u64::from(width)).next_multiple_of(256);
    let bytes = row_bytes * u64::from(height);
    if bytes > capabilities.max_buffer {
        let (limit, fits) = (capabilities.max_buffer, capabilities.max_buffer / row_bytes);
        return Err(Refusal::ReadBackTooLarge { width, height, bytes, limit, fits });
    }
    // The smallest band: a row and its apron.
    let needed = (1 + 2 * u64::from(plan.apron)).min(u64::from(height));
    let image = PlannedBuffer { name: "image", bytes: 16 * pixels, exact: true };
    let mut buffers = if picked.is_some() { Vec::new() } else { vec![image] };
    let bands = |height: u32, rows: u64, apron: u32| match picked {
        Some(row) => vec![band_around(row, row + 1, height, apron)],
        None => equal_bands(height, rows, apron),
    };
    if plan.runs(Pass::OutlineMask) {
        buffers.push(PlannedBuffer { name: "outline_mask", bytes: pixels, exact: true });
    }
    if plan.samples > 1 {
        buffers.push(PlannedBuffer { name: "sums", bytes: 32 * pixels, exact: true });
    }
    match plan.capture {
        Capture::None => {
            buffers.push(PlannedBuffer { name: "opaque_colors", bytes: 8 * pixels, exact: true });
            buffers.push(PlannedBuffer { name: "opaque_depth", bytes: 4 * pixels, exact: true });
            plan.bands = vec![Band { first_row: 0, end_row: height, first_output_row: 0, end_output_row: height }];
        }
        Capture::BucketedKBuffer { k, tail, .. } => {
            // The tally has 8 bytes a pixel and the tail 24, which for small k is more than a column.
            let row = |k: u32| u64::from(width) * (u64::from(k) * widest).max(if tail { 24 } else { 8 });
            let rows = limit / row(k);
            if rows < needed {
                let fits = (1..k).rev().find(|&k| limit / row(k) >= needed);
                return Err(Refusal::RowTooLarge { k, width, rows: needed, bytes: needed * row(k), limit, fits });
            }
            plan.bands = bands(height, rows, plan.apron);
            let band_pixels =
                plan.bands.iter().map(|b| b.end_row - b.first_row).max().unwrap_or(0) as u64 * u64::from(width);
            let slots = band_pixels * u64::from(k);
            buffers.extend(columns(plan).into_iter().map(|(name, b)| PlannedBuffer {
                name,
                bytes: b * slots,
                exact: true,
            }));
            buffers.push(PlannedBuffer { name: "pixel_table", bytes: 4 * band_pixels, exact: true });
            buffers.push(PlannedBuffer { name: "tally", bytes: 8 * band_pixels, exact: true });
            if plan.runs(Pass::ZReordering) {
                buffers.push(PlannedBuffer { name: "class_pixels", bytes: 4 * band_pixels, exact: true });
            }
            if plan.runs(Pass::Boundary) {
                buffers.push(PlannedBuffer { name: "ends", bytes: 8 * band_pixels, exact: true });
            }
            if tail {
                buffers.push(PlannedBuffer { name: "tail", bytes: 24 * band_pixels, exact: true });
            }
        }
        Capture::Compacted | Capture::LinkedList { .. } => {
            let most = plan.most_fragments(limit).max(1);
            let fragments = view.fragments.unwrap_or(LAYERS_EXPECTED * pixels);
            let count = fragments.div_ceil(most).max(1);
            plan.bands = bands(height, (u64::from(height) / count).max(1) + 2 * u64::from(plan.apron), plan.apron);
            let in_band = fragments.min(most);
            let exact = false;
            // The pixel table has an entry more than there are pixels.
            let entry = if plan.runs(Pass::Boundary) { 8 } else { 4 };
            let most_rows = (limit / entry).saturating_sub(1) / u64::from(width);
            if most_rows < needed {
                let bytes = entry * (needed * u64::from(width) + 1);
                let fits = ((limit / entry).saturating_sub(1) / needed) as u32;
                return Err(Refusal::TableTooLarge { width, rows: needed, bytes, limit, fits });
            }
            plan.most_rows = most_rows.min(if picked.is_some() { needed } else { u64::from(height) }) as u32;
            let pixels = u64::from(plan.most_rows) * u64::from(width);
            buffers.extend(columns(plan).into_iter().map(|(name, b)| PlannedBuffer {
                name,
                bytes: b * in_band,
                exact,
            }));
            buffers.push(PlannedBuffer { name: "pixel_table", bytes: 4 * (pixels + 1), exact: true });
            buffers.push(PlannedBuffer { name: "cursors", bytes: 4 * pixels, exact: true });
            if plan.runs(Pass::Fill) {
                buffers.push(PlannedBuffer { name: "list_heads", bytes: 4 * pixels, exact: true });
                buffers.push(PlannedBuffer { name: "list_count", bytes: 4, exact: true });
            }
            buffers.push(PlannedBuffer { name: "class_pixels", bytes: 4 * pixels, exact: true });
            if plan.runs(Pass::Boundary) {
                buffers.push(PlannedBuffer { name: "ends", bytes: 8 * pixels, exact: true });
            }
        }
    }
    plan.buffers = buffers;
    Ok(())
}

/// Bands of at most `rows` captured rows each (apron included).
fn equal_bands(height: u32, rows: u64, apron: u32) -> Vec<Band> {
    if rows >= u64::from(height) {
        return vec![Band { first_row: 0, end_row: height, first_output_row: 0, end_output_row: height }];
    }
    let own = (rows - 2 * u64::from(apron)).max(1) as u32;
    (0..height).step_by(own as usize).map(|first| band_around(first, height.min(first + own), height, apron)).collect()
}

fn band_around(first: u32, end: u32, height: u32, apron: u32) -> Band {
    Band {
        first_row: first.saturating_sub(apron),
        end_row: (end + apron).min(height),
        first_output_row: first,
        end_output_row: end,
    }
}

/// Cuts the image into bands so that none captures more than `most` fragments or `most_rows` rows, from the counted
/// fragments of each row.
///
/// A band has at least one row; if one row with its apron alone exceeds `most`, the row and its count are the error.
///
/// # Errors
/// `(row, fragments)` of the first row that does not fit.
pub fn bands_of_rows(row_fragments: &[u64], apron: u32, most: u64, most_rows: u32) -> Result<Vec<Band>, (u32, u64)> {
    let height = row_fragments.len() as u32;
    let sum = |band: &Band| -> u64 { row_fragments[band.first_row as usize..band.end_row as usize].iter().sum() };
    let mut bands = Vec::new();
    let mut first = 0;
    while first < height {
        let mut end = height;
        let mut band = band_around(first, end, height, apron);
        while sum(&band) > most || band.end_row - band.first_row > most_rows {
            let rows = end - first;
            if rows == 1 {
                return Err((first, sum(&band)));
            }
            // Aim at what the mean row allows, and at least one row less.
            let by_fragments = (u64::from(rows) * most / sum(&band).max(1)) as u32;
            let guess = by_fragments.min(most_rows.saturating_sub(2 * apron));
            end = first + guess.clamp(1, rows - 1);
            band = band_around(first, end, height, apron);
        }
        bands.push(band);
        first = end;
    }
    Ok(bands)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once_and_fit() {
        let rows: Vec<u64> = (0..97).map(|r| 100 + 37 * (r % 11)).collect();
        for apron in [0, 1, 5] {
            let bands = bands_of_rows(&rows, apron, 6000, 97).unwrap();
            assert!(bands.len() > 1);
            assert_eq!(bands[0].first_output_row, 0);
            assert_eq!(bands.last().unwrap().end_output_row, 97);
            for pair in bands.windows(2) {
                assert_eq!(pair[0].end_output_row, pair[1].first_output_row);
            }
            for b in &bands {
                assert!(rows[b.first_row as usize..b.end_row as usize].iter().sum::<u64>() <= 6000);
                assert_eq!(b.first_row, b.first_output_row.saturating_sub(apron));
            }
        }
        assert_eq!(bands_of_rows(&[10, 99, 10], 0, 50, 3), Err((1, 99)));
        assert_eq!(bands_of_rows(&[0; 40], 1, 1, 10).unwrap().len(), 5);
        assert_eq!(bands_of_rows(&[0; 4], 3, 1, 4).unwrap().len(), 1);
    }
}
