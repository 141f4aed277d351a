//! stub
use crate::scene::Scene;
pub(super) fn scene() -> Scene { Scene::default() }
