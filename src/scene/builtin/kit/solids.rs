//! Balls and tori.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Path, Shell, Tolerance, Vertex, revolve};

/// A ball around the origin: an icosahedron with its edges divided, so that triangles are of nearly one size.
pub fn ball(radius: f64, tolerance: Tolerance) -> Shell {
    // An icosahedron's edge spans 63.4°.
    ball_divided(radius, tolerance.arc(radius, 1.107_148_717_794_09).max(2))
}

/// A ball with every edge of the icosahedron divided into `divisions`: 20·divisions² triangles.
pub fn ball_divided(radius: f64, divisions: usize) -> Shell {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut corners = Vec::with_capacity(12);
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        corners.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    let mut shell = Shell::new();
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-6;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let (a, b, c) = (corners[i], corners[j], corners[k]);
                if near(a, b) && near(b, c) && near(c, a) {
                    divide(&mut shell, [a, b, c], radius, divisions);
                }
            }
        }
    }
    shell
}

fn divide(shell: &mut Shell, [a, b, c]: [DVec3; 3], radius: f64, divisions: usize) {
    let at = |i: usize, j: usize| {
        let n = divisions as f64;
        let (u, v) = (i as f64 / n, j as f64 / n);
        let normal = (a * (1.0 - u - v) + b * u + c * v).normalize();
        Vertex { position: normal * radius, normal }
    };
    for i in 0..divisions {
        for j in 0..divisions - i {
            shell.triangle(at(i, j), at(i + 1, j), at(i, j + 1));
            if i + j + 2 <= divisions {
                shell.triangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
        }
    }
}

/// A torus around the z axis at height `z`: a tube of radius `tube` around a circle of radius `radius`.
pub fn torus_tube(radius: f64, tube: f64, z: f64, tolerance: Tolerance) -> Shell {
    let count = tolerance.arc(tube, TAU).max(12);
    revolve(&Path::circle(DVec2::new(radius, z), tube, count), tolerance)
}

#[cfg(test)]
mod tests {
    use super::super::shell::{faults, volume};
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn balls_and_tori_are_closed_and_have_their_volume() {
        let tolerance = Tolerance(0.01);
        let ball = ball(4.0, tolerance).primitive(0);
        assert!(faults(&ball).is_empty(), "{:?}", faults(&ball));
        assert!((volume(&ball) / (4.0 / 3.0 * PI * 64.0) - 1.0).abs() < 0.02);
        let torus = torus_tube(10.0, 2.0, 5.0, tolerance).primitive(0);
        assert!(faults(&torus).is_empty(), "{:?}", faults(&torus));
        assert!((volume(&torus) / (2.0 * PI * PI * 10.0 * 4.0) - 1.0).abs() < 0.03);
    }
}
