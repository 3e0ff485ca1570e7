//! Errors of building and of validation.

use rt_math::Aabb;

/// Error of [`Accelerator`](crate::Accelerator) builds: primitives over which no accelerator can be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The bounds of a primitive are not a box: a corner is NaN, `min` exceeds `max`, or a side is infinite. A side may
    /// also be too large to be padded. An unbounded primitive must return `None` instead of an infinite box.
    #[error("primitive {index} has bounds from {:?} to {:?}: {}", bounds.min.to_array(), bounds.max.to_array(), defect(bounds))]
    BadBounds {
        /// Index of the primitive.
        index: u32,
        /// Result of its `bounds`.
        bounds: Aabb,
    },
    /// More primitives, cells or references than indices.
    #[error("{count} primitives, cells or references exceed the limit of {limit}; split the primitives into instances")]
    TooMany {
        /// Actual number.
        count: u64,
        /// Maximum number.
        limit: u64,
    },
    /// The accelerator was built over other primitives, and cannot be refitted to these.
    #[error("the accelerator was built over other primitives: {0}; build it again")]
    Changed(ValidationError),
}

/// Reason why bounds are not a box.
fn defect(Aabb { min, max }: &Aabb) -> &'static str {
    if min.is_nan() || max.is_nan() {
        "a corner is NaN"
    } else if min.cmpgt(*max).any() {
        "min exceeds max"
    } else if min.is_finite() && max.is_finite() {
        "their size overflows"
    } else {
        "they are infinite; unbounded primitives return `None`"
    }
}

/// Mismatch between an accelerator and a set of primitives. Occurs only if the primitives have changed since the
/// accelerator was built, or if it was damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ValidationError {
    /// The accelerator was built over a different number of primitives.
    #[error("built over {built} primitives, but there are {given}")]
    Count {
        /// Number of primitives at build time.
        built: u32,
        /// Number of primitives now.
        given: usize,
    },
    /// A primitive is not listed according to its bounds. It is in no leaf or in several, or missing in a cell that it
    /// overlaps. Or it is listed as unbounded although it is bounded, or the reverse.
    #[error("primitive {primitive} is not listed in a cell that its bounds overlap")]
    Misplaced {
        /// Index of the primitive.
        primitive: u32,
    },
    /// The padded bounds of a primitive exceed an enclosing box.
    #[error("primitive {primitive} exceeds the bounds of a node above it")]
    Outside {
        /// Index of the primitive.
        primitive: u32,
    },
    /// A box exceeds that of its parent, or a reference is invalid.
    #[error("node {node} exceeds the bounds of its parent, or has an index out of range")]
    Node {
        /// Index of the node.
        node: u32,
    },
    /// A leaf lies too deep for the traversal stack.
    #[error("a leaf at depth {depth} overflows the traversal stack")]
    Depth {
        /// Depth of the leaf; the root has depth 0.
        depth: u32,
    },
    /// The list of triangles of a small tree does not match the tree or the primitives.
    #[error("the list of triangles does not match the tree; build it again")]
    List,
}
