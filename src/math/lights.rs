//! The lights of the studio in which everything is shown: plain numbers, in view space.
//!
//! Three directional lights and a surrounding that is bright above and dark below. All of them move with the camera, so
//! a part that faces the viewer looks the same from every side, as CAD users expect. What the numbers do to a surface
//! is written twice, in `shaders/common/lighting.wgsl` for the GPU and in `oracle::lighting` in `f64`; both read this
//! rig, so that neither can drift in its defaults.
//!
//! Intensity: a white Lambert surface that faces a light of intensity `I` reflects `I / π`.

use glam::DVec3;

/// How bright the lights of [`LightRig::studio`] are; 1 for `exposure` and `ambient`, 2, 0.7 and 1 for the three lights
/// is the balance at which a grey surface that faces the viewer shows its own colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightLevels {
    /// Multiplies everything, emitted light included.
    pub exposure: f64,
    /// Intensity of the key light: in front, above, to the right.
    pub key: f64,
    /// Intensity of the fill light: in front, to the left.
    pub fill: f64,
    /// Intensity of the rim light: above and behind.
    pub rim: f64,
    /// Multiplies the light from all around.
    pub ambient: f64,
}

impl Default for LightLevels {
    fn default() -> LightLevels {
        LightLevels { exposure: 1.0, key: 2.0, fill: 0.7, rim: 1.0, ambient: 1.0 }
    }
}

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector towards the light, in view space (x right, y up, z towards the viewer).
    pub direction: DVec3,
    /// Intensity, ≥ 0; its tint belongs to the shading code.
    pub intensity: f64,
}

/// Light from one half of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hemisphere {
    /// Linear rgb radiance at level 1.
    pub color: DVec3,
    /// Multiplies `color`.
    pub intensity: f64,
}

/// All lights of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRig {
    /// The main light; a little warm.
    pub key: DirectionalLight,
    /// Lightens what the key light leaves dark; a little cool.
    pub fill: DirectionalLight,
    /// Comes from behind and draws the upper edge of things.
    pub rim: DirectionalLight,
    /// The upper half of the surroundings.
    pub sky: Hemisphere,
    /// The lower half.
    pub ground: Hemisphere,
    /// Unit vector to the middle of the sky, in view space.
    pub up: DVec3,
    /// Multiplies everything, emitted light included.
    pub exposure: f64,
}

impl LightRig {
    /// The studio with the given levels.
    pub fn studio(levels: LightLevels) -> LightRig {
        let light = |x: f64, y: f64, z: f64, intensity| DirectionalLight {
            direction: DVec3::new(x, y, z).normalize(),
            intensity,
        };
        LightRig {
            key: light(0.45, 0.65, 0.75, levels.key),
            fill: light(-0.80, 0.05, 0.60, levels.fill),
            rim: light(-0.25, 0.60, -0.75, levels.rim),
            sky: Hemisphere { color: DVec3::new(0.46, 0.475, 0.50), intensity: levels.ambient },
            ground: Hemisphere { color: DVec3::new(0.22, 0.21, 0.20), intensity: levels.ambient },
            // Leans towards the viewer: what faces the camera sees more sky than ground.
            up: DVec3::new(0.0, 0.93, 0.37).normalize(),
            exposure: levels.exposure,
        }
    }

    /// The six `vec4` of the shader's `Lights`, in its order: key, fill, rim (xyz direction, w intensity), sky, ground
    /// (rgb, w intensity), up (xyz direction, w exposure).
    pub fn to_vec4s(&self) -> [[f32; 4]; 6] {
        let pack = |v: DVec3, w: f64| [v.x as f32, v.y as f32, v.z as f32, w as f32];
        [
            pack(self.key.direction, self.key.intensity),
            pack(self.fill.direction, self.fill.intensity),
            pack(self.rim.direction, self.rim.intensity),
            pack(self.sky.color, self.sky.intensity),
            pack(self.ground.color, self.ground.intensity),
            pack(self.up, self.exposure),
        ]
    }
}
