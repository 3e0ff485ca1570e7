//! Memory of loading: an estimate before a file is read, an account of the bytes held, and the error beyond the budget.

#[cfg(feature = "format")]
mod budget;
mod error;
#[cfg(feature = "format")]
mod estimate;
#[cfg(any(feature = "gltf", feature = "nff", feature = "obj", feature = "pbrt", feature = "ply", feature = "stl"))]
mod load_within_budget;

#[cfg(feature = "format")]
pub use budget::MemoryBudget;
#[cfg(feature = "format")]
pub(crate) use budget::Reservation;
pub use error::MemoryError;
#[cfg(feature = "format")]
pub(crate) use estimate::{reserve_scene, tree_bytes};
#[cfg(any(
    feature = "gltf",
    feature = "nff",
    feature = "obj",
    feature = "pbrt",
    feature = "ply",
    feature = "stl"
))]
pub(crate) use {estimate::FileSample, load_within_budget::load_within_budget};
