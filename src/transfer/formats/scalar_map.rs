//! What ParaView's and Slicer's files describe alike: VTK's colour and opacity over a scalar, as functions over κ.
//!
//! Colours are interpolated in the space that the file names, by the formulas that VTK documents: HSV with hue as a
//! number (the short way round only where the file asks for it), CIELAB with D65's white, and *Diverging*, which is
//! Moreland's Msh space (*Diverging Color Maps for Scientific Visualization*, 2009). Opacity follows VTK's midpoint and
//! sharpness. Our own interpolation is between values as they are, so everything but RGB and Step is resampled:
//! straight pieces within 5e-4 of the curve, or 1/8192 of the range wide; the reader's notice gives the error.
//!
//! The scalar range of the colours is mapped onto κ from −1 to 1, that of the opacity onto |κ| from 0 to 1, linearly,
//! each by itself.

use super::fit::{Fit, NARROWEST, TOLERANCE, color_points, opacity_points};
use super::{Imported, assemble};
use crate::transfer::{
    ColorFunction, ColorMode, ColorShape, Interpolation, OpacityCurve, OpacityFunction, OpacityShape, Points,
    TransferError,
};

/// Where colours are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    Rgb,
    /// `wrap`: hue goes the short way round.
    Hsv {
        wrap: bool,
    },
    Lab,
    Diverging,
    /// The colour of the next point, up to it.
    Step,
}

impl Space {
    /// A space by the name that a file gives it.
    ///
    /// # Errors
    /// A sentence for the user.
    pub fn named(name: &str) -> Result<Space, String> {
        match name.to_ascii_lowercase().as_str() {
            "rgb" => Ok(Space::Rgb),
            "hsv" => Ok(Space::Hsv { wrap: false }),
            "wrapped" | "hsvwrap" | "hsv_wrap" => Ok(Space::Hsv { wrap: true }),
            "lab" => Ok(Space::Lab),
            "diverging" => Ok(Space::Diverging),
            "step" => Ok(Space::Step),
            _ => Err(format!("colour space '{name}': expected RGB, HSV, Wrapped, Lab, Diverging or Step")),
        }
    }
}

/// An opacity with the shape of the curve behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpacityNode {
    pub x: f64,
    pub alpha: f64,
    /// Where, between this point and the next, half of the way is done.
    pub midpoint: f64,
    /// 0 straight, 1 a jump at the midpoint.
    pub sharpness: f64,
}

/// A map as a file describes it.
#[derive(Clone, Debug)]
pub(super) struct ScalarMap {
    pub space: Space,
    /// Scalar and colour; may be in any order.
    pub colors: Vec<(f64, [f64; 3])>,
    /// Colours without a place: equal steps.
    pub indexed: Vec<[f64; 3]>,
    pub opacities: Vec<OpacityNode>,
}

impl ScalarMap {
    /// A map that says nothing.
    pub fn new() -> ScalarMap {
        ScalarMap { space: Space::Rgb, colors: Vec::new(), indexed: Vec::new(), opacities: Vec::new() }
    }

    /// The functions over κ. What the map does not have is taken from the default functions.
    ///
    /// # Errors
    /// [`TransferError`] with `place`'s file and line if a number cannot be used.
    pub fn import(
        mut self,
        mut notices: Vec<String>,
        place: impl Fn(String) -> TransferError,
    ) -> Result<Imported, TransferError> {
        if !self.colors.is_empty() && !self.indexed.is_empty() {
            notices.push("ignored: indexed colours, because there are colours over a scalar too".to_owned());
        }
        let color = if !self.colors.is_empty() {
            Some(self.color(&mut notices).map_err(&place)?)
        } else {
            stepped(&mut self.indexed, &mut notices).map_err(&place)?
        };
        let opacity = self.opacity(&mut notices).map_err(&place)?;
        assemble(color, opacity, notices).map_err(place)
    }

