//! What keys do. The list for people is in [`super::panels::shortcuts`].

use winit::event::KeyEvent;
use winit::keyboard::{Key, KeyCode, ModifiersState, NamedKey, PhysicalKey};

use super::camera;
use super::dialogs::Choice;
use super::panels::menu;
use super::workspace::{Ask, Workspace};

/// Does what a pressed key means; says whether it means anything. While text is typed only what has Ctrl or a name does, and
/// undo is left to the text.
pub fn press(workspace: &mut Workspace, event: &KeyEvent, held: ModifiersState, typing: bool) -> bool {
    let command = held.control_key() || held.super_key();
    match &event.logical_key {
        Key::Named(NamedKey::F1) => workspace.layout.shortcuts = !workspace.layout.shortcuts,
        Key::Named(NamedKey::Home) if !typing => {
            workspace.look(|f, s, c| Some(camera::framed(c, &s.bounds(), f.aspect())));
        }
        Key::Named(NamedKey::Escape) if !typing => {
            workspace.layout.shortcuts = false;
            workspace.messages.clear();
        }
        Key::Character(text) if command => {
            let shift = held.shift_key();
            match text.to_lowercase().as_str() {
                "o" => workspace.asks.push(Ask::Choose(Choice::Open)),
                "s" => workspace.asks.push(Ask::Choose(Choice::SaveSession)),
                "p" => workspace.asks.push(Ask::Choose(Choice::SavePicture)),
                "q" => workspace.asks.push(Ask::Quit),
                "z" if shift && !typing => workspace.redo(),
                "z" if !typing => workspace.undo(),
                "y" if !typing => workspace.redo(),
                "c" if shift => menu::copy_command_line(workspace),
                _ => return !typing && view(workspace, event, true),
            }
        }
        _ => return !typing && view(workspace, event, false),
    }
    true
}

/// The keys of the number row or pad, wherever the layout has them.
fn view(workspace: &mut Workspace, event: &KeyEvent, opposite: bool) -> bool {
    let PhysicalKey::Code(code) = event.physical_key else {
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
