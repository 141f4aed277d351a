//! Which parts of the window have to be drawn again.
//!
//! Egui draws all of a window each time. On a software rasterizer that takes the processor longer than everything else that
//! answers the mouse, and while a view is turned only the picture changes. So there the window's last frame is kept, what is
//! to be drawn is compared with what was drawn, and only the rectangles around differences are drawn again, each with
//! everything that lies in it from the bottom up: the pixels are those of a whole frame.

use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use egui::epaint::{ClippedPrimitive, Mesh, Primitive, WHITE_UV};
use egui::{Color32, Pos2, Rect, Vec2};

/// Share of the window from which on drawing all of it is as good.
const MOST: f32 = 0.8;
/// Rectangles that are drawn one by one; more are drawn as the one around them.
const MOST_RECTANGLES: usize = 6;

/// What is known of something that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trace {
    /// Equal for equal things; `None` for what may look different each time.
    digest: Option<u64>,
    /// Where it shows.
    rect: Rect,
}

/// What the last frame consisted of.
#[derive(Default)]
pub struct Damage {
    drawn: Option<(Vec2, f32, Vec<Trace>)>,
}

impl Damage {
    /// The whole window has to be drawn next.
    pub fn forget(&mut self) {
        self.drawn = None;
    }

    /// What has to be drawn of `shapes` so that a window of `size` points that shows the last frame shows this one: rectangles
    /// in points on whole pixels, apart from each other. `None` is all of it.
    pub fn of(&mut self, shapes: &[ClippedPrimitive], size: Vec2, pixels_per_point: f32) -> Option<Vec<Rect>> {
        let window = Rect::from_min_size(Pos2::ZERO, size);
        let new: Vec<Trace> = shapes.iter().map(|s| trace(s, window)).collect();
        let before = self.drawn.take();
        let rects = before.filter(|(s, p, _)| (*s, *p) == (size, pixels_per_point)).and_then(|(_, _, old)| {
            let rects = differences(&old, &new)?;
            let rects = apart(rects.into_iter().map(|r| on_pixels(r, pixels_per_point).intersect(window)).collect());
            let area: f32 = rects.iter().map(|r| r.area()).sum();
            (area <= MOST * window.area()).then_some(rects)
        });
        self.drawn = Some((size, pixels_per_point, new));
        rects
    }
}

/// The part of `shapes` that lies in the rectangles, over black as a cleared window is.
pub fn within(shapes: &[ClippedPrimitive], rects: &[Rect]) -> Vec<ClippedPrimitive> {
    let mut all = Vec::new();
    for &rect in rects {
        let mut ground = Mesh::default();
        ground.add_rect_with_uv(rect, Rect::from_min_max(WHITE_UV, WHITE_UV), Color32::BLACK);
        all.push(ClippedPrimitive { clip_rect: rect, primitive: Primitive::Mesh(ground) });
        for shape in shapes {
            let clip_rect = shape.clip_rect.intersect(rect);
            let shows = match &shape.primitive {
                Primitive::Mesh(mesh) => clip_rect.intersects(mesh.calc_bounds()),
                Primitive::Callback(_) => true,
            };
            if clip_rect.is_positive() && shows {
                all.push(ClippedPrimitive { clip_rect, primitive: shape.primitive.clone() });
            }
        }
    }
    all
}

fn trace(shape: &ClippedPrimitive, window: Rect) -> Trace {
    let clip = shape.clip_rect.intersect(window);
    match &shape.primitive {
        Primitive::Mesh(mesh) => {
            let mut hasher = DefaultHasher::new();
            let Rect { min, max } = shape.clip_rect;
            [min.x, min.y, max.x, max.y].map(f32::to_bits).hash(&mut hasher);
            mesh.texture_id.hash(&mut hasher);
            mesh.indices.hash(&mut hasher);
            let vertices: &[u8] = bytemuck::cast_slice(&mesh.vertices);
            vertices.hash(&mut hasher);
            Trace { digest: Some(hasher.finish()), rect: clip.intersect(mesh.calc_bounds().expand(1.0)) }
        }
        Primitive::Callback(callback) => Trace { digest: None, rect: clip.intersect(callback.rect) },
    }
}

