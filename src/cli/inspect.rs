//! What is in a file, for people and as JSON.

use std::collections::HashMap;
use std::fmt::Write;

use glam::DVec3;
use serde::Serialize;

use super::failure::printable;
use super::load::Times;
use super::output::grouped;
use crate::math::{Bounds, Projection};
use crate::scene::{AlphaMode, Scene, SceneCamera, SceneStats};

/// What is in a scene. Positions are in the file's own coordinates.
#[derive(Serialize)]
pub struct Report {
    name: String,
    triangles: u64,
    vertices: u64,
    meshes: usize,
    bounds: Option<BoxFacts>,
    /// What became a part and why.
    #[serde(skip_serializing_if = "String::is_empty")]
    partition: String,
    /// Material variants that can be chosen, by name.
    variants: Vec<String>,
    parts: Vec<PartFacts>,
    nodes: Vec<NodeFacts>,
    materials: Vec<MaterialFacts>,
    images: Vec<ImageFacts>,
    cameras: Vec<CameraFacts>,
    notices: Vec<NoticeFacts>,
    /// How long it took to read.
    times: Times,
}

#[derive(Serialize)]
struct BoxFacts {
    min: [f64; 3],
    max: [f64; 3],
}

#[derive(Serialize)]
struct PartFacts {
    name: String,
    node: usize,
    mesh: usize,
    triangles: u32,
    materials: Vec<usize>,
    bounds: Option<BoxFacts>,
}

#[derive(Serialize)]
struct NodeFacts {
    name: String,
    parent: Option<usize>,
    children: Vec<usize>,
    mesh: Option<usize>,
    part: Option<usize>,
}

#[derive(Serialize)]
struct MaterialFacts {
    name: String,
    base_color: [f32; 4],
    metallic: f32,
    roughness: f32,
    alpha: &'static str,
    textures: usize,
    emissive: bool,
    unlit: bool,
}

#[derive(Serialize)]
struct ImageFacts {
    name: String,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct CameraFacts {
    name: String,
    projection: &'static str,
    /// Where it stands, in the file's coordinates.
    position: [f64; 3],
}

#[derive(Serialize)]
struct NoticeFacts {
    kind: &'static str,
    message: String,
}

impl BoxFacts {
    fn size(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.max[i] - self.min[i])
    }
}

impl Report {
    /// Collects the facts of a scene that took so long to read.
    pub fn of(scene: &Scene, times: Times) -> Report {
        let stats = SceneStats::of(scene);
        let box_of = |b: &Bounds| {
            (!b.is_empty())
                .then(|| BoxFacts { min: (b.min + scene.origin).to_array(), max: (b.max + scene.origin).to_array() })
        };
        let parts = scene.parts.iter().map(|part| {
            let mut materials: Vec<usize> =
                scene.meshes.get(part.mesh).into_iter().flat_map(|m| &m.primitives).map(|p| p.material).collect();
            materials.sort_unstable();
            materials.dedup();
            PartFacts {
                name: part.name.clone(),
                node: part.node,
                mesh: part.mesh,
                triangles: part.triangle_count,
                materials,
                bounds: box_of(&part.bounds),
            }
        });
        let part_of: HashMap<usize, usize> = scene.parts.iter().enumerate().map(|(i, part)| (part.node, i)).collect();
        let nodes = scene.nodes.iter().enumerate().map(|(i, node)| NodeFacts {
            name: node.name.clone(),
            parent: node.parent,
            children: node.children.clone(),
            mesh: node.mesh,
            part: part_of.get(&i).copied(),
        });
        let materials = scene.materials.iter().map(|m| MaterialFacts {
            name: m.name.clone(),
            base_color: m.base_color,
            metallic: m.metallic,
            roughness: m.roughness,
            alpha: match m.alpha_mode {
                AlphaMode::Opaque => "opaque",
                AlphaMode::Mask { .. } => "mask",
                AlphaMode::Blend => "blend",
            },
            textures: m.texture_refs().count(),
            emissive: m.emissive != [0.0; 3],
            unlit: m.unlit,
        });
        let image = |i: &std::sync::Arc<crate::scene::Image>| ImageFacts {
            name: i.name.clone(),
            width: i.width,
            height: i.height,
        };
        let camera = |c: &SceneCamera| CameraFacts {
            name: c.name.clone(),
            projection: match c.projection {
                Projection::Perspective { .. } => "perspective",
                Projection::Orthographic { .. } => "orthographic",
            },
            position: (c.world_from_camera.transform_point3(DVec3::ZERO) + scene.origin).to_array(),
        };
        let notice = |n: &crate::scene::Notice| NoticeFacts { kind: n.kind.name(), message: n.message.clone() };
        Report {
            name: scene.name.clone(),
            triangles: stats.triangles,
            vertices: stats.vertices,
            meshes: scene.meshes.len(),
            bounds: box_of(&stats.bounds),
            partition: scene.partition.clone(),
            variants: scene.variants.clone(),
            parts: parts.collect(),
            nodes: nodes.collect(),
            materials: materials.collect(),
            images: scene.images.iter().map(image).collect(),
            cameras: scene.cameras.iter().map(camera).collect(),
            notices: scene.notices.iter().map(notice).collect(),
            times,
        }
    }

