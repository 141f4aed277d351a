//! Records the passes of a frame and times each.
//!
//! Two ways of timing. Timestamps cost nothing and are right on GPUs. On Mesa's software rasterizer a compute pass begins only
//! when something waits for it, so its timestamps say next to nothing (a 45 ms pass reads 0.03 ms); there the benchmark runs
//! pass by pass, submitting each and waiting, and takes wall time. That is slower as a whole, so it is asked for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use super::{Gpu, GpuError, Kernel, Resources};
use crate::plan::Pass;

/// GPU time of a pass, all its parts together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// Which.
    pub pass: Pass,
    /// Milliseconds between the timestamps before and after it.
    pub milliseconds: f64,
}

/// How passes are timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Timing {
    /// By timestamps around each pass, where the device has them.
    #[default]
    Timestamps,
    /// Each pass is submitted and waited for; wall time.
    Serial,
    /// Not at all, and nothing waits for the end of a submission but who needs it.
    Off,
}

impl Timing {
    /// In a few words.
    pub fn name(self) -> &'static str {
        match self {
            Timing::Timestamps => "GPU timestamps",
            Timing::Serial => "each pass run alone, wall time",
            Timing::Off => "not timed",
        }
    }
}

/// Most timed pieces in one submission; later ones run untimed.
const MOST_PIECES: u32 = 2048;

/// A command encoder that writes a timestamp before and after every piece of a pass.
pub struct Recorder {
    /// The encoder, for copies and clears.
    pub encoder: wgpu::CommandEncoder,
    gpu: Gpu,
    queries: Option<wgpu::QuerySet>,
    pieces: Vec<Pass>,
    timing: Timing,
    serial: Vec<PassTime>,
    cancel: Option<Arc<AtomicBool>>,
}

/// Fails if the flag is raised.
///
/// # Errors
/// [`GpuError::Cancelled`].
pub fn go_on(cancel: Option<&Arc<AtomicBool>>) -> Result<(), GpuError> {
    match cancel {
        Some(flag) if flag.load(Ordering::Relaxed) => Err(GpuError::Cancelled),
        _ => Ok(()),
    }
}

