//! Decoders of the `image` crate behind dynamic calls: their generic code is compiled once, and not for each type of reader.

use std::io::{BufRead, Seek};

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::jpeg_decoder::JpegDecoder;

/// Content of an image file.
pub trait ImageSource: BufRead + Seek {}

impl<R: BufRead + Seek> ImageSource for R {}

/// Reads the header of an image of a known format. The decoder allocates at most `max_bytes`.
///
/// # Errors
/// Those of the `image` crate: a damaged header, and a format that is not compiled in.
pub fn image_decoder<'r>(
    mut source: Box<dyn ImageSource + 'r>,
    format: ImageFormat,
    max_bytes: u64,
) -> Result<Box<dyn ImageDecoder + 'r>, ImageError> {
    if format == ImageFormat::Jpeg {
        return Ok(Box::new(JpegDecoder::new(&mut *source, max_bytes)?));
    }
    let mut reader = ImageReader::with_format(source, format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(max_bytes);
    reader.limits(limits);
    Ok(Box::new(reader.into_decoder()?))
}

/// Decodes the pixels.
///
/// # Errors
/// Those of the `image` crate: damaged data, and too little memory.
pub fn decode_pixels(decoder: Box<dyn ImageDecoder + '_>) -> Result<DynamicImage, ImageError> {
    DynamicImage::from_decoder(decoder)
}
