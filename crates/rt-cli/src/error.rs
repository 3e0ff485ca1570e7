//! Errors of the commands, and their exit codes.

use std::io;
#[cfg(feature = "view")]
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use rt_image::{ImageFileError, metrics::PairError};
use rt_render::RenderError;
use rt_scene_io::{LoadError, MemoryError};

use crate::artifact_error::ArtifactError;
use crate::output_error::OutputError;
use crate::saved_checkpoint::SavedCheckpoint;

/// Exit code of an interrupted command: 128 + SIGINT, as in shells.
pub(crate) const INTERRUPTED_EXIT_CODE: u8 = 130;

#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// The arguments do not fit together, or do not fit the scene.
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A valid scene that cannot be rendered.
    #[error("{}: {source}", file.display())]
    Plan { file: PathBuf, source: RenderError },
    #[error(transparent)]
    Image(#[from] ImageFileError),
    #[error("{}: {cause}", file.display())]
    Memory { file: PathBuf, cause: MemoryError },
    /// Two images cannot be compared.
    #[error("{} and {}: {source}", test.display(), reference.display())]
    Pair { test: PathBuf, reference: PathBuf, source: PairError },
    /// Two images are not equal enough.
    #[error("{} and {} differ: {}", test.display(), reference.display(), difference(metric, value, *threshold, *non_finite))]
    Different {
        test: PathBuf,
        reference: PathBuf,
        metric: String,
        /// Value with the digits of the report.
        value: String,
        threshold: f64,
        /// Pixels that are NaN or infinite in one of the images and not the same in the other.
        non_finite: u64,
    },
    /// Warnings with `--strict`.
    #[error("{}: {count} {}; fix the scene, or remove --strict", file.display(), if *count == 1 { "warning" } else { "warnings" })]
    Warnings { file: PathBuf, count: usize },
    /// A frame of an animation failed; earlier ones are finished.
    #[error("frame {frame}: {source}{}", single_frame(*frame, source))]
    Frame { frame: u32, source: Box<Self> },
    #[error(transparent)]
    Output(#[from] OutputError),
    /// One line per file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Outputs(Vec<OutputError>),
    #[error(transparent)]
    Artifact(#[from] ArtifactError),
    /// The shards do not make an image.
    #[error("{0}; nothing was written")]
    Join(String),
    #[error("interrupted after {after}; {}{}", saved(.image.as_deref()), resumption(.checkpoint))]
    Interrupted {
        /// Work done so far.
        after: String,
        image: Option<PathBuf>,
        /// Its checkpoint, or the reason why there is none.
        checkpoint: Option<Result<SavedCheckpoint, String>>,
    },
    /// An interrupt before the first sample.
    #[error(
        "interrupted while the scene was loaded: no image was written; {}",
        if *has_frames { "--resume continues the frames that are not finished" } else { "run the command again" }
    )]
    InterruptedLoading {
        /// True if this run has finished frames.
        has_frames: bool,
    },
    /// An interrupt after the previous frame was finished.
    #[error("interrupted before it was begun; --resume continues the frames that are not finished")]
    InterruptedBetweenFrames,
    /// An interrupt before any tile or pass was finished.
    #[error(
        "interrupted before the first {unit} was finished: no image was written, and older files are unchanged{}{}",
        resumption(.checkpoint), if *can_take_time { "; with --time, passes are finished sooner" } else { "" }
    )]
    NothingFinished {
        /// "tile" or "pass".
        unit: &'static str,
        /// True if `--time` would render in passes instead.
        can_take_time: bool,
        /// Its checkpoint, or the reason why there is none.
        checkpoint: Option<Result<SavedCheckpoint, String>>,
    },
    /// An interrupt within a render of `converge`, which reports [`MeasurementInterrupted`](Self::MeasurementInterrupted) instead.
    #[error("interrupted during a render")]
    RenderInterrupted,
    /// An interrupt of `converge`.
    #[error("interrupted after {measured} of {planned} sample counts; {}", measurements(*measured, folder))]
    MeasurementInterrupted { measured: usize, planned: usize, folder: PathBuf },
    /// A panic in a worker thread.
    #[error(
        "internal error: {tiles} tiles failed and are black or incomplete; please report this bug and attach the scene; {}{}",
        saved(.image.as_deref()), retry(.checkpoint)
    )]
    Lost { tiles: usize, image: Option<PathBuf>, checkpoint: Option<Result<SavedCheckpoint, String>> },
    /// The server of `view` cannot listen.
    #[cfg(feature = "view")]
    #[error("cannot listen on {0}: {1}; choose another --port or --bind")]
    Server(SocketAddr, io::Error),
    #[error("standard output cannot be written: {0}")]
    Stdout(io::Error),
    /// An image that is black or shows no object, with `--strict`.
    #[error("{warning}; the image was written to {}", file.display())]
    Empty { warning: String, file: PathBuf },
    /// Bad samples, with `--strict`.
    #[error(
        "{bad_samples} of {samples} samples were NaN, infinite or negative and count as black; \
         the image was written to {}", file.display()
    )]
    Damaged { bad_samples: u64, samples: u64, file: PathBuf },
    /// Lost light of caustics, with `--strict`.
    #[error(
        "the light of caustics was cut off at a radiance of 2^41 in {pixels} {}, summed over passes; reduce the radiance of all \
         lights, and raise the exposure instead; the image was written to {}",
        if *pixels == 1 { "pixel" } else { "pixels" }, file.display()
    )]
    Saturated { pixels: u64, file: PathBuf },
}

