//! What stands still: the three housing pieces, gaskets, covers with seals, bolts, base plate.

use glam::{DMat4, DVec2};

use super::super::{
    assembly::{Assembly, shift, upside_down},
    bearings::seal,
    kit::{
        Chamfer, Path, Shell, Step, bevel, extrude, face, hex_bolt, hex_nut, revolve_with, ribbed, socket_screw, wall,
        washer,
    },
};
use super::{FINE, Materials, SMALL};

/// Chords of every full circle of a housing piece, so that its faces and its turned sides meet.
const CHORDS: usize = 192;

/// Radius and number of the flange bolts.
const BOLT_CIRCLE: f64 = 94.0;
const BOLTS: usize = 12;

fn circle(radius: f64) -> Path {
    Path::circle(DVec2::ZERO, radius, CHORDS)
}

pub fn angles() -> Vec<f64> {
    (0..CHORDS).map(|i| std::f64::consts::TAU * i as f64 / CHORDS as f64).collect()
}

/// Round holes of radius `hole` on a circle, the first turned by half a step.
pub fn bolt_circle(count: usize, radius: f64, hole: f64) -> Vec<Path> {
    (0..count)
        .map(|i| {
            let angle = std::f64::consts::TAU * (i as f64 + 0.5) / count as f64;
            Path::circle(DVec2::from_angle(angle) * radius, hole, FINE.circle(hole))
        })
        .collect()
}

/// The loops of a face: an outline, then what is cut out.
pub fn loops<'a>(outline: &'a Path, holes: impl IntoIterator<Item = &'a Path>) -> Vec<Vec<DVec2>> {
    std::iter::once(outline).chain(holes).map(Path::points).collect()
}

/// Holes from an open face at `z` down to `bottom`, closed there.
fn blind_holes(shell: &mut Shell, holes: &[Path], z: f64, bottom: f64) {
    for hole in holes {
        wall(shell, hole, z.min(bottom), z.max(bottom), false);
        face(shell, bottom, &[hole.points()], z > bottom);
    }
}

/// The outline of a flange of the ring housing: round, with feet.
fn footed() -> Path {
    let (x, y) = (104.0 * 35.0_f64.to_radians().cos(), -104.0 * 35.0_f64.to_radians().sin());
    Path::closed(
        &[
            Step::Round(50.0, -116.0, 4.0),
            Step::Round(60.0, -124.0, 2.0),
            Step::Round(104.0, -124.0, 2.0),
            Step::Round(104.0, -112.0, 4.0),
            Step::Round(87.0, -106.0, 6.0),
            Step::To(x, y),
            Step::Arc(0.0, 0.0, 0.0, 104.0),
            Step::Arc(0.0, 0.0, -x, y),
            Step::Round(-87.0, -106.0, 6.0),
            Step::Round(-104.0, -112.0, 4.0),
            Step::Round(-104.0, -124.0, 2.0),
            Step::Round(-60.0, -124.0, 2.0),
            Step::Round(-50.0, -116.0, 4.0),
        ],
        FINE,
    )
}

fn ring_housing() -> Shell {
    let mut s = Shell::new();
    let (flange, ribs, bore) = (footed(), ribbed(12, 84.0, 97.0, 6.0, FINE), circle(75.2));
    let holes = bolt_circle(BOLTS, BOLT_CIRCLE, 4.3);
    let cut = 0.8;
    for (out, back) in [(-30.0, -20.0), (30.0, 20.0)] {
        let toward = if out > back { 1.0 } else { -1.0 };
        let (low, high) = if out < back { (out + cut, back - cut) } else { (back + cut, out - cut) };
        wall(&mut s, &flange, low, high, true);
        bevel(&mut s, &flange, out - cut * toward, out, cut, true);
        bevel(&mut s, &flange, back + cut * toward, back, cut, true);
        for hole in &holes {
            wall(&mut s, hole, out.min(back), out.max(back), false);
        }
        let rim = flange.offset(-cut);
        face(&mut s, out, &loops(&rim, holes.iter().chain([&bore])), out > 0.0);
        face(&mut s, back, &loops(&rim, holes.iter().chain([&ribs])), out < 0.0);
    }
    wall(&mut s, &ribs, -20.0, 20.0, true);
    wall(&mut s, &bore, -30.0, 30.0, false);
    s
}

/// The turned sides of an end housing plus its flange faces at `joint` and `back`, and its nose face at `nose`.
fn end_housing(
    profile: &[Step],
    joint: f64,
    back: f64,
    cone: f64,
    nose: (f64, f64, f64),
    holes: (usize, f64, f64),
) -> Shell {
    let mut s = revolve_with(&Path::closed(profile, FINE), &angles());
    let out = joint > 0.0;
    let bolts = bolt_circle(BOLTS, BOLT_CIRCLE, 4.3);
    for hole in &bolts {
        wall(&mut s, hole, joint.min(back), joint.max(back), false);
    }
    face(&mut s, joint, &loops(&circle(103.0), bolts.iter().chain([&circle(75.2)])), !out);
    face(&mut s, back, &loops(&circle(103.0), bolts.iter().chain([&circle(cone)])), out);
    let (z, rim, bore) = nose;
    let tapped = bolt_circle(holes.0, holes.1, holes.2);
    blind_holes(&mut s, &tapped, z, if out { z - 13.0 } else { z + 11.0 });
    face(&mut s, z, &loops(&circle(rim), tapped.iter().chain([&circle(bore)])), out);
    s
}

