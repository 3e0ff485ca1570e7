//! Decoder of JPEG files.
//!
//! The versions of the `image` crate that build without colour management use a decoder that interpolates the colours of the
//! last columns wrongly.

use std::io::Read;

use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat};
use zune_jpeg::zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};
use zune_jpeg::{JpegDecoder as ZuneDecoder, errors::DecodeErrors};

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
        // A width or height of JPEG has 16 bits, and the part that is missing of a damaged file becomes grey.
        let most = usize::from(u16::MAX);
        let options = DecoderOptions::default().set_strict_mode(false).set_max_width(most).set_max_height(most);
        let mut decoder = ZuneDecoder::new_with_options(ZCursor::new(bytes), options);
        decoder.decode_headers().map_err(damaged)?;
        let is_gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
        let (color, space) =
            if is_gray { (ColorType::L8, ColorSpace::Luma) } else { (ColorType::Rgb8, ColorSpace::RGB) };
        decoder.set_options(options.jpeg_set_out_colorspace(space));
        let (width, height) = decoder.dimensions().unwrap_or_default();
        let this = Self { decoder, size: (width as u32, height as u32), color };
        if this.total_bytes() > max_bytes {
            return Err(ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory)));
        }
        Ok(this)
    }
}

fn damaged(error: DecodeErrors) -> ImageError {
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
        self.decoder.decode_into(pixels).map_err(damaged)
    }

    fn read_image_boxed(self: Box<Self>, pixels: &mut [u8]) -> Result<(), ImageError> {
        (*self).read_image(pixels)
    }
}
