//! Files of what is kept of a render: checkpoints, to go on from, and parts, to be joined.
//!
//! ```text
//!   "rt-cli kept 1\n" | what it is of | what is kept | hash of all that
//! ```
//!
//! Numbers are written by postcard. A file is only as good as its hash: a flipped bit is found before anything is read.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read as _, Write};
use std::path::{Path, PathBuf};

use rt_image::{Development, Dither, Encoding};
use rt_render::{Checkpoint, ContentError, Part, UncheckedCheckpoint, UncheckedPart};
use rt_scene_io::MemoryError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::args::{tone_name, tone_of_name};
use crate::identity::Identity;

/// How each such file begins.
const MAGIC: &[u8] = b"rt-cli kept 1\n";

/// Bytes of the hash at its end.
const HASH: usize = blake3::OUT_LEN;

/// Bytes of the longest label.
const MAX_LABEL: u64 = 8192;

/// Bytes of the longest name of a version or of a scene's file.
const MAX_NAME: usize = 1024;

/// What a file is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Label {
    kind: KeptKind,
    version: String,
    pub(crate) identity: Identity,
    /// Name of the scene's file, for messages.
    pub(crate) scene: String,
    exposure: f64,
    tone: String,
    gamma: Option<f64>,
    /// Where the upper left pixel lies in the full image, if colours are dithered.
    dither_origin: Option<[u32; 2]>,
}

/// What is kept in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum KeptKind {
    /// A render in the midst of it.
    Checkpoint,
    /// A share of a picture, finished.
    Part,
}

/// Why a file is no use.
#[derive(Debug, thiserror::Error)]
pub(crate) enum KeptError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It is a folder, a pipe or a device.
    #[error("{}: is not a regular file", .0.display())]
    NotAFile(PathBuf),
    /// Reading it would take more memory than is allowed.
    #[error("{}: {shortage}", file.display())]
    Memory {
        /// The file.
        file: PathBuf,
        /// How much more.
        shortage: MemoryError,
    },
    /// It has the right hash, and a number in it cannot be right.
    #[error("{}: is no sound {kind}: {reason}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// What it should be.
        kind: KeptKind,
        /// The number.
        reason: String,
    },
    /// It is something else.
    #[error("{}: is no {kind}", file.display())]
    OtherKind {
        /// The file.
        file: PathBuf,
        /// What it should be.
        kind: KeptKind,
    },
    /// It is not what was written.
    #[error("{}: is damaged: its content does not have the hash at its end", .0.display())]
    Damaged(PathBuf),
    /// A list of frames that is none.
    #[error("{}: is no list of the frames that are done; remove it to begin anew", .0.display())]
    Log(PathBuf),
    /// Its content makes no sense to this program.
    #[error("{}: was written by version {version} of this program, and this is version {}", file.display(), env!("CARGO_PKG_VERSION"))]
    Version {
        /// The file.
        file: PathBuf,
        /// What wrote it.
        version: String,
    },
    /// It is of the same picture, and something else was wanted of it.
    #[error("{}: was made with other options: --stats, --aov, --time and --target-error must be given again, or not, as they were at \
             first; begin anew with --restart", .0.display())]
    OtherOptions(PathBuf),
    /// It is of another picture.
    #[error("{}: is of another picture: its scene ({scene}), a file of it, or an option is not the same{advice}", file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// The scene that it is of.
        scene: String,
        /// What can be done.
        advice: &'static str,
    },
}

impl core::fmt::Display for KeptKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Checkpoint => "checkpoint",
            Self::Part => "part of a picture",
        })
    }
}

impl Label {
    /// The label of what this version of the program keeps of a scene.
    pub(crate) fn new(kind: KeptKind, identity: Identity, scene: &Path, development: &Development) -> Self {
        Self {
            kind,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            identity,
            scene: scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            exposure: development.exposure,
            tone: tone_name(development.tone).to_owned(),
            gamma: match development.encoding {
                Encoding::Srgb => None,
                Encoding::Power(gamma) => Some(gamma),
            },
            dither_origin: development.dither.map(|dither| dither.origin),
        }
    }

    /// Checks that it is one that this program writes.
    fn check(&self, file: &Path, kind: KeptKind) -> Result<(), KeptError> {
        let content = |reason: String| KeptError::Content { file: file.to_owned(), kind, reason };
        if self.version.len() > MAX_NAME || self.scene.len() > MAX_NAME {
            return Err(content("its label is too long".to_owned()));
        }
        if self.version != env!("CARGO_PKG_VERSION") {
            return Err(KeptError::Version { file: file.to_owned(), version: self.version.clone() });
        }
        if self.kind != kind {
            return Err(KeptError::OtherKind { file: file.to_owned(), kind });
        }
        if tone_of_name(&self.tone).is_none() {
            return Err(content("there is no such tone curve".to_owned()));
        }
        self.development().validate().map_err(|error| content(error.to_string()))
    }

    /// How the scene wants its picture developed.
    pub(crate) fn development(&self) -> Development {
        let standard = Development::default();
        Development {
            exposure: self.exposure,
            tone: tone_of_name(&self.tone).unwrap_or(standard.tone),
            encoding: self.gamma.map_or(Encoding::Srgb, Encoding::Power),
            dither: self.dither_origin.map(|origin| Dither { origin }),
        }
    }
}

/// What is kept in a file, and checked when it is read.
pub(crate) trait Content: Sized {
    /// What is decoded.
    type Unchecked: DeserializeOwned;

    /// Checks all numbers.
    fn check(unchecked: Self::Unchecked) -> Result<Self, ContentError>;
}

impl Content for Part {
    type Unchecked = UncheckedPart;

