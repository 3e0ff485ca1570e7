//! Images to files.

use std::io::Write;

use image::{
    ExtendedColorType, ImageEncoder, ImageError,
    codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, png::PngEncoder},
    error::{EncodingError, ParameterError, ParameterErrorKind},
};

use crate::{Development, Image, ImageFileError, ImageFormat, exr_layers::encode_image, pfm};

/// Quality of JPEG files, out of 100: no visible blocks.
const JPEG_QUALITY: u8 = 95;

/// Writes an image in the given format: developed for PNG and JPEG, linear radiance for EXR, HDR and PFM.
///
/// The file is made in memory and then handed to the writer, which is not touched if the format cannot hold the image.
/// If the writer fails, the output is incomplete: to keep an older file, write to another one and rename that.
///
/// # Errors
/// [`ImageFileError::Write`] if the writer fails, [`ImageFileError::Encode`] if the format cannot hold the image.
pub fn write_image(
    image: &Image,
    development: &Development,
    format: ImageFormat,
    mut writer: impl Write,
) -> Result<(), ImageFileError> {
    // The encoders would hide the kind of a writer's error (a full disk) in their own.
    let bytes = encode(image, development, format)
        .map_err(|error| ImageFileError::Encode { format, reason: error.to_string() })?;
    writer.write_all(&bytes).and_then(|()| writer.flush()).map_err(ImageFileError::Write)
}

/// Pixels of the longest scanline of a Radiance file that is compressed.
const LONGEST_SCANLINE: u32 = 0x7fff;

/// The bytes of the file.
fn encode(image: &Image, development: &Development, format: ImageFormat) -> Result<Vec<u8>, ImageError> {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        let kind = ParameterErrorKind::Generic("it has no pixels".to_owned());
        return Err(ImageError::Parameter(ParameterError::from_kind(kind)));
    }
    let mut bytes = Vec::new();
    match format {
        ImageFormat::Png => {
            let bitmap = development.develop(image);
            let layout = if bitmap.channels == 4 { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 };
            PngEncoder::new(&mut bytes).write_image(&bitmap.bytes, width, height, layout)?;
        }
        ImageFormat::Jpeg => {
            let bitmap = development.develop_over_black(image);
            let encoder = JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
            encoder.write_image(&bitmap.bytes, width, height, ExtendedColorType::Rgb8)?;
        }
        ImageFormat::Exr => {
            let format = image::ImageFormat::OpenExr.into();
            bytes = encode_image(image).map_err(|error| ImageError::Encoding(EncodingError::new(format, error)))?;
        }
        ImageFormat::Hdr => {
            let pixels: Vec<_> = image.pixels().iter().map(|&value| image::Rgb(representable_in_rgbe(value))).collect();
            if width == LONGEST_SCANLINE + 1 {
                // The encoder would compress its scanlines, of which the format cannot state the length. It stores narrow images as they are.
                HdrEncoder::new(&mut bytes).encode(&pixels, 1, pixels.len())?;
                let size = format!("-Y {} +X 1\n", pixels.len());
                if let Some(at) = bytes.windows(size.len()).position(|window| window == size.as_bytes()) {
                    bytes.splice(at..at + size.len(), format!("-Y {height} +X {width}\n").into_bytes());
                }
            } else {
                HdrEncoder::new(&mut bytes).encode(&pixels, width as usize, height as usize)?;
            }
        }
        ImageFormat::Pfm => pfm::write(image, &mut bytes)?,
    }
    Ok(bytes)
}

/// The nearest radiance that three bytes with a shared exponent represent. The encoder rounds others down, by 0.3 % on average, and
/// wraps exponents around that do not fit in a byte.
fn representable_in_rgbe(radiance: [f32; 3]) -> [f32; 3] {
    // 255/256 · 2¹²⁷.
    const LARGEST: f32 = 255.0 * (1u128 << 119) as f32;
    let clamped = radiance.map(|value| if value.is_nan() { 0.0 } else { value.clamp(0.0, LARGEST) });
    let largest = clamped.into_iter().fold(0.0, f32::max);
    if largest < f32::MIN_POSITIVE {
        return [0.0; 3];
    }
    // The largest number has eight bits. It may be rounded up to the next power of two.
    let rounded = |value: f32, step: f32| (value / step).round() * step;
    let step = step_below(rounded(largest, step_below(largest)));
    clamped.map(|value| rounded(value, step).min(LARGEST))
}

