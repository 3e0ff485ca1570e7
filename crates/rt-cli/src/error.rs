//! Why a command fails, and the exit code that says so to scripts.

use std::io;
#[cfg(feature = "view")]
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use rt_image::{ImageFileError, metrics::PairError};
use rt_render::RenderError;
use rt_scene_io::{LoadError, MemoryError};

use crate::interruption;
use crate::kept_file::KeptError;
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
    /// What is to be read needs more memory than is allowed.
    #[error("{}: {shortage}", file.display())]
    Memory {
        /// The file, or the first of them.
        file: PathBuf,
        /// How much more.
        shortage: MemoryError,
    },
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
    #[error("{} and {} differ: {}", test.display(), reference.display(), difference(metric, *value, *threshold, *non_finite))]
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
        non_finite: u64,
    },
    /// There are warnings, and the user is strict.
    #[error("{}: {count} {}; mend the scene, or leave --strict out", file.display(), if *count == 1 { "warning" } else { "warnings" })]
    Warnings {
        /// The scene.
        file: PathBuf,
        /// How many.
        count: usize,
    },
    /// A frame of an animation failed; those before it are done.
    #[error("frame {frame}: {source}")]
    Frame {
        /// Its number.
        frame: u32,
        /// Why.
        source: Box<Self>,
    },
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Files could not be written: one line for each.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Outputs(Vec<OutputError>),
    /// A checkpoint or a part is bad.
    #[error(transparent)]
    Kept(#[from] KeptError),
    /// Parts do not make a picture.
    #[error("{0}; nothing was written")]
    Join(String),
    /// The render was interrupted.
    #[error("interrupted after {percent:.1} % of the samples; {}{}", saved(.picture.as_deref()), goes_on(.checkpoint))]
    Interrupted {
        /// How far it has come.
        percent: f64,
        /// The picture so far.
        picture: Option<PathBuf>,
        /// Where the checkpoint is, or why it is nowhere.
        checkpoint: Option<Result<PathBuf, String>>,
    },
    /// A worker has failed, by a defect of the program.
    #[error(
        "a defect of this program cost {tiles} of the tiles, which are black or noisy; please report it with the scene; {}{}",
        saved(.picture.as_deref()), tries_again(.checkpoint)
    )]
    Lost {
        /// How many.
        tiles: usize,
        /// The picture.
        picture: Option<PathBuf>,
        /// Where the checkpoint of the others is, or why it is nowhere.
        checkpoint: Option<Result<PathBuf, String>>,
    },
    /// The server of `view` cannot listen.
    #[cfg(feature = "view")]
    #[error("cannot listen on {0}: {1}; choose another --port or --bind")]
    Server(SocketAddr, io::Error),
    /// Standard output could not be written.
    #[error("standard output cannot be written: {0}")]
    Stdout(io::Error),
    /// The picture is complete, but shows nothing, and the user is strict.
    #[error("{warning}; the picture was written to {}", file.display())]
    Empty {
        /// What is odd about it, and why.
        warning: String,
        /// The picture.
        file: PathBuf,
    },
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
            | RenderError::AdaptiveUntil
            | RenderError::SharedUntil => Self::Usage(source.to_string()),
            source => Self::Plan { file: file.to_owned(), source },
        }
    }

    /// 1 difference found, 2 usage, 3 bad input, 4 output could not be written, 5 finished but damaged, 130
    /// interrupted.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Frame { source, .. } => return source.exit_code(),
            Self::Different { .. } => 1,
            Self::Usage(_) => 2,
            Self::Load(_) | Self::Plan { .. } | Self::Image(_) | Self::Pair { .. } | Self::Warnings { .. } => 3,
            Self::Kept(_) | Self::Join(_) | Self::Memory { .. } => 3,
            Self::Output(_) | Self::Outputs(_) | Self::Stdout(_) => 4,
            #[cfg(feature = "view")]
            Self::Server(..) => 4,
            Self::Damaged { .. } | Self::Empty { .. } | Self::Lost { .. } => 5,
            Self::Interrupted { .. } => interruption::EXIT_CODE,
        })
    }
}

/// Where the picture is.
fn saved(picture: Option<&std::path::Path>) -> String {
    picture.map_or_else(
        || "no picture was written".to_owned(),
        |file| format!("the picture was written to {}", file.display()),
    )
}

/// How an interrupted render goes on.
fn goes_on(checkpoint: &Option<Result<PathBuf, String>>) -> String {
    match checkpoint {
        Some(Ok(file)) => format!("; --resume goes on from {}", file.display()),
        Some(Err(reason)) => format!("; it cannot go on, as no checkpoint could be written: {reason}"),
        None => String::new(),
    }
}

/// How tiles that were lost can be had.
fn tries_again(checkpoint: &Option<Result<PathBuf, String>>) -> String {
    match checkpoint {
        Some(Ok(file)) => format!("; --resume tries them again, from {}", file.display()),
        _ => String::new(),
    }
}

/// What speaks against two images.
fn difference(metric: &str, value: f64, threshold: f64, non_finite: u64) -> String {
    match non_finite {
        0 => format!("{metric} is {value}, and {threshold} is allowed"),
        1 => "a pixel is NaN or infinite in one of them and not the same in the other".to_owned(),
        n => format!("{n} pixels are NaN or infinite in one of them and not the same in the other"),
    }
}
