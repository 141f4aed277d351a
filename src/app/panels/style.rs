//! How it looks: quiet greys, one accent, text that can be read, little air.

use egui::{Color32, Context, CornerRadius, FontFamily, FontId, Stroke, TextStyle, Theme as Side, Visuals, vec2};

use crate::app::config::{Preferences, Theme};

/// Blue that is told from grey under every kind of colour vision.
pub const ACCENT: Color32 = Color32::from_rgb(0x3d, 0x86, 0xc6);
/// Orange beside it, for what something else is better than.
pub const BEATEN: Color32 = Color32::from_rgb(0xc8, 0x8a, 0x3a);

/// What is behind the picture before there is one.
pub fn behind_the_picture(dark: bool) -> Color32 {
    if dark { Color32::from_rgb(0x26, 0x2b, 0x33) } else { Color32::from_rgb(0xd4, 0xd8, 0xde) }
}

/// Takes over theme and scale.
pub fn apply(context: &Context, preferences: &Preferences) {
    context.set_theme(match preferences.theme {
        Theme::System => egui::ThemePreference::System,
        Theme::Dark => egui::ThemePreference::Dark,
        Theme::Light => egui::ThemePreference::Light,
    });
    context.set_zoom_factor(preferences.scale);
}

/// Sets both themes up, once.
pub fn set_up(context: &Context) {
    // The size is a preference, with one place to change it.
    context.options_mut(|o| o.zoom_with_keyboard = false);
    for (side, visuals) in [(Side::Dark, dark()), (Side::Light, light())] {
        context.style_mut_of(side, |style| {
            style.visuals = visuals;
            style.spacing.item_spacing = vec2(6.0, 4.0);
            style.spacing.button_padding = vec2(6.0, 2.0);
            style.spacing.interact_size = vec2(32.0, 19.0);
            style.spacing.slider_width = 96.0;
            style.spacing.slider_rail_height = 4.0;
            style.spacing.tooltip_width = 300.0;
            style.spacing.indent = 14.0;
            style.interaction.selectable_labels = false;
            style.interaction.tooltip_delay = 0.6;
            // Nothing moves on its own: a frame costs something.
            style.animation_time = 0.0;
            style.text_styles = [
                (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
                (TextStyle::Body, FontId::new(12.5, FontFamily::Proportional)),
                (TextStyle::Button, FontId::new(12.5, FontFamily::Proportional)),
                (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
                (TextStyle::Monospace, FontId::new(11.5, FontFamily::Monospace)),
            ]
            .into();
        });
    }
}

fn dark() -> Visuals {
    let mut v = Visuals::dark();
    v.panel_fill = Color32::from_rgb(0x1d, 0x20, 0x25);
    v.window_fill = Color32::from_rgb(0x23, 0x27, 0x2d);
    v.extreme_bg_color = Color32::from_rgb(0x15, 0x17, 0x1b);
    v.faint_bg_color = Color32::from_rgb(0x24, 0x28, 0x2e);
    v.override_text_color = None;
    v.widgets.noninteractive.fg_stroke.color = Color32::from_rgb(0xc4, 0xc9, 0xd0);
    v.widgets.inactive.fg_stroke.color = Color32::from_rgb(0xd2, 0xd6, 0xdc);
    v.widgets.inactive.weak_bg_fill = Color32::from_rgb(0x2e, 0x33, 0x3b);
    v.widgets.inactive.bg_fill = Color32::from_rgb(0x3a, 0x41, 0x4b);
    v.widgets.hovered.weak_bg_fill = Color32::from_rgb(0x39, 0x40, 0x4a);
    v.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(0x2f, 0x34, 0x3b));
    v.selection.bg_fill = Color32::from_rgb(0x28, 0x5a, 0x88);
    v.selection.stroke = Stroke::new(1.0, Color32::from_rgb(0xe8, 0xf2, 0xfb));
    common(v)
}

fn light() -> Visuals {
    let mut v = Visuals::light();
    v.panel_fill = Color32::from_rgb(0xf1, 0xf2, 0xf4);
    v.window_fill = Color32::from_rgb(0xfa, 0xfa, 0xfb);
    v.widgets.noninteractive.fg_stroke.color = Color32::from_rgb(0x2c, 0x31, 0x38);
    v.widgets.inactive.fg_stroke.color = Color32::from_rgb(0x25, 0x2a, 0x30);
    v.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(0xd3, 0xd6, 0xdb));
    v.selection.bg_fill = Color32::from_rgb(0xa9, 0xcd, 0xec);
    v.selection.stroke = Stroke::new(1.0, Color32::from_rgb(0x10, 0x33, 0x52));
    common(v)
}

fn common(mut v: Visuals) -> Visuals {
    v.hyperlink_color = ACCENT;
    v.text_cursor.blink = false;
    v.slider_trailing_fill = true;
    v.indent_has_left_vline = false;
    v.window_corner_radius = CornerRadius::same(5);
    v.menu_corner_radius = CornerRadius::same(4);
    for w in [&mut v.widgets.inactive, &mut v.widgets.hovered, &mut v.widgets.active, &mut v.widgets.open] {
        w.corner_radius = CornerRadius::same(3);
        w.expansion = 0.0;
    }
    v
}
