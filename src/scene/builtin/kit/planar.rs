//! Triangulation of a plane outline with holes: ear clipping along bridges, then Delaunay flips.

use std::collections::HashMap;

use glam::DVec2;

/// Triangulates the region inside `loops[0]` and outside the other loops. Indices count the points loop after loop.
/// Triangles are counter-clockwise. Loops may run either way; they must not cross.
pub fn triangulate(loops: &[Vec<DVec2>]) -> Vec<[usize; 3]> {
    let points: Vec<DVec2> = loops.iter().flatten().copied().collect();
    let mut rings: Vec<Vec<usize>> = Vec::new();
    let mut first = 0;
    for (i, ring) in loops.iter().enumerate() {
        let mut indices: Vec<usize> = (first..first + ring.len()).collect();
        if (area(&points, &indices) > 0.0) != (i == 0) {
            indices.reverse();
        }
        first += ring.len();
        rings.push(indices);
    }
    let mut rings = rings.into_iter();
    let Some(mut polygon) = rings.next() else { return Vec::new() };
    let mut holes: Vec<Vec<usize>> = rings.collect();
    while !holes.is_empty() {
        let Some((h, at_hole, at_polygon)) = bridge(&points, &polygon, &holes) else { break };
        let hole = holes.swap_remove(h);
        let around = (0..=hole.len()).map(|k| hole[(at_hole + k) % hole.len()]);
        let again = std::iter::once(polygon[at_polygon]);
        let inserted: Vec<usize> = around.chain(again).collect();
        polygon.splice(at_polygon + 1..at_polygon + 1, inserted);
    }
    let mut triangles = clip_ears(&points, polygon);
    flip_to_delaunay(&points, &mut triangles);
    triangles
}

fn area(points: &[DVec2], ring: &[usize]) -> f64 {
    (0..ring.len()).map(|i| points[ring[i]].perp_dot(points[ring[(i + 1) % ring.len()]])).sum()
}

fn cross(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The shortest segment from a hole to the polygon that crosses nothing: hole, position in it, position in the polygon.
fn bridge(points: &[DVec2], polygon: &[usize], holes: &[Vec<usize>]) -> Option<(usize, usize, usize)> {
    let mut candidates: Vec<(f64, usize, usize, usize)> = Vec::new();
    for (h, hole) in holes.iter().enumerate() {
        for (i, &from) in hole.iter().enumerate() {
            let near = polygon.iter().enumerate().map(|(j, &to)| (points[from].distance_squared(points[to]), h, i, j));
            // For each hole point only its nearest few can be the shortest bridge.
            let mut near: Vec<_> = near.collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            candidates.extend(near.into_iter().take(6));
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3)));
    let rings = || std::iter::once(polygon).chain(holes.iter().map(Vec::as_slice));
    candidates
        .into_iter()
        .find(|&(_, h, i, j)| {
            let (a, b) = (points[holes[h][i]], points[polygon[j]]);
            let clear = rings().all(|ring| {
                (0..ring.len()).all(|k| {
                    let (c, d) = (points[ring[k]], points[ring[(k + 1) % ring.len()]]);
                    c == a || d == a || c == b || d == b || !crosses(a, b, c, d)
                })
            });
            // Where earlier bridges made two copies of a corner, the segment must leave inside this copy's angle.
            let n = polygon.len();
            clear && inside_corner(points[polygon[(j + n - 1) % n]], b, points[polygon[(j + 1) % n]], a)
        })
        .map(|(_, h, i, j)| (h, i, j))
}

fn crosses(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    cross(a, b, c) * cross(a, b, d) <= 0.0 && cross(c, d, a) * cross(c, d, b) <= 0.0
}

fn inside_corner(before: DVec2, corner: DVec2, after: DVec2, target: DVec2) -> bool {
    if cross(before, corner, after) >= 0.0 {
        cross(before, corner, target) > 0.0 && cross(corner, after, target) > 0.0
    } else {
        cross(before, corner, target) > 0.0 || cross(corner, after, target) > 0.0
    }
}

