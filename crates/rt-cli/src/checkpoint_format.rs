//! File format of checkpoints and of shards of an image.
//!
//! ```text
//!   "rt-cli checkpoint 2\n" | label | content | 128-bit XXH3 hash of all before
//! ```
//!
//! Label and content are encoded by postcard. The hash detects any flipped bit before the content is decoded.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read as _, Write};
use std::path::Path;

use rt_image::{Development, Dither, Encoding};
use rt_render::{Checkpoint, ContentError, Shard, UncheckedCheckpoint, UncheckedShard};
use rt_scene_io::MemoryError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use crate::args::{tone_name, tone_of_name};
use crate::artifact_error::{ArtifactError, ArtifactKind};
use crate::identity::{Identity, hash_bytes};

const MAGIC: &[u8] = b"rt-cli checkpoint 2\n";

/// Size of the hash in bytes.
const HASH: usize = 16;

/// Maximum size of a label in bytes.
const MAX_LABEL: u64 = 8192;

/// Maximum length of a version or of the name of a scene file in bytes.
const MAX_NAME: usize = 1024;

/// Identity and tone mapping of the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Label {
    kind: ArtifactKind,
    version: String,
    pub(crate) identity: Identity,
    /// Name of the scene file, for messages.
    pub(crate) scene: String,
    exposure: f64,
    tone: String,
    gamma: Option<f64>,
    /// Position of the upper left pixel in the full image, for dithering.
    dither_origin: Option<[u32; 2]>,
}

