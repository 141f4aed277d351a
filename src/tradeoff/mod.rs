//! Accuracy against time: what is wrong in a picture, by how much, and what it would cost to have it right.
//!
//! Techniques declare axes beside their code ([`crate::settings::Axis`], listed in [`crate::passes::TECHNIQUES`]); [`axis`]
//! makes configurations of them, [`mod@reference`] what they are compared with, [`sweep`] measures each (errors of the picture
//! and of its layers, time whole and by pass), and [`report`] writes it all down, with [`page`] and [`diagram`] for the eye.
//! [`budget`] chooses settings by a promise about time or error, and [`kept`] keeps what it measured. [`gate`] lets others work
//! first. [`flicker`] measures what is wrong between frames, and [`study`] how plainly a picture says what lies in front. [`limits`]
//! turns the errors into a verdict for continuous integration. [`hard_cases`] runs what is numerically hard, which techniques
//! declare in the same way, against the oracle.

pub mod axis;
pub mod budget;
pub mod diagram;
pub mod difference;
pub mod flicker;
mod flip;
pub mod gate;
pub mod hard_cases;
pub mod image_error;
pub mod kept;
pub mod layer_error;
pub mod limits;
pub mod page;
mod picture;
pub mod reference;
pub mod report;
pub mod statistics;
pub mod study;
pub mod sweep;
pub mod table;
pub mod words;
pub mod workbench;
