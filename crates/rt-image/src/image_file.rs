//! Image files: formats and errors.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Pixels of the largest image that [`read_image`](crate::read_image) reads: 2²⁷, such as an environment map of 16,384 by
/// 8,192.
pub const MAX_READ_PIXELS: u64 = 1 << 27;

/// The file formats that are written and read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// Portable Network Graphics: developed, 8 bits a channel, with coverage if the film has it.
    Png,
    /// JPEG: developed, 8 bits a channel, lossy, in front of black.
    Jpeg,
    /// OpenEXR: linear `f32`, bit for bit, with premultiplied coverage if the film has it.
    Exr,
    /// Radiance RGBE: linear, 8 bits and a shared exponent, without coverage; negative values become 0.
    Hdr,
    /// Portable float map: linear `f32`, bit for bit, without coverage.
    Pfm,
}

impl ImageFormat {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Png, Self::Jpeg, Self::Exr, Self::Hdr, Self::Pfm];

    /// The endings of file names in this format, without the dot; the first is the usual one.
    pub const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::Exr => &["exr"],
            Self::Hdr => &["hdr"],
            Self::Pfm => &["pfm"],
        }
    }

    /// Format of a file name by its extension, in upper or lower case.
    ///
    /// # Errors
    /// [`ImageFileError::UnknownExtension`], which lists the known extensions.
    pub fn from_path(path: &Path) -> Result<Self, ImageFileError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        Self::ALL
            .into_iter()
            .find(|format| format.extensions().iter().any(|known| known.eq_ignore_ascii_case(extension)))
            .ok_or_else(|| ImageFileError::UnknownExtension(path.to_owned()))
    }

    fn list_extensions() -> String {
        let known: Vec<_> = Self::ALL.iter().flat_map(|format| format.extensions()).map(|e| format!(".{e}")).collect();
        known.join(", ")
    }
}

/// Error of the functions that write or read images.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageFileError {
    /// The file's name has no ending that names a format.
    #[error("unknown image format of `{}`: use one of {}", .0.display(), ImageFormat::list_extensions())]
    UnknownExtension(PathBuf),
    /// The writer failed.
    #[error("the image cannot be written: {0}")]
    Write(#[source] io::Error),
    /// The format cannot hold the image, such as a side that is 0 or too long for it.
    #[error("the image cannot be stored as {format:?}: {reason}")]
    Encode {
        /// The format.
        format: ImageFormat,
        /// Message of the encoder.
        reason: String,
    },
    /// The file cannot be opened or read.
    #[error("{}: {}", path.display(), unreadable(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The path is a directory, a pipe or a device.
    #[error("{}: is not a regular file", .0.display())]
    NotAFile(PathBuf),
    /// The file has no bytes.
    #[error("{}: is empty (0 bytes)", .0.display())]
    Empty(PathBuf),
    /// The file is in no known format.
    #[error("{}: is not an image in one of the formats {}; convert it to one of them", .0.display(), ImageFormat::list_extensions())]
    UnknownFormat(PathBuf),
    /// The image has more pixels than [`MAX_READ_PIXELS`].
    #[error(
        "{}: is {width}x{height} pixels, but at most {max} pixels can be read; scale it down",
        path.display(),
        max = MAX_READ_PIXELS
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Width that the file claims, in pixels.
        width: u32,
        /// Height that the file claims, in pixels.
        height: u32,
    },
    /// The file is damaged, or uses a feature that is not supported.
    #[error("{}: cannot be decoded: {reason}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// Message of the decoder.
        reason: String,
    },
}

fn unreadable(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "does not exist".to_owned(),
        _ => format!("cannot be read: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_the_format() {
        for (name, format) in [
            ("a.png", ImageFormat::Png),
            ("a.b.JPG", ImageFormat::Jpeg),
            ("dir.exr/a.jpeg", ImageFormat::Jpeg),
            ("a.Exr", ImageFormat::Exr),
            ("a.hdr", ImageFormat::Hdr),
            ("a.pfm", ImageFormat::Pfm),
        ] {
            assert_eq!(ImageFormat::from_path(Path::new(name)).expect("known"), format);
        }
    }

    #[test]
    fn unknown_names_are_refused_with_the_known_ones() {
        for name in ["a.tif", "png", ".png", "a.", ""] {
            let message = ImageFormat::from_path(Path::new(name)).expect_err("unknown").to_string();
            assert!(message.contains(".png, .jpg, .jpeg, .exr, .hdr, .pfm"), "{message}");
        }
    }
}
