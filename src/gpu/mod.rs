//! The graphics device, and everything that wgpu asks of a program and that no technique should have to repeat: choosing an
//! adapter, composing shaders, pipelines and bind groups by reflection, buffers, timing, read-back, errors.
//!
//! Knows no technique. Errors of the device are caught here once: nothing panics when a GPU refuses ([`GpuError`]).

mod buffers;
mod kernel;
mod recorder;
mod shaders;

use std::sync::{Arc, Mutex};

use serde::Serialize;

use crate::plan::{self, Capabilities};

pub use buffers::{Resource, Resources};
pub use kernel::{Kernel, RasterKernel, RasterSpec, SharedLayouts};
pub use recorder::{PassTime, Recorder, Timing, go_on};
pub use shaders::{ShaderSpec, Shaders, check_shader, compose, shader_files};

/// Why the device did not do what was asked.
#[derive(Debug, thiserror::Error, Clone, PartialEq)]
pub enum GpuError {
    /// No adapter answers.
    #[error(
        "no graphics adapter answers ({reason}); a Vulkan driver is needed, and Mesa's software one will do \
         (Debian: mesa-vulkan-drivers)"
    )]
    NoAdapter {
        /// What wgpu says.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("the adapter '{adapter}' gave no device: {reason}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What wgpu says.
        reason: String,
    },
    /// Memory could not be allocated.
    #[error("the graphics adapter has no memory left for '{what}' ({bytes} bytes)")]
    OutOfMemory {
        /// What was to be stored.
        what: String,
        /// How large it is.
        bytes: u64,
    },
    /// Memory ran out, and the device does not say for what.
    #[error("the graphics adapter has no memory left")]
    Exhausted,
    /// A shader does not compile.
    #[error("shader {file}:{line}: {reason}")]
    Shader {
        /// File below `shaders/`.
        file: String,
        /// Line in that file, from 1.
        line: u32,
        /// What is wrong.
        reason: String,
    },
    /// A pass was given no resource for one of its bindings: a fault of this program.
    #[error("pass '{pass}' was given nothing for its binding '{binding}'")]
    Unbound {
        /// Name of the pass.
        pass: String,
        /// Name of the variable in the shader.
        binding: String,
    },
    /// The device reported an error.
    #[error("the graphics device reports: {0}")]
    Device(String),
    /// What was asked is no longer wanted.
    #[error("cancelled")]
    Cancelled,
    /// The device was lost.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
}

/// What to ask of the adapter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuOptions {
    /// Substring of the adapter's name, without regard to case; `WGPU_ADAPTER_NAME` if `None`.
    pub adapter_name: Option<String>,
    /// Largest storage buffer binding to use, bytes; for testing bands. The adapter's limit if `None`.
    pub max_binding: Option<u64>,
}

/// What an adapter is and can do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdapterFacts {
    /// Name, as the driver gives it.
    pub name: String,
    /// Driver name.
    pub driver: String,
    /// Driver version.
    pub driver_info: String,
    /// Graphics API.
    pub backend: String,
    /// Kind of device: discrete, integrated, software.
    pub device_type: String,
    /// Features that matter here and are available.
    pub features: Vec<String>,
    /// Limits that matter here.
    pub limits: Vec<(String, u64)>,
    /// What a plan may assume.
    pub capabilities: Capabilities,
    /// Why it cannot be used, if it cannot.
    pub unusable: Option<String>,
}

impl AdapterFacts {
    /// How passes are timed here. Timestamps are wrong for compute passes on software rasterizers, and not every adapter has
    /// them: there each pass is run alone and timed by the wall clock.
    pub fn pass_timing(&self) -> Timing {
        let timestamps = self.features.iter().any(|f| f == TIMESTAMPS);
        if timestamps && self.device_type != "Cpu" { Timing::Timestamps } else { Timing::Serial }
    }
}

const TIMESTAMPS: &str = "timestamp queries";

const WANTED: &[(&str, wgpu::Features)] = &[
    (TIMESTAMPS, wgpu::Features::TIMESTAMP_QUERY),
    ("64-bit integers", wgpu::Features::SHADER_INT64),
    ("64-bit atomics", wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS),
];

/// A device, its queue and what it can do.
#[derive(Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    facts: Arc<AdapterFacts>,
    fault: Arc<Mutex<Option<GpuError>>>,
}

/// Graphics interfaces in the order in which they are tried. OpenGL comes last: it lacks what the default capture is fastest
/// with, and merely asking it makes some drivers write to standard error.
const BACKENDS: [wgpu::Backends; 2] = [wgpu::Backends::PRIMARY, wgpu::Backends::SECONDARY];

/// The adapters of some graphics interfaces; `WGPU_BACKEND` overrides which.
fn enumerate(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    if wgpu::Backends::from_env().is_none() {
        descriptor.backends = backends;
    }
    pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(wgpu::Backends::all()))
}

