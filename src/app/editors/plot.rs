//! A rectangle with two axes.

use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Stroke, Ui, Vec2, pos2, vec2};

/// Room left of a plot for the words of its upright axis.
const LEFT: f32 = 38.0;
/// Room below it for those of the other.
const BELOW: f32 = 15.0;
/// Room around the rest, so that a handle at a corner is seen whole.
const AROUND: f32 = 7.0;

/// A word on an axis: where it stands, and what it says.
pub type Tick = (f64, &'static str);

/// A rectangle on the screen in which positions have meanings.
#[derive(Clone, Copy, Debug)]
pub struct Plot {
    /// The rectangle, without the words around it.
    pub rect: Rect,
    /// Lowest and highest value to the right.
    pub x: [f64; 2],
    /// Lowest and highest value upwards.
    pub y: [f64; 2],
}

impl Plot {
    /// A plot and its words in all of `outer`.
    pub fn within(outer: Rect, x: [f64; 2], y: [f64; 2]) -> Plot {
        let least = pos2(outer.left() + LEFT, outer.top() + AROUND);
        let most = pos2(outer.right() - AROUND, outer.bottom() - BELOW);
        Plot { rect: Rect::from_min_max(least, most.max(least + Vec2::splat(8.0))), x, y }
    }

    /// Where a value stands.
    pub fn to_screen(&self, [x, y]: [f64; 2]) -> Pos2 {
        let share = |v: f64, [from, to]: [f64; 2]| ((v - from) / (to - from)) as f32;
        let (right, up) = (share(x, self.x), share(y, self.y));
        self.rect.left_bottom() + vec2(right * self.rect.width(), -up * self.rect.height())
    }

    /// What stands there.
    pub fn value_at(&self, at: Pos2) -> [f64; 2] {
        let [x, y] = self.value_of(at - self.rect.left_bottom());
        [self.x[0] + x, self.y[0] + y]
    }

    /// What a way on the screen means.
    pub fn value_of(&self, way: Vec2) -> [f64; 2] {
        let [dx, dy] = self.of_one_pixel();
        [f64::from(way.x) * dx, -f64::from(way.y) * dy]
    }

    /// How much of either axis one point of the screen is.
    pub fn of_one_pixel(&self) -> [f64; 2] {
        let per = |[from, to]: [f64; 2], length: f32| (to - from) / f64::from(length.max(1.0));
        [per(self.x, self.rect.width()), per(self.y, self.rect.height())]
    }

    /// Places to the right at which a curve is drawn.
    pub fn samples(&self) -> impl Iterator<Item = f64> + use<> {
        let count = (self.rect.width() / 1.5).clamp(16.0, 1024.0) as usize;
        let [from, to] = self.x;
        (0..=count).map(move |i| from + (to - from) * i as f64 / count as f64)
    }

    /// Ground, lines at the ticks, and their words.
    pub fn paint_axes(&self, ui: &Ui, across: &[Tick], upwards: &[Tick]) {
        let visuals = ui.visuals();
        let painter = ui.painter();
        painter.rect_filled(self.rect, 2.0, ground(visuals.dark_mode));
        let line = Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.28));
        let font = FontId::proportional(10.5);
        let ink = visuals.text_color().gamma_multiply(0.85);
        for (i, &(x, word)) in across.iter().enumerate() {
            let at = self.to_screen([x, self.y[0]]);
            painter.vline(at.x, self.rect.y_range(), line);
            let align = match i {
                0 => Align2::LEFT_TOP,
                _ if i + 1 == across.len() => Align2::RIGHT_TOP,
                _ => Align2::CENTER_TOP,
            };
            painter.text(at + vec2(0.0, 2.0), align, word, font.clone(), ink);
        }
        for &(y, word) in upwards {
            let at = self.to_screen([self.x[0], y]);
            painter.hline(self.rect.x_range(), at.y, line);
            // The lowest makes room for the first word of the other axis.
            let align = if y == self.y[0] { Align2::RIGHT_BOTTOM } else { Align2::RIGHT_CENTER };
            painter.text(at - vec2(6.0, 0.0), align, word, font.clone(), ink);
        }
    }

    /// Counts as a hill: `counts` spread evenly over the axis, by the logarithm, `full` as high as the plot.
    pub fn paint_counts(&self, painter: &Painter, counts: &[u64], full: u64, color: Color32) {
        let full = (full as f64).ln_1p();
        if counts.is_empty() || full <= 0.0 {
            return;
        }
        let width = self.rect.width() / counts.len() as f32;
        // Without soft edges: two triangles a bar.
        let mut bars = Mesh::default();
        for (i, &n) in counts.iter().enumerate().filter(|(_, n)| **n > 0) {
            let height = ((n as f64).ln_1p() / full).min(1.0) as f32 * self.rect.height();
            let left = self.rect.left() + i as f32 * width;
            let bar = Rect::from_min_max(
                pos2(left, self.rect.bottom() - height.max(1.0)),
                pos2(left + width, self.rect.bottom()),
            );
            bars.add_colored_rect(bar, color);
        }
        painter.add(bars);
    }
}

/// Behind every plot.
pub fn ground(dark: bool) -> Color32 {
    if dark { Color32::from_rgb(0x13, 0x15, 0x19) } else { Color32::from_rgb(0xfd, 0xfd, 0xfe) }
}

/// What counts are painted in: orange, which is told from blue by everybody.
pub fn counted(dark: bool) -> Color32 {
    if dark { Color32::from_rgb(0xd0, 0x86, 0x38) } else { Color32::from_rgb(0xe0, 0x90, 0x3c) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        let outer = Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 200.0));
        let plot = Plot::within(outer, [-1.0, 1.0], [0.0, 1.0]);
        assert_eq!(plot.to_screen([-1.0, 0.0]), plot.rect.left_bottom());
        assert_eq!(plot.to_screen([1.0, 1.0]), plot.rect.right_top());
        let [x, y] = plot.value_at(plot.to_screen([0.3, 0.7]));
        assert!((x - 0.3).abs() < 1e-5 && (y - 0.7).abs() < 1e-5);
        let [dx, dy] = plot.value_of(vec2(plot.rect.width(), plot.rect.height()));
        assert!((dx - 2.0).abs() < 1e-6 && (dy + 1.0).abs() < 1e-6, "down is less");
        let nothing = Plot::within(Rect::from_min_size(pos2(0.0, 0.0), Vec2::ZERO), [0.0, 1.0], [0.0, 1.0]);
        assert!(nothing.value_at(pos2(3.0, 3.0)).iter().all(|v| v.is_finite()));
    }
}
