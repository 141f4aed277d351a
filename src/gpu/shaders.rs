//! Shaders: files below `shaders/`, composed by their `//@ use` lines.
//!
//! WGSL does not care about the order of declarations, so composing is putting files one after another, each once. Variants
//! are chosen by module: a pass names the file that declares `layer_base` for its store, or `best_candidate` for its search,
//! and constants by a header. There is no conditional compilation inside a file.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, PoisonError};

use include_dir::{Dir, include_dir};

use super::kernel::{self, Kernel, RasterKernel, RasterSpec, SharedLayouts};
use super::{Gpu, GpuError};

static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/shaders");

/// A shader: root file, further modules, constants, generated text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ShaderSpec {
    /// Root file below `shaders/`, without `.wgsl`.
    pub root: &'static str,
    /// Further modules, without `.wgsl`.
    pub modules: Vec<&'static str>,
    /// Constants for the header, as WGSL literals.
    pub constants: Vec<(&'static str, String)>,
    /// Generated WGSL, put at the end.
    pub generated: String,
}

impl ShaderSpec {
    /// A shader of one file and what it uses.
    pub fn new(root: &'static str) -> ShaderSpec {
        ShaderSpec { root, ..ShaderSpec::default() }
    }

    /// Adds a module.
    #[must_use]
    pub fn with(mut self, module: &'static str) -> ShaderSpec {
        self.modules.push(module);
        self
    }

    /// Adds a constant.
    #[must_use]
    pub fn constant(mut self, name: &'static str, value: impl Into<String>) -> ShaderSpec {
        self.constants.push((name, value.into()));
        self
    }
}

/// A composed shader and where each of its lines comes from.
#[derive(Clone, Debug)]
pub struct Composed {
    /// WGSL.
    pub text: String,
    /// For each line: index into `files` and line in that file, from 1.
    lines: Vec<(usize, u32)>,
    files: Vec<String>,
}

impl Composed {
    /// File and line that a line of the composed text (from 1) comes from.
    pub fn origin(&self, line: u32) -> (&str, u32) {
        match self.lines.get(line.saturating_sub(1) as usize) {
            Some(&(file, line)) => (&self.files[file], line),
            None => ("<generated>", line),
        }
    }

    /// The files that it is made of, below `shaders/`, in order; names in angle brackets stand for generated text.
    pub fn files(&self) -> &[String] {
        &self.files
    }

    fn append(&mut self, file: &str, text: &str) {
        let index = self.files.len();
        self.files.push(file.to_owned());
        for (number, line) in text.lines().enumerate() {
            self.text.push_str(line);
            self.text.push('\n');
            self.lines.push((index, number as u32 + 1));
        }
    }
}