    /// The report for people.
    pub fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "{}: {} of {}, {}, {}, {}, {}",
            printable(&self.name),
            counted(self.parts.len() as u64, "part"),
            counted(self.meshes as u64, "mesh"),
            counted(self.triangles, "triangle"),
            counted(self.vertices, "vertex"),
            counted(self.materials.len() as u64, "material"),
            counted(self.images.len() as u64, "image"),
        )?;
        match &self.bounds {
            Some(b) => {
                writeln!(out, "size    {}", numbers(b.size(), " × "))?;
                writeln!(out, "bounds  {} to {}", numbers(b.min, ", "), numbers(b.max, ", "))?;
            }
            None => writeln!(out, "bounds  empty: there is nothing to see")?,
        }
        if !self.partition.is_empty() {
            writeln!(out, "parts   {}", printable(&self.partition))?;
        }
        if !self.variants.is_empty() {
            let names: Vec<String> = self.variants.iter().map(|name| format!("'{}'", printable(name))).collect();
            writeln!(out, "variants {} (for --variant)", names.join(", "))?;
        }
        writeln!(out, "\nhierarchy")?;
        self.write_hierarchy(out)?;
        writeln!(out, "\nmaterials")?;
        for (i, m) in self.materials.iter().enumerate() {
            let users = self.parts.iter().filter(|p| p.materials.contains(&i)).count() as u64;
            write!(out, "  {i} '{}' of {}: {}", printable(&m.name), counted(users, "part"), m.alpha)?;
            write!(out, ", base {}", numbers(m.base_color.map(f64::from), " "))?;
            write!(out, ", metallic {}, roughness {}", m.metallic, m.roughness)?;
            if m.textures > 0 {
                write!(out, ", {}", counted(m.textures as u64, "texture"))?;
            }
            let extra = [(m.emissive, ", emissive"), (m.unlit, ", unlit")];
            let extra: String = extra.iter().filter(|(is, _)| *is).map(|(_, word)| *word).collect();
            writeln!(out, "{extra}")?;
        }
        if !self.images.is_empty() {
            writeln!(out, "\nimages")?;
            for (i, image) in self.images.iter().enumerate() {
                writeln!(out, "  {i} '{}' {}×{}", printable(&image.name), image.width, image.height)?;
            }
        }
        if !self.cameras.is_empty() {
            writeln!(out, "\ncameras (for --camera, by name or number)")?;
            for (i, c) in self.cameras.iter().enumerate() {
                writeln!(out, "  {i} '{}' {} at {}", printable(&c.name), c.projection, numbers(c.position, ", "))?;
            }
        }
        if !self.notices.is_empty() {
            writeln!(out, "\nnotices")?;
            for notice in &self.notices {
                writeln!(out, "  {}: {}", notice.kind, printable(&notice.message))?;
            }
        }
        writeln!(out, "\ntime")?;
        for time in &self.times.phases {
            writeln!(out, "  {:<22}{:>10.1} ms", time.phase, time.milliseconds)?;
        }
        writeln!(out, "  {:<22}{:>10.1} ms", "all", self.times.milliseconds)?;
        Ok(())
    }

    /// Nodes as an indented tree. With a stack, since a file may nest them as deep as it likes.
    fn write_hierarchy(&self, out: &mut String) -> std::fmt::Result {
        let mut stack: Vec<(usize, usize)> =
            (0..self.nodes.len()).rev().filter(|&i| self.nodes[i].parent.is_none()).map(|i| (i, 1)).collect();
        let mut shown = vec![false; self.nodes.len()];
        while let Some((i, depth)) = stack.pop() {
            let Some(node) = self.nodes.get(i) else { continue };
            if std::mem::replace(&mut shown[i], true) {
                continue;
            }
            let part = node.part.and_then(|p| self.parts.get(p).map(|part| (p, part)));
            let name = match part {
                Some((_, part)) => &part.name,
                None if node.name.is_empty() => "(no name)",
                None => &node.name,
            };
            write!(out, "{}{}", "  ".repeat(depth.min(32)), printable(name))?;
            if let Some((p, part)) = part {
                write!(out, ": part {p}, {}", counted(part.triangles.into(), "triangle"))?;
                if let Some(b) = &part.bounds {
                    write!(out, ", {}", numbers(b.size(), " × "))?;
                }
                write!(out, ", material {}", numbers_of(&part.materials))?;
            }
            writeln!(out)?;
            stack.extend(node.children.iter().rev().map(|&child| (child, depth + 1)));
        }
        Ok(())
    }
}