    fn color(&mut self, notices: &mut Vec<String>) -> Result<ColorFunction, String> {
        unit_colors(self.colors.iter_mut().map(|c| &mut c.1), notices)?;
        let nodes = arrange(&mut self.colors, |c| &mut c.0, [-1.0, 1.0], "colour", "kappa", notices)?;
        let mut fit = Fit::new();
        let mut last: Option<(f64, [f64; 3])> = None;
        for node in nodes {
            match (last, self.space) {
                (None, _) | (_, Space::Rgb) => fit.push(node.0, node.1),
                (Some((from, _)), Space::Step) => {
                    // VTK shows a point's colour up to it; a step of ours begins at its point.
                    let begin = from.next_up();
                    if begin < node.0 {
                        fit.push(begin, node.1);
                    }
                }
                (Some((from, start)), space) => {
                    let curve = |x: f64| between(space, start, node.1, (x - from) / (node.0 - from));
                    fit.follow(curve, [from, node.0], TOLERANCE, 2.0 * NARROWEST);
                }
            }
            last = Some(node);
        }
        if fit.error > 0.0 {
            notices.push(format!(
                "approximated: colours between points, as {} straight pieces; largest error {:.5}",
                fit.points.len() - 1,
                fit.error
            ));
        }
        let interpolation = if self.space == Space::Step { Interpolation::Step } else { Interpolation::Linear };
        let points = color_points(&fit).ok_or("there is no colour point")?;
        Ok(ColorFunction { mode: ColorMode::Tint, shape: ColorShape::Points { interpolation, points } })
    }

    fn opacity(&mut self, notices: &mut Vec<String>) -> Result<Option<OpacityFunction>, String> {
        if self.opacities.is_empty() {
            return Ok(None);
        }
        clamp(self.opacities.iter_mut().map(|n| &mut n.alpha), "opacities", notices)?;
        if self.opacities.iter().any(|n| !n.midpoint.is_finite() || !n.sharpness.is_finite()) {
            return Err("a midpoint or a sharpness is not a number".to_owned());
        }
        let nodes = arrange(&mut self.opacities, |n| &mut n.x, [0.0, 1.0], "opacity", "|kappa|", notices)?;
        let mut fit = Fit::new();
        let mut last: Option<OpacityNode> = None;
        for node in nodes {
            if let Some(from) = last {
                bend(&mut fit, from, node);
            }
            fit.push(node.x, [node.alpha]);
            last = Some(node);
        }
        if fit.error > 0.0 {
            notices.push(format!(
                "approximated: midpoints and sharpness of the opacity, as {} straight pieces; largest error {:.5}",
                fit.points.len() - 1,
                fit.error
            ));
        }
        let points = opacity_points(&fit).ok_or("there is no opacity point")?;
        Ok(Some(one_curve(points)))
    }
}

/// Opacity over |κ| alone, straight between points.
pub(super) fn one_curve(points: Points<crate::transfer::OpacityPoint>) -> OpacityFunction {
    let curves = Points::one(OpacityCurve { depth: 0.0, points });
    let line = Interpolation::Linear;
    OpacityFunction { shape: OpacityShape::Curves { interpolation: line, depth_interpolation: line, curves } }
}

/// Colours without a place, as equal steps from κ = −1 to 1.
fn stepped(colors: &mut [[f64; 3]], notices: &mut Vec<String>) -> Result<Option<ColorFunction>, String> {
    if colors.is_empty() {
        return Ok(None);
    }
    unit_colors(colors.iter_mut(), notices)?;
    notices.push(format!("approximated: {} indexed colours, as equal steps over kappa from -1 to 1", colors.len()));
    let mut fit = Fit::new();
    for (i, color) in colors.iter().enumerate() {
        fit.push(2.0 * i as f64 / colors.len() as f64 - 1.0, *color);
    }
    let points = color_points(&fit).ok_or("the indexed colours cannot be used")?;
    let shape = ColorShape::Points { interpolation: Interpolation::Step, points };
    Ok(Some(ColorFunction { mode: ColorMode::Tint, shape }))
}

