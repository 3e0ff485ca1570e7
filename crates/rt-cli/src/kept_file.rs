//! Files of what is kept of a render: checkpoints, to go on from, and parts, to be joined.
//!
//! ```text
//!   "rt-cli kept 1\n" | what it is of | what is kept | hash of all that
//! ```
//!
//! Numbers are written by postcard. A file is only as good as its hash: a flipped bit is found before anything is read.

use std::fs;
use std::io::{self, BufWriter, Read as _, Write};
use std::path::{Path, PathBuf};

use rt_camera::{Development, Dither, Encoding};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::args::{tone_name, tone_of_name};
use crate::identity::Identity;

/// How each such file begins.
const MAGIC: &[u8] = b"rt-cli kept 1\n";

/// Bytes of the hash at its end.
const HASH: usize = blake3::OUT_LEN;

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

/// False if there is a file which is not one of these, or the beginning of one.
pub(crate) fn may_be_replaced(file: &Path) -> bool {
    let mut head = Vec::new();
    let read = fs::File::open(file).and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut head));
    read.is_err() || MAGIC.starts_with(&head)
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

/// Reads a file of this kind.
pub(crate) fn read<T: DeserializeOwned>(file: &Path, kind: KeptKind) -> Result<(Label, T), KeptError> {
    let bytes = fs::read(file).map_err(|source| KeptError::Read { file: file.to_owned(), source })?;
    let damaged = || KeptError::Damaged(file.to_owned());
    let other_kind = || KeptError::OtherKind { file: file.to_owned(), kind };
    if !bytes.starts_with(MAGIC) {
        return Err(other_kind());
    }
    let (content, hash) = bytes.split_last_chunk::<HASH>().ok_or_else(damaged)?;
    if blake3::Hasher::new().update_rayon(content).finalize() != *hash {
        return Err(damaged());
    }
    let content = content.get(MAGIC.len()..).ok_or_else(damaged)?;
    let (label, content) = postcard::take_from_bytes::<Label>(content).map_err(|_| damaged())?;
    if label.version != env!("CARGO_PKG_VERSION") {
        return Err(KeptError::Version { file: file.to_owned(), version: label.version });
    }
    if label.kind != kind {
        return Err(other_kind());
    }
    match postcard::take_from_bytes::<T>(content) {
        Ok((kept, [])) => Ok((label, kept)),
        _ => Err(damaged()),
    }
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
