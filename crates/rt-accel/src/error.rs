//! Why a structure cannot be built, or does not fit its primitives.

use core::fmt;

use rt_math::Aabb;

/// Why no structure can be built over a set of primitives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// The bounds of a primitive are not a box: a corner is NaN, `min` exceeds `max`, or a side is infinite (or too
    /// large to be padded). An unbounded primitive must return `None` instead of an infinite box.
    BadBounds {
        /// Which primitive.
        index: u32,
        /// What its `bounds` returned.
        bounds: Aabb,
    },
    /// More primitives, cells or references to primitives than the structure can number.
    TooMany {
        /// How many there are.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
    /// The primitives are not those that a structure was built over, so that it cannot be fitted to them.
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
                } else {
                    "they are infinite; unbounded primitives return `None`"
                };
                write!(f, "primitive {index} has bounds from {min} to {max}: {reason}")
            }
            Self::TooMany { count, limit } => {
                write!(f, "{count} primitives, cells or references, but at most {limit} can be numbered")
            }
            Self::Changed(violation) => write!(f, "the structure does not belong to these primitives: {violation}"),
        }
    }
}

impl core::error::Error for BuildError {}

/// How a structure fails to fit a set of primitives. Structures straight from their builder never do; one that is
/// asked about primitives which have changed since may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValidationError {
    /// The structure was built over another number of primitives.
    Count {
        /// Number of primitives at build time.
        built: u32,
        /// Number of primitives now.
        given: usize,
    },
    /// A primitive cannot be found where its bounds put it: in no leaf or in several, missing in a cell that it
    /// overlaps, or bounded but kept in the list of unbounded ones (and the reverse).
    Misplaced {
        /// Which primitive.
        primitive: u32,
    },
    /// The own box of a primitive reaches out of a box above it.
    Outside {
        /// Which primitive.
        primitive: u32,
    },
    /// A box reaches out of the one above it, or a reference points nowhere.
    Node {
        /// Which node.
        node: u32,
    },
    /// A leaf lies too deep for the traversal stack.
    Depth {
        /// Depth of the leaf; the root has depth 0.
        depth: u32,
    },
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { built, given } => write!(f, "built over {built} primitives, but there are {given}"),
            Self::Misplaced { primitive } => write!(f, "primitive {primitive} is not where its bounds put it"),
            Self::Outside { primitive } => write!(f, "primitive {primitive} reaches out of a box above it"),
            Self::Node { node } => write!(f, "node {node} reaches out of its parent, or points nowhere"),
            Self::Depth { depth } => write!(f, "a leaf at depth {depth} overflows the traversal stack"),
        }
    }
}

impl core::error::Error for ValidationError {}
