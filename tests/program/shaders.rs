//! All shaders are valid, every entry point in every combination that a plan can ask for; every file is used; structs have
//! the same layout in Rust and in WGSL. No GPU is needed.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::mem::offset_of;

use bytemuck::Zeroable;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ShaderStage, TypeInner};
use pellucid::gpu::{compose, shader_files};
use pellucid::passes::shaders::{PassShader, RASTER, all_plans, all_shaders};
use pellucid::passes::{
    BlendParameters, CurvatureParameters, FrameUniform, IllustrationParameters, InstanceUniform, MaterialUniform,
    ModelParameters, OutlineParameters, PartFacts, Sections, ShadeParameters, StepParameters, StoreLayout,
    SweepParameters, TransferParameters,
};
use pellucid::plan::{Pass, storage_buffers};
use rayon::prelude::*;

/// Invocations of a workgroup that WebGPU guarantees.
const LARGEST_WORKGROUP: u32 = 256;

/// Shaders that share a text, parsed once.
struct Parsed {
    text: String,
    files: Vec<String>,
    module: Module,
    users: Vec<PassShader>,
}

impl Parsed {
    /// For messages: the pass, and what the shader is made of.
    fn name(&self) -> String {
        let spec = &self.users[0].spec;
        format!("{} ({} with {})", self.users[0].pass.name(), spec.root, spec.modules.join(", "))
    }
}

fn parsed() -> Vec<Parsed> {
    let mut by_text: HashMap<String, (Vec<String>, Vec<PassShader>)> = HashMap::new();
    for shader in all_shaders() {
        let composed = compose(&shader.spec).unwrap_or_else(|e| panic!("{:?}: {e}", shader.spec.root));
        let entry = by_text.entry(composed.text.clone()).or_insert_with(|| (composed.files().to_vec(), Vec::new()));
        entry.1.push(shader);
    }
    by_text
        .into_par_iter()
        .map(|(text, (files, users))| {
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| {
                let composed = compose(&users[0].spec).unwrap();
                let place = e.location(&text).map(|l| composed.origin(l.line_number).to_owned());
                panic!("{}: {place:?}: {}", users[0].pass.name(), e.message())
            });
            Parsed { text, files, module, users }
        })
        .collect()
}

fn validate(shader: &Parsed, capabilities: Capabilities) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), capabilities)
        .validate(&shader.module)
        .map_err(|e| format!("{}: {}", shader.name(), e.emit_to_string(&shader.text)))
}

/// What naga may assume of an adapter: no more than WebGPU guarantees, and 64-bit atomics where the plan asks for them.
fn capabilities(shader: &Parsed) -> Capabilities {
    let wide = Capabilities::SHADER_INT64
        | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX
        | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS;
    // Packing halves is a part of WebGPU that only some GLES adapters lack; those are refused when they are opened.
    let usual = Capabilities::default() | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    if shader.users.iter().all(|u| u.atomics_64) { usual | wide } else { usual }
}

/// Names of the storage buffers that an entry point binds.
fn storage_of(shader: &Parsed, info: &ModuleInfo, entry: usize) -> Vec<String> {
    let used = info.get_entry_point(entry);
    let variables = shader.module.global_variables.iter();
    variables
        .filter(|(handle, v)| matches!(v.space, AddressSpace::Storage { .. }) && !used[*handle].is_empty())
        .filter_map(|(_, v)| v.name.clone())
        .collect()
}