fn facts_of(adapter: &wgpu::Adapter, options: &GpuOptions) -> AdapterFacts {
    let info = adapter.get_info();
    let limits = adapter.limits();
    let features = adapter.features();
    let atomics = wgpu::Features::SHADER_INT64 | wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS;
    let max_binding = limits.max_storage_buffer_binding_size;
    let capabilities = Capabilities {
        max_binding: options.max_binding.map_or(max_binding, |m| m.min(max_binding)),
        max_buffer: limits.max_buffer_size,
        max_texture: limits.max_texture_dimension_2d,
        max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
        atomic_min_64: features.contains(atomics),
        most_layers: if info.driver == "llvmpipe" { plan::MOST_LAYERS_LLVMPIPE } else { plan::MOST_LAYERS },
    };
    let flags = adapter.get_downlevel_capabilities().flags;
    // OpenGL has no way to take a flat value from a triangle's first vertex.
    let flat_first = info.backend != wgpu::Backend::Gl;
    let missing: Vec<&str> = [
        ("compute shaders", wgpu::DownlevelFlags::COMPUTE_SHADERS),
        ("storage writes in fragment shaders", wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE),
        ("indirect dispatch", wgpu::DownlevelFlags::INDIRECT_EXECUTION),
        ("packing of 16-bit floats", wgpu::DownlevelFlags::SHADER_F16_IN_F32),
    ]
    .into_iter()
    .filter(|(_, flag)| !flags.contains(*flag))
    .map(|(name, _)| name)
    .chain((!flat_first).then_some("flat interpolation from the first vertex"))
    .collect();
    AdapterFacts {
        name: info.name,
        driver: info.driver,
        driver_info: info.driver_info,
        backend: info.backend.to_string(),
        device_type: format!("{:?}", info.device_type),
        features: WANTED.iter().filter(|(_, f)| features.contains(*f)).map(|(n, _)| (*n).to_owned()).collect(),
        limits: vec![
            ("storage binding bytes".to_owned(), max_binding),
            ("buffer bytes".to_owned(), limits.max_buffer_size),
            ("texture edge".to_owned(), u64::from(limits.max_texture_dimension_2d)),
            ("storage buffers a stage".to_owned(), u64::from(limits.max_storage_buffers_per_shader_stage)),
        ],
        capabilities,
        unusable: (!missing.is_empty()).then(|| format!("it has no {}", missing.join(", no "))),
    }
}

impl Gpu {
    /// Opens a device on the best adapter: the one asked for by name, else a discrete GPU before an integrated one before
    /// software.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] if none answers or none of that name; [`GpuError::NoDevice`] if it gives no device.
    pub fn new(options: &GpuOptions) -> Result<Gpu, GpuError> {
        let wanted = options.adapter_name.clone().or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
        let mut names = Vec::new();
        let mut reasons = Vec::new();
        for backends in BACKENDS {
            let mut adapters = enumerate(backends);
            adapters.sort_by_key(|a| match a.get_info().device_type {
                wgpu::DeviceType::DiscreteGpu => 0,
                wgpu::DeviceType::IntegratedGpu => 1,
                wgpu::DeviceType::VirtualGpu => 2,
                wgpu::DeviceType::Cpu => 3,
                wgpu::DeviceType::Other => 4,
            });
            for adapter in adapters {
                let facts = facts_of(&adapter, options);
                if !names.contains(&facts.name) {
                    names.push(facts.name.clone());
                }
                if let Some(wanted) = &wanted
                    && !facts.name.to_lowercase().contains(&wanted.to_lowercase())
                {
                    continue;
                }
                if let Some(reason) = &facts.unusable {
                    reasons.push(format!("{}: {reason}", facts.name));
                    continue;
                }
                return Gpu::open(&adapter, facts);
            }
        }
        let reason = match (wanted, reasons.is_empty()) {
            (_, false) => reasons.join("; "),
            (Some(wanted), true) if names.is_empty() => format!("none is called '{wanted}', nor anything else"),
            (Some(wanted), true) => format!("none is called '{wanted}'; there is: {}", names.join(", ")),
            (None, true) => "there is none".to_owned(),
        };
        Err(GpuError::NoAdapter { reason })
    }

    /// All adapters that answer.
    pub fn adapters() -> Vec<AdapterFacts> {
        let options = GpuOptions::default();
        enumerate(wgpu::Backends::all()).iter().map(|a| facts_of(a, &options)).collect()
    }