    fn check(unchecked: UncheckedPart) -> Result<Self, ContentError> {
        unchecked.check()
    }
}

impl Content for Checkpoint {
    type Unchecked = UncheckedCheckpoint;

    fn check(unchecked: UncheckedCheckpoint) -> Result<Self, ContentError> {
        unchecked.check()
    }
}

/// Opens a regular file, and tells its length. Whoever opens a pipe waits for its other end, so that this comes first.
fn open(file: &Path) -> Result<(File, u64), KeptError> {
    let failed = |source| KeptError::Read { file: file.to_owned(), source };
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Err(KeptError::NotAFile(file.to_owned()));
    }
    Ok((File::open(file).map_err(failed)?, metadata.len()))
}

/// Length of a file of this kind, before it is read.
pub(crate) fn length(file: &Path) -> Result<u64, KeptError> {
    open(file).map(|(_, length)| length)
}

/// The label of a file, if there is a file. Nothing but its beginning is read, so that its hash is not checked.
///
/// # Errors
/// [`KeptError`] if it is damaged, of another kind or version, or something else.
pub(crate) fn label(file: &Path, kind: KeptKind) -> Result<Option<Label>, KeptError> {
    let (opened, _) = match open(file) {
        Err(KeptError::Read { source, .. })
            if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
        {
            return Ok(None);
        }
        opened => opened?,
    };
    let mut head = Vec::new();
    opened
        .take(MAGIC.len() as u64 + MAX_LABEL)
        .read_to_end(&mut head)
        .map_err(|source| KeptError::Read { file: file.to_owned(), source })?;
    if MAGIC.starts_with(&head) {
        return Err(KeptError::Damaged(file.to_owned()));
    }
    let Some(head) = head.strip_prefix(MAGIC) else {
        return Err(KeptError::OtherKind { file: file.to_owned(), kind });
    };
    let (label, _) = postcard::take_from_bytes::<Label>(head).map_err(|_| KeptError::Damaged(file.to_owned()))?;
    label.check(file, kind)?;
    Ok(Some(label))
}

/// Writes a file.
pub(crate) fn write(file: impl Write, label: &Label, content: &impl Serialize) -> Result<(), String> {
    let mut hashed = BufWriter::with_capacity(1 << 18, Hashed { file, hasher: blake3::Hasher::new() });
    hashed.write_all(MAGIC).map_err(|error| error.to_string())?;
    for_postcard(&mut hashed, label)?;
    for_postcard(&mut hashed, content)?;
    let Hashed { mut file, hasher } = hashed.into_inner().map_err(|error| error.error().to_string())?;
    file.write_all(hasher.finalize().as_bytes()).map_err(|error| error.to_string())
}

/// What the system says of a failure matters more than that there was one.
fn for_postcard(mut writer: impl Write, value: &impl Serialize) -> Result<(), String> {
    struct Watched<W> {
        writer: W,
        error: Option<String>,
    }
    impl<W: Write> Write for &mut Watched<W> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.writer.write(bytes).inspect_err(|error| self.error = Some(error.to_string()))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut watched = Watched { writer: &mut writer, error: None };
    let written = postcard::to_io(value, &mut watched).map(|_| ()).map_err(|error| error.to_string());
    written.map_err(|error| watched.error.take().unwrap_or(error))
}

/// Reads a file of this kind, unless that would take more bytes of memory than `memory`.
pub(crate) fn read<T: Content>(file: &Path, kind: KeptKind, memory: Option<u64>) -> Result<(Label, T), KeptError> {
    let failed = |source| KeptError::Read { file: file.to_owned(), source };
    let damaged = || KeptError::Damaged(file.to_owned());
    let (opened, length) = open(file)?;
    let mut bytes = Vec::new();
    let mut reader = opened.take(length);
    reader.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(failed)?;
    if bytes != MAGIC {
        return Err(KeptError::OtherKind { file: file.to_owned(), kind });
    }
    check_memory(file, kind, length, memory)?;
    reader.read_to_end(&mut bytes).map_err(failed)?;
    let (content, hash) = bytes.split_last_chunk::<HASH>().ok_or_else(damaged)?;
    if blake3::Hasher::new().update_rayon(content).finalize() != *hash {
        return Err(damaged());
    }
    let content = content.get(MAGIC.len()..).ok_or_else(damaged)?;
    let (label, content) = postcard::take_from_bytes::<Label>(content).map_err(|_| damaged())?;
    label.check(file, kind)?;
    let Ok((unchecked, [])) = postcard::take_from_bytes::<T::Unchecked>(content) else { return Err(damaged()) };
    let content = T::check(unchecked).map_err(|error| {
        let reason = error.to_string();
        KeptError::Content { file: file.to_owned(), kind, reason }
    })?;
    Ok((label, content))
}

/// Refuses a file whose bytes and content take too much memory.
fn check_memory(file: &Path, kind: KeptKind, length: u64, memory: Option<u64>) -> Result<(), KeptError> {
    let predicted = length.saturating_add(decoded_bytes(length));
    match memory {
        Some(budget) if predicted > budget => {
            let largest = format!("the {kind} {}", file.display());
            let shortage = MemoryError { predicted, budget, largest, most: predicted };
            Err(KeptError::Memory { file: file.to_owned(), shortage })
        }
        _ => Ok(()),
    }
}

/// Bytes of memory that the content of a file of this length takes: numbers as they are, and some for each tile.
pub(crate) const fn decoded_bytes(length: u64) -> u64 {
    length.saturating_add(length / 8)
}

/// Hashes what goes to a file.
struct Hashed<W> {
    file: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