/// All shader files: path below `shaders/` and text.
pub fn shader_files() -> Vec<(String, &'static str)> {
    fn walk(dir: &'static Dir<'static>, all: &mut Vec<(String, &'static str)>) {
        for file in dir.files() {
            if let Some(text) = file.contents_utf8() {
                all.push((file.path().to_string_lossy().into_owned(), text));
            }
        }
        for dir in dir.dirs() {
            walk(dir, all);
        }
    }
    let mut all = Vec::new();
    walk(&FILES, &mut all);
    all.sort();
    all
}

/// Puts a shader together.
///
/// # Errors
/// [`GpuError::Shader`] if a file does not exist.
pub fn compose(spec: &ShaderSpec) -> Result<Composed, GpuError> {
    compose_with(spec, &HashMap::new())
}

/// Puts a shader together with other texts for some modules and checks it, if it is made of any of `changed` (files below
/// `shaders/`) and not among the texts already `seen`.
///
/// # Errors
/// [`GpuError::Shader`] with file, line and reason.
pub fn check_shader(
    spec: &ShaderSpec,
    replaced: &BTreeMap<String, String>,
    changed: &BTreeSet<String>,
    seen: &mut BTreeSet<u64>,
) -> Result<(), GpuError> {
    let replaced: HashMap<String, String> = replaced.clone().into_iter().collect();
    let composed = compose_with(spec, &replaced)?;
    if composed.files().iter().any(|f| changed.contains(f)) && seen.insert(key_of(&[&composed.text])) {
        kernel::check(&composed)?;
    }
    Ok(())
}

/// [`compose`], with other texts for some of the modules.
fn compose_with(spec: &ShaderSpec, replaced: &HashMap<String, String>) -> Result<Composed, GpuError> {
    let mut composed = Composed { text: String::new(), lines: Vec::new(), files: Vec::new() };
    let header: String = spec.constants.iter().map(|(name, value)| format!("const {name} = {value};\n")).collect();
    composed.append("<constants>", &header);
    let mut seen = Vec::new();
    for file in std::iter::once(&spec.root).chain(&spec.modules) {
        include(file, ("<pass>", 0), replaced, &mut seen, &mut composed)?;
    }
    composed.append("<generated>", &spec.generated);
    Ok(composed)
}

fn include(
    module: &str,
    (from, line): (&str, u32),
    replaced: &HashMap<String, String>,
    seen: &mut Vec<String>,
    composed: &mut Composed,
) -> Result<(), GpuError> {
    if seen.iter().any(|s| s == module) {
        return Ok(());
    }
    seen.push(module.to_owned());
    let file = format!("{module}.wgsl");
    let own = FILES.get_file(&file).and_then(|f| f.contents_utf8());
    let text = replaced.get(module).map(String::as_str).or(own).ok_or_else(|| GpuError::Shader {
        file: from.to_owned(),
        line,
        reason: format!("there is no module '{module}'"),
    })?;
    for (number, used) in text.lines().enumerate().filter_map(|(n, l)| Some((n, l.strip_prefix("//@ use ")?))) {
        include(used.trim(), (&file, number as u32 + 1), replaced, seen, composed)?;
    }
    composed.append(&file, text);
    Ok(())
}

/// Compiled shaders, each once.
pub struct Shaders {
    gpu: Gpu,
    /// Bind group layouts that passes share.
    pub shared: SharedLayouts,
    kernels: Mutex<HashMap<u64, Arc<Kernel>>>,
    raster: Mutex<HashMap<u64, Arc<RasterKernel>>>,
    /// Digests of the texts that specs are composed to, because composing one takes longer than a small dispatch.
    texts: Mutex<HashMap<ShaderSpec, u64>>,
    replaced: HashMap<String, String>,
    revision: u64,
}

fn key_of(parts: &[&str]) -> u64 {
    let mut hasher = DefaultHasher::new();
    parts.hash(&mut hasher);
    hasher.finish()
}

impl Shaders {
    /// An empty cache.
    pub fn new(gpu: &Gpu) -> Shaders {
        Shaders {
            gpu: gpu.clone(),
            shared: SharedLayouts::new(gpu),
            kernels: Mutex::default(),
            raster: Mutex::default(),
            texts: Mutex::default(),
            replaced: HashMap::new(),
            revision: 0,
        }
    }

    /// Lets another text stand in for a module from now on, or the module's own again for `None`. For tests that plant
    /// an error and see that it is found.
    pub fn replace(&mut self, module: &str, text: Option<String>) {
        self.revision += 1;
        self.texts.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
        match text {
            Some(text) => self.replaced.insert(module.to_owned(), text),
            None => self.replaced.remove(module),
        };
    }

    /// How often modules have been replaced.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The digest of the text of `spec`, if it has been composed before, and the text otherwise.
    fn text(&self, spec: &ShaderSpec) -> Result<(u64, Option<Composed>), GpuError> {
        let mut texts = self.texts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&digest) = texts.get(spec) {
            return Ok((digest, None));
        }
        let composed = compose_with(spec, &self.replaced)?;
        let digest = key_of(&[&composed.text]);
        texts.insert(spec.clone(), digest);
        Ok((digest, Some(composed)))
    }

    /// What is in `all` for a spec and a variant of it; it is compiled if it is not there.
    fn compiled<T>(
        &self,
        all: &Mutex<HashMap<u64, Arc<T>>>,
        spec: &ShaderSpec,
        variant: &str,
        compile: impl FnOnce(&Composed) -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        let (digest, composed) = self.text(spec)?;
        let key = key_of(&[&digest.to_string(), variant]);
        let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernel) = all.get(&key) {
            return Ok(Arc::clone(kernel));
        }
        let composed = composed.map_or_else(|| compose_with(spec, &self.replaced), Ok)?;
        let kernel = Arc::new(compile(&composed)?);
        all.insert(key, Arc::clone(&kernel));
        Ok(kernel)
    }

    /// The compute pipeline of an entry point.
    ///
    /// # Errors
    /// [`GpuError::Shader`] if it does not compile.
    pub fn kernel(&self, spec: &ShaderSpec, entry: &str) -> Result<Arc<Kernel>, GpuError> {
        let compile =
            |composed: &Composed| kernel::compile_compute(&self.gpu, &self.shared, spec.root, composed, entry);
        self.compiled(&self.kernels, spec, entry, compile)
    }

    /// The render pipeline of a shader with `vertex_main` and `fragment_main`.
    ///
    /// # Errors
    /// [`GpuError::Shader`] if it does not compile.
    pub fn raster(&self, spec: &ShaderSpec, raster: &RasterSpec) -> Result<Arc<RasterKernel>, GpuError> {
        let compile =
            |composed: &Composed| kernel::compile_raster(&self.gpu, &self.shared, spec.root, composed, raster);
        self.compiled(&self.raster, spec, &format!("{raster:?}"), compile)
    }
}
