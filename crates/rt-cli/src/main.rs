//! # rt-cli: the command line
//!
//! ```text
//!   arguments ──> scene ──> settings ──> RenderPlan ──> Image ──> file, written atomically
//!                   │                       │             │
//!                 notes                  explain     statistics, progress
//! ```
//!
//! ```text
//! rt-cli                                  renders the built-in scene to still_life.png
//! rt-cli scene.ron                        same as rt-cli render scene.ron
//! rt-cli render scene.ron -o image.exr    also reads .json, .gltf, .glb, .obj, .nff, .pbrt, .ply, .stl; writes .png, .jpg, .hdr, .pfm
//! rt-cli view scene.ron                   interactive view in the browser
//! rt-cli explain scene.ron                prints the render plan: used and removed features, with reasons
//! rt-cli check scene.ron                  checks the numerical health of a scene
//! rt-cli merge *.part -o image.exr        merges the shards of a distributed render
//! rt-cli compare a.exr b.exr              measures the difference of two images
//! rt-cli converge scene.ron --vary ...    measures error against run time
//! rt-cli --help                           lists all commands
//! ```
//!
//! **Owns** arguments, settings, progress, reports, exit codes, checkpoints, and atomic output files.
//! **Does not own** anything that computes pixels: that is in the libraries.

#![forbid(unsafe_code)]

mod aov_file;
mod args;
mod artifact_error;
mod atomic_write;
mod checkpoint_format;
mod checkpointer;
mod commands;
mod console;
#[cfg_attr(not(feature = "display"), path = "no_display.rs")]
mod display;
mod done_frames;
mod empty_image;
mod error;
mod frame_log;
mod identity;
mod image_file;
mod input;
mod job;
mod memory;
mod output_error;
mod output_file;
mod processor;
mod progress;
mod render_observer;
mod report;
mod saved_checkpoint;
mod settings;
mod signals;
mod stats;
mod stdin;

use std::process::ExitCode;

fn main() -> ExitCode {
    signals::report_file_size_limit();
    let result = match args::parse(std::env::args_os()) {
        Ok(cli) => commands::run(cli),
        Err(error) if error.use_stderr() => error.exit(),
        // A help page or the version. clap ignores that it cannot be written.
        Err(error) => console::flushed(error.print()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console::print_error(&failure);
            failure.exit_code()
        }
    }
}
