//! The hard cases of all techniques, run on the present adapter against the `f64` oracle.
//!
//! Techniques declare their cases beside their code; [`ROOMS`] lists the rooms, and a test keeps the list complete. A case
//! is drawn as ours and, where it has one, as its contrast (the printed method, or ours with an error planted into it);
//! both figures come from the same measurement, so that a contrast within the bound would show a case that proves nothing.

mod illustration;
mod measure;
mod random;
mod shot;
mod table;

use serde::Serialize;

use crate::oracle::compare::AMBIGUOUS;
use crate::passes::{self, capture, composite, features, geometry, opacity, opaque, shade};
use crate::plan::Refusal;
use crate::render::{RenderError, Renderer};
use crate::scene::hard_case::{Contrast, HardCase, Method};
use crate::{export, import, settings};

pub use shot::{Shot, changed_module, scene_of};
pub use table::{figure_text, markdown, text};

/// The cases of one technique.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// The technique's room below `src/`.
    pub technique: &'static str,
    /// Its cases.
    pub cases: &'static [HardCase],
}

/// Every technique that has cases; a technique without fails a test.
pub const ROOMS: &[Room] = &[
    Room { technique: "import", cases: import::cases::CASES },
    Room { technique: "passes/geometry", cases: geometry::cases::CASES },
    Room { technique: "passes/capture", cases: capture::cases::CASES },
    Room { technique: "passes/features", cases: features::cases::CASES },
    Room { technique: "passes/shade", cases: shade::CASES },
    Room { technique: "passes/opacity", cases: opacity::CASES },
    Room { technique: "passes/illustration", cases: passes::illustration::cases::CASES },
    Room { technique: "passes/opaque", cases: opaque::CASES },
    Room { technique: "passes/composite", cases: composite::cases::CASES },
];

/// All cases with their techniques.
pub fn all() -> impl Iterator<Item = (&'static str, &'static HardCase)> {
    ROOMS.iter().flat_map(|room| room.cases.iter().map(|case| (room.technique, case)))
}

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Random scenes of every case that has such.
    pub random_scenes: u32,
    /// Whether contrasts are drawn too.
    pub contrasts: bool,
}

impl Effort {
    /// What runs unless more is asked for.
    pub const USUAL: Effort = Effort { random_scenes: 512, contrasts: true };
    /// Random scenes of a thorough run.
    pub const MANY_SCENES: u32 = 100_000;
}

/// What became of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Ours keeps the bound.
    Passed,
    /// It does not.
    Failed,
    /// The adapter lacks something.
    Skipped,
}

impl Verdict {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Passed => "passed",
            Verdict::Failed => "FAILED",
            Verdict::Skipped => "skipped",
        }
    }
}

/// A contrast's outcome.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContrastOutcome {
    /// Whether the paper (or common practice) does it so; otherwise the error is planted.
    pub printed: bool,
    /// What was drawn.
    pub label: &'static str,
    /// Its figure, in the unit of the case.
    pub figure: Option<f64>,
    /// Why there is no figure: the planner refused, or the picture broke.
    pub reason: Option<String>,
}

impl ContrastOutcome {
    /// Whether the case's bound tells this from ours: it is above the bound, or was refused.
    pub fn is_caught(&self, bound: f64) -> bool {
        self.figure.is_none_or(|figure| figure.is_nan() || figure > bound)
    }
}

/// What running a case gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Name of the case.
    pub name: &'static str,
    /// Number of the trap.
    pub trap: &'static str,
    /// Room of the technique.
    pub technique: &'static str,
    /// Why it is hard.
    pub why: &'static str,
    /// What is measured.
    pub measured: &'static str,
    /// Unit of the figures.
    pub unit: &'static str,
    /// What the figure of ours must not exceed.
    pub bound: f64,
    /// Our figure; none if it could not be measured.
    pub ours: Option<f64>,
    /// What was compared: fragments, links, pixels or scenes.
    pub samples: usize,
    /// How many of them are ambiguous, where either answer passes.
    pub ambiguous: usize,
    /// The method that fails.
    pub contrast: Option<ContrastOutcome>,
    /// Verdict.
    pub verdict: Verdict,
    /// Why it failed or was skipped, where the figures do not say it.
    pub reason: Option<String>,
}

