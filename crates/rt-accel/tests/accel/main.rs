//! Tests of all accelerators and ready-made scenes, in one program: each program of its own would compile the kernels again.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and print what they tried")]

#[macro_use]
mod streams;

mod degenerate;
mod differential;
mod distant_instances;
mod field_cases;
mod grazing_rays;
mod lazy;
mod queries;
mod refit;
#[cfg(feature = "serde")]
mod saved;
mod scene;
mod scene_updates;
mod soup;
