//! Why a command fails, and the exit code that says so to scripts.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use rt_camera::ImageFileError;
use rt_camera::metrics::PairError;
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
    /// An image is bad.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// Two images cannot be compared.
    #[error("{} and {}: {source}", test.display(), reference.display())]
    Pair {
        /// The image under test.
        test: PathBuf,
        /// What it is compared with.
        reference: PathBuf,
        /// Why they cannot.
        source: PairError,
    },
    /// Two images are not equal enough.
    #[error("{} and {} differ: {}", test.display(), reference.display(), difference(metric, *value, *threshold, *not_finite))]
    Different {
        /// The image under test.
        test: PathBuf,
        /// What it is compared with.
        reference: PathBuf,
        /// Name of the metric that was asked for.
        metric: &'static str,
        /// Its value.
        value: f64,
        /// What it was allowed to be.
        threshold: f64,
        /// Pixels that are NaN or infinite in one of the images and not the same in the other.
        not_finite: u64,
    },
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
            // No scene can be the reason of these.
            RenderError::Crop { .. }
            | RenderError::Threads(_)
            | RenderError::SamePasses(_)
            | RenderError::Adaptive(_)
            | RenderError::AdaptiveLens
            | RenderError::AdaptiveMotion
            | RenderError::AdaptiveUntil => Self::Usage(source.to_string()),
            source => Self::Plan { file: file.to_owned(), source },
        }
    }

    /// 1 difference found, 2 usage, 3 bad input, 4 output could not be written, 5 finished but damaged.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Different { .. } => 1,
            Self::Usage(_) => 2,
            Self::Load(_) | Self::Plan { .. } | Self::Image(_) | Self::Pair { .. } | Self::Warnings { .. } => 3,
            Self::Output(_) | Self::Stdout(_) => 4,
            Self::Damaged { .. } => 5,
        })
    }
}

/// What speaks against two images.
fn difference(metric: &str, value: f64, threshold: f64, not_finite: u64) -> String {
    match not_finite {
        0 => format!("{metric} is {value}, and {threshold} is allowed"),
        1 => "a pixel is NaN or infinite in one of them and not the same in the other".to_owned(),
        n => format!("{n} pixels are NaN or infinite in one of them and not the same in the other"),
    }
}