/// Puts points in order and maps their range onto `ends`. Points in one place make a jump: the later one is moved to
/// the next number, as VTK reads them.
///
/// # Errors
/// A sentence for the user if a position is not a number, or the range is none.
pub(super) fn arrange<T: Copy>(
    nodes: &mut [T],
    x: impl Fn(&mut T) -> &mut f64,
    ends: [f64; 2],
    what: &str,
    axis: &str,
    notices: &mut Vec<String>,
) -> Result<Vec<T>, String> {
    let mut placed: Vec<(f64, T)> = nodes.iter().map(|n| (*x(&mut n.clone()), *n)).collect();
    if let Some((at, _)) = placed.iter().find(|(at, _)| !at.is_finite()) {
        return Err(format!("{what} at {at}: expected a number"));
    }
    if placed.windows(2).any(|pair| pair[0].0 > pair[1].0) {
        notices.push(format!("repaired: {what} points put in increasing order"));
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let (Some(&(low, _)), Some(&(high, _))) = (placed.first(), placed.last()) else {
        return Ok(Vec::new());
    };
    let width = high - low;
    if !width.is_finite() {
        return Err(format!("the {what}'s range, {low} to {high}, is too wide"));
    }
    let [least, most] = ends;
    if width > 0.0 && [low, high] != ends {
        notices.push(format!("approximated: {what} over {low} to {high} mapped onto {axis} from {least} to {most}"));
    }
    let mut arranged: Vec<T> = Vec::with_capacity(placed.len());
    let mut before: Option<f64> = None;
    for (at, mut node) in placed {
        let mapped = if [low, high] == ends {
            at
        } else if width > 0.0 {
            least + ((at - low) / width) * (most - least)
        } else {
            least
        };
        let place = match before {
            Some(before) if mapped <= before => before.next_up(),
            _ => mapped.clamp(least, most),
        };
        if place > most {
            notices.push(format!("ignored: {what} points behind the first at the upper end of the range"));
            break;
        }
        before = Some(place);
        *x(&mut node) = place;
        arranged.push(node);
    }
    Ok(arranged)
}

/// Brings colours into [0, 1]: bytes are divided by 255, anything else is clamped; both are said.
///
/// # Errors
/// A sentence for the user if a value is not a number.
pub(super) fn unit_colors<'a>(
    colors: impl Iterator<Item = &'a mut [f64; 3]>,
    notices: &mut Vec<String>,
) -> Result<(), String> {
    let mut values: Vec<&mut f64> = colors.flatten().collect();
    let most = values.iter().fold(0.0_f64, |most, v| most.max(**v));
    // A little over 1 is rounding; beyond, no colour is meant in [0, 1].
    if most > 1.5 && most <= 255.0 {
        notices.push("approximated: colours above 1, read as bytes over 255".to_owned());
        values.iter_mut().for_each(|v| **v /= 255.0);
    }
    clamp(values.into_iter(), "colour values", notices)
}

/// Clamps to [0, 1] and says how many values that changed.
///
/// # Errors
/// A sentence for the user if a value is not a number.
pub(super) fn clamp<'a>(
    values: impl Iterator<Item = &'a mut f64>,
    what: &str,
    notices: &mut Vec<String>,
) -> Result<(), String> {
    let mut changed = 0_usize;
    for value in values {
        if !value.is_finite() {
            return Err(format!("{what}: {value} is not a number from 0 to 1"));
        }
        changed += usize::from(!(0.0..=1.0).contains(value));
        *value = value.clamp(0.0, 1.0);
    }
    if changed > 0 {
        notices.push(format!("repaired: {changed} {what} outside 0 to 1 clamped"));
    }
    Ok(())
}

/// The points between two opacities.
fn bend(fit: &mut Fit<1>, from: OpacityNode, to: OpacityNode) {
    let (a, b) = (from.alpha, to.alpha);
    let midpoint = from.midpoint.clamp(1e-5, 1.0 - 1e-5);
    let middle = from.x + (to.x - from.x) * midpoint;
    let narrow = !(from.x < middle && middle < to.x) || to.x - from.x <= NARROWEST;
    if a == b || narrow {
        return;
    }
    if from.sharpness > 0.99 {
        let before = middle.next_down();
        if before > from.x {
            fit.push(before, [a]);
        }
        fit.push(middle, [b]);
    } else if from.sharpness < 0.01 {
        if midpoint != 0.5 {
            fit.push(middle, [0.5 * (a + b)]);
        }
    } else {
        let curve = |x: f64| {
            let t = (x - from.x) / (to.x - from.x);
            [sharpened(a, b, t, midpoint, from.sharpness)]
        };
        fit.follow(curve, [from.x, middle], TOLERANCE, NARROWEST);
        fit.follow(curve, [middle, to.x], TOLERANCE, NARROWEST);
        // The caller adds the end.
        fit.points.pop();
    }
}

