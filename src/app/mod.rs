//! The window: the same settings, plan and renderer as the command line, under the hand.
//!
//! It adds no rendering of its own. What is seen is one value ([`document::Seen`]); panels and gestures change it, undo keeps
//! copies of it, and whenever it differs from what was last asked for, [`pictures`] is asked for another picture. Threads with
//! devices of their own draw; the window's thread only shows what they deliver and never waits for them, so that it answers
//! whatever a picture costs. A frame is drawn when something changed and not otherwise.
//!
//! | module | what is in it |
//! |---|---|
//! | [`shell`] | winit's events and the loop; [`surface`] the window's device; [`keys`], [`dialogs`] |
//! | [`workspace`] | everything the window knows; [`panels`] show and change it |
//! | [`document`] | model, what is seen of it, undo |
//! | [`pictures`] | previews and exact pictures; [`viewport`] brings them to the screen pixel for pixel |
//! | [`hand`] | the mouse on the picture; [`camera`] gestures, as functions |
//! | [`picking`] | what becomes of layers under a pixel; [`measure`] distances between them |
//! | [`editors`] | transfer functions under the hand; [`functions`] resolves them |
//! | [`planes`] | section planes moved and tilted on the picture, as functions |
//! | [`compare`] | two settings under a divider |
//! | [`accuracy`] | the reference of the picture, sweeps and budgets beside it, hard cases |
//! | [`exports`] | pictures of any size and turntables into files |
//! | [`loader`] | opening files; [`watch`] files that somebody edits |

pub mod accuracy;
pub mod camera;
pub mod command_line;
pub mod compare;
pub mod config;
pub mod dialogs;
pub mod document;
pub mod editors;
pub mod exports;
pub mod functions;
pub mod hand;
pub mod keys;
pub mod loader;
pub mod measure;
pub mod models;
pub mod panels;
pub mod picking;
pub mod pictures;
pub mod planes;
pub mod shell;
pub mod surface;
pub mod viewport;
pub mod watch;
pub mod workspace;

#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod gestures;
#[cfg(test)]
mod planted;

pub use shell::run;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// No display, or none that can be drawn on.
    #[error("no window can be opened: {0}")]
    Display(String),
}