impl Label {
    pub(crate) fn new(kind: ArtifactKind, identity: Identity, scene: &Path, development: &Development) -> Self {
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

    /// Checks version, kind and values.
    fn check(&self, file: &Path, kind: ArtifactKind) -> Result<(), ArtifactError> {
        let content = |reason: String| ArtifactError::Content { file: file.to_owned(), kind, reason };
        if self.version.len() > MAX_NAME || self.scene.len() > MAX_NAME {
            return Err(content("the label is too long".to_owned()));
        }
        if self.version != env!("CARGO_PKG_VERSION") {
            return Err(ArtifactError::Version { file: file.to_owned(), version: self.version.clone() });
        }
        if self.kind != kind {
            return Err(ArtifactError::OtherKind { file: file.to_owned(), kind });
        }
        if tone_of_name(&self.tone).is_none() {
            return Err(content("unknown tone curve".to_owned()));
        }
        self.development().validate().map_err(|error| content(error.to_string()))
    }

    /// Tone mapping of the scene.
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

/// Content of a file, validated after decoding.
pub(crate) trait Content: Sized {
    type Unchecked: DeserializeOwned;

    fn check(unchecked: Self::Unchecked) -> Result<Self, ContentError>;
}

impl Content for Shard {
    type Unchecked = UncheckedShard;

    fn check(unchecked: UncheckedShard) -> Result<Self, ContentError> {
        unchecked.check()
    }
}

impl Content for Checkpoint {
    type Unchecked = UncheckedCheckpoint;

    fn check(unchecked: UncheckedCheckpoint) -> Result<Self, ContentError> {
        unchecked.check()
    }
}

/// Opens a regular file and returns its length. Checks the type first, because opening a pipe blocks.
fn open(file: &Path) -> Result<(File, u64), ArtifactError> {
    let failed = |source| ArtifactError::Read { file: file.to_owned(), source };
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Err(ArtifactError::NotAFile(file.to_owned()));
    }
    Ok((File::open(file).map_err(failed)?, metadata.len()))
}

/// Length of a regular file.
pub(crate) fn length(file: &Path) -> Result<u64, ArtifactError> {
    open(file).map(|(_, length)| length)
}

/// Reads the label of a file, if it exists. The hash is not checked.
pub(crate) fn label(file: &Path, kind: ArtifactKind) -> Result<Option<Label>, ArtifactError> {
    let (opened, _) = match open(file) {
        Err(ArtifactError::Read { source, .. })
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
        .map_err(|source| ArtifactError::Read { file: file.to_owned(), source })?;
    if head.is_empty() {
        return Err(ArtifactError::Empty(file.to_owned()));
    }
    if MAGIC.starts_with(&head) {
        return Err(ArtifactError::Damaged(file.to_owned()));
    }
    let Some(head) = head.strip_prefix(MAGIC) else {
        return Err(ArtifactError::OtherKind { file: file.to_owned(), kind });
    };
    let (label, _) = postcard::take_from_bytes::<Label>(head).map_err(|_| ArtifactError::Damaged(file.to_owned()))?;
    label.check(file, kind)?;
    Ok(Some(label))
}

pub(crate) fn write(file: impl Write, label: &Label, content: &impl Serialize) -> Result<(), String> {
    let mut hashed = BufWriter::with_capacity(1 << 18, Hashed { file, hasher: Xxh3::new() });
    hashed.write_all(MAGIC).map_err(|error| error.to_string())?;
    write_postcard(&mut hashed, label)?;
    write_postcard(&mut hashed, content)?;
    let Hashed { mut file, hasher } = hashed.into_inner().map_err(|error| error.error().to_string())?;
    file.write_all(&hasher.digest128().to_le_bytes()).map_err(|error| error.to_string())
}

/// Encodes a value. Postcard drops the reason of a failed write, so that it is stored here.
fn write_postcard(mut writer: impl Write, value: &impl Serialize) -> Result<(), String> {
    struct Recorder<W> {
        writer: W,
        error: Option<String>,
    }
    impl<W: Write> Write for &mut Recorder<W> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.writer.write(bytes).inspect_err(|error| self.error = Some(error.to_string()))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut recorder = Recorder { writer: &mut writer, error: None };
    let written = postcard::to_io(value, &mut recorder).map(|_| ()).map_err(|error| error.to_string());
    written.map_err(|error| recorder.error.take().unwrap_or(error))
}

/// Reads a file within `memory` bytes.
pub(crate) fn read<T: Content>(
    file: &Path,
    kind: ArtifactKind,
    memory: Option<u64>,
) -> Result<(Label, T), ArtifactError> {
    let failed = |source| ArtifactError::Read { file: file.to_owned(), source };
    let damaged = || ArtifactError::Damaged(file.to_owned());
    let (opened, length) = open(file)?;
    let mut bytes = Vec::new();
    let mut reader = opened.take(length);
    reader.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(failed)?;
    if bytes != MAGIC {
        return Err(ArtifactError::OtherKind { file: file.to_owned(), kind });
    }
    check_memory(file, kind, length, memory)?;
    reader.read_to_end(&mut bytes).map_err(failed)?;
    let (content, hash) = bytes.split_last_chunk::<HASH>().ok_or_else(damaged)?;
    if hash_bytes(content) != *hash {
        return Err(damaged());
    }
    let content = content.get(MAGIC.len()..).ok_or_else(damaged)?;
    let (label, content) = postcard::take_from_bytes::<Label>(content).map_err(|_| damaged())?;
    label.check(file, kind)?;
    let Ok((unchecked, [])) = postcard::take_from_bytes::<T::Unchecked>(content) else { return Err(damaged()) };
    let content = T::check(unchecked).map_err(|error| {
        let reason = error.to_string();
        ArtifactError::Content { file: file.to_owned(), kind, reason }
    })?;
    Ok((label, content))
}

fn check_memory(file: &Path, kind: ArtifactKind, length: u64, memory: Option<u64>) -> Result<(), ArtifactError> {
    let predicted = length.saturating_add(decoded_bytes(length));
    match memory {
        Some(budget) if predicted > budget => {
            let largest = format!("the {kind} {}", file.display());
            let cause = MemoryError { predicted, budget, largest, most: predicted };
            Err(ArtifactError::Memory { file: file.to_owned(), cause })
        }
        _ => Ok(()),
    }
}

/// Memory of the decoded content in bytes: the numbers, and overhead per tile.
pub(crate) const fn decoded_bytes(length: u64) -> u64 {
    length.saturating_add(length / 8)
}

/// Writer that hashes its output.
struct Hashed<W> {
    file: W,
    hasher: Xxh3,
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