/// Where two frames differ; `None` if the same things lie in another order.
fn differences(old: &[Trace], new: &[Trace]) -> Option<Vec<Rect>> {
    let mut counts: HashMap<u64, usize> = HashMap::new();
    for digest in old.iter().filter_map(|t| t.digest) {
        *counts.entry(digest).or_default() += 1;
    }
    let mut rects = Vec::new();
    let mut common_of_new = Vec::new();
    for trace in new {
        match trace.digest.and_then(|d| counts.get_mut(&d).filter(|n| **n > 0).map(|n| (d, n))) {
            Some((digest, count)) => {
                *count -= 1;
                common_of_new.push(digest);
            }
            None => rects.push(trace.rect),
        }
    }
    // What is left of the old frame has gone. Of several equal things the first ones stay, in both.
    let mut kept: HashMap<u64, usize> = HashMap::new();
    for digest in &common_of_new {
        *kept.entry(*digest).or_default() += 1;
    }
    let mut common_of_old = Vec::new();
    for trace in old {
        match trace.digest.and_then(|d| kept.get_mut(&d).filter(|n| **n > 0).map(|n| (d, n))) {
            Some((digest, count)) => {
                *count -= 1;
                common_of_old.push(digest);
            }
            None => rects.push(trace.rect),
        }
    }
    (common_of_old == common_of_new).then_some(rects)
}

/// The smallest rectangle of whole pixels around one.
fn on_pixels(rect: Rect, pixels_per_point: f32) -> Rect {
    let scaled = rect * pixels_per_point;
    Rect::from_min_max(scaled.min.floor(), scaled.max.ceil()) / pixels_per_point
}

