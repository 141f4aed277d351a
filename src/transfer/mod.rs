//! Transfer functions: colour over curvature (1D), opacity over depth and absolute curvature (2D).
use serde::{Deserialize, Serialize};

/// Where transfer functions come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TransferSource {
    /// A name from `transfer_functions/`, or a path.
    Named(String),
}

impl Default for TransferSource {
    fn default() -> TransferSource {
        TransferSource::Named("pellucid".to_owned())
    }
}