/// VTK's curve between two values: the way is squeezed towards the midpoint by a power, then walked by a Hermite cubic
/// whose slopes shrink with the sharpness.
fn sharpened(a: f64, b: f64, t: f64, midpoint: f64, sharpness: f64) -> f64 {
    let way = if t < midpoint { 0.5 * t / midpoint } else { 0.5 + 0.5 * (t - midpoint) / (1.0 - midpoint) };
    let power = 1.0 + 10.0 * sharpness;
    let s = if way < 0.5 { 0.5 * (2.0 * way).powf(power) } else { 1.0 - 0.5 * (2.0 * (1.0 - way)).powf(power) };
    let rise = s * s * (3.0 - 2.0 * s);
    let slope = (1.0 - sharpness) * s * (1.0 - s) * (1.0 - 2.0 * s);
    let y = a + (b - a) * (rise + slope);
    y.clamp(a.min(b), a.max(b))
}

/// The colour at `t` between two.
pub(super) fn between(space: Space, start: [f64; 3], end: [f64; 3], t: f64) -> [f64; 3] {
    let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
    match space {
        Space::Rgb => mix(start, end),
        Space::Step => end,
        Space::Hsv { wrap } => {
            let (mut a, mut b) = (hsv(start), hsv(end));
            if wrap && (a[0] - b[0]).abs() > 0.5 {
                if a[0] > b[0] { a[0] -= 1.0 } else { b[0] -= 1.0 }
            }
            rgb_of_hsv(mix(a, b))
        }
        Space::Lab => rgb_of_lab(mix(lab(start), lab(end))),
        Space::Diverging => diverging(start, end, t),
    }
}

fn hsv([r, g, b]: [f64; 3]) -> [f64; 3] {
    let most = r.max(g).max(b);
    let spread = most - r.min(g).min(b);
    if spread <= 0.0 {
        return [0.0, 0.0, most];
    }
    let sixth = if r == most {
        (g - b) / spread
    } else if g == most {
        2.0 + (b - r) / spread
    } else {
        4.0 + (r - g) / spread
    };
    [(sixth / 6.0).rem_euclid(1.0), spread / most, most]
}

fn rgb_of_hsv([h, s, v]: [f64; 3]) -> [f64; 3] {
    let h = h.rem_euclid(1.0) * 6.0;
    [0.0, 4.0, 2.0].map(|offset: f64| {
        let from_peak = ((h + offset).rem_euclid(6.0) - 3.0).abs() - 1.0;
        v * (1.0 - s + s * from_peak.clamp(0.0, 1.0))
    })
}

/// White of D65, as VTK has it.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];
const XYZ_OF_RGB: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
const RGB_OF_XYZ: [[f64; 3]; 3] = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

