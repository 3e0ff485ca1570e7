//! Tests that need most crates of the workspace, in one program.

mod explain;
mod path_reference;
mod scene_health;
mod skipping;