fn faults_of(shader: &Parsed) -> Vec<String> {
    let name = shader.name();
    let info = match validate(shader, capabilities(shader)) {
        Ok(info) => info,
        Err(fault) => return vec![fault],
    };
    let mut faults = Vec::new();
    let entries = shader.users[0].entries;
    let declared: BTreeSet<&str> = shader.module.entry_points.iter().map(|e| e.name.as_str()).collect();
    if declared != entries.iter().copied().collect() {
        faults.push(format!("{name}: has the entry points {declared:?}, but {entries:?} are used"));
    }
    for (index, entry) in shader.module.entry_points.iter().enumerate() {
        let stage = match entry.name.as_str() {
            "vertex_main" => ShaderStage::Vertex,
            "fragment_main" => ShaderStage::Fragment,
            _ => ShaderStage::Compute,
        };
        if entry.stage != stage || (stage == ShaderStage::Compute) == (entries == RASTER) {
            faults.push(format!("{name}: {} is a {:?} shader", entry.name, entry.stage));
        }
        if stage == ShaderStage::Compute && entry.workgroup_size.iter().product::<u32>() > LARGEST_WORKGROUP {
            faults.push(format!("{name}: {} has workgroups of {:?}", entry.name, entry.workgroup_size));
        }
        let used = info.get_entry_point(index);
        let buffers = storage_of(shader, &info, index);
        // What shares a text must fit the smallest of its plans.
        let limit = storage_buffers(shader.users.iter().all(|u| u.tail), shader.users.iter().all(|u| u.looks));
        if buffers.len() as u32 > limit {
            faults.push(format!("{name}: {} binds {buffers:?}, more than the planned {limit}", entry.name));
        }
        let mut places = BTreeMap::new();
        for (handle, v) in shader.module.global_variables.iter().filter(|(h, _)| !used[*h].is_empty()) {
            let Some(binding) = v.binding else { continue };
            if let Some(other) = places.insert((binding.group, binding.binding), handle) {
                let names = (&v.name, &shader.module.global_variables[other].name);
                faults.push(format!("{name}: {names:?} share {binding:?}"));
            }
        }
    }
    faults
}

#[test]
fn every_shader_that_a_plan_can_ask_for_is_valid() {
    let shaders = parsed();
    let faults: Vec<String> = shaders.par_iter().flat_map(faults_of).collect();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
    let variants: usize = shaders.iter().map(|s| s.users.len()).sum();
    println!("{} plans, {variants} shaders of passes, {} texts", all_plans().len(), shaders.len());
    assert!(shaders.len() > 150, "only {} shaders: choices are missing", shaders.len());
}

/// An adapter must not be refused for buffers that no shader binds.
#[test]
fn the_planned_number_of_storage_buffers_is_needed() {
    let most = |tail: bool, looks: bool| {
        let shaders = parsed()
            .into_iter()
            .filter(|s| s.users.iter().all(|u| u.tail) == tail && s.users.iter().all(|u| u.looks) == looks);
        let counts = shaders.map(|shader| {
            let info = validate(&shader, capabilities(&shader)).unwrap();
            let entries = 0..shader.module.entry_points.len();
            entries.map(|entry| storage_of(&shader, &info, entry).len()).max().unwrap_or(0)
        });
        counts.max().unwrap_or(0) as u32
    };
    for (tail, looks) in [(false, false), (true, false), (true, true)] {
        assert_eq!(most(tail, looks), storage_buffers(tail, looks), "tail {tail}, looks {looks}");
    }
    assert!(most(false, true) <= storage_buffers(false, true));
}

#[test]
fn a_wrong_shader_does_not_pass() {
    let mut spec = all_shaders().remove(0);
    spec.spec.generated = "fn wrong() -> u32 { return 1.5; }".to_owned();
    let text = compose(&spec.spec).unwrap().text;
    let module = naga::front::wgsl::parse_str(&text);
    let valid =
        module.is_ok_and(|m| Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&m).is_ok());
    assert!(!valid);
}

#[test]
fn every_pass_and_every_file_is_used() {
    let shaders = parsed();
    let passes: BTreeSet<&str> = shaders.iter().flat_map(|s| &s.users).map(|u| u.pass.name()).collect();
    let unused: Vec<&str> = Pass::ALL.map(Pass::name).into_iter().filter(|p| !passes.contains(p)).collect();
    assert!(unused.is_empty(), "no plan has {unused:?}");
    let used: BTreeSet<&String> = shaders.iter().flat_map(|s| &s.files).collect();
    let files = shader_files();
    let unused: Vec<&String> = files.iter().map(|(file, _)| file).filter(|f| !used.contains(f)).collect();
    assert!(unused.is_empty(), "no plan uses {unused:#?}");
    assert!(files.len() > 50);
}