/// "1 part", "2 meshes".
fn counted(count: u64, what: &str) -> String {
    let plural = match what {
        "mesh" => "meshes".to_owned(),
        "vertex" => "vertices".to_owned(),
        _ => format!("{what}s"),
    };
    format!("{} {}", grouped(count), if count == 1 { what } else { &plural })
}

fn numbers_of(values: &[usize]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// Numbers to five significant digits, or as whole numbers where those are more.
fn numbers<const N: usize>(values: [f64; N], between: &str) -> String {
    values.map(five_digits).join(between)
}

fn five_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..=9).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let text = format!("{value:.*}", usize::try_from(4 - magnitude).unwrap_or(0));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::scene::{Material, Mesh, Node, Primitive};

    fn scene(offset: f64) -> Scene {
        let primitive = Primitive {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let mut child = Node::root("wheel\n\u{1b}[31m", Some(0), DMat4::from_translation(glam::DVec3::X * offset));
        child.parent = Some(0);
        let mut root = Node::root("car", None, DMat4::IDENTITY);
        root.children = vec![1];
        Scene {
            name: "model".to_owned(),
            nodes: vec![root, child],
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            materials: vec![Material::default()],
            ..Scene::default()
        }
        .finish()
        .unwrap()
    }

    #[test]
    fn text_shows_the_tree_and_no_control_characters() {
        let text = Report::of(&scene(0.0), Times::default()).text();
        assert!(
            text.starts_with(
                "model: 1 part of 1 mesh, 1 triangle, 3 vertices, 1 material, 0 images\nsize    1 × 1 × 0\n"
            ),
            "{text}"
        );
        let tree = "  car\n    wheel\u{fffd}\u{fffd}[31m: part 0, 1 triangle, 1 × 1 × 0, material 0\n";
        assert!(text.contains(tree), "{text}");
    }

    #[test]
    fn json_has_bounds_in_the_files_coordinates() {
        let json = serde_json::to_value(Report::of(&scene(1e6), Times::default())).unwrap();
        assert_eq!(json["bounds"]["min"][0], 1e6);
        assert_eq!(json["bounds"]["max"][0], 1e6 + 1.0);
        assert_eq!(json["nodes"][1]["parent"], 0);
        assert_eq!(json["nodes"][1]["part"], 0);
        assert_eq!(json["notices"][0]["kind"], "computed");
    }

    #[test]
    fn a_deep_chain_and_an_empty_scene_are_shown() {
        let nodes = (0..100_000_usize).map(|i| {
            let mut node = Node::root("n", None, DMat4::IDENTITY);
            node.parent = i.checked_sub(1);
            node.children = if i + 1 < 100_000 { vec![i + 1] } else { Vec::new() };
            node
        });
        let text = Report::of(&Scene { nodes: nodes.collect(), ..Scene::default() }, Times::default()).text();
        assert_eq!(text.lines().filter(|l| l.ends_with(" n")).count(), 100_000);
        assert!(text.contains("bounds  empty"));
    }

    #[test]
    fn numbers_are_short_and_right() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-2.430_910_11, "-2.4309"),
            (0.012_345_67, "0.012346"),
            (123_456.78, "123457"),
            (1e6 + 1.0, "1000001"),
            (99_999.96, "100000"),
            (1e-9, "1.0000e-9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(five_digits(value), text);
        }
    }
}
