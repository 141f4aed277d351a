//! Where things are in the window and what it is at, logged for tests that drive the real one.
//!
//! Keys and which picture is shown are logged with everything else. Where the log asks for it (`RUST_LOG=pellucid::places=trace`),
//! egui makes its tree for screen readers too, and each frame in which that differs from the frame before writes it out, a line
//! for every widget that has a name, in pixels of the window. A test finds widgets by what a screen reader reads, and waits for
//! facts instead of sleeping.

use egui::accesskit::{Node, NodeId, TreeUpdate};

use super::Shell;
use crate::app::workspace::Workspace;

/// The target of these lines.
const TARGET: &str = "pellucid::places";

/// Whether anybody wants to know where widgets are.
pub(super) fn wanted() -> bool {
    tracing::enabled!(target: TARGET, tracing::Level::TRACE)
}

/// What was written last.
#[derive(Default)]
pub(super) struct Places {
    tree: String,
    shown: String,
}

impl Places {
    /// Writes out the tree of a frame, if it is another one.
    pub(super) fn note(&mut self, update: Option<&TreeUpdate>, pixels_per_point: f32) {
        let Some(update) = update else {
            return;
        };
        let tree = lines_of(update, f64::from(pixels_per_point));
        if tree != self.tree {
            tracing::trace!(target: TARGET, "tree\n{tree}end of tree");
            self.tree = tree;
        }
    }

    /// Writes out of which order the picture is that a frame has brought to the display.
    pub(super) fn note_shown(&mut self, workspace: &Workspace) {
        let Some(screen) = &workspace.screen else {
            return;
        };
        let shown = format!("{} {} of {}", screen.kind.name(), screen.number, workspace.order);
        if shown != self.shown {
            tracing::debug!(target: TARGET, "shown {shown}");
            self.shown = shown;
        }
    }
}

/// A line for every widget that has a name: role, name, value, and left, top, right and bottom in pixels of the window.
fn lines_of(update: &TreeUpdate, pixels_per_point: f64) -> String {
    let mut lines = String::new();
    for (_, node) in &update.nodes {
        let Some((name, bounds)) = name_of(node, update).zip(node.bounds()) else {
            continue;
        };
        let value = node.value().map(str::to_owned).or_else(|| node.numeric_value().map(|v| v.to_string()));
        let [left, top, right, bottom] =
            [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|v| (v * pixels_per_point).round());
        let (role, value) = (node.role(), value.unwrap_or_default());
        lines.push_str(&format!("  {role:?}\t{name:?}\t{value:?}\t{left} {top} {right} {bottom}\n"));
    }
    lines
}

/// What a screen reader calls it: its own name, the text of what labels it, or its text.
fn name_of(node: &Node, update: &TreeUpdate) -> Option<String> {
    let text = |id: &NodeId| {
        let (_, found) = update.nodes.iter().find(|(other, _)| other == id)?;
        found.label().or(found.value()).map(str::to_owned)
    };
    let name = node.label().map(str::to_owned);
    let name = name.or_else(|| node.labelled_by().iter().find_map(text));
    name.or_else(|| node.value().map(str::to_owned)).filter(|n| !n.is_empty())
}

impl Shell {
    /// Writes out a key that was pressed: everything that came before it has been dealt with.
    pub(super) fn note_key(&self, key: &winit::keyboard::Key) {
        tracing::debug!(target: TARGET, "key {key:?}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widgets_are_found_by_name_and_in_pixels() {
        let context = egui::Context::default();
        context.enable_accesskit();
        let mut text = "typed".to_owned();
        let mut shown = egui::Rect::NOTHING;
        let mut output = context.run_ui(Default::default(), |ui| {
            let name = ui.label("Name of it");
            shown = ui.text_edit_singleline(&mut text).labelled_by(name.id).rect;
        });
        output.textures_delta.clear();
        let lines = lines_of(&output.platform_output.accesskit_update.unwrap(), 2.0);
        let place = [shown.left(), shown.top(), shown.right(), shown.bottom()].map(|v| (v * 2.0).round().to_string());
        let line = format!("  TextInput\t\"Name of it\"\t\"typed\"\t{}\n", place.join(" "));
        assert!(lines.contains(&line), "{line}{lines}");
    }
}
