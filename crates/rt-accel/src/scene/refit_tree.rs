//! Trees that follow changes.

use rt_geometry::Primitives;

use crate::wide::BuildParams;
use crate::{Accelerator, BuildError, Refit as _, WideBvh};

/// Cost of a refitted tree by the surface area heuristic, relative to when it was built, above which it is built anew.
const MAX_DEGRADATION: f64 = 1.5;

/// A tree that is refitted to changed primitives as long as that leaves it efficient.
#[derive(Clone, Debug)]
pub(super) struct RefitTree {
    pub(super) tree: WideBvh,
    /// Its cost when it was built; `None` if it was not refitted since.
    built_cost: Option<f64>,
}

impl RefitTree {
    pub(super) fn build(primitives: &impl Primitives, params: &BuildParams) -> Result<Self, BuildError> {
        Ok(Self { tree: WideBvh::build_with(primitives, params)?, built_cost: None })
    }

    /// The tree of as many changed primitives: refitted, or built anew if its cost exceeds [`MAX_DEGRADATION`].
    pub(super) fn refitted(mut self, primitives: &impl Primitives, params: &BuildParams) -> Result<Self, BuildError> {
        let cost = |tree: &WideBvh| tree.build_stats().sah_cost;
        let Some(built_cost) = self.built_cost.or_else(|| cost(&self.tree)) else {
            return Self::build(primitives, params);
        };
        self.tree.refit(primitives)?;
        if cost(&self.tree).is_some_and(|cost| cost <= MAX_DEGRADATION * built_cost) {
            Ok(Self { built_cost: Some(built_cost), ..self })
        } else {
            Self::build(primitives, params)
        }
    }
}