impl CliError {
    /// This error in a frame of an animation.
    pub(crate) fn in_frame(self, frame: u32) -> Self {
        Self::Frame { frame, source: Box::new(self) }
    }

    /// Error of the plan, or a usage error if only an option can cause it.
    pub(crate) fn plan(file: &Path, source: RenderError) -> Self {
        match source {
            RenderError::Crop { .. } => Self::Usage(format!("{source}; reduce --crop, or raise --size")),
            RenderError::Adaptive(_) => Self::Usage(format!("{source}, or turn it off by --adaptive off")),
            RenderError::SamePasses(_)
            | RenderError::AdaptiveLens
            | RenderError::AdaptiveMotion
            | RenderError::AdaptiveUntil
            | RenderError::ShardWithStopRule => Self::Usage(source.to_string()),
            source => Self::Plan { file: file.to_owned(), source },
        }
    }

    /// Exit code; `rt-cli --help` lists all.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Frame { source, .. } => return source.exit_code(),
            Self::Different { .. } => 1,
            Self::Usage(_) => 2,
            Self::Load(_) | Self::Plan { .. } | Self::Image(_) | Self::Pair { .. } | Self::Warnings { .. } => 3,
            Self::Artifact(_) | Self::Join(_) | Self::Memory { .. } => 3,
            Self::Output(_) | Self::Outputs(_) | Self::Stdout(_) => 4,
            #[cfg(feature = "view")]
            Self::Server(..) => 4,
            Self::Damaged { .. } | Self::Saturated { .. } | Self::Empty { .. } | Self::Lost { .. } => 5,
            Self::Interrupted { .. } | Self::NothingFinished { .. } | Self::MeasurementInterrupted { .. } => {
                INTERRUPTED_EXIT_CODE
            }
            Self::InterruptedLoading { .. } | Self::InterruptedBetweenFrames | Self::RenderInterrupted => {
                INTERRUPTED_EXIT_CODE
            }
        })
    }
}

/// Refuses arguments that do not fit together, or do not fit the scene.
pub(crate) fn usage<T>(message: impl Into<String>) -> Result<T, CliError> {
    Err(CliError::Usage(message.into()))
}

fn saved(image: Option<&Path>) -> String {
    image.map_or_else(
        || "no image was written".to_owned(),
        |file| format!("the image was written to {}", file.display()),
    )
}

fn measurements(measured: usize, folder: &Path) -> String {
    match measured {
        0 => "nothing was written".to_owned(),
        _ => format!("their results were written to {}", folder.display()),
    }
}

fn resumption(checkpoint: &Option<Result<SavedCheckpoint, String>>) -> String {
    match checkpoint {
        Some(Ok(checkpoint)) => format!("; {}", checkpoint.advice("continues")),
        Some(Err(reason)) => format!("; it cannot be resumed, because no checkpoint could be written: {reason}"),
        None => "; it cannot be resumed, because it has no checkpoint".to_owned(),
    }
}

fn retry(checkpoint: &Option<Result<SavedCheckpoint, String>>) -> String {
    match checkpoint {
        Some(Ok(checkpoint)) => format!("; {}", checkpoint.advice("renders them again")),
        _ => String::new(),
    }
}

/// Option for the frame of a checkpoint that is named without `####`.
fn single_frame(frame: u32, source: &CliError) -> String {
    match source {
        CliError::Interrupted { checkpoint: Some(Ok(checkpoint)), .. }
        | CliError::NothingFinished { checkpoint: Some(Ok(checkpoint)), .. }
        | CliError::Lost { checkpoint: Some(Ok(checkpoint)), .. }
            if checkpoint.is_elsewhere =>
        {
            format!(" with --frames {frame}")
        }
        _ => String::new(),
    }
}

fn difference(metric: &str, value: &str, threshold: f64, non_finite: u64) -> String {
    match non_finite {
        0 => format!("{metric} is {value}, the threshold is {threshold}"),
        1 => "1 pixel is NaN or infinite in one image and different in the other".to_owned(),
        n => format!("{n} pixels are NaN or infinite in one image and different in the other"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message on the first frame named --resume, although there was nothing to resume.
    #[test]
    fn interrupts_before_the_first_frame_do_not_advise_to_resume() {
        let message = |has_frames| CliError::InterruptedLoading { has_frames }.in_frame(4).to_string();
        let start = "frame 4: interrupted while the scene was loaded: no image was written; ";
        assert_eq!(message(false), format!("{start}run the command again"));
        assert_eq!(message(true), format!("{start}--resume continues the frames that are not finished"));
    }
}