#[test]
fn every_module_of_a_shader_exists_once() {
    for (file, text) in shader_files() {
        let mut seen = BTreeSet::new();
        for used in text.lines().filter_map(|l| l.strip_prefix("//@ use ")) {
            let used = used.trim();
            assert!(seen.insert(used), "{file} uses {used} twice");
            assert!(shader_files().iter().any(|(f, _)| *f == format!("{used}.wgsl")), "{file}: no module '{used}'");
        }
    }
}

/// A field: name, offset, size, in bytes.
type Field = (String, usize, usize);

/// A struct of `passes::uniforms`, and what it is called in WGSL.
struct Twin {
    rust: &'static str,
    wgsl: &'static str,
    size: usize,
    fields: Vec<Field>,
}

fn size_of_field<T, F>(_: impl Fn(&T) -> &F) -> usize {
    size_of::<F>()
}

/// Lists the fields of a struct; leaving one out does not compile.
macro_rules! twin {
    ($Rust:ident = $wgsl:literal { $($field:ident),+ }) => {{
        let $Rust { $($field: _),+ } = <$Rust as Zeroable>::zeroed();
        Twin {
            rust: stringify!($Rust),
            wgsl: $wgsl,
            size: size_of::<$Rust>(),
            fields: vec![$((
                stringify!($field).to_owned(),
                offset_of!($Rust, $field),
                size_of_field(|s: &$Rust| &s.$field),
            )),+],
        }
    }};
}

fn twins() -> Vec<Twin> {
    vec![
        twin!(FrameUniform = "Frame" {
            clip_from_view, unproject, size, first_row, end_row, first_output_row, end_output_row, orthographic, _pad,
            near, far, depth_min, depth_scale
        }),
        twin!(StoreLayout = "StoreLayout" { k, capacity, chunk, _pad }),
        twin!(InstanceUniform = "Instance" { view_x, view_y, view_z, normal_x, normal_y, normal_z, ids }),
        twin!(MaterialUniform = "Material" { base_color, emissive, factors, modes, uv_rows }),
        twin!(PartFacts = "PartFacts" { first_triangle, inverse_radius, radius, look, color }),
        twin!(Sections = "Sections" { planes, caps, count, _pad }),
        twin!(CurvatureParameters = "CurvatureParameters" {
            scale, part_scale, radius, reach, line, crease_cosine, kind, _pad
        }),
        twin!(ShadeParameters = "ShadeParameters" { lights }),
        twin!(TransferParameters = "TransferParameters" { color_mode, gain, constant, ghost }),
        twin!(ModelParameters = "ModelParameters" { share, low, high, scale }),
        twin!(IllustrationParameters = "IllustrationParameters" {
            lambda, diffusion, profile, p, strength, constant, heat_steps, printed, feature_size
        }),
        twin!(StepParameters = "StepParameters" { always, early_stop, _pad }),
        twin!(SweepParameters = "Sweep" { first, end, _pad }),
        twin!(BlendParameters = "BlendParameters" { opacity, ghost, _pad }),
        twin!(OutlineParameters = "OutlineParameters" { color, width, _pad }),
    ]
}

/// A struct as naga lays it out: span and fields.
fn layout(module: &Module, name: &str) -> Option<(usize, Vec<Field>)> {
    let (_, ty) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name))?;
    let TypeInner::Struct { members, span } = &ty.inner else { return None };
    let field = |m: &naga::StructMember| {
        let size = module.types[m.ty].inner.size(module.to_ctx());
        (m.name.clone().unwrap_or_default(), m.offset as usize, size as usize)
    };
    Some((*span as usize, members.iter().map(field).collect()))
}

