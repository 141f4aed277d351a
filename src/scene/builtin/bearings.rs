//! Rolling bearings and shaft seals as sub-assemblies.

use glam::DMat4;

use super::assembly::{Assembly, shift};
use super::kit::{Perforation, Shell, Step, Tolerance, ball, perforated_tube, torus_tube, turned};

/// A deep-groove ball bearing around the z axis.
#[derive(Clone, Copy, Debug)]
pub struct BallBearing {
    /// Radius of the bore.
    pub bore: f64,
    /// Outer radius.
    pub outer: f64,
    /// Width along z.
    pub width: f64,
    /// Number of balls.
    pub balls: usize,
}

/// Materials of a bearing.
#[derive(Clone, Copy, Debug)]
pub struct BearingMaterials {
    /// Rings.
    pub ring: usize,
    /// Balls or rollers.
    pub ball: usize,
    /// Cage.
    pub cage: usize,
}

impl BallBearing {
    /// Meshes of the bearing: inner ring, outer ring, cage, ball. Use them for as many bearings as are alike.
    pub fn meshes(&self, assembly: &mut Assembly, name: &str, m: BearingMaterials, tolerance: Tolerance) -> [usize; 4] {
        let radial = self.outer - self.bore;
        let pitch = 0.5 * (self.bore + self.outer);
        let ball_radius = self.ball_radius();
        let half = self.width / 2.0;
        let (inner, outer) = self.rings(tolerance);
        let cage = perforated_tube(&Perforation {
            inner: pitch - 0.075 * radial,
            outer: pitch + 0.075 * radial,
            z0: -0.86 * half,
            z1: 0.86 * half,
            rows: 1,
            holes: self.balls,
            hole_radius: ball_radius * 1.04,
            divisions: 3,
            shift: 0.0,
        });
        [
            assembly.mesh(&format!("{name} inner ring"), &inner, m.ring),
            assembly.mesh(&format!("{name} outer ring"), &outer, m.ring),
            assembly.mesh(&format!("{name} cage"), &cage, m.cage),
            assembly.mesh(&format!("{name} ball"), &ball(ball_radius, tolerance), m.ball),
        ]
    }

    fn ball_radius(&self) -> f64 {
        // A narrow bearing has smaller balls: the cage must still close around them.
        (0.3 * (self.outer - self.bore)).min(0.36 * self.width)
    }

    fn rings(&self, tolerance: Tolerance) -> (Shell, Shell) {
        let radial = self.outer - self.bore;
        let pitch = 0.5 * (self.bore + self.outer);
        let half = self.width / 2.0;
        let shoulder = 0.17 * radial;
        // The groove's radius is a little over the ball's, as in real ones.
        let groove = self.ball_radius() * 1.04;
        let clearance = self.ball_radius() * 1.005;
        let round = 0.05 * radial;
        let ring = |side: f64, fit: f64| {
            let wall = pitch + side * shoulder;
            let center = pitch + side * (clearance - groove);
            let reach = (groove * groove - (wall - center).powi(2)).max(0.0).sqrt();
            turned(
                &[
                    Step::Round(fit, -half, round),
                    Step::To(wall, -half),
                    Step::To(wall, -reach),
                    Step::Arc(center, 0.0, wall, reach),
                    Step::To(wall, half),
                    Step::Round(fit, half, round),
                ],
                tolerance,
            )
        };
        (ring(-1.0, self.bore), ring(1.0, self.outer))
    }

    /// Adds one bearing at `place` as a group.
    pub fn add(&self, assembly: &mut Assembly, parent: usize, name: &str, meshes: [usize; 4], place: DMat4) -> usize {
        let group = assembly.group(Some(parent), name, place);
        assembly.part(group, "inner ring", meshes[0], DMat4::IDENTITY);
        assembly.part(group, "outer ring", meshes[1], DMat4::IDENTITY);
        assembly.part(group, "cage", meshes[2], DMat4::IDENTITY);
        let pitch = 0.5 * (self.bore + self.outer);
        assembly.circle(group, "ball", meshes[3], self.balls, 0.0, shift(pitch, 0.0, 0.0));
        group
    }
}

/// A radial shaft seal between the shaft's and the bore's radius, with a lip and its garter spring.
pub fn seal(shaft: f64, bore: f64, width: f64, tolerance: Tolerance) -> [Shell; 2] {
    let wall = 0.16 * (bore - shaft);
    let spring = 0.11 * (bore - shaft);
    let lip = shaft + 0.03 * (bore - shaft);
    let body = turned(
        &[
            Step::Cut(bore, 0.0, 0.4 * wall),
            Step::Round(bore, width, 0.5 * wall),
            Step::Round(bore - wall, width, 0.3 * wall),
            Step::Round(bore - wall, wall, 0.4 * wall),
            Step::Round(lip + 2.2 * wall, wall, 0.4 * wall),
            Step::Round(lip + 1.4 * wall, 0.62 * width, 0.3 * wall),
            Step::Round(lip + 1.6 * wall, 0.85 * width, 0.3 * wall),
            Step::To(lip + 0.4 * wall, 0.85 * width),
            Step::To(lip, 0.7 * width),
            Step::To(lip + wall, 0.4 * width),
            Step::Round(lip + wall, 0.0, 0.4 * wall),
        ],
        tolerance,
    );
    [body, torus_tube(lip + 1.45 * wall + spring, spring, 0.62 * width, tolerance)]
}

#[cfg(test)]
mod tests {
    use super::super::kit::shell::faults;
    use super::*;

    #[test]
    fn rings_and_seals_are_closed() {
        let bearing = BallBearing { bore: 20.0, outer: 40.0, width: 18.0, balls: 9 };
        let (inner, outer) = bearing.rings(Tolerance(0.03));
        let [body, spring] = seal(20.0, 31.0, 8.0, Tolerance(0.03));
        for (name, shell) in [("inner", inner), ("outer", outer), ("body", body), ("spring", spring)] {
            assert_eq!(faults(&shell.primitive(0)), Vec::<String>::new(), "{name}");
        }
    }
}