fn output_housing() -> Shell {
    let profile = [
        Step::To(75.2, 30.5),
        Step::Open(103.0, 30.5),
        Step::To(104.0, 31.5),
        Step::To(104.0, 39.0),
        Step::To(103.0, 40.0),
        Step::Open(82.0, 40.0),
        Step::Round(79.0, 40.0, 2.5),
        Step::Round(54.0, 60.0, 8.0),
        Step::To(52.0, 97.0),
        Step::To(51.0, 98.0),
        Step::Open(40.0, 98.0),
        Step::To(40.0, 76.0),
        Step::To(36.0, 76.0),
        Step::To(36.0, 58.0),
        Step::To(40.0, 58.0),
        Step::Cut(40.0, 38.0, 0.6),
        Step::Cut(46.0, 38.0, 0.6),
        Step::Round(46.0, 52.0, 2.5),
        Step::Round(51.0, 52.0, 2.5),
        Step::Round(71.0, 37.0, 6.0),
        Step::To(75.2, 34.0),
    ];
    end_housing(&profile, 30.5, 40.0, 82.0, (98.0, 51.0, 40.0), (8, 46.0, 2.5))
}

fn input_housing() -> Shell {
    let profile = [
        Step::To(75.2, -30.5),
        Step::Open(103.0, -30.5),
        Step::To(104.0, -31.5),
        Step::To(104.0, -39.0),
        Step::To(103.0, -40.0),
        Step::Open(82.0, -40.0),
        Step::Round(79.0, -40.0, 2.5),
        Step::Round(48.0, -54.0, 8.0),
        Step::Round(37.0, -56.0, 3.0),
        Step::To(34.0, -75.0),
        Step::To(33.0, -76.0),
        Step::Open(21.0, -76.0),
        Step::To(21.0, -56.0),
        Step::To(17.0, -56.0),
        Step::To(17.0, -47.0),
        Step::To(31.0, -47.0),
        Step::To(31.0, -43.5),
        Step::To(36.0, -43.5),
        Step::Cut(36.0, -29.0, 0.6),
        Step::Cut(42.0, -29.0, 0.6),
        Step::Round(42.0, -45.0, 2.5),
        Step::Round(50.0, -46.0, 2.5),
        Step::Round(71.0, -36.0, 5.0),
        Step::To(75.2, -34.0),
    ];
    end_housing(&profile, -30.5, -40.0, 82.0, (-76.0, 33.0, 21.0), (6, 27.5, 2.0))
}

/// A cover: `side` +1 for the output end, −1 for the input end; all heights are measured outward.
struct Cover {
    side: f64,
    seat: f64,
    spigot: (f64, f64),
    bore: f64,
    rim: f64,
    top: f64,
    neck: f64,
    holes: (usize, f64, f64),
}

impl Cover {
    fn shell(&self) -> Shell {
        let z = |h: f64| self.side * h;
        let profile = [
            Step::To(self.bore, z(self.spigot.1)),
            Step::Cut(self.spigot.0, z(self.spigot.1), 0.5),
            Step::To(self.spigot.0, z(self.seat)),
            Step::Open(self.rim - 1.0, z(self.seat)),
            Step::To(self.rim, z(self.seat + 1.0)),
            Step::To(self.rim, z(self.top - 1.0)),
            Step::To(self.rim - 1.0, z(self.top)),
            Step::Open(self.neck + 2.0, z(self.top)),
            Step::Arc(self.neck + 2.0, z(self.top + 2.0), self.neck, z(self.top + 2.0)),
            Step::Cut(self.neck, z(self.top + 4.0), 0.6),
            Step::Cut(self.bore, z(self.top + 4.0), 0.6),
        ];
        let mut s = revolve_with(&Path::closed(&profile, FINE), &angles());
        let (count, radius, hole) = self.holes;
        let holes = bolt_circle(count, radius, hole);
        for hole in &holes {
            wall(&mut s, hole, z(self.seat).min(z(self.top)), z(self.seat).max(z(self.top)), false);
        }
        let rim = circle(self.rim - 1.0);
        face(&mut s, z(self.seat), &loops(&rim, holes.iter().chain([&circle(self.spigot.0)])), self.side < 0.0);
        face(&mut s, z(self.top), &loops(&rim, holes.iter().chain([&circle(self.neck + 2.0)])), self.side > 0.0);
        s
    }
}

