//! Models that a scene includes.

use std::collections::HashMap;

use crate::{Model, SceneNode};

/// Model files by reference, each loaded once.
#[derive(Default)]
pub(super) struct Models {
    /// Loaded beforehand.
    pub(super) at_hand: HashMap<String, Model>,
    /// The trees of models whose other parts are in the scene; `None` for one that could not be loaded.
    pub(super) trees: HashMap<String, Option<Vec<SceneNode>>>,
}

impl Models {
    /// A model that need not be loaded any more, by its reference.
    pub(super) fn at_hand(model: Option<(String, Model)>) -> Self {
        Self { at_hand: model.into_iter().collect(), ..Self::default() }
    }
}
