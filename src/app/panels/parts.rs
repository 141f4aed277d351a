//! The parts: their tree with counts, a search, and what is shown of them.
//!
//! The eye goes from shown over ghosted to hidden, for everything below a node at once. A click on a name selects, with Ctrl one
//! more; the rest is in the context menu. Rows that scroll out of sight cost nothing, however many parts a file has.

use std::collections::{BTreeSet, HashSet};
use std::ops::Range;

use egui::{Button, RichText, ScrollArea, TextEdit, Ui, vec2};

use crate::app::panels::selection;
use crate::app::workspace::Workspace;
use crate::scene::{Arrangement, PartLook, Presence, Scene};

/// What the tree and what is above it keep of the panel's height, points, before the selection takes the rest.
const LEAST_TREE: f32 = 130.0;
/// What is left for the selection even so.
const LEAST_SELECTION: f32 = 60.0;

/// A node of the tree that has parts at or below it.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    name: String,
    depth: usize,
    /// Parts at and below it: they are numbered depth first.
    parts: Range<u32>,
    /// The row after its last descendant.
    end: usize,
}

/// The tree of a scene, laid flat.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    of: u64,
    rows: Vec<Row>,
    closed: HashSet<usize>,
}

impl Tree {
    fn new(of: u64, scene: &Scene) -> Tree {
        let mut part_of = vec![None; scene.nodes.len()];
        for (i, part) in scene.parts.iter().enumerate() {
            part_of[part.node] = Some(i as u32);
        }
        let mut rows: Vec<Row> = Vec::new();
        let mut closed = HashSet::new();
        // Node, depth; or the row that ends.
        enum Step {
            Enter(usize, usize),
            Leave(usize),
        }
        let roots = (0..scene.nodes.len()).rev().filter(|&n| scene.nodes[n].parent.is_none());
        let mut stack: Vec<Step> = roots.map(|n| Step::Enter(n, 0)).collect();
        let mut next_part = 0;
        let mut visited = vec![false; scene.nodes.len()];
        while let Some(step) = stack.pop() {
            match step {
                Step::Enter(node, depth) => {
                    if std::mem::replace(&mut visited[node], true) {
                        continue;
                    }
                    let first = next_part;
                    if let Some(part) = part_of[node] {
                        next_part = part + 1;
                    }
                    let name = match (&scene.nodes[node].name, part_of[node]) {
                        (name, _) if !name.is_empty() => name.clone(),
                        (_, Some(part)) => scene.parts[part as usize].name.clone(),
                        _ => "(no name)".to_owned(),
                    };
                    stack.push(Step::Leave(rows.len()));
                    rows.push(Row { name, depth, parts: first..first, end: 0 });
                    stack.extend(scene.nodes[node].children.iter().rev().map(|&c| Step::Enter(c, depth + 1)));
                }
                Step::Leave(row) => {
                    rows[row].parts.end = next_part;
                    if rows[row].parts.is_empty() {
                        rows.truncate(row);
                        continue;
                    }
                    rows[row].end = rows.len();
                    // What has very many below it begins closed, except at the top.
                    if rows[row].depth > 0 && rows.len() - row > 40 {
                        closed.insert(row);
                    }
                }
            }
        }
        Tree { of, rows, closed }
    }

    /// Rows to show: those in no closed node, or those that are found.
    fn visible(&self, search: &str) -> Vec<usize> {
        if !search.is_empty() {
            let wanted = search.to_lowercase();
            return (0..self.rows.len()).filter(|&i| self.rows[i].name.to_lowercase().contains(&wanted)).collect();
        }
        let mut rows = Vec::new();
        let mut at = 0;
        while at < self.rows.len() {
            rows.push(at);
            at = if self.closed.contains(&at) { self.rows[at].end } else { at + 1 };
        }
        rows
    }
}

/// What a row asks for.
enum Act {
    Toggle(usize),
    Presence(Range<u32>, Presence),
    Select(Range<u32>, bool),
    Isolate(Range<u32>),
    Frame(Range<u32>),
    ShowAll,
}

