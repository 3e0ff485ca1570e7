//! Image files to linear pixels.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits};
use rt_camera::Encoding;
use rt_shading::Bitmap;

/// Most pixels that a texture may have.
const MAX_PIXELS: u64 = 1 << 28;

/// Most memory that a texture may take, decoded.
const MAX_BYTES: u64 = 1 << 30;

/// Why an image cannot be used as a texture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The bytes are no PNG, JPEG, HDR or EXR image.
    #[error("is not a PNG, JPEG, HDR or EXR image")]
    UnknownFormat,
    /// The image is damaged, or uses a part of its format that is not supported.
    #[error("cannot be decoded: {0}")]
    Damaged(String),
    /// More than 2²⁸ pixels or more than 1 GiB as linear `f32`.
    #[error("has {0} x {1} pixels; textures may have at most 2^28 pixels and take at most 1 GiB; scale it down")]
    TooLarge(u32, u32),
    /// No pixels.
    #[error("has {0} x {1} pixels; it must have at least one")]
    NoPixels(u32, u32),
    /// A pixel that is NaN or infinite.
    #[error("has {0} pixels that are not finite numbers")]
    NotFinite(usize),
}

/// Decodes a PNG, JPEG, HDR or EXR image, told apart by content, to linear colour; an alpha channel is dropped.
///
/// Integer formats hold sRGB-encoded colour, floating-point formats linear light.
///
/// # Errors
/// If the image is damaged, of another format, empty, too large, or holds a NaN. Its size is checked before memory is
/// taken.
pub fn decode_texture(bytes: &[u8]) -> Result<Bitmap, TextureError> {
    let damaged = |error: image::ImageError| TextureError::Damaged(error.to_string());
    let format = image::guess_format(bytes).map_err(|_| TextureError::UnknownFormat)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);

    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(TextureError::NoPixels(width, height));
    }
    if pixels > MAX_PIXELS || pixels * size_of::<[f32; 3]>() as u64 > MAX_BYTES {
        return Err(TextureError::TooLarge(width, height));
    }
    let pixels = linear_pixels(DynamicImage::from_decoder(decoder).map_err(damaged)?);
    match pixels.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count() {
        0 => Ok(Bitmap { width, height, pixels }),
        bad => Err(TextureError::NotFinite(bad)),
    }
}

fn linear_pixels(image: DynamicImage) -> Vec<[f32; 3]> {
    use image::ColorType::{L16, La16, Rgb16, Rgb32F, Rgba16, Rgba32F};
    match image.color() {
        Rgb32F | Rgba32F => image.into_rgb32f().pixels().map(|pixel| pixel.0).collect(),
        L16 | La16 | Rgb16 | Rgba16 => {
            let decode = |c: u16| Encoding::Srgb.decode_signal(f64::from(c) / 65535.0) as f32;
            image.into_rgb16().pixels().map(|pixel| pixel.0.map(decode)).collect()
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|c| Encoding::Srgb.decode(c as u8));
            image.into_rgb8().pixels().map(|pixel| pixel.0.map(|c| table[usize::from(c)])).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageFormat, Luma, Rgb, RgbImage};

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
        assert!(matches!(decode_texture(&encode(nan, ImageFormat::OpenExr)), Err(TextureError::NotFinite(1))));
    }

    #[test]
    fn damaged_images_are_refused_at_every_length() {
        let whole = encode(RgbImage::from_fn(9, 9, |x, y| Rgb([x as u8, y as u8, 7])), ImageFormat::Png);
        for length in 0..whole.len() - 12 {
            assert!(decode_texture(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
        assert!(matches!(decode_texture(b"not an image"), Err(TextureError::UnknownFormat)));
    }

    #[test]
    fn a_texture_bomb_is_refused_before_it_is_decoded() {
        // The header alone claims 60 000² pixels.
        let mut bytes = encode(RgbImage::new(1, 1), ImageFormat::Png);
        bytes[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        assert!(matches!(decode_texture(&bytes), Err(TextureError::TooLarge(60_000, 60_000))));
    }

    /// The checksum of PNG chunks (ISO 3309), bit by bit.
    fn crc32(bytes: &[u8]) -> u32 {
        let mut crc = !0_u32;
        for &byte in bytes {
            crc ^= u32::from(byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
            }
        }
        !crc
    }
}
