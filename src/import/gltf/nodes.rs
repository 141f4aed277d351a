//! The hierarchy of the scene that is shown, and its cameras.

use glam::{DMat4, DQuat, DVec3};
use gltf_json::Root;
use gltf_json::camera::Type;
use gltf_json::scene::Node as Source;
use gltf_json::validation::Checked;

use super::accessor::{Data, missing};
use super::{Fallible, Fault, Limits, Notices, instancing};
use crate::math::Projection;
use crate::scene::{Mesh, Node, NoticeKind, Scene, SceneCamera};

/// The nodes of the shown scene, and where its cameras are.
pub(super) struct Hierarchy {
    pub(super) nodes: Vec<Node>,
    /// Per camera: its node (in `nodes`) and its index in the file.
    pub(super) cameras: Vec<(usize, usize)>,
}

/// Checks all nodes and keeps, in file order, those that the shown scene reaches; after them their instances.
pub(super) fn read(
    root: &Root,
    data: &Data,
    meshes: &[Mesh],
    limits: &Limits,
    notices: &mut Notices,
) -> Fallible<Hierarchy> {
    let parents = parents(root)?;
    let roots = roots(root, &parents, notices)?;
    let (reached, hidden) = reach(root, &roots, limits)?;
    let what = "nodes are hidden by the file (KHR_node_visibility) and are left out";
    notices.count(NoticeKind::Ignored, what, hidden.iter().filter(|&&h| h).count() as u64, "nodes");
    let (mut instances, mut instanced) = (Vec::new(), 0);
    let mut next = 0;
    let number: Vec<Option<usize>> = reached
        .iter()
        .map(|&reached| {
            next += usize::from(reached);
            reached.then(|| next - 1)
        })
        .collect();
    let mut hierarchy = Hierarchy { nodes: Vec::new(), cameras: Vec::new() };
    for (i, source) in root.nodes.iter().enumerate() {
        let place = format!("nodes[{i}]");
        let parent_from_node = transform(source, &place, notices)?;
        let mesh = source.mesh.map(|m| m.value());
        if let Some(mesh) = mesh.filter(|&m| m >= meshes.len()) {
            return Err(missing(format!("{place}.mesh"), "mesh", mesh, meshes.len()));
        }
        let copies = instancing::read(source, data, &place, limits, &mut instanced, notices)?;
        let camera = source.camera.map(|c| c.value());
        if let Some(camera) = camera.filter(|&c| c >= root.cameras.len()) {
            return Err(missing(format!("{place}.camera"), "camera", camera, root.cameras.len()));
        }
        if number[i].is_none() {
            continue;
        }
        if let Some(camera) = camera {
            check_camera(root, camera, &mut hierarchy.cameras, hierarchy.nodes.len(), notices)?;
        }
        let shown = mesh.filter(|_| !hidden[i]);
        hierarchy.nodes.push(Node {
            name: source.name.clone().unwrap_or_default(),
            parent: parents[i].and_then(|p| number[p]),
            children: children(source).filter_map(|c| number.get(c).copied().flatten()).collect(),
            parent_from_node,
            mesh: shown.filter(|_| copies.is_none()),
        });
        if let (Some(copies), Some(mesh)) = (copies, shown) {
            instances.push((hierarchy.nodes.len() - 1, mesh, copies));
        }
    }
    for (parent, mesh, copies) in instances {
        let names = [&hierarchy.nodes[parent].name, &meshes[mesh].name];
        let name = names.into_iter().find(|n| !n.is_empty()).cloned().unwrap_or_else(|| "instance".to_owned());
        for (i, parent_from_node) in copies.into_iter().enumerate() {
            let child = hierarchy.nodes.len();
            hierarchy.nodes[parent].children.push(child);
            let name = format!("{name} #{}", i + 1);
            hierarchy.nodes.push(Node { parent: Some(parent), ..Node::root(name, Some(mesh), parent_from_node) });
        }
    }
    finite(&hierarchy.nodes)?;
    Ok(hierarchy)
}

fn children(node: &Source) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(|c| c.value())
}

