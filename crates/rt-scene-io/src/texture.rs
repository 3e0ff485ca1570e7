//! Image files to linear pixels.

use std::fmt::Display;
use std::io::Cursor;

use image::{ImageDecoder, ImageFormat};
use rt_image::{Encoding, ExrParts, TexturePixels, decode_pixels, exr_parts, guess_format, image_decoder};
use rt_shading::Bitmap;

use crate::texture_error::TextureError;
use crate::{LoadErrorKind, MemoryBudget, limits};

/// Decodes a PNG, JPEG, HDR or EXR image, recognised by its content, to linear colour and alpha.
///
/// Integer formats hold sRGB-encoded colour, floating-point formats linear colour. Alpha is always linear.
///
/// # Errors
/// A damaged, unsupported, empty or too large image, or a NaN. The size is checked before memory is allocated.
pub fn decode_texture(bytes: &[u8]) -> Result<Bitmap, TextureError> {
    open(bytes)?.decode(PixelEncoding::Colors)
}

/// Version of [`decode_texture`] for data such as normal maps: integers are divided by their maximum.
///
/// # Errors
/// Errors of [`decode_texture`].
pub fn decode_numbers(bytes: &[u8]) -> Result<Bitmap, TextureError> {
    open(bytes)?.decode(PixelEncoding::Numbers)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum PixelEncoding {
    /// Colours: integers are encoded as sRGB.
    Colors,
    /// Numbers without conversion.
    Numbers,
}

/// Decodes an image if the budget suffices, and charges the budget for the result.
pub(crate) fn decode_within(
    bytes: &[u8],
    pixels: PixelEncoding,
    what: impl Display + Copy,
    memory: &MemoryBudget,
) -> Result<Bitmap, LoadErrorKind> {
    let image = open(bytes)?;
    let decoding = memory.reserve(what, image.peak_bytes())?;
    let bitmap = image.decode(pixels)?;
    drop(decoding);
    memory.keep(what, bitmap.memory() as u64)?;
    Ok(bitmap)
}

/// An image whose header is read and sound.
struct OpenedImage<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
    /// Bytes of the largest block that the decoder of an EXR image unpacks at once.
    block_bytes: u64,
}

fn open(bytes: &[u8]) -> Result<OpenedImage<'_>, TextureError> {
    let damaged = |error: image::ImageError| TextureError::Damaged(error.to_string());
    let format = guess_format(bytes).filter(ImageFormat::reading_enabled).ok_or(TextureError::UnknownFormat)?;
    let mut source = Box::new(Cursor::new(bytes));
    // An EXR image is decoded in tiles or blocks of rows of the data window, whose sizes are taken from the header.
    let exr = exr_parts(&mut *source).map_err(|error| TextureError::Damaged(error.to_string()))?;
    let ExrParts { window_pixels, block_bytes } = exr.unwrap_or(ExrParts { window_pixels: 0, block_bytes: 0 });
    if window_pixels > limits::TEXTURE_PIXELS || block_bytes / limits::TEXTURE_EXPANSION > bytes.len() as u64 {
        let length = bytes.len();
        let message =
            format!("{window_pixels} pixels in blocks of {block_bytes} bytes cannot come from {length} bytes");
        return Err(TextureError::Damaged(message));
    }
    let decoder = image_decoder(source, format, limits::TEXTURE_BYTES).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(TextureError::NoPixels(width, height));
    }
    if pixels > limits::TEXTURE_PIXELS || pixels * size_of::<[f32; 3]>() as u64 > limits::TEXTURE_BYTES {
        return Err(TextureError::TooLarge(width, height));
    }
    let decoded = decoder.total_bytes();
    let can_be = match packed_png_bytes(bytes) {
        // Images of few colours grow when they are read, to a byte and more for each bit.
        Some(packed) => packed / limits::PNG_EXPANSION <= bytes.len() as u64,
        None => decoded / limits::TEXTURE_EXPANSION <= bytes.len() as u64,
    };
    if !can_be {
        let message = format!("{width}x{height} pixels cannot come from {} bytes", bytes.len());
        return Err(TextureError::Damaged(message));
    }
    Ok(OpenedImage { decoder, block_bytes })
}

