//! Named views of a model, and how one is framed unless something else is asked for.

use glam::DVec3;

/// Vertical angle of view unless another is asked for, in degrees.
pub const VIEW_ANGLE: f64 = 30.0;
/// Leaves a margin of a tenth, as in f3d.
pub const ZOOM_FACTOR: f64 = 0.9;

/// Named views: viewing direction and up. Files are y-up and face +z, as in glTF. The last is the default.
pub const VIEWS: &[(&str, DVec3, DVec3)] = &[
    ("front", DVec3::NEG_Z, DVec3::Y),
    ("back", DVec3::Z, DVec3::Y),
    ("left", DVec3::X, DVec3::Y),
    ("right", DVec3::NEG_X, DVec3::Y),
    ("top", DVec3::NEG_Y, DVec3::NEG_Z),
    ("bottom", DVec3::Y, DVec3::Z),
    ("isometric", DVec3::NEG_ONE, DVec3::Y),
    // From the front, 35° to the right and 25° up.
    ("three-quarter", DVec3::new(-0.519_837, -0.422_618, -0.742_404), DVec3::Y),
];
