//! Work-precision diagrams as SVG: time against error, both logarithmic, the Pareto front marked.
//!
//! An error of exactly 0 has no logarithm; such points stand on a line of their own at the bottom. Points that another one
//! beats in both time and error are drawn hollow and keep their labels.

use std::fmt::Write;

/// A point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What it is called.
    pub label: String,
    /// Over that of the baseline: lower end, median, upper end; positive.
    pub time: [f64; 3],
    /// At least 0.
    pub error: f64,
    /// Whether there are frames enough to tell: else it is on no front.
    pub sure: bool,
}

/// Which points no other beats, of those that are sure: as fast or faster with less error, or faster with no more.
pub fn pareto_front(points: &[Point]) -> Vec<bool> {
    let beats = |a: &Point, b: &Point| {
        a.time[1] <= b.time[1] && a.error <= b.error && (a.time[1] < b.time[1] || a.error < b.error)
    };
    points.iter().map(|p| p.sure && !points.iter().any(|q| q.sure && beats(q, p))).collect()
}

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 500.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 52.0;
/// Height of the strip for errors of exactly 0.
const ZERO: f64 = 46.0;

/// A logarithmic axis.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// Holds all values with a margin, over at least a factor of two.
    pub fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Scale {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for value in values.filter(|v| *v > 0.0 && v.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if high == 0.0 {
            (low, high) = (1.0, 1.0);
        }
        let margin = (high / low).powf(0.06).max(1.25);
        Scale { low: low / margin, high: high * margin, from, to }
    }

    /// Where a value above 0 stands.
    pub fn at(&self, value: f64) -> f64 {
        let t = (value / self.low).ln() / (self.high / self.low).ln();
        self.from + t * (self.to - self.from)
    }

    /// Values for lines: powers of ten with as many values between them as it takes for a handful.
    pub fn ticks(&self) -> Vec<f64> {
        const STEPS: [&[f64]; 4] = [
            &[1.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 2.0, 3.0, 4.0, 5.0, 7.0],
            &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 9.0],
        ];
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let with = |steps: &[f64]| -> Vec<f64> {
            (first..=last)
                .flat_map(|e| steps.iter().map(move |s| s * 10_f64.powi(e)))
                .filter(|v| (self.low..=self.high).contains(v))
                .collect()
        };
        let fullest = with(STEPS[STEPS.len() - 1]);
        STEPS.iter().map(|steps| with(steps)).find(|ticks| ticks.len() >= 4).unwrap_or(fullest)
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Left, top, right, bottom.
pub type Rectangle = [f64; 4];

fn overlap(a: &Rectangle, b: &Rectangle) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// A place inside `room` for a label of a point that covers no other label or point, if there is one; else the least bad.
pub fn place_label([x, y]: [f64; 2], [w, h]: [f64; 2], room: &Rectangle, taken: &[Rectangle]) -> Rectangle {
    let mut best: Option<(usize, Rectangle)> = None;
    for distance in [7.0, 18.0, 32.0, 50.0, 72.0, 98.0] {
        for (dx, dy) in
            [(1.0, 0.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 0.0), (-1.0, -1.0), (-1.0, 1.0), (0.0, -1.0), (0.0, 1.0)]
        {
            let left = match dx {
                d if d > 0.0 => x + distance,
                d if d < 0.0 => x - distance - w,
                _ => x - w / 2.0,
            };
            let top = y + dy * distance - h / 2.0;
            let rectangle = [left, top, left + w, top + h];
            let inside = left >= room[0] && top >= room[1] && rectangle[2] <= room[2] && rectangle[3] <= room[3];
            if !inside {
                continue;
            }
            let hits = taken.iter().filter(|t| overlap(t, &rectangle)).count();
            if hits == 0 {
                return rectangle;
            }
            if best.is_none_or(|(least, _)| hits < least) {
                best = Some((hits, rectangle));
            }
        }
    }
    best.map_or([x + 7.0, y - h / 2.0, x + 7.0 + w, y + h / 2.0], |(_, r)| r)
}

/// The diagram of points, with what its vertical axis shows.
pub fn diagram(points: &[Point], error_name: &str) -> String {
    let any_zero = points.iter().any(|p| p.error == 0.0);
    let floor = HEIGHT - BOTTOM - if any_zero { ZERO } else { 0.0 };
    let xs = Scale::over(points.iter().flat_map(|p| p.time), LEFT, WIDTH - RIGHT);
    let ys = Scale::over(points.iter().map(|p| p.error), floor, TOP);
    let y_of = |error: f64| if error > 0.0 { ys.at(error) } else { HEIGHT - BOTTOM - ZERO / 2.0 };
    let front = pareto_front(points);
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"time against {}\">",
        escape(error_name)
    );
    let bottom = HEIGHT - BOTTOM;
    for value in xs.ticks() {
        let x = xs.at(value);
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" y1=\"{TOP}\" x2=\"{x:.1}\" y2=\"{bottom}\"/>\
             <text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            bottom + 16.0,
            super::table::figure(value)
        );
    }
    if points.iter().any(|p| p.error > 0.0) {
        for value in ys.ticks() {
            let y = ys.at(value);
            let _ = writeln!(
                svg,
                "<line class=\"grid\" x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 8.0,
                y + 4.0,
                super::table::figure(value)
            );
        }
    }
    if any_zero {
        let y = y_of(0.0);
        let _ = writeln!(
            svg,
            "<rect class=\"zero\" x=\"{LEFT}\" y=\"{floor}\" width=\"{:.1}\" height=\"{ZERO}\"/>\
             <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">0</text>",
            WIDTH - RIGHT - LEFT,
            LEFT - 8.0,
            y + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time of a frame, times that of what was asked for</text>\
         <text class=\"axis\" transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 12.0,
        (TOP + bottom) / 2.0,
        escape(error_name)
    );

    let mut best: Vec<&Point> = points.iter().zip(&front).filter(|(_, f)| **f).map(|(p, _)| p).collect();
    best.sort_by(|a, b| a.time[1].total_cmp(&b.time[1]));
    let path: Vec<String> = best.iter().map(|p| format!("{:.1},{:.1}", xs.at(p.time[1]), y_of(p.error))).collect();
    let _ = writeln!(svg, "<polyline class=\"front\" points=\"{}\"/>", path.join(" "));

    let mut taken: Vec<Rectangle> = points
        .iter()
        .map(|p| {
            let (x, y) = (xs.at(p.time[1]), y_of(p.error));
            [x - 5.0, y - 5.0, x + 5.0, y + 5.0]
        })
        .collect();
    for (point, on_front) in points.iter().zip(&front) {
        let [low, x, high] = point.time.map(|t| xs.at(t));
        let y = y_of(point.error);
        let class = match (*on_front, point.sure) {
            (true, _) => "best",
            (false, true) => "beaten",
            (false, false) => "beaten unsure",
        };
        let _ = writeln!(
            svg,
            "<g class=\"{class}\"><line class=\"interval\" x1=\"{low:.1}\" y1=\"{y:.1}\" x2=\"{high:.1}\" y2=\"{y:.1}\"/>\
             <circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"><title>{}: {}×, {} {}</title></circle></g>",
            escape(&point.label),
            super::table::figure(point.time[1]),
            super::table::figure(point.error),
            escape(error_name)
        );
    }
    // The best get their labels first.
    for wanted in [true, false] {
        for (point, _) in points.iter().zip(&front).filter(|(_, f)| **f == wanted) {
            let (x, y) = (xs.at(point.time[1]), y_of(point.error));
            // As wide as the widest of the fonts that the page may get.
            let size = [7.3 * point.label.chars().count() as f64 + 6.0, 13.0];
            let r = place_label([x, y], size, &[LEFT, 2.0, WIDTH - 2.0, HEIGHT - BOTTOM], &taken);
            taken.push(r);
            let class = if wanted { "best" } else { "beaten" };
            let near = [x.clamp(r[0], r[2]), y.clamp(r[1], r[3])];
            if (near[0] - x).hypot(near[1] - y) > 12.0 {
                let _ = writeln!(
                    svg,
                    "<line class=\"leader\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
                    near[0], near[1]
                );
            }
            let _ = writeln!(
                svg,
                "<text class=\"label {class}\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{}\">{}</text>",
                if r[2] <= x { r[2] - 2.0 } else { r[0] + 2.0 },
                r[3] - 3.0,
                if r[2] <= x { "end" } else { "start" },
                escape(&point.label)
            );
        }
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(label: &str, time: f64, error: f64) -> Point {
        Point { label: label.to_owned(), time: [0.9 * time, time, 1.2 * time], error, sure: true }
    }

    #[test]
    fn what_too_few_frames_say_is_on_no_front_and_beats_nothing() {
        let points = [Point { sure: false, ..point("lucky", 0.1, 0.0) }, point("sure", 1.0, 0.0)];
        assert_eq!(pareto_front(&points), [false, true]);
        assert!(diagram(&points, "error").contains("beaten unsure"));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [
            point("fast and wrong", 1.0, 10.0),
            point("slower and worse", 2.0, 11.0),
            point("middle", 3.0, 1.0),
            point("as wrong, slower", 4.0, 1.0),
            point("exact", 9.0, 0.0),
            point("exact twin", 9.0, 0.0),
        ];
        assert_eq!(pareto_front(&points), [true, false, true, false, true, true]);
    }

    #[test]
    fn every_point_is_drawn_and_labelled_within_the_picture() {
        let points: Vec<Point> =
            (0..30).map(|i| point(&format!("p<{i}"), 10.0 + f64::from(i % 6), f64::from(i % 5) * 0.3)).collect();
        let svg = diagram(&points, "error & more");
        assert_eq!(svg.matches("<circle").count(), 30);
        assert_eq!(svg.matches("class=\"label").count(), 30);
        assert!(
            svg.contains("p&lt;7") && svg.contains("error &amp; more") && !svg.contains("NaN") && !svg.contains("inf")
        );
        for text in ["cx=\"", "cy=\"", "x=\"", "y=\""] {
            for value in svg.split(text).skip(1).filter_map(|s| s.split('"').next()?.parse::<f64>().ok()) {
                assert!((0.0..=WIDTH).contains(&value), "{text}{value}");
            }
        }
    }

    #[test]
    fn one_point_none_and_zeros_are_drawn_too() {
        for points in [vec![], vec![point("a", 3.0, 0.0)], vec![point("a", 3.0, 2.0)]] {
            let svg = diagram(&points, "error");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
