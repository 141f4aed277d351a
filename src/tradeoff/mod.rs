//! What accuracy costs and where it holds: the hard cases.

pub mod hard_cases;