/// The parent of every node. A node with two is an error: glTF's hierarchy is a strict tree.
fn parents(root: &Root) -> Fallible<Vec<Option<usize>>> {
    let mut parents: Vec<Option<usize>> = vec![None; root.nodes.len()];
    for (i, node) in root.nodes.iter().enumerate() {
        for (k, child) in children(node).enumerate() {
            let place = format!("nodes[{i}].children[{k}]");
            let Some(parent) = parents.get_mut(child) else {
                return Err(missing(place, "node", child, root.nodes.len()));
            };
            if let Some(other) = parent.replace(i) {
                return Err(Fault::invalid(place, format!("node {child} is also a child of node {other}")));
            }
        }
    }
    // With one parent each, following them from a node either ends at a root or goes around a loop.
    let mut state = vec![0_u8; parents.len()];
    for start in 0..parents.len() {
        let (mut at, mut path) = (start, Vec::new());
        while state[at] == 0 {
            state[at] = 1;
            path.push(at);
            match parents[at] {
                Some(parent) => at = parent,
                None => break,
            }
        }
        if state[at] == 1 && parents[at].is_some() {
            return Err(Fault::invalid(format!("nodes[{at}]"), "is its own ancestor: the nodes form a loop"));
        }
        for node in path {
            state[node] = 2;
        }
    }
    Ok(parents)
}

/// The roots of the scene that is shown: the default scene, else the first, else all roots.
fn roots(root: &Root, parents: &[Option<usize>], notices: &mut Notices) -> Fallible<Vec<usize>> {
    for (s, scene) in root.scenes.iter().enumerate() {
        for (k, node) in scene.nodes.iter().map(|n| n.value()).enumerate() {
            let place = format!("scenes[{s}].nodes[{k}]");
            match parents.get(node) {
                None => return Err(missing(place, "node", node, parents.len())),
                Some(Some(parent)) => {
                    return Err(Fault::invalid(
                        place,
                        format!("node {node} is not a root but a child of node {parent}"),
                    ));
                }
                Some(None) => {}
            }
        }
    }
    let shown = match root.scene.map(|s| s.value()) {
        Some(scene) if scene >= root.scenes.len() => return Err(missing("scene", "scene", scene, root.scenes.len())),
        Some(scene) => scene,
        None => 0,
    };
    if root.scenes.len() > 1 {
        notices.ignored(format!("{} scenes: only scenes[{shown}] is shown", root.scenes.len()));
    }
    match root.scenes.get(shown) {
        Some(scene) => {
            let mut roots: Vec<usize> = scene.nodes.iter().map(|n| n.value()).collect();
            roots.sort_unstable();
            roots.dedup();
            Ok(roots)
        }
        None => {
            if !root.nodes.is_empty() {
                notices.approximated("the file has no scene: all its nodes are shown".to_owned());
            }
            Ok((0..parents.len()).filter(|&n| parents[n].is_none()).collect())
        }
    }
}

/// Which nodes the roots reach, and which of them the file hides (KHR_node_visibility: a node with all below it).
fn reach(root: &Root, roots: &[usize], limits: &Limits) -> Fallible<(Vec<bool>, Vec<bool>)> {
    let mut reached = vec![false; root.nodes.len()];
    let mut hidden = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, u64, bool)> = roots.iter().map(|&n| (n, 1, false)).collect();
    while let Some((node, depth, under_hidden)) = stack.pop() {
        if depth > limits.node_depth {
            return Err(Fault::limit(format!("nodes[{node}]"), "levels of nodes", depth, limits.node_depth));
        }
        reached[node] = true;
        hidden[node] = under_hidden || !is_visible(&root.nodes[node], node)?;
        stack.extend(children(&root.nodes[node]).map(|c| (c, depth + 1, hidden[node])));
    }
    Ok((reached, hidden))
}

fn is_visible(node: &Source, index: usize) -> Fallible<bool> {
    let object = node.extensions.as_ref().and_then(|e| e.others.get("KHR_node_visibility"));
    match object.map(|o| o.get("visible")) {
        None | Some(None) => Ok(true),
        Some(Some(visible)) => visible.as_bool().ok_or_else(|| {
            Fault::invalid(format!("nodes[{index}].extensions.KHR_node_visibility.visible"), "is not true or false")
        }),
    }
}

