//! Tests of files and what is read from them, in one program.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "all of this is tests, which say what they tried")]

#[cfg(feature = "format")]
mod animated;
#[cfg(feature = "format")]
mod bad_input;
#[cfg(all(feature = "gltf", feature = "nff", feature = "obj", feature = "pbrt", feature = "ply", feature = "stl"))]
mod damaged_files;
#[cfg(feature = "format")]
mod friendly;
#[cfg(feature = "gltf")]
mod gltf_files;
#[cfg(feature = "obj")]
mod models;
#[cfg(feature = "nff")]
mod nff_files;
#[cfg(feature = "obj")]
mod obj_files;
#[cfg(feature = "format")]
mod resolved;
#[cfg(all(feature = "gltf", feature = "nff", feature = "obj", feature = "pbrt", feature = "ply", feature = "stl"))]
mod strictness;