/// Rectangles that cover the same and do not meet each other.
fn apart(rects: Vec<Rect>) -> Vec<Rect> {
    let mut done: Vec<Rect> = Vec::new();
    for mut rect in rects.into_iter().filter(|r| r.is_positive()) {
        while let Some(other) = done.iter().position(|r| r.intersects(rect)) {
            rect = rect.union(done.swap_remove(other));
        }
        done.push(rect);
    }
    if done.len() > MOST_RECTANGLES {
        return done.into_iter().reduce(|a, b| a.union(b)).into_iter().collect();
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(100.0, 50.0);

    fn rect(x: f32, y: f32, w: f32, h: f32) -> Rect {
        Rect::from_min_size(Pos2::new(x, y), Vec2::new(w, h))
    }

    fn shape(at: Rect, color: Color32) -> ClippedPrimitive {
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(at, color);
        ClippedPrimitive { clip_rect: rect(0.0, 0.0, 100.0, 50.0), primitive: Primitive::Mesh(mesh) }
    }

    fn callback(at: Rect) -> ClippedPrimitive {
        let callback = egui::PaintCallback { rect: at, callback: std::sync::Arc::new(()) };
        ClippedPrimitive { clip_rect: at, primitive: Primitive::Callback(callback) }
    }

    #[test]
    fn what_stays_is_not_drawn_again_and_what_moves_is_on_both_sides() {
        let (panel, dot) = (rect(0.0, 0.0, 30.0, 50.0), rect(40.5, 10.0, 4.0, 4.0));
        let mut damage = Damage::default();
        let first = [shape(panel, Color32::RED), shape(dot, Color32::BLUE)];
        assert_eq!(damage.of(&first, SIZE, 1.0), None, "the first frame is drawn whole");
        assert_eq!(damage.of(&first, SIZE, 1.0), Some(vec![]));
        let moved = [shape(panel, Color32::RED), shape(dot.translate(Vec2::new(20.0, 0.0)), Color32::BLUE)];
        let rects = damage.of(&moved, SIZE, 1.0).unwrap();
        assert_eq!(rects.len(), 2);
        for (r, x) in rects.iter().zip([59.0, 39.0]) {
            assert_eq!((r.left(), r.right(), r.top()), (x, x + 7.0, 9.0), "whole pixels, with a pixel for feathering");
        }
        // A callback is drawn each time.
        let with = [first[0].clone(), callback(rect(50.0, 5.0, 20.0, 20.0))];
        damage.of(&with, SIZE, 1.0);
        assert_eq!(damage.of(&with, SIZE, 1.0), Some(vec![rect(50.0, 5.0, 20.0, 20.0)]));
        assert_eq!(damage.of(&with, SIZE, 2.0), None, "another scale");
        assert_eq!(damage.of(&with, SIZE * 2.0, 2.0), None, "another size");
        damage.forget();
        assert_eq!(damage.of(&with, SIZE * 2.0, 2.0), None);
    }

    #[test]
    fn another_order_is_another_frame() {
        let [a, b] = [rect(0.0, 0.0, 9.0, 9.0), rect(3.0, 3.0, 9.0, 9.0)];
        let (a, b) = (shape(a, Color32::RED), shape(b, Color32::GREEN));
        let mut damage = Damage::default();
        damage.of(&[a.clone(), b.clone()], SIZE, 1.0);
        assert_eq!(damage.of(&[b.clone(), a.clone()], SIZE, 1.0), None);
        assert_eq!(damage.of(&[b.clone(), a.clone(), b.clone()], SIZE, 1.0).map(|r| r.len()), Some(1));
        assert_eq!(damage.of(&[b.clone(), b, a], SIZE, 1.0), None, "equal ones on either side of it");
    }

    #[test]
    fn rectangles_are_apart_and_few() {
        let merged = apart(vec![rect(0.0, 0.0, 4.0, 4.0), rect(10.0, 0.0, 4.0, 4.0), rect(3.0, 1.0, 8.0, 1.0)]);
        assert_eq!(merged, [rect(0.0, 0.0, 14.0, 4.0)]);
        let many = (0..20).map(|i| rect(5.0 * i as f32, 0.0, 2.0, 2.0)).collect();
        assert_eq!(apart(many), [rect(0.0, 0.0, 97.0, 2.0)]);
        assert_eq!(apart(vec![Rect::NOTHING]), []);
    }

    /// Painted one rectangle after the other over the frame before, the pixels are those of the whole frame.
    #[test]
    fn patches_make_the_whole() {
        use proptest::prelude::*;
        let shapes = proptest::collection::vec((0..20i32, 0..10i32, 1..9i32, 1..9i32, 0..5usize), 0..7);
        let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
        let colors = [
            Color32::RED,
            Color32::GREEN,
            Color32::from_rgba_premultiplied(40, 0, 90, 128),
            Color32::BLUE,
            Color32::from_rgba_premultiplied(10, 20, 30, 60),
        ];
        let frame = |list: &[(i32, i32, i32, i32, usize)]| -> Vec<ClippedPrimitive> {
            let make = |&(x, y, w, h, c): &(i32, i32, i32, i32, usize)| {
                shape(rect(x as f32 * 5.0, y as f32 * 5.0, w as f32 * 5.0, h as f32 * 5.0), colors[c])
            };
            list.iter().map(make).collect()
        };
        proptest!(config, |(frames in proptest::collection::vec(shapes, 1..6))| {
            let mut damage = Damage::default();
            let mut canvas = vec![[0u8; 4]; 100 * 50];
            for list in &frames {
                let all = frame(list);
                match damage.of(&all, SIZE, 1.0) {
                    None => {
                        canvas.fill([0, 0, 0, 255]);
                        paint(&mut canvas, &all);
                    }
                    Some(rects) => paint(&mut canvas, &within(&all, &rects)),
                }
                let mut whole = vec![[0, 0, 0, 255]; 100 * 50];
                paint(&mut whole, &all);
                prop_assert_eq!(&canvas, &whole);
            }
        });
    }

    /// Rectangles on whole pixels, blended as egui blends.
    fn paint(canvas: &mut [[u8; 4]], shapes: &[ClippedPrimitive]) {
        for ClippedPrimitive { clip_rect, primitive } in shapes {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let area = mesh.calc_bounds().intersect(*clip_rect).intersect(rect(0.0, 0.0, 100.0, 50.0));
            let color = mesh.vertices[0].color.to_array();
            for y in area.top().max(0.0) as usize..area.bottom().max(0.0) as usize {
                for x in area.left().max(0.0) as usize..area.right().max(0.0) as usize {
                    let under = &mut canvas[y * 100 + x];
                    for (u, c) in under.iter_mut().zip(color) {
                        *u = c + ((u32::from(*u) * (255 - u32::from(color[3])) + 127) / 255) as u8;
                    }
                }
            }
        }
    }
}
