//! Axis-aligned boxes and spheres, in `f64`, robust to the empty set and to non-finite points (T29).

use glam::{DMat4, DVec3};

/// Axis-aligned bounding box. The empty box has `min > max` and joins neutrally.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner, in scene units.
    pub min: DVec3,
    /// Largest corner, in scene units.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds { min: DVec3::splat(f64::INFINITY), max: DVec3::splat(f64::NEG_INFINITY) };

    /// The smallest box around `points`. Points with a non-finite coordinate are left out.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        points.into_iter().fold(Bounds::EMPTY, Bounds::including)
    }

    /// This box grown to hold `point`; unchanged if a coordinate is not finite.
    #[must_use]
    pub fn including(self, point: DVec3) -> Bounds {
        if !point.is_finite() {
            return self;
        }
        Bounds { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if no point was ever included.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Middle of the box; the origin for the empty box.
    pub fn center(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { (self.min + self.max) * 0.5 }
    }

    /// Edge lengths; zero for the empty box.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.max - self.min }
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The box around this box's corners after an affine map.
    #[must_use]
    pub fn transformed(&self, to_from_self: DMat4) -> Bounds {
        if self.is_empty() {
            return *self;
        }
        Bounds::of_points(self.corners().map(|c| to_from_self.transform_point3(c)))
    }

    /// The sphere around the box: its center and half its diagonal.
    pub fn bounding_sphere(&self) -> Sphere {
        Sphere { center: self.center(), radius: self.size().length() * 0.5 }
    }
}

/// A sphere in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Center, in scene units.
    pub center: DVec3,
    /// Radius, in scene units; zero for a point or an empty set.
    pub radius: f64,
}
