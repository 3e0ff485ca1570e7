//! Tests that need most crates of the workspace, in one program.

mod determinism;
mod explain;
mod scene_health;
mod skipping;