impl OpenedImage<'_> {
    /// Peak memory of decoding: the pixels of the file, those of three channels, and the linear ones with alpha. Or three copies of a
    /// block, if these take more.
    fn peak_bytes(&self) -> u64 {
        let (width, height) = self.decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        let color = self.decoder.color_type();
        let file = u64::from(color.bytes_per_pixel());
        let three_channels = file / u64::from(color.channel_count()) * 3;
        let alpha = if color.has_alpha() { size_of::<f32>() as u64 } else { 0 };
        let bytes = file.max(three_channels) + three_channels + size_of::<[f32; 3]>() as u64 + alpha;
        pixels.saturating_mul(bytes).max(self.block_bytes.saturating_mul(3))
    }

    fn decode(self, pixels: PixelEncoding) -> Result<Bitmap, TextureError> {
        let (width, height) = self.decoder.dimensions();
        let image = decode_pixels(self.decoder).map_err(|error| TextureError::Damaged(error.to_string()))?;
        let decoded = match pixels {
            PixelEncoding::Colors => TexturePixels::decode(image, &|signal| Encoding::Srgb.decode_signal(signal)),
            PixelEncoding::Numbers => TexturePixels::decode(image, &|signal| signal),
        };
        match decoded.non_finite() {
            0 => Ok(Bitmap { width, height, pixels: decoded.pixels, alpha: decoded.alpha }),
            bad => Err(TextureError::NonFinite(bad)),
        }
    }
}

