//! Which parts of the window have to be drawn again.
//!
//! Egui draws all of a window each time. On a software rasterizer that takes the processor longer than everything else that
//! answers the mouse, and while a view is turned only the picture changes. So there the window's last frame is kept, what is
//! to be drawn is compared with what was drawn, triangle by triangle (egui makes one mesh of all that a panel holds), and only
//! rectangles around differences are drawn again, each with everything that lies in it from the bottom up: the pixels are those
//! of a whole frame.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, DefaultHasher, Hash, Hasher};

use egui::epaint::{ClippedPrimitive, Mesh, Primitive, WHITE_UV};
use egui::{Color32, Pos2, Rect, TextureId, TexturesDelta, Vec2};

/// Share of the window from which on drawing all of it is as good.
const MOST: f32 = 0.8;
/// Differences are gathered on a grid of squares with this side, pixels.
const SQUARE: f32 = 16.0;
/// Rectangles that are drawn one by one; where more would be needed, some are drawn as the one around them.
const MOST_RECTANGLES: usize = 12;

/// What is known of a triangle or a callback that was drawn.
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
    /// Textures that have changed since.
    repainted: HashSet<TextureId>,
}

impl Damage {
    /// The whole window has to be drawn next.
    pub fn forget(&mut self) {
        self.drawn = None;
    }

    /// What is drawn with these textures looks different from now on. Letters that are added to a texture change nothing that
    /// has been drawn with it, and they come in pieces.
    pub fn repaint(&mut self, textures: &TexturesDelta) {
        for (id, deltas) in &textures.set {
            if *id != TextureId::default() || deltas.iter().any(|d| d.pos.is_none()) {
                self.repainted.insert(*id);
            }
        }
    }

    /// What has to be drawn of `shapes` so that a window of `size` points that shows the last frame shows this one: rectangles
    /// in points on whole pixels, apart from each other. `None` is all of it.
    pub fn of(&mut self, shapes: &[ClippedPrimitive], size: Vec2, pixels_per_point: f32) -> Option<Vec<Rect>> {
        let window = Rect::from_min_size(Pos2::ZERO, size);
        let repainted = std::mem::take(&mut self.repainted);
        let before = self.drawn.take().filter(|(s, p, _)| (*s, *p) == (size, pixels_per_point));
        let new: Vec<Trace> = shapes.iter().flat_map(|s| traces(s, window)).collect();
        let rects = before.and_then(|(_, _, old)| {
            let mut differ = differences(&old, &new)?;
            for shape in shapes {
                if let Primitive::Mesh(mesh) = &shape.primitive
                    && repainted.contains(&mesh.texture_id)
                {
                    differ.push(shape.clip_rect.intersect(mesh.calc_bounds()).intersect(window));
                }
            }
            let rects = Grid::of(&differ, window, SQUARE / pixels_per_point).rectangles();
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
            if !clip_rect.is_positive() {
                continue;
            }
            let primitive = match &shape.primitive {
                Primitive::Mesh(mesh) => match part_of(mesh, clip_rect) {
                    Some(part) => Primitive::Mesh(part),
                    None => continue,
                },
                callback => callback.clone(),
            };
            all.push(ClippedPrimitive { clip_rect, primitive });
        }
    }
    all
}

/// The triangles of a mesh that may show in a rectangle, in their order; `None` if there are none. Egui makes one mesh of all that
/// a panel holds, and a rasterizer without hardware takes as long for a vertex that is clipped as for one that shows.
fn part_of(mesh: &Mesh, rect: Rect) -> Option<Mesh> {
    // What is drawn of a triangle stays within a pixel of it, however coarse the points are.
    let reach = rect.expand(1.0);
    let mut part = Mesh::with_texture(mesh.texture_id);
    for triangle in mesh.indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|i| mesh.vertices.get(triangle[i] as usize).copied().unwrap_or_default());
        let [a, b, c] = corners.map(|v| v.pos);
        let bounds = Rect::from_min_max(a.min(b).min(c), a.max(b).max(c));
        if bounds.intersects(reach) {
            let first = part.vertices.len() as u32;
            part.vertices.extend(corners);
            part.indices.extend([first, first + 1, first + 2]);
        }
    }
    (!part.indices.is_empty()).then_some(part)
}

