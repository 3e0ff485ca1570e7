//! Images that several tests look at.

use crate::Image;

/// A film of the given radiance.
pub(super) fn film(width: u32, height: u32, pixels: &[[f32; 3]]) -> Image {
    let mut film = Image::new(width, height, false);
    film.pixels_mut().copy_from_slice(pixels);
    film
}

/// A film of which every pixel is computed from its column and row.
pub(super) fn film_of(width: u32, height: u32, radiance: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let pixels: Vec<_> =
        (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).map(|[x, y]| radiance(x, y)).collect();
    film(width, height, &pixels)
}

/// 48 by 32 pixels of colour ramps with edges, in [0, 1].
pub(super) fn ramps() -> Image {
    film_of(48, 32, |x, y| [1, 2, 3].map(|factor| ((x * factor + 3 * y) % 33) as f32 / 32.0))
}

/// The same with a pattern added, in [0, 1].
pub(super) fn disturbed_ramps() -> Image {
    let ramps = ramps();
    film_of(48, 32, |x, y| {
        let ramp = ramps.pixels()[(48 * y + x) as usize];
        [0, 1, 2].map(|c: u32| (ramp[c as usize] + ((5 * x + 3 * y + 7 * c) % 11) as f32 / 64.0).min(1.0))
    })
}

/// Radiance multiplied by powers of two that grow from 2⁻² at the left to 2³ at the right.
pub(super) fn brightened(film: &Image) -> Image {
    film_of(film.width(), film.height(), |x, y| {
        let gain = 2f32.powi((x / 8) as i32 - 2);
        film.pixels()[(film.width() * y + x) as usize].map(|value| value * gain)
    })
}
