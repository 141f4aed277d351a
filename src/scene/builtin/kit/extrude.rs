//! Outlines drawn out along z: walls, bevels, planar faces, and whole prisms with holes.

use glam::{DVec2, DVec3};

use super::{Path, Shell, Vertex, planar::triangulate};

/// What an extruded outline's rim looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chamfer {
    /// A plain edge.
    None,
    /// A 45° cut of this size.
    Cut(f64),
}

impl Chamfer {
    fn size(self) -> f64 {
        match self {
            Chamfer::None => 0.0,
            Chamfer::Cut(size) => size,
        }
    }
}

/// The wall of `outline` from `z0` to `z1`. `solid` says whether matter lies inside the outline (else it is a hole's
/// wall, and its normals look inward).
pub fn wall(shell: &mut Shell, outline: &Path, z0: f64, z1: f64, solid: bool) {
    ruled(shell, outline, z0, outline, z1, |n| (if solid { n } else { -n }).extend(0.0));
}

/// The slanted face between `outline` at `z0` and the same outline moved `inset` inward (towards matter) at `z1`.
pub fn bevel(shell: &mut Shell, outline: &Path, z0: f64, z1: f64, inset: f64, solid: bool) {
    let side = if solid { 1.0 } else { -1.0 };
    let rise = inset * (z1 - z0).signum();
    let run = (z1 - z0).abs();
    ruled(shell, outline, z0, &outline.offset(-inset * side), z1, |n| (n * (side * run)).extend(rise));
}

fn ruled(shell: &mut Shell, low: &Path, z0: f64, high: &Path, z1: f64, normal: impl Fn(DVec2) -> DVec3) {
    for ((a, b), (c, d)) in low.pieces().zip(high.pieces()) {
        if b.open {
            continue;
        }
        let (start, end) = (normal(a.normal_out), normal(b.normal_in));
        shell.quad(
            Vertex::new(a.point.extend(z0), start),
            Vertex::new(b.point.extend(z0), end),
            Vertex::new(d.point.extend(z1), end),
            Vertex::new(c.point.extend(z1), start),
        );
    }
}

/// The planar face at height `z` inside `loops[0]` and outside the others, looking up or down.
pub fn face(shell: &mut Shell, z: f64, loops: &[Vec<DVec2>], up: bool) {
    let points: Vec<DVec2> = loops.iter().flatten().copied().collect();
    let normal = if up { DVec3::Z } else { DVec3::NEG_Z };
    for triangle in triangulate(loops) {
        let [a, b, c] = triangle.map(|i| Vertex { position: points[i].extend(z), normal });
        shell.triangle(a, b, c);
    }
}

/// A closed prism from `z0` up to `z1` inside `outline` and around `holes`, with its outer rims cut by `chamfer`.
pub fn prism(outline: &Path, holes: &[Path], z0: f64, z1: f64, chamfer: Chamfer) -> Shell {
    extrude(outline, holes, z0, z1, [chamfer, chamfer], [Chamfer::None; 2])
}

/// A closed prism with different chamfers below and above, on its outer rims and on the rims of its holes.
pub fn extrude(outline: &Path, holes: &[Path], z0: f64, z1: f64, outer: [Chamfer; 2], inner: [Chamfer; 2]) -> Shell {
    let mut shell = Shell::new();
    let mut ends: [Vec<Vec<DVec2>>; 2] = [Vec::new(), Vec::new()];
    for (i, path) in std::iter::once(outline).chain(holes).enumerate() {
        let solid = i == 0;
        let [below, above] = if solid { outer } else { inner }.map(Chamfer::size);
        let side = if solid { 1.0 } else { -1.0 };
        wall(&mut shell, path, z0 + below, z1 - above, solid);
        for (end, (size, from, to)) in [(below, z0 + below, z0), (above, z1 - above, z1)].into_iter().enumerate() {
            if size > 0.0 {
                bevel(&mut shell, path, from, to, size, solid);
            }
            ends[end].push(path.offset(-size * side).points());
        }
    }
    face(&mut shell, z0, &ends[0], false);
    face(&mut shell, z1, &ends[1], true);
    shell
}

#[cfg(test)]
mod tests {
    use super::super::{
        Step, Tolerance,
        shell::{faults, volume},
    };
    use super::*;

    #[test]
    fn a_plate_with_holes_and_chamfers_is_closed_and_has_its_volume() {
        let tolerance = Tolerance(0.01);
        let outline = Path::closed(
            &[Step::Round(0.0, 0.0, 3.0), Step::To(40.0, 0.0), Step::Cut(40.0, 20.0, 2.0), Step::To(0.0, 20.0)],
            tolerance,
        );
        let holes = [Path::circle(DVec2::new(10.0, 10.0), 3.0, 32), Path::circle(DVec2::new(30.0, 10.0), 4.0, 32)];
        let shell = extrude(&outline, &holes, -2.0, 3.0, [Chamfer::Cut(0.5); 2], [Chamfer::Cut(0.3), Chamfer::None]);
        let primitive = shell.primitive(0);
        assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
        let solid = 5.0 * (800.0 - 2.0 - 9.0 * (1.0 - std::f64::consts::FRAC_PI_4) - std::f64::consts::PI * 25.0);
        assert!((volume(&primitive) / solid - 1.0).abs() < 0.02, "{} of {solid}", volume(&primitive));
    }
}
