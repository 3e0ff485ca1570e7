//! Images that several tests look at.

use crate::{Development, Encoding, Image};
#[cfg(feature = "files")]
use crate::{ImageFormat, write_image};

/// Development that keeps light from 0 to 1 as it is.
pub(crate) fn linear() -> Development {
    Development { encoding: Encoding::Power(1.0), ..Development::default() }
}

/// A film of the given radiance.
pub(crate) fn film(width: u32, height: u32, pixels: &[[f32; 3]]) -> Image {
    let mut film = Image::new(width, height, false);
    film.pixels_mut().copy_from_slice(pixels);
    film
}

/// A film of which every pixel is computed from its index. Coverage is 0.
pub(crate) fn film_by_index(width: u32, height: u32, with_alpha: bool, radiance: impl Fn(usize) -> [f32; 3]) -> Image {
    let mut film = Image::new(width, height, with_alpha);
    for (index, pixel) in film.pixels_mut().iter_mut().enumerate() {
        *pixel = radiance(index);
    }
    film
}

/// A film of which every pixel is computed from its column and row.
pub(crate) fn film_of(width: u32, height: u32, radiance: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    film_by_index(width, height, false, |index| radiance(index as u32 % width, index as u32 / width))
}

/// The bytes of a file.
#[cfg(feature = "files")]
pub(crate) fn written(image: &Image, development: &Development, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_image(image, development, format, &mut bytes).expect("written");
    bytes
}

/// 48 by 32 pixels of colour ramps with edges, in [0, 1].
pub(crate) fn ramps() -> Image {
    film_of(48, 32, |x, y| [1, 2, 3].map(|factor| ((x * factor + 3 * y) % 33) as f32 / 32.0))
}

/// The same with a pattern added, in [0, 1].
pub(crate) fn disturbed_ramps() -> Image {
    let ramps = ramps();
    film_of(48, 32, |x, y| {
        let ramp = ramps.pixels()[(48 * y + x) as usize];
        [0, 1, 2].map(|c: u32| (ramp[c as usize] + ((5 * x + 3 * y + 7 * c) % 11) as f32 / 64.0).min(1.0))
    })
}

/// Radiance multiplied by powers of two that grow from 2⁻² at the left to 2³ at the right.
pub(crate) fn brightened(film: &Image) -> Image {
    film_of(film.width(), film.height(), |x, y| {
        let gain = 2f32.powi((x / 8) as i32 - 2);
        film.pixels()[(film.width() * y + x) as usize].map(|value| value * gain)
    })
}
