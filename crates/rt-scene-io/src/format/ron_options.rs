//! RON as scene files use it.

use ron::extensions::Extensions;

use crate::limits::NESTING;

/// The limit that RON's parser needs for it: it counts each bracket twice.
const RON_RECURSION_LIMIT: usize = NESTING * 2;

/// RON as scene files use it: optional values are written without `Some`.
pub(super) fn ron_options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).with_recursion_limit(RON_RECURSION_LIMIT)
}