fn times(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let linear = rgb.map(|c| if c > 0.04045 { ((c + 0.055) / 1.055).powf(2.4) } else { c / 12.92 });
    let xyz = times(XYZ_OF_RGB, linear);
    let [x, y, z] = std::array::from_fn(|i| {
        let t = xyz[i] / WHITE[i];
        if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// A colour outside sRGB's gamut is scaled down to its brightest channel, then clipped.
fn rgb_of_lab([l, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let roots = [a / 500.0 + y, y, y - b / 200.0];
    let xyz = std::array::from_fn(|i| {
        let cube = roots[i].powi(3);
        WHITE[i] * if cube > 0.008856 { cube } else { (roots[i] - 16.0 / 116.0) / 7.787 }
    });
    let rgb = times(RGB_OF_XYZ, xyz).map(|c| if c > 0.0031308 { 1.055 * c.powf(1.0 / 2.4) - 0.055 } else { 12.92 * c });
    let most = rgb.iter().fold(1.0_f64, |most, c| most.max(*c));
    rgb.map(|c| (c / most).clamp(0.0, 1.0))
}

/// Between two colours through white if both are saturated and far apart in hue, at an even pace for the eye.
fn diverging(start: [f64; 3], end: [f64; 3], mut t: f64) -> [f64; 3] {
    const SATURATED: f64 = 0.05;
    let (mut a, mut b) = (msh(lab(start)), msh(lab(end)));
    let apart = {
        let turn = (a[2] - b[2]).abs().rem_euclid(std::f64::consts::TAU);
        turn.min(std::f64::consts::TAU - turn)
    };
    if a[1] > SATURATED && b[1] > SATURATED && apart > 0.33 * std::f64::consts::PI {
        let white = [a[0].max(b[0]).max(88.0), 0.0, 0.0];
        if t < 0.5 {
            b = white;
            t *= 2.0;
        } else {
            a = white;
            t = 2.0 * t - 1.0;
        }
    }
    if a[1] < SATURATED && b[1] > SATURATED {
        a[2] = spun(b, a[0]);
    } else if b[1] < SATURATED && a[1] > SATURATED {
        b[2] = spun(a, b[0]);
    }
    let [m, s, h] = std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
    rgb_of_lab([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

/// CIELAB in polar form: magnitude, saturation as an angle, hue.
fn msh([l, a, b]: [f64; 3]) -> [f64; 3] {
    let m = (l * l + a * a + b * b).sqrt();
    let s = if m > 0.001 { (l / m).clamp(-1.0, 1.0).acos() } else { 0.0 };
    let h = if s > 0.001 { b.atan2(a) } else { 0.0 };
    [m, s, h]
}

/// The hue that an unsaturated colour of magnitude `unsaturated` is given on the way to a saturated one.
fn spun([m, s, h]: [f64; 3], unsaturated: f64) -> f64 {
    if m >= unsaturated - 0.1 {
        return h;
    }
    let spin = s * (unsaturated * unsaturated - m * m).sqrt() / (m * s.sin());
    if h > -0.3 * std::f64::consts::PI { h + spin } else { h - spin }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3], by: f64) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= by), "{a:?}, not {b:?}");
    }

    /// Moreland's own table of his cool-to-warm map, in bytes.
    #[test]
    fn diverging_is_morelands_map() {
        let (cool, warm) = ([59.0, 76.0, 192.0].map(|v| v / 255.0), [180.0, 4.0, 38.0].map(|v| v / 255.0));
        for (t, bytes) in [
            (0.0, [59.0, 76.0, 192.0]),
            (0.25, [141.0, 176.0, 254.0]),
            (0.5, [221.0, 221.0, 221.0]),
            (0.75, [244.0, 154.0, 123.0]),
            (1.0, [180.0, 4.0, 38.0]),
        ] {
            close(between(Space::Diverging, cool, warm, t), bytes.map(|v| v / 255.0), 1.01 / 255.0);
        }
    }

    #[test]
    fn hue_goes_through_green_or_the_short_way() {
        let (blue, red) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        close(between(Space::Hsv { wrap: false }, blue, red, 0.5), [0.0, 1.0, 0.0], 1e-12);
        close(between(Space::Hsv { wrap: true }, blue, red, 0.5), [1.0, 0.0, 1.0], 1e-12);
        for rgb in [[0.1, 0.7, 0.3], [0.9, 0.2, 0.2], [0.5; 3], [0.0; 3], [0.3, 0.1, 0.9]] {
            close(rgb_of_hsv(hsv(rgb)), rgb, 1e-12);
        }
    }

    #[test]
    fn lab_is_cies() {
        for (rgb, cie) in [
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
            ([1.0; 3], [100.0, 0.0, 0.0]),
        ] {
            close(lab(rgb), cie, 0.05);
            close(rgb_of_lab(lab(rgb)), rgb, 1e-3);
        }
    }

    #[test]
    fn midpoint_and_sharpness_bend_as_vtk_does() {
        assert!((sharpened(0.0, 1.0, 0.25, 0.25, 0.5) - 0.5).abs() < 1e-12, "half of the way at the midpoint");
        assert_eq!(sharpened(0.2, 0.8, 0.0, 0.3, 0.5), 0.2);
        assert_eq!(sharpened(0.2, 0.8, 1.0, 0.3, 0.5), 0.8);
        // By hand: midpoint 0.5, sharpness 0.2, t = 0.25: s = 0.5·0.5³ = 0.0625;
        // 3s² − 2s³ = 0.01123047, 0.8·(s³ − 2s² + s + s³ − s²) = 0.8·(0.0625 − 0.01171875 + 0.00048828) = 0.04101563.
        assert!((sharpened(0.0, 1.0, 0.25, 0.5, 0.2) - 0.052_246_093_75).abs() < 1e-12);
    }
}
