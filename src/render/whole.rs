//! Captures that keep every layer: how many there are is known only when they are counted, and then cut into bands that fit.

use super::frame::{Tally, View, Work, capture_counted, count_band, ensure_fragments, light_layers};
use super::{Kept, RenderError, Renderer};
use crate::gpu::{GpuError, Resource};
use crate::passes::capture::{BAND_DEEPEST, STATISTICS_WORDS, linked_list};
use crate::passes::{StoreLayout, composite, opacity};
use crate::plan::{self, Band, Capture, FramePlan, Pass};

/// Captures all layers: counts, cuts bands that fit, and draws each. Linked lists are filled and counted in one, and filled
/// again where there was no room for all of them.
pub(super) fn draw_whole(
    renderer: &mut Renderer,
    plan: &FramePlan,
    view: &View<'_>,
    blank: &wgpu::TextureView,
    tally: &mut Tally,
) -> Result<(), RenderError> {
    let height = plan.size[1];
    // A band without apron may hold as many rows as its pixel table fits; usually that is all of them.
    let mut rows = Vec::with_capacity(height as usize);
    let mut deepest = 0;
    let room = make_room(renderer, plan)?;
    for first in (0..height).step_by(plan.most_rows as usize) {
        let end = height.min(first + plan.most_rows);
        let piece = Band { first_row: first, end_row: end, first_output_row: first, end_output_row: end };
        let mut work = Work::new(renderer, plan, view, piece, blank)?;
        count_band(&mut work.context(), view.scene)?;
        work.submit_times(tally)?;
        let words = |bytes: &[u8]| bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect::<Vec<u32>>();
        let buffer = |name| renderer.resources.require("prefix sum", name);
        let wanted =
            [(buffer("row_sums")?, 4 * u64::from(end - first)), (buffer("statistics")?, 4 * STATISTICS_WORDS as u64)];
        let read = renderer.gpu.read_buffers(&wanted)?;
        rows.extend(words(&read[0]).into_iter().map(u64::from));
        deepest = deepest.max(words(&read[1])[BAND_DEEPEST]);
    }
    let most = renderer.gpu.capabilities().most_layers;
    if deepest > most {
        return Err(RenderError::PixelTooDeep { layers: deepest, limit: most });
    }
    let largest = renderer.gpu.capabilities().largest_buffer();
    let limit = plan.most_fragments(largest);
    let bands = plan::bands_of_rows(&rows, plan.apron, limit, plan.most_rows).map_err(|(row, fragments)| match plan
        .capture
    {
        Capture::LinkedList { memory, .. } if limit < largest / plan.widest_column() => {
            RenderError::ListsTooLarge { row, fragments, limit, memory: memory >> 20 }
        }
        _ => RenderError::RowTooDeep { row, fragments, limit },
    })?;
    let single = bands.len() == 1;
    let mut first = true;
    // Opacity that depends on the whole image wants all bands captured before the first is lit.
    let rounds: &[bool] = if plan.gathers_first(bands.len()) { &[false, true] } else { &[true] };
    for &lights in rounds {
        for &band in &bands {
            let fragments = rows[band.first_row as usize..band.end_row as usize].iter().sum();
            let lacking = room.is_some_and(|room| fragments > room);
            ensure_fragments(renderer, plan, fragments, deepest)?;
            let mut work = Work::new(renderer, plan, view, band, blank)?;
            let mut context = work.context();
            context.deepest = deepest;
            if !single || lacking {
                count_band(&mut context, view.scene)?;
                tally.refilled += u32::from(lacking && lights);
            }
            capture_counted(&mut context, view.scene)?;
            if !lights || single {
                opacity::gather(&mut context, std::mem::take(&mut first))?;
            }
            if lights {
                light_layers(&mut context, Kept::Nothing)?;
                composite::blend(&mut context)?;
                work.finish(tally)?;
                tally.collect(renderer, plan, view, band)?;
                tally.room = Some((fragments, deepest));
            } else {
                work.submit_times(tally)?;
            }
        }
    }
    Ok(())
}

/// Makes room for linked lists before their fragments are counted: as planned, or as much as an earlier frame needed. Gives
/// the number of fragments.
fn make_room(renderer: &mut Renderer, plan: &FramePlan) -> Result<Option<u64>, GpuError> {
    if !plan.runs(Pass::Fill) {
        return Ok(None);
    }
    let gpu = renderer.gpu.clone();
    let there = renderer.resources.buffer("list_next").map_or(0, |b| b.size() / 4);
    let pixels = u64::from(plan.size[0]) * u64::from(plan.most_rows);
    let most = plan.most_fragments(gpu.capabilities().largest_buffer());
    let room = plan.first_capacity(pixels).max(there).clamp(1, most.max(1));
    for (name, bytes) in plan.columns().into_iter().filter(|(name, _)| linked_list::COLUMNS.contains(name)) {
        renderer.resources.ensure(&gpu, name, bytes * room)?;
    }
    let layout = StoreLayout { k: 0, capacity: room as u32, chunk: 1, _pad: 0 };
    renderer.resources.set("store_layout", Resource::Buffer(gpu.uniform("store_layout", &layout)?));
    Ok(Some(room))
}
