//! Stands for rooms that are written elsewhere. Delete on merging.
#![allow(missing_docs, clippy::missing_errors_doc)]

pub mod gpu {
    use serde::Serialize;

    #[derive(Default)]
    pub struct GpuOptions {}
    #[derive(Debug, thiserror::Error)]
    #[error("no usable adapter")]
    pub struct GpuError;
    #[derive(Clone, Debug, Serialize)]
    pub struct AdapterFacts {
        pub name: String,
        pub driver: String,
        pub driver_info: String,
        pub backend: String,
        pub device_type: String,
        pub features: Vec<String>,
        pub limits: Vec<(String, u64)>,
        pub usable: Result<(), String>,
    }
    pub struct Gpu(AdapterFacts);
    impl Gpu {
        pub fn new(_: &GpuOptions) -> Result<Gpu, GpuError> {
            Gpu::adapters().pop().map(Gpu).ok_or(GpuError)
        }
        pub fn adapters() -> Vec<AdapterFacts> {
            if std::env::var_os("STUB_NO_ADAPTER").is_some() {
                return Vec::new();
            }
            vec![AdapterFacts {
                name: "stub".into(),
                driver: "none".into(),
                driver_info: "0".into(),
                backend: "none".into(),
                device_type: "cpu".into(),
                features: vec!["SHADER_INT64".into()],
                limits: vec![("max_buffer_size".into(), 1 << 27)],
                usable: Ok(()),
            }]
        }
        pub fn facts(&self) -> &AdapterFacts {
            &self.0
        }
    }
}

pub mod plan {
    use serde::Serialize;

    #[derive(Clone, Debug, Serialize)]
    pub struct FramePlan {
        pub passes: Vec<String>,
    }
    impl std::fmt::Display for FramePlan {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str(&self.passes.join("\n"))
        }
    }
    #[derive(Debug, thiserror::Error)]
    #[error("k = 32 at {0}×{1} needs too much")]
    pub struct Refusal(pub u32, pub u32);
}

pub mod render {
    use super::gpu::Gpu;
    use super::plan::{FramePlan, Refusal};
    use crate::export::image::LinearImage;
    use crate::math::Camera;
    use crate::scene::Scene;
    use crate::settings::Settings;
    use serde::Serialize;

    #[derive(Debug, thiserror::Error)]
    pub enum RenderError {
        #[error(transparent)]
        Refused(#[from] Refusal),
    }
    #[derive(Clone, Debug, Default, Serialize)]
    pub struct Layers {
        pub rasterized: u64,
        pub stored: u64,
        pub merged: u64,
        pub dropped: u64,
        pub lost: u64,
        pub deepest: u32,
    }
    #[derive(Clone, Debug, Serialize)]
    pub struct FrameReport {
        pub layers: Layers,
        pub passes: Vec<(String, f64)>,
        pub plan: FramePlan,
        pub adapter: String,
        pub milliseconds: f64,
    }
    pub struct Frame {
        pub image: LinearImage,
        pub report: FrameReport,
    }
    pub struct Renderer(Gpu);
    pub struct GpuScene;
    impl Renderer {
        pub fn new(gpu: Gpu) -> Result<Renderer, RenderError> {
            Ok(Renderer(gpu))
        }
        pub fn load(&mut self, _: &Scene) -> Result<GpuScene, RenderError> {
            Ok(GpuScene)
        }
        pub fn plan(&self, _: &GpuScene, _: &Camera, _: &Settings, size: [u32; 2]) -> Result<FramePlan, RenderError> {
            if size[0] > 16384 {
                return Err(Refusal(size[0], size[1]).into());
            }
            Ok(FramePlan { passes: vec!["nothing: this is a stub".into()] })
        }
        pub fn render(
            &mut self,
            s: &GpuScene,
            c: &Camera,
            settings: &Settings,
            size: [u32; 2],
        ) -> Result<Frame, RenderError> {
            let plan = self.plan(s, c, settings, size)?;
            let mut image = LinearImage::clear(size[0], size[1]);
            for (i, pixel) in image.pixels.iter_mut().enumerate() {
                let a = (i as u32 % size[0]) as f32 / size[0] as f32;
                *pixel = [a * 0.5, a * 0.25, a, a];
            }
            let report = FrameReport {
                layers: Layers::default(),
                passes: vec![("nothing".into(), 0.1)],
                plan,
                adapter: self.0.facts().name.clone(),
                milliseconds: 1.0,
            };
            Ok(Frame { image, report })
        }
    }
}

pub mod import {
    use crate::scene::Scene;
    use std::path::Path;

    #[derive(Debug, thiserror::Error)]
    #[error("{0}: no importer yet")]
    pub struct ImportError(String);
    pub fn load(path: &Path) -> Result<Scene, ImportError> {
        Err(ImportError(path.display().to_string()))
    }
    pub mod builtin {
        use crate::scene::{Material, Mesh, Node, Primitive, Scene};
        use glam::DMat4;
        pub fn names() -> &'static [&'static str] {
            &["triangle"]
        }
        pub fn generate(name: &str) -> Option<Scene> {
            (name == "triangle").then_some(())?;
            let primitive = Primitive {
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                normals: vec![[0.0, 0.0, 1.0]; 3],
                triangles: vec![[0, 1, 2]],
                ..Primitive::default()
            };
            let mut child = Node::root("child\n\u{1b}[31m", Some(0), DMat4::IDENTITY);
            child.parent = Some(0);
            let mut root = Node::root("root", None, DMat4::IDENTITY);
            root.children = vec![1];
            Scene {
                name: name.into(),
                nodes: vec![root, child],
                meshes: vec![Mesh { name: "mesh".into(), primitives: vec![primitive] }],
                materials: vec![Material::default()],
                ..Scene::default()
            }
            .finish()
            .ok()
        }
    }
    pub fn write_assets(folder: &Path) -> Result<Vec<std::path::PathBuf>, ImportError> {
        Err(ImportError(folder.display().to_string()))
    }
}
