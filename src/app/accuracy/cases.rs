//! A hard case in the window: ours right of the divider, what fails left of it, as far as a divider can show that.
//!
//! Under the divider both sides have one model, camera and arrangement. So a contrast that differs in settings or in a shader
//! (an error planted into ours) is shown; one that differs in geometry is not, and the window says so.

use std::sync::Arc;

use super::Workspace;
use crate::app::compare::Compare;
use crate::app::pictures::Against;
use crate::app::watch::ShaderTexts;
use crate::scene::hard_case::{Contrast, HardCase, Method, Source};
use crate::settings::Settings;
use crate::tradeoff::hard_cases::changed_module;
use crate::transfer::TransferSource;

/// A hard case, for show.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseShown {
    /// Its name.
    pub name: &'static str,
    /// Why it is hard.
    pub why: &'static str,
    /// What is measured, and what it must not exceed.
    pub bound: String,
    /// The size at which it is measured, pixels.
    pub size: [u32; 2],
    /// What is left of the divider, or why nothing is.
    pub contrast: Result<String, String>,
}

/// What a contrast is, in words.
fn words(contrast: &Contrast) -> String {
    match contrast {
        Contrast::Printed(method) => format!("as printed: {}", method.label),
        Contrast::Planted(method) => format!("with an error planted: {}", method.label),
    }
}

/// The geometry that a method is drawn over, if that is not the case's.
fn same_geometry(case: &HardCase, method: &Method) -> bool {
    let named = |method: &Method| match method.scene.unwrap_or(case.scene) {
        Source::Builtin(name) => Some((0, name, None)),
        Source::Cut(name, normal, offset) => Some((1, name, Some((normal, offset)))),
        Source::ThroughFile(name) => Some((2, name, None)),
        Source::Bytes(_) => None,
    };
    let neither = case.ours.scene.is_none() && method.scene.is_none();
    neither || (named(&case.ours).is_some() && named(&case.ours) == named(method))
}

/// The settings and shaders of a contrast, or why it cannot be shown.
fn against(case: &HardCase) -> Result<(String, Settings, Option<ShaderTexts>), String> {
    let contrast =
        case.contrast.as_ref().ok_or("This case has nothing that fails: ours is held to its bound alone.")?;
    let method = contrast.method();
    if !same_geometry(case, method) {
        return Err(format!(
            "What fails ({}) is drawn over other geometry, which a divider over one model cannot show.",
            words(contrast)
        ));
    }
    let settings = Settings::from_pairs(method.settings).map_err(|e| e.to_string())?;
    let shaders = method
        .shader
        .as_ref()
        .map(|change| changed_module(change).map(|text| ShaderTexts::from([(change.module.to_owned(), text)])));
    let shaders = shaders.transpose().map_err(|e| e.to_string())?;
    let ours = Settings::from_pairs(case.ours.settings).map_err(|e| e.to_string())?;
    if settings == ours && shaders.is_none() {
        return Err(format!("What fails ({}) has the settings of ours: a picture does not show it.", words(contrast)));
    }
    Ok((words(contrast), settings, shaders))
}

impl Workspace {
    /// Puts what fails in a hard case left of the divider.
    pub fn show_case(&mut self, case: &'static HardCase) {
        // Not what failed in another case.
        self.end_case();
        let shown = against(case).and_then(|(words, settings, shaders)| {
            let source: &TransferSource = &settings.opacity.transfer;
            let transfer = self.functions.of(source)?;
            let kept = Against { settings, transfer, shaders: shaders.map(Arc::new) };
            let left = words.split(':').next().unwrap_or(&words).to_owned();
            let names = Some([left, "ours".to_owned()]);
            self.compare = Some(Compare { names, ..Compare::with(kept) });
            Ok(words)
        });
        let bound = format!("{}: at most {}", case.measure.what(), case.bound);
        self.accuracy.case = Some(CaseShown {
            name: case.name,
            why: case.why,
            bound: bound + case.measure.unit(),
            size: case.size,
            contrast: shown,
        });
    }

    /// Ends the comparison of a hard case when another model is opened.
    pub fn end_case(&mut self) {
        if self.compare.as_ref().is_some_and(|c| c.names.is_some()) {
            self.compare = None;
        }
        self.accuracy.case = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::hard_cases;

    #[test]
    fn every_case_shows_its_contrast_or_says_why_not() {
        let (mut shown, mut said) = (0, 0);
        for (_, case) in hard_cases::all() {
            match against(case) {
                Ok((words, settings, shaders)) => {
                    shown += 1;
                    let contrast = case.contrast.unwrap();
                    assert!(words.contains(contrast.method().label), "{words}");
                    assert_eq!(settings, Settings::from_pairs(contrast.method().settings).unwrap());
                    assert_eq!(shaders.is_some(), contrast.method().shader.is_some(), "{}", case.name);
                }
                Err(reason) => {
                    said += 1;
                    println!("{}: {reason}", case.name);
                    let other = case.contrast.is_some_and(|c| c.method().scene.is_some() || case.ours.scene.is_some());
                    let same = case.contrast.is_some_and(|c| c.method().settings == case.ours.settings);
                    assert!(other || same || case.contrast.is_none(), "{}: {reason}", case.name);
                }
            }
        }
        println!("{shown} shown, {said} not");
        assert!(shown > said, "{shown} shown, {said} not");
    }
}
