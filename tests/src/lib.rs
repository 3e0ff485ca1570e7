//! # rt-tests: what the crates are tried with
//!
//! ```text
//!   tests/tests ──┐
//!                 ├── rt-tests: shapes, meshes, scenes, and rays that look for the seams
//!   xtask ────────┘
//! ```
//!
//! **Owns** generators of shapes, meshes, scenes and rays for tests and tasks of several crates, lists of test files, and
//! the reports of skipped tests. Tests of the whole workspace are in the folder `tests`. **Does not own** expected values: those are
//! in the tests.
//!
//! ```
//! use rt_tests::{Draw, icosphere};
//!
//! let (vertices, triangles) = icosphere(2);
//! assert_eq!((vertices.len(), triangles.len()), (162, 320));
//! assert_eq!(Draw::new(7).point(), Draw::new(7).point());
//! ```

#![forbid(unsafe_code)]

mod draw;
mod files_below;
mod icosphere;
mod moved;
mod seams;
mod shape_set;
mod skip;
mod spawned;

pub use draw::Draw;
pub use files_below::files_below;
pub use icosphere::icosphere;
pub use moved::moved;
pub use seams::{Seams, span_at};
pub use shape_set::{ShapeKind, ShapeSet};
pub use skip::{
    REQUIRE_ALL, SHARED, SKIPPED, report_skipped, requires_all, shared, shared_or_skip, skip, skipped_file,
};
pub use spawned::{SpawnSetup, Spawned, spawn_setups};

/// The library example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
