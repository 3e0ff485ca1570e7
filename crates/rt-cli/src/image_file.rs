//! Image files: formats and their limits.

use std::path::Path;

use rt_image::{Image, ImageFormat, decode_image, format_of_bytes, image_format, read_image};

use crate::error::CliError;
use crate::output::refuse_terminal;
use crate::stdin::{self, is_dash};

/// Maximum side of a JPEG in pixels: its header has 16 bits.
const MAX_JPEG_SIDE: u32 = u16::MAX as u32;

/// Format by file extension.
pub(crate) fn format_of(path: &Path) -> Result<ImageFormat, CliError> {
    ImageFormat::from_path(path).map_err(|error| CliError::Usage(error.to_string()))
}

/// The given format, or else that of the file extension; PNG for standard output.
pub(crate) fn chosen_format(path: &Path, given: Option<ImageFormat>) -> Result<ImageFormat, CliError> {
    refuse_terminal(path)?;
    match given {
        Some(format) => Ok(format),
        None if is_dash(path) => Ok(ImageFormat::Png),
        None => format_of(path),
    }
}

/// Reads an image from a file or standard input.
pub(crate) fn read(path: &Path) -> Result<Image, CliError> {
    if is_dash(path) {
        Ok(decode_image(&stdin::content(None, None)?, Path::new("standard input"))?)
    } else {
        Ok(read_image(path)?)
    }
}

pub(crate) fn format_by_content(path: &Path) -> Result<ImageFormat, CliError> {
    if is_dash(path) {
        Ok(format_of_bytes(&stdin::content(None, None)?, Path::new("standard input"))?)
    } else {
        Ok(image_format(path)?)
    }
}

/// Refuses images that the format cannot hold.
pub(crate) fn check(format: ImageFormat, [width, height]: [u32; 2], transparent: bool) -> Result<(), CliError> {
    let has_alpha = matches!(format, ImageFormat::Png | ImageFormat::Exr);
    if transparent && !has_alpha {
        return Err(CliError::Usage("a transparent background requires a .png or .exr file".to_owned()));
    }
    if format == ImageFormat::Jpeg && width.max(height) > MAX_JPEG_SIDE {
        let message =
            format!("a .jpg file of {width}x{height} pixels exceeds {MAX_JPEG_SIDE} pixels a side; use .png or .exr");
        return Err(CliError::Usage(message));
    }
    Ok(())
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
            assert_eq!(check(format, [8, 8], true).is_ok(), holds, "{format:?}");
            assert!(check(format, [8, 8], false).is_ok(), "{format:?}");
        }
    }

    #[test]
    fn long_sides_do_not_fit_in_a_jpeg() {
        assert!(check(ImageFormat::Jpeg, [65_535, 1], false).is_ok());
        assert!(check(ImageFormat::Jpeg, [1, 65_536], false).is_err());
        assert!(check(ImageFormat::Png, [1, 65_536], false).is_ok());
    }
}