/// A trace of every triangle that is in sight, or of the callback.
fn traces(shape: &ClippedPrimitive, window: Rect) -> Vec<Trace> {
    let clip = shape.clip_rect.intersect(window);
    let mesh = match &shape.primitive {
        Primitive::Mesh(mesh) => mesh,
        Primitive::Callback(callback) => return vec![Trace { digest: None, rect: clip.intersect(callback.rect) }],
    };
    let Rect { min, max } = shape.clip_rect;
    let mut hasher = DefaultHasher::new();
    [min.x, min.y, max.x, max.y].map(f32::to_bits).hash(&mut hasher);
    mesh.texture_id.hash(&mut hasher);
    let common = hasher.finish();
    let corner = |&index: &u32| mesh.vertices.get(index as usize).copied().unwrap_or_default();
    let of = |triangle: &[u32]| {
        let mut digest = common;
        let mut bounds = Rect::NOTHING;
        for vertex in triangle.iter().map(corner) {
            bounds.extend_with(vertex.pos);
            let place = [vertex.pos.x, vertex.pos.y, vertex.uv.x, vertex.uv.y].map(|v| u64::from(v.to_bits()));
            let color = u64::from(u32::from_le_bytes(vertex.color.to_array()));
            for word in [place[0] << 32 | place[1], place[2] << 32 | place[3], color] {
                digest = mixed(digest, word);
            }
        }
        Trace { digest: Some(digest), rect: clip.intersect(bounds) }
    };
    mesh.indices.chunks_exact(3).map(of).filter(|t| t.rect.is_positive()).collect()
}

/// A digest with a word more: one step of multiplication and folding, because there are ten thousands of triangles and egui
/// is no adversary.
fn mixed(digest: u64, word: u64) -> u64 {
    let product = u128::from(digest ^ word ^ 0x9e37_79b9_7f4a_7c15) * 0xd6e8_feb8_6659_fd93;
    (product as u64) ^ (product >> 64) as u64
}

/// Digests are hashes already.
#[derive(Default)]
struct AsItIs(u64);

impl Hasher for AsItIs {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |digest, byte| mixed(digest, u64::from(*byte)));
    }

    fn write_u64(&mut self, digest: u64) {
        self.0 = digest;
    }
}

/// How often there is something with a digest.
type Counts = HashMap<u64, usize, BuildHasherDefault<AsItIs>>;

