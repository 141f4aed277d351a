//! Hard cases can fail: every contrast breaks its case's bound, and a case that is drawn by its contrast fails.

use pellucid::scene::hard_case::HardCase;
use pellucid::tradeoff::hard_cases::{self, Effort, Verdict};

use crate::common::*;

/// One picture of random scenes is enough here.
const SHORT: Effort = Effort { random_scenes: 256, contrasts: true };

#[test]
fn every_case_passes_and_its_contrast_breaks_its_bound() {
    let Some(mut r) = renderer() else { return };
    let mut without = Vec::new();
    for (technique, case) in hard_cases::all() {
        let outcome = hard_cases::run(&mut r, technique, case, SHORT);
        assert_eq!(outcome.verdict, Verdict::Passed, "{outcome:?}");
        match &outcome.contrast {
            Some(contrast) => assert!(contrast.is_caught(case.bound), "{} proves nothing: {outcome:?}", case.name),
            None => without.push(case.name),
        }
    }
    assert!(without.is_empty(), "nothing shows that these can fail: {without:?}");
}

#[test]
fn a_case_drawn_by_its_contrast_fails() {
    let Some(mut r) = renderer() else { return };
    for name in ["t01-equal-keys", "t03-two-geometry-passes", "t04-70000-parts", "t09-normals", "random-scenes"] {
        let (technique, case) = hard_cases::all().find(|(_, case)| case.name == name).expect("a case");
        let ours = *case.contrast.expect("a contrast").method();
        let wrong = HardCase { ours, contrast: None, ..*case };
        let outcome = hard_cases::run(&mut r, technique, &wrong, SHORT);
        assert_eq!(outcome.verdict, Verdict::Failed, "{outcome:?}");
        // The planted change is gone afterwards.
        let again = hard_cases::run(&mut r, technique, case, Effort { contrasts: false, ..SHORT });
        assert_eq!(again.verdict, Verdict::Passed, "{again:?}");
    }
}

#[test]
fn what_the_adapter_lacks_is_skipped_with_its_reason() {
    let Some(mut small) = small_renderer() else { return };
    let (technique, case) = hard_cases::all().find(|(_, case)| case.name == "k-of-64").expect("a case");
    // A store that takes several bands, and a row of pixels that fits no band.
    for (size, reason) in [([128, 32], "bands"), ([512, 8], "a binding holds")] {
        let outcome = hard_cases::run(&mut small, technique, &HardCase { size, contrast: None, ..*case }, SHORT);
        assert_eq!(outcome.verdict, Verdict::Skipped, "{outcome:?}");
        assert!(outcome.reason.as_ref().is_some_and(|r| r.contains(reason)), "{outcome:?}");
    }
}
