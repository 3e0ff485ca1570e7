//! Images of few bytes.

use image::{
    ExtendedColorType, ImageEncoder, ImageResult, RgbImage,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// A PNG file of an image with 32 steps for each colour, between which its compression finds much in common.
pub(super) fn png(image: &RgbImage) -> ImageResult<Vec<u8>> {
    let coarse: Vec<u8> = image.as_raw().iter().copied().map(coarse).collect();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter).write_image(
        &coarse,
        image.width(),
        image.height(),
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The nearest of 32 even steps from 0 to 255.
fn coarse(value: u8) -> u8 {
    let step = (u32::from(value) * 31 + 127) / 255;
    ((step * 255 + 15) / 31) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_keep_black_and_white_and_stay_near() {
        assert_eq!([coarse(0), coarse(255)], [0, 255]);
        assert!((0..=255).all(|value| coarse(value).abs_diff(value) <= 4 && coarse(coarse(value)) == coarse(value)));
    }

    #[test]
    fn the_file_holds_the_image() {
        let image = RgbImage::from_fn(5, 4, |x, y| image::Rgb([(x * 50) as u8, (y * 60) as u8, 255]));
        let read = image::load_from_memory(&png(&image).unwrap()).unwrap().to_rgb8();
        assert!(read.as_raw().iter().zip(image.as_raw()).all(|(a, b)| *a == coarse(*b)));
    }
}
