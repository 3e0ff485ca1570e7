//! Image files: formats and their limits.

use std::path::Path;
use std::sync::Arc;

use rt_image::{
    Image, ImageFormat, ImageHeader, decode_image, format_of_bytes, header_of_bytes, image_format, image_header,
    read_image,
};

use crate::error::{CliError, usage};
use crate::output_file::{OutputFile, is_null_device, refuse_terminal};
use crate::stdin::{self, is_dash};

/// Maximum side of a JPEG in pixels: its header has 16 bits.
const MAX_JPEG_SIDE: u32 = u16::MAX as u32;

/// Format by file extension.
pub(crate) fn format_of(path: &Path) -> Result<ImageFormat, CliError> {
    ImageFormat::from_path(path).map_err(|error| CliError::Usage(error.to_string()))
}

/// Usual extension of a format.
pub(crate) fn extension_of(format: ImageFormat) -> &'static str {
    format.extensions().first().copied().unwrap_or_default()
}

/// The given format, or else that of the file extension; PNG for standard output and the null device. They must not contradict.
pub(crate) fn chosen_format(path: &Path, given: Option<ImageFormat>) -> Result<ImageFormat, CliError> {
    refuse_terminal(path)?;
    match (given, ImageFormat::from_path(path)) {
        (Some(format), Ok(named)) if named != format => {
            let extension = extension_of(format);
            let (path, other) = (path.display(), path.with_extension(extension));
            let other = other.display();
            usage(format!(
                "--output-format {extension} contradicts the extension of {path}; remove it, or name the file {other}"
            ))
        }
        (Some(format), _) => Ok(format),
        (None, _) if is_dash(path) || is_null_device(path) => Ok(ImageFormat::Png),
        (None, Ok(named)) => Ok(named),
        (None, Err(error)) => usage(format!("{error}, or choose one by --output-format")),
    }
}

/// Image of a file or of standard input, of which at most `memory` bytes are read.
pub(crate) struct ImageInput<'a> {
    path: &'a Path,
    /// Content of standard input.
    piped: Option<Arc<[u8]>>,
}

impl<'a> ImageInput<'a> {
    pub(crate) fn new(path: &'a Path, memory: Option<u64>) -> Result<Self, CliError> {
        let piped = if is_dash(path) { Some(stdin::content(None, memory)?) } else { None };
        Ok(Self { path: if piped.is_some() { Path::new("standard input") } else { path }, piped })
    }

    /// Name for messages.
    pub(crate) const fn name(&self) -> &'a Path {
        self.path
    }

    pub(crate) fn header(&self) -> Result<ImageHeader, CliError> {
        Ok(match &self.piped {
            Some(bytes) => header_of_bytes(bytes, self.path)?,
            None => image_header(self.path)?,
        })
    }

    pub(crate) fn read(&self) -> Result<Image, CliError> {
        Ok(match &self.piped {
            Some(bytes) => decode_image(bytes, self.path)?,
            None => read_image(self.path)?,
        })
    }

    pub(crate) fn format(&self) -> Result<ImageFormat, CliError> {
        Ok(match &self.piped {
            Some(bytes) => format_of_bytes(bytes, self.path)?,
            None => image_format(self.path)?,
        })
    }
}

/// Refuses images that the format of a file cannot hold.
pub(crate) fn check(
    file: &Path,
    format: ImageFormat,
    [width, height]: [u32; 2],
    transparent: bool,
) -> Result<(), CliError> {
    let file = file.display();
    let has_alpha = matches!(format, ImageFormat::Png | ImageFormat::Exr);
    if transparent && !has_alpha {
        return usage(format!(
            "{file}: a transparent background requires a .png or .exr file; choose another name or background"
        ));
    }
    if format == ImageFormat::Jpeg && width.max(height) > MAX_JPEG_SIDE {
        return usage(format!(
            "{file}: a .jpg file of {width}x{height} pixels exceeds {MAX_JPEG_SIDE} pixels a side; use .png or .exr"
        ));
    }
    Ok(())
}

/// Path of a written image, or its format and standard output.
pub(crate) fn written(file: &OutputFile, format: ImageFormat) -> String {
    let path = file.path().display();
    if file.is_stdout() { format!("{} to {path}", extension_of(format).to_uppercase()) } else { path.to_string() }
}

/// Maximum size of an image file in bytes.
pub(crate) const fn max_bytes(format: ImageFormat, [width, height]: [u32; 2]) -> u64 {
    let pixels = width as u64 * height as u64;
    // Four channels of a byte or a float, and headers and row tables.
    pixels * if is_developed(format) { 4 } else { 16 } + 65_536 + 32 * height as u64
}

/// True if the format holds display bytes instead of linear radiance.
pub(crate) const fn is_developed(format: ImageFormat) -> bool {
    matches!(format, ImageFormat::Png | ImageFormat::Jpeg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_formats_with_coverage_are_transparent() {
        for format in ImageFormat::ALL {
            let holds = [ImageFormat::Png, ImageFormat::Exr].contains(&format);
            assert_eq!(check(Path::new("a"), format, [8, 8], true).is_ok(), holds, "{format:?}");
            assert!(check(Path::new("a"), format, [8, 8], false).is_ok(), "{format:?}");
        }
    }

    #[test]
    fn long_sides_do_not_fit_in_a_jpeg() {
        assert!(check(Path::new("a"), ImageFormat::Jpeg, [65_535, 1], false).is_ok());
        assert!(check(Path::new("a"), ImageFormat::Jpeg, [1, 65_536], false).is_err());
        assert!(check(Path::new("a"), ImageFormat::Png, [1, 65_536], false).is_ok());
    }
}