/// The place value of the last of eight bits of a normal number.
fn step_below(value: f32) -> f32 {
    const EXPONENT: u32 = 0xff << 23;
    f32::from_bits(value.to_bits() & EXPONENT) / 128.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_image;
    use crate::test_images::{film, film_by_index, written};
    use std::io;

    /// Writes the image to a file, and reads it.
    fn read_back(image: &Image, format: ImageFormat) -> Image {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("image");
        std::fs::write(&path, written(image, &Development::default(), format)).expect("a file");
        read_image(&path).expect("readable")
    }

    /// Values over the whole range of `f32`, also those that no image should hold.
    fn varied_image(with_alpha: bool) -> Image {
        let mut image = film_by_index(9, 5, with_alpha, |index| {
            let value = index as f32;
            [value / 44.0, 1e30 / (1.0 + value), -value * 1e-40]
        });
        image.pixels_mut()[7] = [f32::INFINITY, -0.0, f32::MAX];
        if let Some(alpha) = image.alpha_mut() {
            for (index, alpha) in alpha.iter_mut().enumerate() {
                *alpha = index as f32 / 44.0;
            }
        }
        image
    }

    #[test]
    fn hdr_images_with_scanlines_of_about_the_longest_compressed_length_are_read_back() {
        for width in [LONGEST_SCANLINE, LONGEST_SCANLINE + 1, LONGEST_SCANLINE + 2] {
            let image = film_by_index(width, 2, false, |index| [(index % 7) as f32, (index % 256) as f32, 0.5]);
            let read = read_back(&image, ImageFormat::Hdr);
            assert_eq!([read.width(), read.height()], [width, 2]);
            for (pixel, written) in read.pixels().iter().zip(image.pixels()) {
                assert_eq!(*pixel, representable_in_rgbe(*written), "width {width}");
            }
        }
    }

    #[test]
    fn exr_keeps_every_bit() {
        for with_alpha in [false, true] {
            let image = varied_image(with_alpha);
            assert_eq!(read_back(&image, ImageFormat::Exr).checksum(), image.checksum());
        }
    }

    /// The encoder wrote blocks as threads finished them.
    #[test]
    fn exr_files_of_many_blocks_are_equal() {
        let mut image = Image::new(700, 300, true);
        // Blocks of noise take longer than black ones.
        for (i, pixel) in image.pixels_mut().iter_mut().enumerate().filter(|(i, _)| i / 64 % 2 == 0) {
            *pixel = [0x9e37_79b9, 0x85eb_ca6b, 0xc2b2_ae35].map(|factor: u32| factor.wrapping_mul(i as u32) as f32);
        }
        let write = || written(&image, &Development::default(), ImageFormat::Exr);
        let first = write();
        assert!((0..20).all(|_| write() == first));
    }

    #[test]
    fn pfm_keeps_every_bit_of_radiance() {
        let image = varied_image(false);
        assert_eq!(read_back(&image, ImageFormat::Pfm).checksum(), image.checksum());
    }

    #[test]
    fn png_holds_the_developed_bytes() {
        let development = Development { exposure: 1.5, ..Development::default() };
        for with_alpha in [false, true] {
            let image = varied_image(with_alpha);
            let decoded = image::load_from_memory(&written(&image, &development, ImageFormat::Png)).expect("a PNG");
            let developed = development.develop(&image);
            assert_eq!(decoded.as_bytes(), developed.bytes);
            assert_eq!(decoded.color().channel_count(), developed.channels);
        }
    }

    #[test]
    fn jpeg_is_close_to_the_developed_bytes() {
        let image = film_by_index(16, 16, true, |index| [index as f32 / 255.0, 0.25, 0.5]);
        let development = Development::default();
        let decoded = image::load_from_memory(&written(&image, &development, ImageFormat::Jpeg)).expect("a JPEG");
        let developed = development.develop_over_black(&image).bytes;
        for (a, b) in decoded.as_bytes().iter().zip(developed) {
            assert!(a.abs_diff(b) < 12, "{a} {b}");
        }
    }

    #[test]
    fn hdr_keeps_seven_bits() {
        let image = film_by_index(40, 3, false, |index| [1e-3 * index as f32, 1.0, index as f32 * 1e3]);
        let read = read_back(&image, ImageFormat::Hdr);
        for (a, b) in image.pixels().iter().zip(read.pixels()) {
            let largest = a.iter().fold(0f32, |largest, &value| largest.max(value));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= largest / 128.0), "{a:?} {b:?}");
        }
    }

    /// Regression: the encoder cuts bits off, so that files were 0.3 to 0.4 % too dark.
    #[test]
    fn hdr_is_rounded_to_the_nearest_number() {
        let mut image = film_by_index(64, 64, false, |index| {
            let number = |offset: u64| even_number(index as u64 * 3 + offset);
            [number(0), 0.1 * number(1), 3.0 * number(2)]
        });
        image.pixels_mut()[0] = [0.999, 0.998, 0.501];
        let read = read_back(&image, ImageFormat::Hdr);
        let mut bias = 0.0;
        for (a, b) in image.pixels().iter().zip(read.pixels()) {
            let largest = a.iter().fold(0f32, |largest, &value| largest.max(value));
            // Half a step of eight bits.
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= largest / 255.0), "{a:?} {b:?}");
            bias += a.iter().zip(b).map(|(a, b)| f64::from(b - a)).sum::<f64>();
        }
        let total: f64 = image.pixels().as_flattened().iter().copied().map(f64::from).sum();
        assert!((bias / total).abs() < 2e-4, "{}", bias / total);
    }

    /// A number from 0 to 1, spread evenly over indices (Weyl 1916).
    fn even_number(index: u64) -> f32 {
        (index as f64 * 0.618_033_988_749_894_8).fract() as f32
    }

    #[test]
    fn hdr_of_tiny_or_huge_radiance_does_not_wrap_around() {
        let pixels = [
            [1e-40, 0.0, 0.0],
            [f32::INFINITY, 0.0, 0.0],
            [f32::NAN, 1.0, -3.0],
            [f32::MAX, 1.0, 0.0],
            [f32::MIN_POSITIVE, 0.0, 0.0],
        ];
        let read = read_back(&film(5, 1, &pixels), ImageFormat::Hdr);
        let red = |index: usize| read.pixels()[index][0];
        assert_eq!(read.pixels()[0], [0.0; 3]);
        assert!(red(1) > 1e38 && red(3) > 1e38);
        assert_eq!(read.pixels()[2], [0.0, 1.0, 0.0]);
        assert_eq!(red(4), f32::MIN_POSITIVE);
    }

    /// A disk that is full after some bytes.
    struct FullDisk(usize);

    impl Write for FullDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0 == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let count = bytes.len().min(self.0);
            self.0 -= count;
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_a_write_error_in_every_format() {
        for format in ImageFormat::ALL {
            for free in [0, 1, 100] {
                match write_image(&varied_image(false), &Development::default(), format, FullDisk(free)) {
                    Err(ImageFileError::Write(error)) => assert_eq!(error.kind(), io::ErrorKind::StorageFull),
                    other => panic!("{format:?} with {free} bytes free: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn images_that_a_format_cannot_hold_are_refused() {
        for format in ImageFormat::ALL {
            for (width, height) in [(0, 0), (0, 3), (3, 0)] {
                let result =
                    write_image(&Image::new(width, height, false), &Development::default(), format, io::sink());
                assert!(matches!(result, Err(ImageFileError::Encode { .. })), "{format:?}: {result:?}");
            }
        }
        let too_long = Image::new(70_000, 1, false);
        let result = write_image(&too_long, &Development::default(), ImageFormat::Jpeg, io::sink());
        assert!(matches!(result, Err(ImageFileError::Encode { format: ImageFormat::Jpeg, .. })), "{result:?}");
    }
}
