//! Entry points of traversal, compiled for each output.

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

use super::WideBvh;
use super::batch::{BatchContext, BatchTraversal};
use super::query::Output;
use super::single_ray::{SingleContext, SingleTraversal};

/// Queries of a tree.
pub(super) trait TreeQuery: Output {
    /// Traces one ray through a tree. Compiled once here, and not in every crate that traces rays.
    fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval);

    /// Traces many rays through a tree.
    fn trace_batch(
        tree: &WideBvh,
        context: &mut BatchContext<'_, Self>,
        rays: &[(Ray, Interval)],
        outputs: &mut [Self],
    );
}

/// Entry points of a query, compiled for a concrete output.
macro_rules! entry_points {
    () => {
        #[inline(never)]
        fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval) {
            tree.level.dispatch(SingleTraversal { tree, context }, ray, span);
        }

        #[inline(never)]
        fn trace_batch(
            tree: &WideBvh,
            context: &mut BatchContext<'_, Self>,
            rays: &[(Ray, Interval)],
            outputs: &mut [Self],
        ) {
            tree.level.dispatch(BatchTraversal { tree, context }, rays, outputs);
        }
    };
}

impl TreeQuery for Option<Hit> {
    entry_points!();
}

impl TreeQuery for bool {
    entry_points!();
}
