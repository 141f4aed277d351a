//! `NAME?key=value&key=value`, and the small random generator of the generated scenes.

use glam::DVec3;

use super::BuiltinError;

/// Parameters of a scene, taken one by one; what is left over is an error.
#[derive(Clone, Debug)]
pub struct Parameters {
    scene: String,
    given: Vec<(String, String)>,
}

impl Parameters {
    /// Splits a name.
    pub fn parse(name: &str) -> Parameters {
        let (scene, rest) = name.split_once('?').unwrap_or((name, ""));
        let pair = |p: &str| {
            let (key, value) = p.split_once('=').unwrap_or((p, ""));
            (key.to_owned(), value.to_owned())
        };
        let given = rest.split('&').filter(|p| !p.is_empty()).map(pair).collect();
        Parameters { scene: scene.to_owned(), given }
    }

    /// The scene's name.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Reads `[key, default, low, high]` for every parameter of the scene.
    pub fn take<const N: usize>(&mut self, known: [(&str, f64, f64, f64); N]) -> Result<[f64; N], BuiltinError> {
        let mut values = known.map(|k| k.1);
        for (key, text) in &self.given {
            let Some(i) = known.iter().position(|k| k.0 == key) else {
                let names: Vec<&str> = known.iter().map(|k| k.0).collect();
                let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                return Err(BuiltinError::UnknownParameter { scene: self.scene.clone(), key: key.clone(), known });
            };
            let (_, _, low, high) = known[i];
            values[i] = match text.parse::<f64>() {
                Ok(value) if value >= low && value <= high => value,
                _ => {
                    let (scene, key, value) = (self.scene.clone(), key.clone(), text.clone());
                    return Err(BuiltinError::BadValue { scene, key, value, low, high });
                }
            };
        }
        Ok(values)
    }

    /// For a scene without parameters.
    pub fn none(&mut self) -> Result<(), BuiltinError> {
        self.take([]).map(|[]| ())
    }
}

/// SplitMix64: small, seeded, the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator that depends on `seed` alone.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number below `bound`, which must not be 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.bits() % bound
    }

    /// A number in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A point in the cube of half edge `half` around the origin.
    pub fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }

    /// A unit vector.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.point(1.0);
            if p.length() > 0.1 && p.length() < 1.0 {
                return p.normalize();
            }
        }
    }
}
