//! Decoder of Radiance files. That of the `image` crate ignores the exposure of the header.

use std::io::Read;

use image::codecs::hdr::{HdrDecoder as ImageHdrDecoder, HdrMetadata};
use image::error::DecodingError;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat};

/// Radiance file whose header is read.
pub(crate) struct HdrDecoder<R> {
    decoder: ImageHdrDecoder<R>,
    /// Product of all `EXPOSURE=` and `COLORCORR=` lines, by which the stored colours are larger than radiance.
    scale: [f32; 3],
}

impl<R: Read> HdrDecoder<R> {
    /// Reads the header. A strict decoder accepts the header of Radiance only.
    pub(crate) fn new(source: R, is_strict: bool) -> Result<Self, ImageError> {
        let decoder = ImageHdrDecoder::with_strictness(source, is_strict)?;
        let HdrMetadata { exposure, color_correction, .. } = decoder.metadata();
        let (red, green, blue) = color_correction.unwrap_or((1.0, 1.0, 1.0));
        let scale = [red, green, blue].map(|factor| factor * exposure.unwrap_or(1.0));
        if !scale.iter().all(|factor| factor.is_normal() && *factor > 0.0) {
            let message = format!("EXPOSURE times COLORCORR is {scale:?}, and must be positive");
            return Err(ImageError::Decoding(DecodingError::new(ImageFormat::Hdr.into(), message)));
        }
        Ok(Self { decoder, scale })
    }
}

impl<R: Read> ImageDecoder for HdrDecoder<R> {
    fn dimensions(&self) -> (u32, u32) {
        self.decoder.dimensions()
    }

    fn color_type(&self) -> ColorType {
        self.decoder.color_type()
    }

    fn read_image(self, pixels: &mut [u8]) -> Result<(), ImageError> {
        self.decoder.read_image(pixels)?;
        if self.scale != [1.0; 3] {
            let (components, _) = pixels.as_chunks_mut::<4>();
            for (component, scale) in components.iter_mut().zip(self.scale.iter().cycle()) {
                *component = (f32::from_ne_bytes(*component) / scale).to_ne_bytes();
            }
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, pixels: &mut [u8]) -> Result<(), ImageError> {
        (*self).read_image(pixels)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Image, ImageFileError, decode_image};

    /// One pixel of (1, 0.5, 0.25), with these lines in the header.
    fn read(magic: &str, lines: &str) -> Result<Image, ImageFileError> {
        let header = format!("{magic}\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
        decode_image(&[header.as_bytes(), &[128, 64, 32, 129]].concat(), Path::new("a.hdr"))
    }

    /// The lines were ignored.
    #[test]
    fn pixels_are_divided_by_the_exposures_and_colour_corrections_of_the_header() {
        for magic in ["#?RADIANCE", "#?RGBE"] {
            let pixels = |lines: &str| read(magic, lines).expect("readable").pixels()[0];
            assert_eq!(pixels(""), [1.0, 0.5, 0.25]);
            assert_eq!(pixels("EXPOSURE=2\nEXPOSURE= 0.25\n"), [2.0, 1.0, 0.5]);
            assert_eq!(pixels("COLORCORR= 1 2 4\nEXPOSURE=0.5\nCOLORCORR= 2 2 2\n"), [1.0, 0.25, 0.0625]);
        }
    }

    #[test]
    fn exposures_that_are_not_positive_are_refused() {
        for line in ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n", "EXPOSURE=1e999\n", "COLORCORR= 1 0 1\n"] {
            let error = read("#?RADIANCE", line).expect_err(line).to_string();
            assert!(error.contains("EXPOSURE times COLORCORR is ["), "{error}");
        }
    }
}