/// The panel.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    // Else the panel shrinks to what is in it.
    ui.take_available_width();
    if workspace.document.is_some() {
        // Where there is little room, the tree keeps some, and the rest can be scrolled.
        let most = (ui.available_height() - LEAST_TREE).max(LEAST_SELECTION);
        let id = ui.scope_id().with("selection is scrolled");
        let scrolls = ui.data(|d| d.get_temp::<bool>(id)).unwrap_or_default();
        let panel = egui::Panel::bottom("selection").frame(egui::Frame::NONE);
        // An area that scrolls is as high as it may be, so it is one only where what is in it is higher.
        let is_higher = if scrolls {
            let area = ScrollArea::vertical().id_salt("selection").auto_shrink(false);
            let inside = panel.exact_size(most).show(ui, |ui| area.show(ui, |ui| selection::show(ui, workspace)));
            inside.inner.content_size.y + 8.0 > most
        } else {
            panel.show(ui, |ui| selection::show(ui, workspace)).response.rect.height() > most
        };
        if is_higher != scrolls {
            ui.data_mut(|d| d.insert_temp(id, is_higher));
            ui.ctx().request_discard("the selection has another height");
        }
    }
    let Some(document) = &workspace.document else {
        ui.weak("No parts.");
        return;
    };
    let number = workspace.scene_number;
    let tree = match &mut workspace.layout.tree {
        Some(tree) if tree.of == number => tree,
        other => other.insert(Tree::new(number, &document.scene)),
    };
    let arrangement = &document.seen.arrangement;
    let mut act = None;
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new("Parts").strong());
        ui.weak(document.scene.parts.len().to_string());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if !arrangement.parts.is_empty() && ui.small_button("Show all").clicked() {
                act = Some(Act::ShowAll);
            }
        });
    });
    let search = TextEdit::singleline(&mut workspace.layout.search).hint_text("Search").desired_width(f32::INFINITY);
    let search = ui.add(search);
    search.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Search parts"));
    let searched = workspace.layout.search.trim().to_owned();
    let visible = tree.visible(&searched);
    let height = ui.spacing().interact_size.y;
    let room = ui.available_height();
    let below = if workspace.picked.is_some() && room > LEAST_TREE { room * 0.35 } else { 0.0 };
    ScrollArea::both().max_height(ui.available_height() - below).auto_shrink(false).show_rows(
        ui,
        height,
        visible.len(),
        |ui, range| {
            for &index in &visible[range] {
                if let Some(asked) = row(ui, tree, index, !searched.is_empty(), arrangement) {
                    act = Some(asked);
                }
            }
        },
    );
    if visible.is_empty() {
        ui.weak("Nothing of that name.");
    }
    if below > 0.0 {
        under_the_cursor(ui, workspace);
    }
    let tree = match &mut workspace.layout.tree {
        Some(tree) => tree,
        None => return,
    };
    match act {
        Some(Act::Toggle(row)) if !tree.closed.remove(&row) => {
            tree.closed.insert(row);
        }
        Some(act) => apply(workspace, act),
        None => {}
    }
}

/// The layers under the last click, nearest first.
fn under_the_cursor(ui: &mut Ui, workspace: &mut Workspace) {
    let (Some((picked, at)), Some(document)) = (&workspace.picked, &workspace.document) else {
        return;
    };
    ui.separator();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Layers at the click").strong());
        ui.weak(picked.layers.len().to_string());
    });
    let mut chosen = None;
    let mut isolated = None;
    let height = ui.spacing().interact_size.y;
    ScrollArea::vertical().id_salt("layers").auto_shrink(false).show_rows(
        ui,
        height,
        picked.layers.len(),
        |ui, range| {
            for i in range {
                let layer = &picked.layers[i];
                let name = document.scene.parts.get(layer.part as usize).map_or("?", |p| p.name.as_str());
                ui.horizontal(|ui| {
                    let help =
                        format!("κ {:+.2}, opacity {:.2}; double-click isolates the part", layer.kappa, layer.opacity);
                    let text = format!("{}  {name}", i + 1);
                    let response = ui.add(Button::selectable(i == *at, text).truncate()).on_hover_text(help);
                    if response.clicked() {
                        chosen = Some((i, ui.input(|i| i.modifiers.command)));
                    }
                    if response.double_clicked() {
                        isolated = Some(layer.part);
                    }
                });
            }
        },
    );
    if let Some((layer, more)) = chosen {
        workspace.choose_layer(layer, more);
    }
    if let Some(part) = isolated {
        apply(workspace, Act::Isolate(part..part + 1));
    }
}

fn row(ui: &mut Ui, tree: &Tree, index: usize, flat: bool, arrangement: &Arrangement) -> Option<Act> {
    let row = &tree.rows[index];
    let mut act = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let presence = presence_of(arrangement, &row.parts);
        let (state, next) = match presence {
            Some(Presence::Shown) => ("shown", Presence::Ghosted),
            Some(Presence::Ghosted) => ("ghosted", Presence::Hidden),
            Some(Presence::Hidden) => ("hidden", Presence::Shown),
            None => ("shown in part", Presence::Shown),
        };
        let eye = eye(ui, presence).on_hover_text(format!("{state}; click for {}", name_of(next)));
        eye.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{} {state}", row.name)));
        if eye.clicked() {
            act = Some(Act::Presence(row.parts.clone(), next));
        }
        if !flat {
            ui.add_space(10.0 * row.depth as f32);
        }
        if row.end > index + 1 && !flat {
            let (openness, what) = if tree.closed.contains(&index) { (0.0, "Open") } else { (1.0, "Close") };
            let (_, arrow) = ui.allocate_exact_size(vec2(14.0, 14.0), egui::Sense::click());
            egui::collapsing_header::paint_default_icon(ui, openness, &arrow);
            arrow.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{what} {}", row.name)));
            if arrow.clicked() {
                act = Some(Act::Toggle(index));
            }
        } else if !flat {
            ui.add_space(16.0);
        }
        let selected = row.parts.clone().all(|p| arrangement.selected.contains(&p));
        let text = RichText::new(&row.name);
        let text = if presence == Some(Presence::Shown) { text } else { text.weak() };
        let name = ui.add(Button::selectable(selected, text));
        if name.clicked() {
            act = Some(Act::Select(row.parts.clone(), ui.input(|i| i.modifiers.command)));
        }
        if name.double_clicked() {
            act = Some(Act::Frame(row.parts.clone()));
        }
        name.context_menu(|ui| {
            if ui.button("Isolate").clicked() {
                act = Some(Act::Isolate(row.parts.clone()));
            }
            if ui.button("Show in the middle").clicked() {
                act = Some(Act::Frame(row.parts.clone()));
            }
            ui.separator();
            for presence in [Presence::Shown, Presence::Ghosted, Presence::Hidden] {
                if ui.button(title_of(presence)).clicked() {
                    act = Some(Act::Presence(row.parts.clone(), presence));
                }
            }
            ui.separator();
            if ui.button("Show all parts").clicked() {
                act = Some(Act::ShowAll);
            }
        });
        if row.parts.len() > 1 {
            ui.label(RichText::new(row.parts.len().to_string()).small().weak());
        }
    });
    act
}