/// Why the two do not agree. Padding at the end has no meaning, and may be left out in WGSL, where a buffer may be longer
/// than its type.
fn disagreement(twin: &Twin, span: usize, wgsl: &[Field]) -> Option<String> {
    let meaning = |fields: &[Field]| {
        let padding = fields.iter().rev().take_while(|(name, ..)| name.starts_with("_pad")).count();
        fields[..fields.len() - padding].to_vec()
    };
    let (rust, ours) = (meaning(&twin.fields), meaning(wgsl));
    let padded = wgsl.len() > ours.len();
    if rust != ours {
        return Some(format!("{} {rust:?}\n{} {ours:?}", twin.rust, twin.wgsl));
    }
    let end = rust.last().map_or(0, |(_, offset, size)| offset + size);
    let fits = twin.size == span || (!padded && span == end && twin.size == span.next_multiple_of(16));
    (!fits).then(|| format!("{} has {} bytes, {} has {span}", twin.rust, twin.size, twin.wgsl))
}

#[test]
fn structs_have_the_same_fields_offsets_and_sizes_in_rust_and_in_wgsl() {
    let (twins, shaders) = (twins(), parsed());
    let mut met = BTreeSet::new();
    for shader in &shaders {
        for twin in &twins {
            let Some((span, fields)) = layout(&shader.module, twin.wgsl) else { continue };
            met.insert(twin.rust);
            if let Some(fault) = disagreement(twin, span, &fields) {
                panic!("{}:\n{fault}", shader.name());
            }
        }
        // Whatever struct a buffer holds has a twin.
        for (_, v) in shader.module.global_variables.iter().filter(|(_, v)| v.binding.is_some()) {
            let base = match shader.module.types[v.ty].inner {
                TypeInner::Array { base, .. } => base,
                _ => v.ty,
            };
            let ty = &shader.module.types[base];
            if let (TypeInner::Struct { .. }, Some(name)) = (&ty.inner, &ty.name) {
                assert!(twins.iter().any(|t| t.wgsl == name), "{}: '{name}' has no twin here", shader.name());
            }
        }
    }
    let unmet: Vec<_> = twins.iter().map(|t| t.rust).filter(|t| !met.contains(t)).collect();
    assert!(unmet.is_empty(), "no shader declares a twin of {unmet:?}");
}

#[test]
fn every_struct_of_the_uniforms_is_compared() {
    let text = std::fs::read_to_string(super::support::repository().join("src/passes/uniforms.rs")).unwrap();
    let declared: BTreeSet<&str> =
        text.lines().filter_map(|l| l.strip_prefix("pub struct ")).filter_map(|l| l.split([' ', '{']).next()).collect();
    assert_eq!(declared, twins().iter().map(|t| t.rust).collect());
    assert_eq!(text.matches("#[repr(C)]").count(), declared.len());
}

#[test]
fn disagreements_are_seen() {
    let twin = || twin!(StoreLayout = "StoreLayout" { k, capacity, chunk, _pad });
    let compare = |wgsl: &str| {
        let module = naga::front::wgsl::parse_str(&format!("struct StoreLayout {{ {wgsl} }}")).unwrap();
        let (span, fields) = layout(&module, "StoreLayout").unwrap();
        disagreement(&twin(), span, &fields)
    };
    assert_eq!(compare("k: u32, capacity: u32, chunk: u32, _pad: u32,"), None);
    assert_eq!(compare("k: u32, capacity: u32, chunk: u32,"), None);
    assert!(compare("k: u32, chunk: u32, capacity: u32, _pad: u32,").is_some());
    assert!(compare("k: u32, capacity: u32,").is_some());
    assert!(compare("k: u32, capacity: u32, chunk: vec2<u32>, _pad: u32,").is_some());
    assert!(compare("k: u32, capacity: u32, chunk: u32, _pad: vec2<u32>,").is_some());
}
