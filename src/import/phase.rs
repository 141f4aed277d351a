//! How far an import is: its phases, told to whoever asks.

use std::fmt;
use std::sync::Arc;

/// What an import is at. Every format passes through these in order; what it has no use for is left out. A file for a
/// converter is read before that too, to see what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// A converter that the user named is at work.
    Converting,
    /// The bytes of the file are read or mapped.
    Reading,
    /// Text or structure of the file becomes numbers.
    Parsing,
    /// Images are decoded.
    Images,
    /// Triangles with their attributes are made: decompressed, checked, cleaned, given normals and tangents.
    Geometry,
    /// Triangles are grouped into parts.
    Parts,
    /// The scene is put together: hierarchy, bounds, numbers of triangles.
    Finishing,
}

impl Phase {
    /// What the user reads.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Converting => "converting",
            Phase::Reading => "reading",
            Phase::Parsing => "parsing",
            Phase::Images => "decoding images",
            Phase::Geometry => "building geometry",
            Phase::Parts => "finding parts",
            Phase::Finishing => "finishing the scene",
        }
    }
}

type Listener = Arc<dyn Fn(Phase, f32) + Send + Sync>;

/// Whoever wants to know how far an import is; copies tell the same one. By default nobody.
#[derive(Clone, Default)]
pub struct Progress(Option<Listener>);

impl Progress {
    /// `listener` is called when a phase begins, with 0, and inside long ones with the share that is done. It is called from
    /// the importer's threads and must return soon.
    pub fn to(listener: impl Fn(Phase, f32) + Send + Sync + 'static) -> Progress {
        Progress(Some(Arc::new(listener)))
    }

    /// Tells that of `phase` the share `done`, from 0 to 1, is done.
    pub fn tell(&self, phase: Phase, done: f32) {
        if let Some(listener) = &self.0 {
            listener(phase, done.clamp(0.0, 1.0));
        }
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Progress(told)" } else { "Progress(nobody)" })
    }
}

impl PartialEq for Progress {
    /// Always: who listens changes nothing of the scene.
    fn eq(&self, _: &Progress) -> bool {
        true
    }
}
