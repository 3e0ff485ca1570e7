//! Tests that need most crates of the workspace, in one program.

#![allow(clippy::print_stdout, reason = "tests say what they found")]

mod determinism;
mod explain;
mod reference;
mod scene_health;
mod skipping;
mod spawned_rays;
