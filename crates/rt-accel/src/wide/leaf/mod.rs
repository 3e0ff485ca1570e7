//! Leaves: copies of primitives for conservative tests, eight at a time.
//!
//! A leaf of n primitives is a block of 32-bit words, aligned to a cache line. It has a header, then each number of all
//! primitives (structure of arrays), then their indices, as words of `index_word`. Loads of eight numbers may read beyond a row;
//! these lanes are masked.

mod block;
mod boxes;
mod index_word;
mod kind;
mod leaves;
mod spheres;
mod triangles;

pub(super) use block::{CacheLine, Lane, LeafView, MAX_LEAF};
pub(super) use boxes::BOX_NUMBERS;
pub(super) use kind::{GeometryCounts, LeafKind};
pub(super) use leaves::{LeafOrder, LeafWriter, Leaves};
pub(super) use spheres::{SPHERE_HEADER, SPHERE_NUMBERS};
pub(super) use triangles::{
    TRIANGLE_HEADER, TRIANGLE_NUMBERS, coordinates, corner, load_coordinates, splat_coordinates,
};
