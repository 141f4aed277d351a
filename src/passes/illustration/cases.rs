//! The hard cases of illustrative transparency.

use crate::scene::hard_case::HardCase;

/// Cases of illustrative transparency.
pub const CASES: &[HardCase] = &[];
