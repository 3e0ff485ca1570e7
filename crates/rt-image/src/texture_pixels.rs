//! Pixels of textures, from decoded image files.

use image::DynamicImage;

/// Pixels of a texture, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturePixels {
    /// Linear colours.
    pub pixels: Vec<[f32; 3]>,
    /// Alpha, 0 to 1; NaN counts as 1. Empty if all pixels are opaque.
    pub alpha: Vec<f32>,
}

impl TexturePixels {
    /// Converts the pixels of a decoded file.
    ///
    /// `linear` maps integers, as fractions of the largest, to linear values. Floating-point numbers are linear already,
    /// and may be NaN or infinite.
    pub fn decode(image: DynamicImage, linear: &dyn Fn(f64) -> f64) -> Self {
        let alpha = alpha(&image);
        Self { pixels: linear_pixels(image, linear), alpha }
    }

    /// Number of pixels with a component that is NaN or infinite.
    pub fn non_finite(&self) -> usize {
        self.pixels.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count()
    }
}

fn linear_pixels(image: DynamicImage, linear: &dyn Fn(f64) -> f64) -> Vec<[f32; 3]> {
    use image::ColorType::{L16, La16, Rgb16, Rgb32F, Rgba16, Rgba32F};
    match image.color() {
        Rgb32F | Rgba32F => image.into_rgb32f().pixels().map(|pixel| pixel.0).collect(),
        L16 | La16 | Rgb16 | Rgba16 => {
            let decode = |c: u16| linear(f64::from(c) / 65535.0) as f32;
            image.into_rgb16().pixels().map(|pixel| pixel.0.map(decode)).collect()
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|c| linear(c as f64 / 255.0) as f32);
            // Not by a conversion of the crate `image`, which the dev profile does not optimise.
            let channels = usize::from(image.color().channel_count());
            let rgb = |pixel: &[u8]| if channels < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
            image.as_bytes().chunks_exact(channels).map(|pixel| rgb(pixel).map(|c| table[usize::from(c)])).collect()
        }
    }
}

fn alpha(image: &DynamicImage) -> Vec<f32> {
    if !image.color().has_alpha() {
        return Vec::new();
    }
    let of = |alpha: f32| if alpha.is_nan() { 1.0 } else { alpha.clamp(0.0, 1.0) };
    let alpha: Vec<f32> = match image {
        DynamicImage::ImageRgba8(image) => image.pixels().map(|pixel| f32::from(pixel.0[3]) / 255.0).collect(),
        DynamicImage::ImageLumaA8(image) => image.pixels().map(|pixel| f32::from(pixel.0[1]) / 255.0).collect(),
        DynamicImage::ImageRgba32F(image) => image.pixels().map(|pixel| of(pixel.0[3])).collect(),
        other => other.to_rgba16().pixels().map(|pixel| f32::from(pixel.0[3]) / 65535.0).collect(),
    };
    if alpha.iter().all(|alpha| *alpha == 1.0) { Vec::new() } else { alpha }
}
