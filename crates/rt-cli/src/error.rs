//! Why a command fails, and the exit code that says so to scripts.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use rt_camera::ImageFileError;
use rt_render::RenderError;
use rt_scene_io::LoadError;

use crate::output::OutputError;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The arguments do not fit together, or do not fit the scene.
    #[error("{0}")]
    Usage(String),
    /// The scene or model is bad.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The scene is sound piece by piece, but cannot be rendered.
    #[error("{}: {source}", file.display())]
    Plan {
        /// The scene.
        file: PathBuf,
        /// What is wrong with it.
        source: RenderError,
    },
    /// The image to develop is bad.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// There are warnings, and the user is strict.
    #[error("{}: {count} {}; mend the scene, or leave --strict out", file.display(), if *count == 1 { "warning" } else { "warnings" })]
    Warnings {
        /// The scene.
        file: PathBuf,
        /// How many.
        count: usize,
    },
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Standard output could not be written.
    #[error("standard output cannot be written: {0}")]
    Stdout(io::Error),
    /// The picture is complete, but some of it is not to be trusted, and the user is strict.
    #[error(
        "{bad_samples} of {samples} samples were NaN, infinite or negative and count as black; \
         the picture was written to {}", file.display()
    )]
    Damaged {
        /// Samples that came out bad.
        bad_samples: u64,
        /// Samples in all.
        samples: u64,
        /// The picture.
        file: PathBuf,
    },
}

impl Failure {
    /// A scene that cannot be rendered, or arguments that ask too much of it.
    pub(crate) fn plan(file: &std::path::Path, source: RenderError) -> Self {
        match source {
            // No scene can be the reason of these two.
            RenderError::Crop { .. } | RenderError::Threads(_) => Self::Usage(source.to_string()),
            source => Self::Plan { file: file.to_owned(), source },
        }
    }

    /// 2 usage, 3 bad input, 4 output could not be written, 5 finished but damaged.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Usage(_) => 2,
            Self::Load(_) | Self::Plan { .. } | Self::Image(_) | Self::Warnings { .. } => 3,
            Self::Output(_) | Self::Stdout(_) => 4,
            Self::Damaged { .. } => 5,
        })
    }
}