impl Recorder {
    /// Begins. Where `cancel` is raised, the next pass that would be submitted alone fails with [`GpuError::Cancelled`].
    pub fn new(gpu: &Gpu, timing: Timing, cancel: Option<Arc<AtomicBool>>) -> Recorder {
        let timed = timing == Timing::Timestamps && gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        Recorder {
            encoder: gpu.device.create_command_encoder(&Default::default()),
            gpu: gpu.clone(),
            queries: timed.then(|| {
                gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("pass times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * MOST_PIECES,
                })
            }),
            pieces: Vec::new(),
            timing,
            serial: Vec::new(),
            cancel,
        }
    }

    /// Ends a pass: under [`Timing::Serial`] submits it, waits, and notes its wall time.
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost or reported an error, or the frame is no longer wanted.
    pub fn end_pass(&mut self, pass: Pass) -> Result<(), GpuError> {
        if self.timing != Timing::Serial {
            return Ok(());
        }
        go_on(self.cancel.as_ref())?;
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let recorded = std::mem::replace(&mut self.encoder, next).finish();
        let begin = std::time::Instant::now();
        self.gpu.queue.submit([recorded]);
        self.gpu.wait()?;
        add_time(&mut self.serial, pass, begin.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    fn next_piece(&mut self, pass: Pass) -> Option<u32> {
        self.queries.as_ref()?;
        let index = self.pieces.len() as u32;
        if index >= MOST_PIECES {
            return None;
        }
        self.pieces.push(pass);
        Some(index)
    }

    /// Runs a compute kernel over `groups` workgroups.
    ///
    /// # Errors
    /// [`GpuError::Unbound`] if a resource is missing.
    pub fn compute(
        &mut self,
        pass: Pass,
        kernel: &Kernel,
        frame: &wgpu::BindGroup,
        resources: &Resources,
        groups: [u32; 3],
    ) -> Result<(), GpuError> {
        self.dispatch(pass, kernel, frame, resources, |p| p.dispatch_workgroups(groups[0], groups[1], groups[2]))
    }

    /// Runs a compute kernel over as many workgroups as a buffer says.
    ///
    /// # Errors
    /// [`GpuError::Unbound`] if a resource is missing.
    pub fn compute_indirect(
        &mut self,
        pass: Pass,
        kernel: &Kernel,
        frame: &wgpu::BindGroup,
        resources: &Resources,
        arguments: (&wgpu::Buffer, u64),
    ) -> Result<(), GpuError> {
        self.dispatch(pass, kernel, frame, resources, |p| p.dispatch_workgroups_indirect(arguments.0, arguments.1))
    }

    fn dispatch(
        &mut self,
        pass: Pass,
        kernel: &Kernel,
        frame: &wgpu::BindGroup,
        resources: &Resources,
        dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) -> Result<(), GpuError> {
        let group = kernel.bind(&self.gpu, resources)?;
        let piece = self.next_piece(pass);
        let timestamp_writes =
            self.queries.as_ref().zip(piece).map(|(query_set, i)| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(2 * i),
                end_of_pass_write_index: Some(2 * i + 1),
            });
        let mut compute = self
            .encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(pass.name()), timestamp_writes });
        compute.set_pipeline(&kernel.pipeline);
        compute.set_bind_group(0, frame, &[]);
        compute.set_bind_group(1, &group, &[]);
        dispatch(&mut compute);
        drop(compute);
        self.end_pass(pass)
    }

    /// Begins a render pass on one colour target.
    pub fn raster<'e>(
        &'e mut self,
        pass: Pass,
        target: &wgpu::TextureView,
        clear: bool,
        depth: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'e> {
        let piece = self.next_piece(pass);
        let timestamp_writes = self.queries.as_ref().zip(piece).map(|(query_set, i)| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(2 * i),
            end_of_pass_write_index: Some(2 * i + 1),
        });
        self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(pass.name()),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// Submits what was recorded. The times can be read once it has run.
    pub fn submit(mut self) -> Submitted {
        let resolved = self.queries.as_ref().filter(|_| !self.pieces.is_empty()).map(|queries| {
            let count = 2 * self.pieces.len() as u32;
            let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size: u64::from(count) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            self.encoder.resolve_query_set(queries, 0..count, &buffer, 0);
            buffer
        });
        self.gpu.queue.submit([self.encoder.finish()]);
        Submitted { gpu: self.gpu, timing: self.timing, resolved, pieces: self.pieces, serial: self.serial }
    }
}

/// A submission whose times can be read.
pub struct Submitted {
    gpu: Gpu,
    timing: Timing,
    resolved: Option<wgpu::Buffer>,
    pieces: Vec<Pass>,
    serial: Vec<PassTime>,
}

fn add_time(times: &mut Vec<PassTime>, pass: Pass, milliseconds: f64) {
    match times.iter_mut().find(|t| t.pass == pass) {
        Some(t) => t.milliseconds += milliseconds,
        None => times.push(PassTime { pass, milliseconds }),
    }
}

impl Submitted {
    /// Waits and adds the time of every piece to its pass in `times`; does neither under [`Timing::Off`].
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost or reported an error.
    pub fn add_times(self, times: &mut Vec<PassTime>) -> Result<(), GpuError> {
        for time in self.serial {
            add_time(times, time.pass, time.milliseconds);
        }
        let Some(buffer) = self.resolved else {
            return if self.timing == Timing::Off { Ok(()) } else { self.gpu.wait() };
        };
        let bytes = self.gpu.read_buffer(&buffer, 16 * self.pieces.len() as u64)?;
        let stamps: Vec<u64> = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let period = f64::from(self.gpu.queue.get_timestamp_period()) * 1e-6;
        for (pass, stamp) in self.pieces.iter().zip(stamps.chunks_exact(2)) {
            let milliseconds = stamp[1].saturating_sub(stamp[0]) as f64 * period;
            add_time(times, *pass, milliseconds);
        }
        Ok(())
    }
}
