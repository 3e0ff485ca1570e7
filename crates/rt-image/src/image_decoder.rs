//! Decoders of the `image` crate behind dynamic calls: their generic code is compiled once, and not for each type of reader.

use std::io::{BufRead, Seek, SeekFrom};

use exr::meta::MetaData;
use image::error::DecodingError;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::gray_exr_decoder::{GrayExrDecoder, missing_colors};
use crate::hdr_decoder::HdrDecoder;
use crate::jpeg_decoder::JpegDecoder;

/// Bytes that the chunks of a PNG file may take in addition to those of the file and of some rows. Colour profiles are
/// unpacked, though nothing uses them. One that takes more is left out.
const PNG_CHUNK_BYTES: u64 = 1 << 20;

/// Bytes per pixel of the rows that a decoder of PNG files holds.
const PNG_ROW_BYTES: u64 = 64;

/// Content of an image file.
pub trait ImageSource: BufRead + Seek {}

impl<R: BufRead + Seek> ImageSource for R {}

/// Header of Radiance files by Ward's `rgbe.c` instead of `#?RADIANCE`.
const RGBE: &[u8] = b"#?RGBE";

/// Format of an image of the `image` crate by its first bytes; `None` for others.
pub fn guess_format(bytes: &[u8]) -> Option<ImageFormat> {
    if bytes.starts_with(RGBE) { Some(ImageFormat::Hdr) } else { image::guess_format(bytes).ok() }
}

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
    if format == ImageFormat::Hdr {
        let is_strict = !source.fill_buf()?.starts_with(RGBE);
        return Ok(Box::new(HdrDecoder::new(source, is_strict)?));
    }
    if format == ImageFormat::OpenExr && GrayExrDecoder::accepts(&mut source)? {
        return Ok(Box::new(GrayExrDecoder::new(source, max_bytes)?));
    }
    if format == ImageFormat::OpenExr
        && let Some(message) = missing_colors(&mut source)?
    {
        return Err(ImageError::Decoding(DecodingError::new(format.into(), message)));
    }
    let max_bytes = if format == ImageFormat::Png { max_bytes.min(png_bytes(&mut *source)?) } else { max_bytes };
    let mut reader = ImageReader::with_format(source, format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(max_bytes);
    reader.limits(limits);
    Ok(Box::new(reader.into_decoder()?))
}

/// Bytes that a decoder of a PNG file may allocate, in addition to the pixels, which its caller provides.
pub(crate) fn png_bytes(source: &mut dyn ImageSource) -> std::io::Result<u64> {
    let length = source.seek(SeekFrom::End(0))?;
    source.seek(SeekFrom::Start(16))?;
    let mut width = [0; 4];
    // A shorter file has no header, which the decoder finds out.
    let _ = source.read(&mut width)?;
    source.rewind()?;
    Ok(length + PNG_CHUNK_BYTES + PNG_ROW_BYTES * u64::from(u32::from_be_bytes(width)))
}

/// Parts of an EXR image that a decoder unpacks. They may be larger than the image, of which it returns the display window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExrParts {
    /// Pixels of the largest data window.
    pub window_pixels: u64,
    /// Bytes of the largest tile or block of rows, with all channels. A decoder holds up to three copies of one.
    pub block_bytes: u64,
}

/// Parts of an EXR image by the header at the start of `source`, where this leaves it. `None` for other formats, and for damaged headers,
/// which no decoder accepts.
///
/// # Errors
/// A source that cannot be read.
pub fn exr_parts(source: &mut dyn ImageSource) -> std::io::Result<Option<ExrParts>> {
    const MAGIC: &[u8] = b"\x76\x2f\x31\x01";
    if !source.fill_buf()?.starts_with(MAGIC) {
        return Ok(None);
    }
    let metadata = MetaData::read_from_buffered(&mut *source, false);
    source.rewind()?;
    let area = |width: usize, height: usize| (width as u64).saturating_mul(height as u64);
    let parts = metadata.ok().map(|metadata| {
        let mut parts = ExrParts { window_pixels: 0, block_bytes: 0 };
        for header in &metadata.headers {
            let (window, block) = (header.layer_size, header.max_block_pixel_size());
            parts.window_pixels = parts.window_pixels.max(area(window.0, window.1));
            let bytes = area(block.0, block.1).saturating_mul(header.channels.bytes_per_pixel as u64);
            parts.block_bytes = parts.block_bytes.max(bytes);
        }
        parts
    });
    Ok(parts)
}

/// Decodes the pixels.
///
/// # Errors
/// Those of the `image` crate: damaged data, and too little memory.
pub fn decode_pixels(decoder: Box<dyn ImageDecoder + '_>) -> Result<DynamicImage, ImageError> {
    DynamicImage::from_decoder(decoder)
}