/// Why a method has no figure.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// It was not drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The scene could not be made.
    #[error(transparent)]
    Builtin(#[from] crate::scene::builtin::BuiltinError),
    /// The scene could not be written.
    #[error(transparent)]
    Write(#[from] export::glb::GlbError),
    /// The scene could not be read.
    #[error(transparent)]
    Import(#[from] import::ImportError),
    /// The case's settings are wrong.
    #[error(transparent)]
    Settings(#[from] settings::SettingsError),
    /// A module has no such text to change.
    #[error("the shader module {module} has no '{text}'")]
    NoSuchText {
        /// The module.
        module: String,
        /// What it should have.
        text: String,
    },
    /// The store does not fit a binding of the adapter, and of several bands only the last is left to be compared.
    #[error("the picture takes {bands} bands on this adapter; a store of one band is needed for the comparison")]
    Banded {
        /// Bands that it takes.
        bands: usize,
    },
    /// The picture is broken in a way that no case allows.
    #[error("{0}")]
    Broken(String),
}

impl CaseError {
    /// Whether the adapter lacks something that another may have.
    fn is_lack(&self) -> bool {
        match self {
            CaseError::Render(RenderError::Refused(refusal)) => {
                !matches!(refusal, Refusal::TooManyParts { .. } | Refusal::EmptyImage { .. } | Refusal::Transfer(_))
            }
            CaseError::Render(
                RenderError::PixelTooDeep { .. } | RenderError::RowTooDeep { .. } | RenderError::ListsTooLarge { .. },
            ) => true,
            CaseError::Banded { .. } => true,
            _ => false,
        }
    }
}

/// A measured figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figure {
    /// The error, in the unit of the measure.
    pub value: f64,
    /// What was compared.
    pub samples: usize,
    /// How many of them are ambiguous.
    pub ambiguous: usize,
}

/// Runs one case.
pub fn run(renderer: &mut Renderer, technique: &'static str, case: &HardCase, effort: Effort) -> Outcome {
    let ours = figure(renderer, case, &case.ours, effort);
    let contrast = case.contrast.filter(|_| effort.contrasts).map(|contrast| {
        let found = figure(renderer, case, contrast.method(), effort);
        ContrastOutcome {
            printed: matches!(contrast, Contrast::Printed(_)),
            label: contrast.method().label,
            figure: found.as_ref().ok().map(|f| f.value),
            reason: found.err().map(|e| e.to_string()),
        }
    });
    let (verdict, reason) = match &ours {
        Err(e) if e.is_lack() => (Verdict::Skipped, Some(e.to_string())),
        Err(e) => (Verdict::Failed, Some(e.to_string())),
        Ok(f) if f.samples == 0 => (Verdict::Failed, Some("nothing was compared".to_owned())),
        Ok(f) if f.ambiguous as f64 > AMBIGUOUS * f.samples as f64 => {
            (Verdict::Failed, Some(format!("{} of {} samples are ambiguous: more than 2 %", f.ambiguous, f.samples)))
        }
        Ok(f) if f.value <= case.bound => (Verdict::Passed, None),
        Ok(_) => (Verdict::Failed, None),
    };
    let found = ours.unwrap_or_default();
    Outcome {
        name: case.name,
        trap: case.trap,
        technique,
        why: case.why,
        measured: case.measure.what(),
        unit: case.measure.unit(),
        bound: case.bound,
        ours: (found.samples > 0).then_some(found.value),
        samples: found.samples,
        ambiguous: found.ambiguous,
        contrast,
        verdict,
        reason,
    }
}

/// The figure of one method.
///
/// # Errors
/// [`CaseError`] if there is none.
pub fn figure(renderer: &mut Renderer, case: &HardCase, method: &Method, effort: Effort) -> Result<Figure, CaseError> {
    if let Some(change) = &method.shader {
        renderer.replace_shader(change.module, Some(changed_module(change)?));
    }
    let found = measure::Stand::new(renderer, case, method, effort).and_then(|mut stand| stand.measure());
    if let Some(change) = &method.shader {
        renderer.replace_shader(change.module, None);
    }
    found
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::scene::hard_case::Source;
    use crate::settings::Settings;

    #[test]
    fn cases_are_well_formed_and_their_names_differ() {
        let mut names = HashSet::new();
        for (technique, case) in all() {
            let name = case.name;
            assert!(names.insert(name), "{name} is there twice");
            assert!(case.why.len() > 80 && case.why.ends_with('.'), "{name}: one paragraph");
            assert!(case.bound >= 0.0 && case.size.iter().all(|s| *s <= 256), "{name}");
            let number = case.trap.strip_prefix('T').and_then(|n| n.parse::<u32>().ok());
            match number {
                Some(number) => assert!(name.starts_with(&format!("t{number:02}-")), "{name} is about {}", case.trap),
                None => assert!(case.trap.is_empty(), "{name}: {}", case.trap),
            }
            assert!(technique == "import" || technique.starts_with("passes/"));
            for method in [Some(&case.ours), case.contrast.as_ref().map(Contrast::method)].into_iter().flatten() {
                Settings::from_pairs(method.settings).unwrap_or_else(|e| panic!("{name}: {e}"));
                if let Some(change) = &method.shader {
                    changed_module(change).unwrap_or_else(|e| panic!("{name}: {e}"));
                }
            }
            assert!(case.ours.shader.is_none(), "{name}: ours is what is there");
            if let Source::Builtin(scene) | Source::Cut(scene, ..) = case.scene {
                let made_for_cases = scene.starts_with("builtin:hard/");
                assert!(made_for_cases || ["builtin:contact", "builtin:flow"].contains(&scene), "{name}");
            }
        }
    }

    #[test]
    fn every_trap_that_can_be_met_has_a_case() {
        let traps: HashSet<&str> = all().map(|(_, case)| case.trap).collect();
        for trap in (1..=19).chain(26..=31) {
            assert!(traps.contains(format!("T{trap}").as_str()), "T{trap} has no case");
        }
    }

    /// A technique is a module of `passes` that draws something: all but the plumbing that techniques share.
    #[test]
    fn every_technique_has_cases() {
        let plumbing = ["mod", "operators", "shaders", "store", "uniforms"];
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/passes");
        let modules: HashSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .filter(|module| !plumbing.contains(&module.as_str()))
            .collect();
        assert!(modules.len() >= 7, "{modules:?}");
        for module in modules {
            let room = ROOMS.iter().find(|r| r.technique == format!("passes/{module}"));
            assert!(room.is_some_and(|r| !r.cases.is_empty()), "src/passes/{module} declares no hard case");
        }
    }
}
