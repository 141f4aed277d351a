//! The functions in the program, as small pictures of what they do.

use egui::{Image, Role, TextureHandle, TextureOptions, Ui, WidgetInfo, vec2};

use super::{colour, map};
use crate::transfer::{self, TransferFunction, TransferSource};

/// Size of a picture, points of the screen.
const SIZE: [usize; 2] = [40, 26];
/// Rows of it that show the colours.
const STRIP: usize = 6;

/// Pictures, painted once for each theme.
#[derive(Default)]
pub struct State {
    pictures: Option<(bool, Vec<Thumbnail>)>,
}

struct Thumbnail {
    name: &'static str,
    description: &'static str,
    picture: TextureHandle,
}

/// All of them in a row; gives the one that was clicked.
pub fn show(ui: &mut Ui, state: &mut State, now: &TransferSource) -> Option<&'static str> {
    let dark = ui.visuals().dark_mode;
    if state.pictures.as_ref().is_none_or(|(with, _)| *with != dark) {
        let all = transfer::presets().into_iter().filter_map(|preset| {
            let function = TransferSource::Named(preset.name.to_owned()).resolve(None).ok()?;
            let picture = ui.ctx().load_texture(preset.name, picture(&function, dark), TextureOptions::LINEAR);
            Some(Thumbnail { name: preset.name, description: preset.description, picture })
        });
        state.pictures = Some((dark, all.collect()));
    }
    let mut wanted = None;
    let size = vec2(SIZE[0] as f32, SIZE[1] as f32);
    for Thumbnail { name, description, picture } in state.pictures.iter().flat_map(|(_, all)| all) {
        let chosen = matches!(now, TransferSource::Named(n) if n == name);
        let image = Image::new((picture.id(), size));
        let button = ui.add(egui::Button::image(image).selected(chosen).frame(true));
        button.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, chosen, format!("Preset {name}")));
        if button.on_hover_text(format!("{name}\n{description}")).clicked() {
            wanted = Some(*name);
        }
    }
    wanted
}

/// Opacities above, colours below.
fn picture(function: &TransferFunction, dark: bool) -> egui::ColorImage {
    let [width, height] = SIZE;
    let mut image = map::picture(&function.opacity, [width, height - STRIP], dark);
    let color_at = function.color.sampler();
    for _ in 0..STRIP {
        let kappa = |x: usize| 2.0 * x as f64 / (width - 1) as f64 - 1.0;
        image.pixels.extend((0..width).map(|x| colour(color_at(kappa(x)))));
    }
    egui::ColorImage::new(SIZE, image.pixels)
}