/// Where two frames differ; `None` if the same things lie in another order.
fn differences(old: &[Trace], new: &[Trace]) -> Option<Vec<Rect>> {
    let mut counts = Counts::with_capacity_and_hasher(old.len(), Default::default());
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
    let mut kept = Counts::with_capacity_and_hasher(new.len(), Default::default());
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

/// Squares of the window in which something differs.
struct Grid {
    window: Rect,
    /// Side of a square, points.
    side: f32,
    columns: usize,
    marked: Vec<bool>,
}

impl Grid {
    fn of(rects: &[Rect], window: Rect, side: f32) -> Grid {
        let count = |length: f32| (length / side).ceil().max(1.0) as usize;
        let (columns, rows) = (count(window.width()), count(window.height()));
        let mut marked = vec![false; columns * rows];
        for rect in rects {
            // Antialiasing and rounding stay within a pixel.
            let reach = rect.expand(side / SQUARE);
            let squares = |from: f32, to: f32, most: usize| {
                let last = ((to / side).ceil().max(0.0) as usize).min(most);
                ((from / side).floor().max(0.0) as usize).min(last)..last
            };
            for row in squares(reach.top(), reach.bottom(), rows) {
                let columns_of = squares(reach.left(), reach.right(), columns);
                marked[row * columns..][columns_of].fill(true);
            }
        }
        Grid { window, side, columns, marked }
    }

    /// Rectangles apart from each other that cover the marked squares.
    fn rectangles(&self) -> Vec<Rect> {
        let mut done: Vec<Rect> = Vec::new();
        let mut open: Vec<(std::ops::Range<usize>, usize)> = Vec::new();
        let rows = self.marked.len() / self.columns;
        for row in 0..=rows {
            let runs = if row < rows { runs(&self.marked[row * self.columns..][..self.columns]) } else { Vec::new() };
            // A run just as wide as the one above it goes on with that.
            let ended = open.extract_if(.., |(run, _)| !runs.contains(run)).collect::<Vec<_>>();
            done.extend(ended.into_iter().map(|(run, first)| self.rect(run, first..row)));
            for run in runs {
                if !open.iter().any(|(other, _)| *other == run) {
                    open.push((run, row));
                }
            }
        }
        fewer(done)
    }

    fn rect(&self, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> Rect {
        let at = |column: usize, row: usize| Pos2::new(column as f32 * self.side, row as f32 * self.side);
        Rect::from_min_max(at(columns.start, rows.start), at(columns.end, rows.end)).intersect(self.window)
    }
}

/// Runs of marked squares in a row.
fn runs(row: &[bool]) -> Vec<std::ops::Range<usize>> {
    let mut all = Vec::new();
    let mut begin = None;
    for (column, marked) in row.iter().copied().chain([false]).enumerate() {
        match (marked, begin) {
            (true, None) => begin = Some(column),
            (false, Some(first)) => {
                all.push(first..column);
                begin = None;
            }
            _ => {}
        }
    }
    all
}

/// No more rectangles than are worth it: those are joined whose joining adds the least, with all that they then meet.
fn fewer(mut rects: Vec<Rect>) -> Vec<Rect> {
    while rects.len() > MOST_RECTANGLES {
        let added = |a: &Rect, b: &Rect| a.union(*b).area() - a.area() - b.area();
        let pairs = (0..rects.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let best = pairs.min_by(|a, b| added(&rects[a.0], &rects[a.1]).total_cmp(&added(&rects[b.0], &rects[b.1])));
        let Some((i, j)) = best else {
            break;
        };
        let mut joined = rects[i].union(rects[j]);
        rects.remove(i);
        rects.remove(j);
        while let Some(other) = rects.iter().position(|r| r.intersect(joined).is_positive()) {
            joined = joined.union(rects.swap_remove(other));
        }
        rects.push(joined);
    }
    rects
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
        assert_eq!(rects, [rect(32.0, 0.0, 48.0, 16.0)], "squares of 16 pixels");
        // A callback is drawn each time.
        let with = [first[0].clone(), callback(rect(50.0, 5.0, 20.0, 20.0))];
        damage.of(&with, SIZE, 1.0);
        assert_eq!(damage.of(&with, SIZE, 1.0), Some(vec![rect(48.0, 0.0, 32.0, 32.0)]));
        assert_eq!(damage.of(&with, SIZE, 2.0), None, "another scale");
        assert_eq!(damage.of(&with, SIZE * 2.0, 2.0), None, "another size");
        damage.forget();
        assert_eq!(damage.of(&with, SIZE * 2.0, 2.0), None);
    }

    #[test]
    fn another_texture_is_drawn_again_and_added_letters_are_not() {
        let mut painted = shape(rect(10.0, 10.0, 5.0, 5.0), Color32::WHITE);
        let Primitive::Mesh(mesh) = &mut painted.primitive else { unreachable!() };
        mesh.texture_id = TextureId::Managed(7);
        let shapes = [shape(rect(0.0, 0.0, 3.0, 3.0), Color32::RED), painted];
        let mut damage = Damage::default();
        damage.of(&shapes, SIZE, 1.0);
        let mut change = |id, pos| {
            let image = egui::ColorImage::filled([2, 2], Color32::WHITE);
            let delta = match pos {
                None => egui::epaint::ImageDelta::full(image, Default::default()),
                Some(pos) => egui::epaint::ImageDelta::partial(pos, image, Default::default()),
            };
            let mut textures = TexturesDelta::default();
            textures.set.entry(id).or_default().push(delta);
            damage.repaint(&textures);
            textures.set.clear();
            damage.of(&shapes, SIZE, 1.0)
        };
        assert_eq!(change(TextureId::Managed(7), Some([0, 0])), Some(vec![rect(0.0, 0.0, 16.0, 16.0)]));
        assert_eq!(change(TextureId::default(), Some([0, 0])), Some(vec![]));
        assert_eq!(change(TextureId::default(), None), Some(vec![rect(0.0, 0.0, 16.0, 16.0)]));
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
        let window = Rect::from_min_size(Pos2::ZERO, Vec2::new(640.0, 480.0));
        let grid = |rects: &[Rect]| Grid::of(rects, window, 16.0).rectangles();
        assert_eq!(grid(&[]), []);
        assert_eq!(grid(&[rect(20.0, 20.0, 4.0, 30.0)]), [rect(16.0, 16.0, 16.0, 48.0)]);
        // Two that meet: the rows that both have, and the rest of each.
        let met = grid(&[rect(17.0, 17.0, 30.0, 14.0), rect(33.0, 20.0, 14.0, 40.0)]);
        assert_eq!(met, [rect(16.0, 16.0, 32.0, 16.0), rect(32.0, 32.0, 16.0, 32.0)]);
        // Many in a diagonal.
        let many: Vec<Rect> = (0..25).map(|i| rect(20.0 * i as f32, 18.0 * i as f32, 3.0, 3.0)).collect();
        let few = grid(&many);
        assert!(few.len() <= MOST_RECTANGLES);
        assert!(many.iter().all(|r| few.iter().any(|f| f.contains_rect(*r))));
        for (i, a) in few.iter().enumerate() {
            assert!(few[..i].iter().all(|b| !a.intersect(*b).is_positive()), "{few:?}");
        }
        assert!(few.iter().map(|r| r.area()).sum::<f32>() < 0.5 * window.area());
        // Outside the window there is nothing.
        assert_eq!(grid(&[rect(-50.0, -50.0, 20.0, 20.0), rect(700.0, 0.0, 9.0, 9.0)]), []);
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
