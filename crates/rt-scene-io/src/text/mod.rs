//! Readers of text formats without a nested grammar: tokens with their lines, and logical lines.

#[cfg(feature = "obj")]
pub(crate) mod lines;
#[cfg(any(feature = "nff", feature = "pbrt"))]
pub(crate) mod tokenizer;

#[cfg(any(feature = "nff", feature = "pbrt"))]
use crate::error::LineError;

/// Size of an image of two whole numbers of pixels.
///
/// # Errors
/// [`LineError`] for other numbers, and beyond [`Image::MAX_PIXELS`](rt_image::Image::MAX_PIXELS).
#[cfg(any(feature = "nff", feature = "pbrt"))]
pub(crate) fn resolution(line: usize, width: f64, height: f64) -> Result<[u32; 2], LineError> {
    let shown = || format!("{width}x{height}");
    let whole = |side: f64| side >= 1.0 && side.fract() == 0.0;
    if !whole(width) || !whole(height) {
        return Err(LineError::new(line, shown(), "is not a resolution: give two whole numbers of pixels, at least 1"));
    }
    if width * height > rt_image::Image::MAX_PIXELS as f64 {
        return Err(LineError::new(line, shown(), "pixels are more than 2^28: choose a smaller image"));
    }
    // Both fit, because their product does.
    Ok([width as u32, height as u32])
}