    fn open(adapter: &wgpu::Adapter, facts: AdapterFacts) -> Result<Gpu, GpuError> {
        let available = adapter.features();
        let required_features = WANTED
            .iter()
            .map(|(_, f)| *f)
            .filter(|f| available.contains(*f))
            .fold(wgpu::Features::empty(), |a, b| a | b);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("pellucid"),
            required_features,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::NoDevice { adapter: facts.name.clone(), reason: e.to_string() })?;
        let fault: Arc<Mutex<Option<GpuError>>> = Arc::default();
        let reported = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let exhausted = matches!(error, wgpu::Error::OutOfMemory { .. });
            note(&reported, if exhausted { GpuError::Exhausted } else { GpuError::Device(error.to_string()) });
        }));
        let lost = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            note(&lost, GpuError::Lost(format!("{reason:?} {message}")))
        });
        Ok(Gpu { device, queue, facts: Arc::new(facts), fault })
    }

    /// What the adapter is.
    pub fn facts(&self) -> &AdapterFacts {
        &self.facts
    }

    /// What a plan may assume.
    pub fn capabilities(&self) -> &Capabilities {
        &self.facts.capabilities
    }

    /// The first error that the device reported since the last call.
    ///
    /// # Errors
    /// That error.
    pub fn check(&self) -> Result<(), GpuError> {
        match self.fault.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Waits until everything submitted has run.
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost or reported an error.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.check()
    }

    /// A buffer of at least 16 bytes, zeroed.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, GpuError> {
        let out_of_memory = || GpuError::OutOfMemory { what: label.to_owned(), bytes };
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16).next_multiple_of(16),
            usage,
            mapped_at_creation: false,
        });
        let invalid = pollster::block_on(validation.pop());
        let exhausted = pollster::block_on(memory.pop());
        if exhausted.is_some() {
            return Err(out_of_memory());
        }
        if let Some(error) = invalid {
            return Err(GpuError::Device(format!("buffer '{label}' of {bytes} bytes: {error}")));
        }
        Ok(buffer)
    }

    /// A buffer that holds `data`.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn buffer_of(&self, label: &str, data: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.buffer(label, data.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        if !data.is_empty() {
            let padded = data.len().next_multiple_of(4);
            if padded == data.len() {
                self.queue.write_buffer(&buffer, 0, data);
            } else {
                let mut bytes = data.to_vec();
                bytes.resize(padded, 0);
                self.queue.write_buffer(&buffer, 0, &bytes);
            }
        }
        Ok(buffer)
    }

    /// A uniform buffer with this value.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn uniform<T: bytemuck::NoUninit>(&self, label: &str, value: &T) -> Result<wgpu::Buffer, GpuError> {
        self.buffer_of(label, bytemuck::bytes_of(value), wgpu::BufferUsages::UNIFORM)
    }

    /// Copies the first `bytes` of a buffer back to the CPU. Waits for everything submitted.
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost, out of memory, or reported an error.
    pub fn read_buffer(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        Ok(self.read_buffers(&[(buffer, bytes)])?.pop().unwrap_or_default())
    }

    /// The same of several buffers, waiting once.
    ///
    /// # Errors
    /// As [`Gpu::read_buffer`].
    pub fn read_buffers(&self, wanted: &[(&wgpu::Buffer, u64)]) -> Result<Vec<Vec<u8>>, GpuError> {
        let sizes: Vec<u64> = wanted.iter().map(|(b, bytes)| bytes.next_multiple_of(4).min(b.size())).collect();
        let size: u64 = sizes.iter().sum();
        if size == 0 {
            return Ok(vec![Vec::new(); wanted.len()]);
        }
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer("read-back", size, usage)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut at = 0;
        for ((buffer, _), size) in wanted.iter().zip(&sizes).filter(|(_, size)| **size > 0) {
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, at, *size);
            at += size;
        }
        self.queue.submit([encoder.finish()]);
        let data = self.map(&staging, size)?;
        let mut rest = &data[..];
        let mut all = Vec::with_capacity(wanted.len());
        for ((_, bytes), size) in wanted.iter().zip(&sizes) {
            let (own, after) = rest.split_at(*size as usize);
            all.push(own[..own.len().min(*bytes as usize)].to_vec());
            rest = after;
        }
        Ok(all)
    }

    /// Copies an Rgba32Float texture back to the CPU, rows from the top.
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost, out of memory, or reported an error.
    pub fn read_image(&self, texture: &wgpu::Texture) -> Result<Vec<[f32; 4]>, GpuError> {
        let (width, height) = (texture.width(), texture.height());
        let row = width * 16;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(padded) * u64::from(height);
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer("image read-back", size, usage)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
            },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let data = self.map(&staging, size)?;
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for line in data.chunks_exact(padded as usize) {
            pixels.extend(line[..row as usize].chunks_exact(16).map(bytemuck::pod_read_unaligned::<[f32; 4]>));
        }
        Ok(pixels)
    }

    fn map(&self, staging: &wgpu::Buffer, size: u64) -> Result<Vec<u8>, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.slice(..size).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if waiting failed, which is reported below.
            let _ = sender.send(result);
        });
        self.wait()?;
        match receiver.recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(GpuError::Device(format!("read-back: {e}"))),
            Err(e) => return Err(GpuError::Lost(format!("read-back: {e}"))),
        }
        let view =
            staging.slice(..size).get_mapped_range().map_err(|e| GpuError::Device(format!("read-back: {e:?}")))?;
        let data = view.to_vec();
        drop(view);
        staging.unmap();
        Ok(data)
    }
}

fn note(fault: &Mutex<Option<GpuError>>, error: GpuError) {
    tracing::error!("{error}");
    let mut first = fault.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    first.get_or_insert(error);
}