/// Adds everything that does not turn.
pub fn add(a: &mut Assembly, root: usize, m: &Materials) {
    let group = a.group(Some(root), "Housing", DMat4::IDENTITY);
    a.single(group, "ring housing", &ring_housing(), m.housing);
    a.single(group, "output housing", &output_housing(), m.housing);
    a.single(group, "input housing", &input_housing(), m.housing);
    let holes = [bolt_circle(BOLTS, BOLT_CIRCLE, 4.3), vec![circle(75.2)]].concat();
    let gasket = a.mesh(
        "gasket",
        &extrude(&circle(103.0), &holes, 0.05, 0.45, [Chamfer::None; 2], [Chamfer::None; 2]),
        m.gasket,
    );
    a.part(group, "output gasket", gasket, shift(0.0, 0.0, 30.0));
    a.part(group, "input gasket", gasket, shift(0.0, 0.0, -30.5));
    flange_bolts(a, group, m);
    covers(a, group, m);
    base(a, group, m);
}

fn flange_bolts(a: &mut Assembly, group: usize, m: &Materials) {
    let bolt = a.mesh("hex bolt M8x32", &hex_bolt(8.0, 1.25, 32.0, 20.0, SMALL), m.bolt);
    let ring = a.mesh("washer M8", &washer(8.0, SMALL), m.ring);
    let nut = a.mesh("hex nut M8", &hex_nut(8.0, SMALL), m.bolt);
    let half = std::f64::consts::PI / BOLTS as f64;
    for (name, end) in [("Output flange bolts", DMat4::IDENTITY), ("Input flange bolts", upside_down())] {
        let set = a.group(Some(group), name, end);
        let at = |z: f64| shift(BOLT_CIRCLE, 0.0, z);
        a.circle(set, "bolt", bolt, BOLTS, half, at(41.5));
        a.circle(set, "washer", ring, BOLTS, half, at(40.03));
        a.circle(set, "nut washer", ring, BOLTS, half, at(18.53));
        a.circle(set, "nut", nut, BOLTS, half, at(12.1));
    }
}

fn covers(a: &mut Assembly, group: usize, m: &Materials) {
    let pi = std::f64::consts::PI;
    let output = a.group(Some(group), "Output cover", DMat4::IDENTITY);
    let cover = Cover {
        side: 1.0,
        seat: 98.1,
        spigot: (39.9, 95.0),
        bore: 31.0,
        rim: 52.0,
        top: 106.0,
        neck: 37.0,
        holes: (8, 46.0, 2.75),
    };
    a.single(output, "output cover", &cover.shell(), m.cover);
    let [body, spring] = seal(20.0, 30.95, 8.0, FINE);
    a.single(output, "output seal", &body.at_z(101.0), m.rubber);
    a.single(output, "garter spring", &spring.at_z(101.0), m.ring);
    let screw = a.mesh("cap screw M5x16", &socket_screw(5.0, 0.8, 16.0, SMALL), m.bolt);
    a.circle(output, "cap screw", screw, 8, pi / 8.0, shift(46.0, 0.0, 106.05));

    let input = a.group(Some(group), "Input cover", DMat4::IDENTITY);
    let cover = Cover {
        side: -1.0,
        seat: 76.1,
        spigot: (20.9, 71.0),
        bore: 17.0,
        rim: 34.0,
        top: 84.0,
        neck: 20.5,
        holes: (6, 27.5, 2.2),
    };
    a.single(input, "input cover", &cover.shell(), m.cover);
    let [body, spring] = seal(10.0, 16.95, 7.0, FINE);
    a.single(input, "input seal", &body.moved(shift(0.0, 0.0, -79.0) * upside_down()), m.rubber);
    a.single(input, "garter spring", &spring.moved(shift(0.0, 0.0, -79.0) * upside_down()), m.ring);
    let screw = a.mesh("cap screw M4x14", &socket_screw(4.0, 0.7, 14.0, SMALL), m.bolt);
    a.circle(input, "cap screw", screw, 6, pi / 6.0, shift(27.5, 0.0, -84.05) * upside_down());
}

/// A plate under the feet with its four anchor bolts. It is drawn in the xy plane and stood on edge.
fn base(a: &mut Assembly, group: usize, m: &Materials) {
    let (x, z, drill) = (118.0, 38.0, 5.5);
    let corners = [(-x, -z), (x, -z), (x, z), (-x, z)].map(|(x, z)| DVec2::new(x, z));
    let outline = corners.map(|c| Step::Round(c.x * 1.1, c.y * 1.3, 8.0));
    let holes = corners.map(|c| Path::circle(c, drill, SMALL.circle(drill)));
    let plate = extrude(&Path::closed(&outline, FINE), &holes, 0.0, 12.0, [Chamfer::Cut(1.0); 2], [Chamfer::None; 2]);
    // Drawing plane to ground: the plate's z becomes y.
    let stand = shift(0.0, -136.1, 0.0) * DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let set = a.group(Some(group), "Base", stand);
    a.single(set, "base plate", &plate, m.base);
    let bolt = a.mesh("anchor bolt M10x35", &hex_bolt(10.0, 1.5, 35.0, 20.0, SMALL), m.bolt);
    let ring = a.mesh("washer M10", &washer(10.0, SMALL), m.ring);
    for (i, c) in corners.into_iter().enumerate() {
        a.part(set, &format!("anchor washer {}", i + 1), ring, shift(c.x, c.y, 12.03));
        a.part(set, &format!("anchor bolt {}", i + 1), bolt, shift(c.x, c.y, 13.86));
    }
}
