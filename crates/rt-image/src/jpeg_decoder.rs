//! Decoder of JPEG files.
//!
//! The versions of the `image` crate that build without colour management use a decoder that interpolates the colours of the
//! last columns wrongly.

use std::error::Error;
use std::io::Read;

use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat};
use zune_jpeg::JpegDecoder as ZuneDecoder;
use zune_jpeg::zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};

/// Marker at the end of a file.
const END: [u8; 2] = [0xff, 0xd9];

/// JPEG file whose header is read.
pub(crate) struct JpegDecoder {
    decoder: ZuneDecoder<ZCursor<Vec<u8>>>,
    size: (u32, u32),
    color: ColorType,
}

impl JpegDecoder {
    /// Reads the header of a file whose pixels take at most `max_bytes`. All colours but grey become RGB.
    pub(crate) fn new(source: &mut dyn Read, max_bytes: u64) -> Result<Self, ImageError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes)?;
        // No code has ones only (ITU-T T.81, annex C), so that ones behind the pixels are an error in a file that ends early.
        // The decoder would read zeros behind the end, which are valid codes.
        let end = bytes.len() - if bytes.ends_with(&END) { END.len() } else { 0 };
        bytes.splice(end..end, [0xff, 0].repeat(16));
        // A width or height of JPEG has 16 bits. Some programs write extra bytes between the parts of the header.
        let most = usize::from(u16::MAX);
        let options = DecoderOptions::default().set_strict_mode(false).set_max_width(most).set_max_height(most);
        let mut decoder = ZuneDecoder::new_with_options(ZCursor::new(bytes), options);
        decoder.decode_headers().map_err(damaged)?;
        let is_gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
        let (color, space) =
            if is_gray { (ColorType::L8, ColorSpace::Luma) } else { (ColorType::Rgb8, ColorSpace::RGB) };
        // Otherwise the missing part of a damaged file becomes grey.
        decoder.set_options(options.set_strict_mode(true).jpeg_set_out_colorspace(space));
        let (width, height) = decoder.dimensions().unwrap_or_default();
        let this = Self { decoder, size: (width as u32, height as u32), color };
        if this.total_bytes() > max_bytes {
            return Err(ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory)));
        }
        Ok(this)
    }
}

fn damaged(error: impl Into<Box<dyn Error + Send + Sync>>) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormat::Jpeg.into(), error))
}

impl ImageDecoder for JpegDecoder {
    fn dimensions(&self) -> (u32, u32) {
        self.size
    }

    fn color_type(&self) -> ColorType {
        self.color
    }

    fn read_image(mut self, pixels: &mut [u8]) -> Result<(), ImageError> {
        self.decoder.decode_into(pixels).map_err(|error| damaged(format!("the file is truncated or damaged: {error}")))
    }

    fn read_image_boxed(self: Box<Self>, pixels: &mut [u8]) -> Result<(), ImageError> {
        (*self).read_image(pixels)
    }
}

#[cfg(test)]
mod tests {
    use image::codecs::jpeg::JpegEncoder;

    use super::*;

    fn decoded(mut file: &[u8]) -> Result<Vec<u8>, ImageError> {
        let decoder = JpegDecoder::new(&mut file, u64::MAX)?;
        let mut pixels = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut pixels)?;
        Ok(pixels)
    }

    /// Image of 64 x 64 pixels that are all different.
    fn noisy() -> Vec<u8> {
        let pixels: Vec<u8> = (0..64 * 64 * 3_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let mut file = Vec::new();
        JpegEncoder::new(&mut file).encode(&pixels, 64, 64, image::ExtendedColorType::Rgb8).expect("a file");
        file
    }

    const PROGRESSIVE: &[u8] = include_bytes!("../../../fuzz/seeds/picture/progressive.jpg");

    /// The rest of the image was grey, without an error.
    #[test]
    fn a_file_that_ends_early_was_accepted() {
        let noisy = noisy();
        for file in [&noisy, PROGRESSIVE] {
            assert!(decoded(file).is_ok());
            for percent in 0..=95 {
                let cut = &file[..file.len() * percent / 100];
                assert!(decoded(cut).is_err(), "{percent} %");
            }
        }
        let cut = &noisy[..noisy.len() / 2];
        for cut in [cut, &[cut, &END].concat()] {
            let error = decoded(cut).expect_err("half a file").to_string();
            assert!(error.contains("the file is truncated or damaged: "), "{error}");
        }
    }

    #[test]
    fn sloppy_files_with_all_pixels_are_accepted() {
        let file = noisy();
        let pixels = decoded(&file).expect("a file");
        let (start, rest) = file.split_at(2);
        for sloppy in [[start, &[0; 9], rest].concat(), [&file, &[7; 9][..]].concat(), file[..file.len() - 2].to_vec()]
        {
            assert!(decoded(&sloppy).is_ok_and(|same| same == pixels));
        }
    }
}
