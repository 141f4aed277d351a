//! What keys do. The list for people is in [`super::panels::shortcuts`].

use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::camera::{self, Held};
use super::dialogs::Choice;
use super::panels::{export, menu, planes, selection, views};
use super::workspace::{Ask, Workspace};
use crate::scene::Presence;

/// Does what a pressed key means; says whether it means anything. While text is typed only what has Ctrl or a name does, and
/// undo is left to the text.
pub fn press(workspace: &mut Workspace, key: &Key, place: PhysicalKey, held: Held, typing: bool) -> bool {
    match key {
        Key::Named(NamedKey::F1) => workspace.layout.shortcuts = !workspace.layout.shortcuts,
        Key::Named(NamedKey::Home) if !typing => selection::frame_all(workspace),
        Key::Named(NamedKey::Escape) if !typing => escape(workspace),
        Key::Character(text) if held.ctrl => {
            let shift = held.shift;
            match text.to_lowercase().as_str() {
                "o" => workspace.asks.push(Ask::Choose(Choice::Open)),
                "s" => workspace.asks.push(Ask::Choose(Choice::SaveSession)),
                "p" if shift => export::ask(workspace),
                "p" => workspace.asks.push(Ask::Choose(Choice::SavePicture)),
                "q" => workspace.asks.push(Ask::Quit),
                "z" if shift && !typing => workspace.redo(),
                "z" if !typing => workspace.undo(),
                "y" if !typing => workspace.redo(),
                "c" if shift => menu::copy_command_line(workspace),
                "d" => views::ask(workspace),
                "+" | "=" => menu::resize(workspace, 1),
                "-" => menu::resize(workspace, -1),
                "0" => menu::resize(workspace, 0),
                _ => return !typing && view(workspace, place, true),
            }
        }
        Key::Character(text) if !typing && !held.alt => match text.to_lowercase().as_str() {
            "f" => selection::frame_selected(workspace),
            "c" => selection::centre_pivot(workspace),
            "i" => selection::isolate(workspace),
            "h" if held.shift => selection::show_all(workspace),
            "h" => selection::set_presence(workspace, Presence::Hidden),
            "g" => selection::set_presence(workspace, Presence::Ghosted),
            "a" => {
                workspace.preferences.accuracy = !workspace.preferences.accuracy;
                workspace.asks.push(Ask::Remember);
            }
            "m" => workspace.measure.on = !workspace.measure.on,
            "v" => views::next(workspace),
            "x" => planes::toggle(workspace),
            "l" => {
                workspace.preferences.hover = !workspace.preferences.hover;
                workspace.hover = None;
                workspace.asks.push(Ask::Remember);
            }
            _ => return view(workspace, place, false),
        },
        _ => return !typing && view(workspace, place, false),
    }
    true
}

/// Ends one thing at a time: a drag of a section plane, then messages and what is asked for, then measuring, then the handles
/// of section planes, then the selection.
fn escape(workspace: &mut Workspace) {
    workspace.hover = None;
    if workspace.layout.planes.is_dragging() && planes::escape(workspace) {
        return;
    }
    let layout = &mut workspace.layout;
    let listed = std::mem::take(&mut layout.shortcuts) | layout.stack.take().is_some();
    let asked = listed | layout.naming.take().is_some() | layout.export.take().is_some();
    let said = !std::mem::take(&mut workspace.messages).is_empty();
    if asked || said {
        return;
    }
    if workspace.measure.on {
        workspace.measure = Default::default();
    } else if planes::escape(workspace) {
    } else if let Some(document) = &mut workspace.document {
        document.settle();
        document.seen.arrangement.selected.clear();
        document.settle();
        workspace.picked = None;
    }
}

/// The keys of the number row or pad, wherever the layout has them.
fn view(workspace: &mut Workspace, place: PhysicalKey, opposite: bool) -> bool {
    let PhysicalKey::Code(code) = place else {
        return false;
    };
    let name = match code {
        KeyCode::Digit1 | KeyCode::Numpad1 => "front",
        KeyCode::Digit3 | KeyCode::Numpad3 => "right",
        KeyCode::Digit7 | KeyCode::Numpad7 => "top",
        KeyCode::Digit9 | KeyCode::Numpad9 => "isometric",
        KeyCode::Digit5 | KeyCode::Numpad5 if !opposite => {
            workspace.look(|_, _, c| Some(camera::other_projection(c)));
            return true;
        }
        _ => return false,
    };
    workspace.look(|f, s, c| camera::named(c, &s.bounds(), f.aspect(), name, opposite));
    true
}
