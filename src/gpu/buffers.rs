//! Buffers and textures by the names that shaders give them, kept from frame to frame and grown when needed.

use std::collections::HashMap;

use super::{Gpu, GpuError};

/// What a shader variable is bound to.
#[derive(Clone)]
pub enum Resource {
    /// A whole buffer.
    Buffer(wgpu::Buffer),
    /// A texture.
    Texture(wgpu::TextureView),
}

/// The resources of a frame. Several names may stand for one resource (a buffer that is atomic in one pass only).
#[derive(Clone, Default)]
pub struct Resources {
    named: HashMap<&'static str, Resource>,
    /// Bytes that the present frame asked for, by name of the buffer.
    needed: HashMap<&'static str, u64>,
}

/// Usage of every buffer that a frame makes.
const USAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_DST)
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::INDIRECT);

impl Resources {
    /// Makes sure that a storage buffer of at least `bytes` has this name; what it held before is lost if it grows.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn ensure(&mut self, gpu: &Gpu, name: &'static str, bytes: u64) -> Result<(), GpuError> {
        let needed = self.needed.entry(name).or_default();
        *needed = bytes.max(*needed);
        match self.named.get(name) {
            Some(Resource::Buffer(b)) if b.size() >= bytes => Ok(()),
            _ => {
                self.named.remove(name);
                let buffer = gpu.buffer(name, bytes, USAGE)?;
                self.named.insert(name, Resource::Buffer(buffer));
                Ok(())
            }
        }
    }

    /// Gives a resource a name.
    pub fn set(&mut self, name: &'static str, resource: Resource) {
        self.named.insert(name, resource);
    }

    /// Lets `alias` stand for the same resource as `name`.
    pub fn alias(&mut self, alias: &'static str, name: &str) {
        if let Some(resource) = self.named.get(name).cloned() {
            self.named.insert(alias, resource);
        }
    }

    /// Forgets every resource whose name is not kept, and frees its memory when nothing else holds it. A frame begins so.
    pub fn retain(&mut self, keep: impl Fn(&str) -> bool) {
        self.needed.clear();
        self.named.retain(|name, _| keep(name));
    }

    /// The buffer of this name.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match self.named.get(name) {
            Some(Resource::Buffer(b)) => Some(b),
            _ => None,
        }
    }

    /// The buffer of this name.
    ///
    /// # Errors
    /// [`GpuError::Unbound`] if there is none.
    pub fn require(&self, pass: &str, name: &str) -> Result<&wgpu::Buffer, GpuError> {
        self.buffer(name).ok_or_else(|| GpuError::Unbound { pass: pass.to_owned(), binding: name.to_owned() })
    }

    pub(super) fn binding(&self, pass: &str, name: &str) -> Result<wgpu::BindingResource<'_>, GpuError> {
        match self.named.get(name) {
            Some(Resource::Buffer(b)) => Ok(b.as_entire_binding()),
            Some(Resource::Texture(t)) => Ok(wgpu::BindingResource::TextureView(t)),
            None => Err(GpuError::Unbound { pass: pass.to_owned(), binding: name.to_owned() }),
        }
    }

    /// Bytes of all buffers that the present frame needs. What an earlier frame made larger counts as what is needed of it.
    pub fn bytes(&self) -> u64 {
        let mut seen: Vec<&wgpu::Buffer> = Vec::new();
        let mut names: Vec<_> = self.named.keys().copied().collect();
        // Names under which buffers were made come before their aliases.
        names.sort_by_key(|name| (!self.needed.contains_key(name), *name));
        let mut sum = 0;
        for name in names {
            if let Some(Resource::Buffer(b)) = self.named.get(name)
                && !seen.contains(&b)
            {
                seen.push(b);
                sum += self.needed.get(name).map_or(b.size(), |needed| b.size().min(*needed));
            }
        }
        sum
    }

    /// Names of all resources, sorted.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.named.keys().copied().collect();
        names.sort_unstable();
        names
    }
}