/// A node's own transform: its matrix, or translation · rotation · scale.
fn transform(node: &Source, place: &str, notices: &mut Notices) -> Fallible<DMat4> {
    let finite = |values: &[f32], member: &str| {
        if values.iter().all(|c| c.is_finite()) {
            return Ok(());
        }
        Err(Fault::invalid(format!("{place}.{member}"), "has a number that is not finite"))
    };
    if let Some(matrix) = node.matrix {
        finite(&matrix, "matrix")?;
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            notices.repaired(format!("{place}: has a matrix and other transforms; the matrix is used"));
        }
        let mut matrix = matrix.map(f64::from);
        if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
            notices.repaired(format!("{place}.matrix: its last row is not 0 0 0 1 and was set to it"));
            (matrix[3], matrix[7], matrix[11], matrix[15]) = (0.0, 0.0, 0.0, 1.0);
        }
        let matrix = DMat4::from_cols_array(&matrix);
        let what = "matrices are not products of translation, rotation and scale; they were used as they are";
        notices.count(NoticeKind::Repaired, what, is_skewed(&matrix).into(), place);
        return Ok(matrix);
    }
    let translation = node.translation.unwrap_or([0.0; 3]);
    let scale = node.scale.unwrap_or([1.0; 3]);
    let rotation = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0);
    finite(&translation, "translation")?;
    finite(&scale, "scale")?;
    finite(&rotation, "rotation")?;
    let turn = DQuat::from_array(rotation.map(f64::from));
    let length = turn.length();
    if (length - 1.0).abs() > 1e-2 {
        notices.repaired(format!("{place}.rotation: a quaternion of length {length} was normalized"));
    }
    let turn = if length > 1e-12 { turn.normalize() } else { DQuat::IDENTITY };
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    Ok(DMat4::from_scale_rotation_translation(vector(scale), turn, vector(translation)))
}

/// Whether the axes of a matrix are not at right angles, or have no length.
fn is_skewed(matrix: &DMat4) -> bool {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|a| a.truncate().normalize_or_zero());
    let cosine = |a: usize, b: usize| axes[a].dot(axes[b]).abs();
    axes.contains(&DVec3::ZERO) || cosine(0, 1).max(cosine(1, 2)).max(cosine(2, 0)) > 1e-3
}

/// Products of finite matrices can still overflow.
fn finite(nodes: &[Node]) -> Fallible<()> {
    let mut stack: Vec<(usize, DMat4)> =
        nodes.iter().enumerate().filter(|(_, n)| n.parent.is_none()).map(|(i, _)| (i, DMat4::IDENTITY)).collect();
    while let Some((i, parent)) = stack.pop() {
        let world = parent * nodes[i].parent_from_node;
        if !world.is_finite() || world.to_cols_array().iter().any(|c| c.abs() > 1e100) {
            let cause =
                format!("{:?}: the transforms up to the root multiply to numbers that are too large", nodes[i].name);
            return Err(Fault::invalid("nodes", cause));
        }
        stack.extend(nodes[i].children.iter().map(|&c| (c, world)));
    }
    Ok(())
}

/// Keeps a camera if its values make sense.
fn check_camera(
    root: &Root,
    camera: usize,
    kept: &mut Vec<(usize, usize)>,
    node: usize,
    notices: &mut Notices,
) -> Fallible<()> {
    if let Checked::Invalid = root.cameras[camera].type_ {
        return Err(Fault::invalid(format!("cameras[{camera}].type"), "is neither perspective nor orthographic"));
    }
    match projection(root, camera) {
        Some(_) => kept.push((node, camera)),
        None => notices.ignored(format!("cameras[{camera}]: it has no usable angle or height and is left out")),
    }
    Ok(())
}

fn projection(root: &Root, camera: usize) -> Option<Projection> {
    let camera = root.cameras.get(camera)?;
    match camera.type_ {
        Checked::Valid(Type::Perspective) => {
            let fov_y = f64::from(camera.perspective.as_ref()?.yfov);
            (fov_y > 0.0 && fov_y < std::f64::consts::PI).then_some(Projection::Perspective { fov_y })
        }
        Checked::Valid(Type::Orthographic) => {
            let height = 2.0 * f64::from(camera.orthographic.as_ref()?.ymag);
            (height > 0.0 && height.is_finite()).then_some(Projection::Orthographic { height })
        }
        Checked::Invalid => None,
    }
}

/// The cameras in the space of the finished scene.
pub(super) fn cameras(root: &Root, found: &[(usize, usize)], scene: &Scene) -> Vec<SceneCamera> {
    let camera = |&(node, camera): &(usize, usize)| {
        let names = [root.cameras.get(camera).and_then(|c| c.name.clone()), Some(scene.nodes[node].name.clone())];
        Some(SceneCamera {
            name: names.into_iter().flatten().find(|n| !n.is_empty()).unwrap_or_default(),
            world_from_camera: scene.world_from_node(node),
            projection: projection(root, camera)?,
        })
    };
    found.iter().filter_map(camera).collect()
}