/// A disc for what is shown, a ring for what is hidden, both for what is ghosted.
fn eye(ui: &mut Ui, presence: Option<Presence>) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(14.0, 14.0), egui::Sense::click());
    let color = ui.style().interact(&response).fg_stroke.color;
    let (inner, ring) = match presence {
        Some(Presence::Shown) => (4.0, false),
        Some(Presence::Ghosted) => (1.5, true),
        Some(Presence::Hidden) => (0.0, true),
        None => (2.5, false),
    };
    ui.painter().circle_filled(rect.center(), inner, color);
    if ring {
        ui.painter().circle_stroke(rect.center(), 4.0, egui::Stroke::new(1.0, color));
    }
    response
}

fn name_of(presence: Presence) -> &'static str {
    match presence {
        Presence::Shown => "shown",
        Presence::Ghosted => "ghosted",
        Presence::Hidden => "hidden",
    }
}

fn title_of(presence: Presence) -> &'static str {
    match presence {
        Presence::Shown => "Show",
        Presence::Ghosted => "Ghost",
        Presence::Hidden => "Hide",
    }
}

/// The presence that all of these have.
fn presence_of(arrangement: &Arrangement, parts: &Range<u32>) -> Option<Presence> {
    if arrangement.parts.is_empty() {
        return Some(Presence::Shown);
    }
    let first = arrangement.look(parts.start).presence;
    parts.clone().all(|p| arrangement.look(p).presence == first).then_some(first)
}

fn apply(workspace: &mut Workspace, act: Act) {
    let Some(document) = &mut workspace.document else {
        return;
    };
    let arrangement = &mut document.seen.arrangement;
    match act {
        Act::Toggle(_) => {}
        Act::Presence(parts, presence) => {
            for part in parts {
                arrangement.parts.entry(part).or_default().presence = presence;
            }
            arrangement.parts.retain(|_, look| *look != PartLook::default());
        }
        Act::Select(parts, more) => {
            let all = parts.clone().all(|p| arrangement.selected.contains(&p));
            let only = all && arrangement.selected.len() == parts.len();
            if !more {
                arrangement.selected.clear();
            }
            if more && all {
                parts.for_each(|p| {
                    arrangement.selected.remove(&p);
                });
            } else if more || !only {
                arrangement.selected.extend(parts);
            }
        }
        Act::Isolate(parts) => {
            let kept: BTreeSet<u32> = parts.collect();
            arrangement.isolate(&kept, document.scene.parts.len() as u32);
        }
        Act::Frame(parts) => selection::frame_parts(workspace, parts),
        Act::ShowAll => {
            for look in arrangement.parts.values_mut() {
                look.presence = Presence::Shown;
            }
            arrangement.parts.retain(|_, look| *look != PartLook::default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn the_tree_holds_every_part_once_and_in_order() {
        for name in ["gearbox", "engine", "quads"] {
            let scene = builtin::build(name).unwrap();
            let tree = Tree::new(1, &scene);
            let count = scene.parts.len() as u32;
            let tops = tree.rows.iter().filter(|r| r.depth == 0);
            assert_eq!(tops.map(|r| r.parts.len()).sum::<usize>(), count as usize, "{name}");
            for (i, row) in tree.rows.iter().enumerate() {
                assert!(!row.parts.is_empty() && row.end > i && row.end <= tree.rows.len());
                for below in &tree.rows[i + 1..row.end] {
                    assert!(below.depth > row.depth);
                    assert!(below.parts.start >= row.parts.start && below.parts.end <= row.parts.end);
                }
            }
            for (i, part) in scene.parts.iter().enumerate() {
                let i = i as u32;
                let deepest = tree.rows.iter().filter(|r| r.parts.contains(&i)).max_by_key(|r| r.depth).unwrap();
                assert!(deepest.name == part.name || deepest.name == scene.nodes[part.node].name, "{}", part.name);
            }
            assert!(tree.visible("no such part at all").is_empty());
        }
    }
}
