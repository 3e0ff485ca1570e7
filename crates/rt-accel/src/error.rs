//! Errors of building and of validation.

use core::fmt;

use rt_math::Aabb;

/// Error of [`Accelerator`](crate::Accelerator) builds: primitives over which no accelerator can be built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// The bounds of a primitive are not a box: a corner is NaN, `min` exceeds `max`, or a side is infinite. A side may
    /// also be too large to be padded. An unbounded primitive must return `None` instead of an infinite box.
    BadBounds {
        /// Index of the primitive.
        index: u32,
        /// Result of its `bounds`.
        bounds: Aabb,
    },
    /// More primitives, cells or references than indices.
    TooMany {
        /// Actual number.
        count: u64,
        /// Maximum number.
        limit: u64,
    },
    /// The accelerator was built over other primitives, and cannot be refitted to these.
    Changed(ValidationError),
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadBounds { index, bounds: Aabb { min, max } } => {
                let reason = if min.is_nan() || max.is_nan() {
                    "a corner is NaN"
                } else if min.cmpgt(*max).any() {
                    "min exceeds max"
                } else if min.is_finite() && max.is_finite() {
                    "their size overflows"
                } else {
                    "they are infinite; unbounded primitives return `None`"
                };
                let [min, max] = [min.to_array(), max.to_array()];
                write!(f, "primitive {index} has bounds from {min:?} to {max:?}: {reason}")
            }
            Self::TooMany { count, limit } => {
                write!(
                    f,
                    "{count} primitives, cells or references exceed the limit of {limit}; split the primitives into instances"
                )
            }
            Self::Changed(violation) => {
                write!(f, "the accelerator was built over other primitives: {violation}; build it again")
            }
        }
    }
}

impl core::error::Error for BuildError {}

/// Mismatch between an accelerator and a set of primitives. Occurs only if the primitives have changed since the
/// accelerator was built, or if it was damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValidationError {
    /// The accelerator was built over a different number of primitives.
    Count {
        /// Number of primitives at build time.
        built: u32,
        /// Number of primitives now.
        given: usize,
    },
    /// A primitive is not listed according to its bounds. It is in no leaf or in several, or missing in a cell that it
    /// overlaps. Or it is listed as unbounded although it is bounded, or the reverse.
    Misplaced {
        /// Index of the primitive.
        primitive: u32,
    },
    /// The padded bounds of a primitive exceed an enclosing box.
    Outside {
        /// Index of the primitive.
        primitive: u32,
    },
    /// A box exceeds that of its parent, or a reference is invalid.
    Node {
        /// Index of the node.
        node: u32,
    },
    /// A leaf lies too deep for the traversal stack.
    Depth {
        /// Depth of the leaf; the root has depth 0.
        depth: u32,
    },
    /// The list of triangles of a small tree does not match the tree or the primitives.
    List,
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { built, given } => write!(f, "built over {built} primitives, but there are {given}"),
            Self::Misplaced { primitive } => {
                write!(f, "primitive {primitive} is not listed in a cell that its bounds overlap")
            }
            Self::Outside { primitive } => write!(f, "primitive {primitive} exceeds the bounds of a node above it"),
            Self::Node { node } => {
                write!(f, "node {node} exceeds the bounds of its parent, or has an index out of range")
            }
            Self::Depth { depth } => write!(f, "a leaf at depth {depth} overflows the traversal stack"),
            Self::List => f.write_str("the list of triangles does not match the tree; build it again"),
        }
    }
}

impl core::error::Error for ValidationError {}
