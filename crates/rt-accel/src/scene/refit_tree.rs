//! Trees that are refitted to changed primitives, or rebuilt.

use rt_geometry::Primitives;

use crate::wide::BuildParams;
use crate::{Accelerator, BuildError, WideBvh};

/// Cost of a refitted tree by the surface area heuristic, relative to when it was built, above which it is built anew.
const MAX_DEGRADATION: f64 = 1.5;

/// A tree that is refitted to changed primitives, and rebuilt once its cost exceeds [`MAX_DEGRADATION`] times the original.
#[derive(Clone, Debug)]
pub(super) struct RefitTree {
    pub(super) bvh: WideBvh,
    /// Its cost when it was built; `None` if it was not refitted since.
    built_cost: Option<f64>,
}

impl RefitTree {
    pub(super) fn build(primitives: &impl Primitives, params: &BuildParams) -> Result<Self, BuildError> {
        Ok(Self { bvh: WideBvh::build_with(primitives, params)?, built_cost: None })
    }

    /// The tree of as many changed primitives. It is refitted, or built anew if its cost would exceed [`MAX_DEGRADATION`] or
    /// if its leaves do not suit the primitives any more.
    pub(super) fn refitted(mut self, primitives: &impl Primitives, params: &BuildParams) -> Result<Self, BuildError> {
        let built_cost = self.built_cost.or_else(|| self.bvh.build_stats().sah_cost);
        let is_refitted = self.bvh.refit_leaves_of_same_kind(primitives)?;
        match (self.bvh.build_stats().sah_cost, built_cost) {
            (Some(cost), Some(built)) if is_refitted && cost <= MAX_DEGRADATION * built => {
                Ok(Self { built_cost, ..self })
            }
            _ => Self::build(primitives, params),
        }
    }
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit};

    use super::*;
    use crate::TriangleMesh;

    /// Triangles whose vertices are exact in single precision, or not.
    fn mesh(is_exact: bool) -> TriangleMesh<'static> {
        let number = |i: u64| (unit(hash(&[1, i])) * 4096.0).round() / 4096.0 + if is_exact { 0.0 } else { 1e-12 };
        let vertices: Vec<[f64; 3]> = (0..600).map(|i| [0, 1, 2].map(|axis| number(3 * i + axis))).collect();
        TriangleMesh::new(vertices, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect::<Vec<_>>())
            .expect("a mesh")
    }

    #[test]
    fn a_change_of_the_kind_of_leaves_keeps_the_build_parameters() {
        let (exact, wide) = (mesh(true), mesh(false));
        let [fast, high] = [BuildParams::FAST, BuildParams::HIGH].map(|params| WideBvh::build_with(&wide, &params));
        assert_ne!(fast, high, "parameters make no difference");
        for params in [BuildParams::FAST, BuildParams::BALANCED, BuildParams::HIGH] {
            let refitted = RefitTree::build(&exact, &params).and_then(|tree| tree.refitted(&wide, &params));
            let expected = WideBvh::build_with(&wide, &params).expect("a tree");
            assert_eq!(refitted.expect("a tree").bvh, expected, "{params:?}");
        }
        let params = BuildParams::HIGH;
        let again = RefitTree::build(&exact, &params).and_then(|tree| tree.refitted(&exact, &params)).expect("a tree");
        assert!(again.built_cost.is_some(), "equal primitives need no new tree");
    }
}
