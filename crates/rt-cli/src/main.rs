//! # rt-cli: the command line
//!
//! ```text
//!   arguments ──> Scene ──> RenderPlan ──> Image ──> file, whole or not at all
//!                   │            │           │
//!                   notes     explain    statistics, progress
//! ```
//!
//! ```text
//! rt-cli                                  renders a built-in scene to showcase.png
//! rt-cli scene.ron                        the same as rt-cli render scene.ron
//! rt-cli render scene.ron -o picture.exr  also .json, .gltf, .glb, .obj, .nff, .pbrt, .ply, .stl; and .png, .jpg, .hdr, .pfm
//! rt-cli view scene.ron                   the scene in the browser
//! rt-cli explain scene.ron                what a render uses, what it leaves out, and why
//! rt-cli check scene.ron                  what may lose digits, and what is probably not meant
//! rt-cli merge *.part -o picture.exr      the picture of all parts that machines have rendered
//! rt-cli compare a.exr b.exr              how much two pictures differ
//! rt-cli converge scene.ron --vary ...    which method reaches an error first
//! rt-cli --help                           what else there is
//! ```
//!
//! **Owns** arguments, progress, reports, exit codes, and the care taken of files.
//! **Does not own** anything that decides what a picture looks like: that is in the libraries.

#![forbid(unsafe_code)]

mod aov_file;
mod args;
mod checkpoints;
mod commands;
mod console;
#[cfg_attr(not(feature = "display"), path = "no_display.rs")]
mod display;
mod done_frames;
mod empty_picture;
mod error;
mod frame_log;
mod identity;
mod input;
mod interruption;
mod job;
mod kept_file;
mod memory;
mod output;
mod overrides;
mod picture_file;
mod processor;
mod progress;
mod report;
mod stats;
mod stdin;
mod watcher;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match commands::run(args::Cli::parse_from(args::with_default_command(std::env::args_os()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console::complain(&failure);
            failure.exit_code()
        }
    }
}