fn clip_ears(points: &[DVec2], polygon: Vec<usize>) -> Vec<[usize; 3]> {
    let mut ring = polygon;
    let mut triangles = Vec::with_capacity(ring.len());
    let quality = |ring: &[usize], i: usize| -> f64 {
        let n = ring.len();
        let ids = [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let [a, b, c] = ids.map(|k| points[k]);
        let double_area = cross(a, b, c);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        if double_area <= longest * 1e-9 {
            return -1.0;
        }
        let blocked = ring.iter().any(|&k| {
            let p = points[k];
            p != a && p != b && p != c && cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0
        });
        if blocked { -1.0 } else { double_area / longest }
    };
    let mut qualities: Vec<f64> = (0..ring.len()).map(|i| quality(&ring, i)).collect();
    while ring.len() >= 3 {
        let n = ring.len();
        let best = (0..n).max_by(|&i, &j| qualities[i].total_cmp(&qualities[j]).then(j.cmp(&i))).unwrap_or(0);
        if n > 3 && qualities[best] <= 0.0 {
            // Clipping may have opened ears that were blocked: look at all again, once.
            let fresh: Vec<f64> = (0..n).map(|i| quality(&ring, i)).collect();
            if fresh == qualities {
                break;
            }
            qualities = fresh;
            continue;
        }
        triangles.push([ring[(best + n - 1) % n], ring[best], ring[(best + 1) % n]]);
        ring.remove(best);
        qualities.remove(best);
        let n = ring.len();
        if n < 3 {
            break;
        }
        for i in [(best + n - 1) % n, best % n] {
            qualities[i] = quality(&ring, i);
        }
    }
    triangles
}

/// Lawson's flips inside the region; outline and bridges' outer edges have one triangle and stay.
fn flip_to_delaunay(points: &[DVec2], triangles: &mut [[usize; 3]]) {
    let key = |a: usize, b: usize| (a.min(b), a.max(b));
    let mut owners: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    for (t, triangle) in triangles.iter().enumerate() {
        for e in 0..3 {
            owners.entry(key(triangle[e], triangle[(e + 1) % 3])).or_default().push(t);
        }
    }
    let mut pending: Vec<(usize, usize)> = owners.keys().copied().collect();
    pending.sort_unstable();
    let mut left = 40 * pending.len();
    while let Some(edge) = pending.pop() {
        left = match left.checked_sub(1) {
            Some(left) => left,
            None => return,
        };
        let Some([s, t]) = owners.get(&edge).and_then(|o| <[usize; 2]>::try_from(o.as_slice()).ok()) else { continue };
        let Some(i) = (0..3).find(|&i| key(triangles[s][i], triangles[s][(i + 1) % 3]) == edge) else { continue };
        let (a, b, c) = (triangles[s][i], triangles[s][(i + 1) % 3], triangles[s][(i + 2) % 3]);
        let Some(&d) = triangles[t].iter().find(|&&v| v != a && v != b) else { continue };
        let angle = |p: usize| {
            let (u, v) = (points[a] - points[p], points[b] - points[p]);
            u.perp_dot(v).abs().atan2(u.dot(v))
        };
        let scale = points[c].distance_squared(points[d]) * 1e-9;
        let convex = cross(points[c], points[a], points[d]) > scale && cross(points[d], points[b], points[c]) > scale;
        if !convex || angle(c) + angle(d) <= std::f64::consts::PI + 1e-9 {
            continue;
        }
        triangles[s] = [c, a, d];
        triangles[t] = [d, b, c];
        owners.remove(&edge);
        owners.insert(key(c, d), vec![s, t]);
        for (side, old, new) in [(key(a, d), t, s), (key(b, c), s, t)] {
            if let Some(list) = owners.get_mut(&side) {
                list.iter_mut().filter(|o| **o == old).for_each(|o| *o = new);
            }
        }
        pending.extend([key(a, c), key(a, d), key(b, c), key(b, d)]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Path;
    use super::*;

    #[test]
    fn a_flange_with_holes_is_covered_exactly() {
        let mut loops =
            vec![Path::circle(DVec2::ZERO, 95.0, 96).points(), Path::circle(DVec2::ZERO, 75.0, 64).points()];
        for i in 0..12 {
            let center = DVec2::from_angle(i as f64 * std::f64::consts::TAU / 12.0) * 88.0;
            loops.push(Path::circle(center, 4.2, 24).points());
        }
        let points: Vec<DVec2> = loops.iter().flatten().copied().collect();
        let triangles = triangulate(&loops);
        assert_eq!(triangles.len(), points.len() + 2 * (loops.len() - 1) - 2);
        let covered: f64 = triangles.iter().map(|t| cross(points[t[0]], points[t[1]], points[t[2]])).sum();
        let ring = |l: &Vec<DVec2>| (0..l.len()).map(|i| l[i].perp_dot(l[(i + 1) % l.len()])).sum::<f64>();
        let expected = ring(&loops[0]) - loops[1..].iter().map(ring).sum::<f64>();
        assert!((covered / expected - 1.0).abs() < 1e-9, "{covered} {expected}");
        assert!(triangles.iter().all(|t| cross(points[t[0]], points[t[1]], points[t[2]]) > 1e-6));
    }
}