/// The size of the pixels of a PNG before they are compressed, by its header; `None` for other formats.
fn packed_png_bytes(bytes: &[u8]) -> Option<u64> {
    let header = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?.get(8..18)?;
    let number = |at: usize| header.get(at..at + 4)?.try_into().ok().map(u32::from_be_bytes);
    let (width, height, depth, kind) = (number(0)?, number(4)?, header[8], header[9]);
    let channels = match kind {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    let line = (u64::from(width) * u64::from(depth) * channels).div_ceil(8);
    Some(line.saturating_mul(u64::from(height)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, Luma, Rgb, RgbImage};

    fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn eight_bit_colour_is_decoded_to_linear() {
        let image = RgbImage::from_fn(2, 1, |x, _| if x == 0 { Rgb([0, 255, 188]) } else { Rgb([10, 11, 12]) });
        let bitmap = decode_texture(&encode(image, ImageFormat::Png)).unwrap();
        assert_eq!((bitmap.width, bitmap.height), (2, 1));
        let [r, g, b] = bitmap.pixels[0];
        assert_eq!((r, g), (0.0, 1.0));
        assert!((b - 0.502_886_5).abs() < 1e-6, "{b}");
        // Both sides of the joint of the curve: 10 lies on the line, 11 on the power.
        assert_eq!(bitmap.pixels[1][0], (10.0 / 255.0 / 12.92) as f32);
        assert!((bitmap.pixels[1][1] - 0.003_346_536).abs() < 1e-8);
    }

    #[test]
    fn sixteen_bits_gray_and_floats_are_read() {
        let gray = image::ImageBuffer::from_pixel(1, 1, Luma([65535_u16]));
        assert_eq!(decode_texture(&encode(gray, ImageFormat::Png)).unwrap().pixels, [[1.0; 3]]);
        let float = || image::Rgb32FImage::from_pixel(1, 1, Rgb([2.5, 0.5, 0.0]));
        for format in [ImageFormat::OpenExr, ImageFormat::Hdr] {
            assert_eq!(decode_texture(&encode(float(), format)).unwrap().pixels, [[2.5, 0.5, 0.0]], "{format:?}");
        }
        let nan = image::Rgb32FImage::from_pixel(1, 1, Rgb([f32::NAN, 0.5, 0.0]));
        assert!(matches!(decode_texture(&encode(nan, ImageFormat::OpenExr)), Err(TextureError::NonFinite(1))));
    }

    /// Mitsuba and others write this header.
    #[test]
    fn radiance_textures_with_the_older_header_were_no_images() {
        let bytes = encode(image::Rgb32FImage::from_pixel(1, 1, Rgb([2.5, 0.5, 0.0])), ImageFormat::Hdr);
        let rest = bytes.strip_prefix(b"#?RADIANCE").unwrap();
        assert_eq!(decode_texture(&[b"#?RGBE", rest].concat()).unwrap().pixels, [[2.5, 0.5, 0.0]]);
    }

    #[test]
    fn damaged_images_are_refused_at_every_length() {
        let whole = encode(RgbImage::from_fn(9, 9, |x, y| Rgb([x as u8, y as u8, 7])), ImageFormat::Png);
        for length in 0..whole.len() - 12 {
            assert!(decode_texture(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
        for other in [&b"not an image"[..], b"BM", b"GIF89a", b"II*\0"] {
            assert!(matches!(decode_texture(other), Err(TextureError::UnknownFormat)), "{other:?}");
        }
    }

    #[test]
    fn a_texture_bomb_is_refused_before_it_is_decoded() {
        // The header alone claims 60 000² pixels.
        let bytes = claiming(60_000, 60_000);
        assert!(matches!(decode_texture(&bytes), Err(TextureError::TooLarge(60_000, 60_000))));
    }

    /// Memory was taken for all pixels that a header claims, however short the file.
    #[test]
    fn a_few_bytes_that_claim_millions_of_pixels_are_refused_before_memory_is_taken() {
        let error = decode_texture(&claiming(40, 2_162_718)).expect_err("83 bytes").to_string();
        assert!(error.contains("40x2162718 pixels cannot come from"), "{error}");
        let mut exr = encode(image::Rgb32FImage::new(6, 4), ImageFormat::OpenExr);
        let name = b"dataWindow\0box2i\0";
        let window = exr.windows(name.len()).position(|bytes| bytes == name).unwrap() + name.len() + 4;
        exr[window + 8..window + 12].copy_from_slice(&8_000_i32.to_le_bytes());
        exr[window + 12..window + 16].copy_from_slice(&8_000_i32.to_le_bytes());
        assert!(matches!(decode_texture(&exr), Err(TextureError::Damaged(_))));
    }

    /// Memory was taken for a whole tile that a header describes, however small the image and short the file.
    #[test]
    fn a_few_bytes_that_describe_a_huge_tile_are_refused_before_memory_is_taken() {
        let plain = encode(image::Rgb32FImage::new(6, 4), ImageFormat::OpenExr);
        let name = b"tiles\0tiledesc\0";
        let sides = plain.windows(name.len()).position(|bytes| bytes == name).expect("it is tiled") + name.len() + 4;
        let tiled = |side: u32| {
            let mut exr = plain.clone();
            exr[sides..sides + 8].copy_from_slice([side, side].map(u32::to_le_bytes).as_flattened());
            exr
        };
        decode_texture(&tiled(48)).expect("a tile that is a little larger than the image");
        let error = decode_texture(&tiled(20_000)).expect_err("some hundred bytes").to_string();
        assert!(error.contains("in blocks of 4800000000 bytes cannot come from"), "{error}");
    }

    #[test]
    fn images_of_few_colours_may_grow_when_they_are_read() {
        let mut header = claiming(1000, 1000);
        (header[24], header[25]) = (1, 0);
        assert_eq!(packed_png_bytes(&header), Some(125_000));
        (header[24], header[25]) = (16, 6);
        assert_eq!(packed_png_bytes(&header), Some(8_000_000));
        assert_eq!(packed_png_bytes(b"GIF"), None);
    }

    /// A PNG of one pixel whose header claims others.
    fn claiming(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = encode(RgbImage::new(1, 1), ImageFormat::Png);
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let checksum = crc32fast::hash(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        bytes
    }
}
