//! Linear radiance, one value per pixel.

use rt_math::{
    Rgb,
    random::{hash, mix},
};

/// Linear radiance of each pixel, row by row from the top, with optional coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    alpha: Option<Vec<f32>>,
}

impl Image {
    /// Pixels of the largest image that is accepted: 2²⁸, four gigabytes with coverage.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// A black image, optionally with an alpha channel of zeros. It allocates all of its pixels: check sizes that
    /// come from outside first.
    pub fn new(width: u32, height: u32, with_alpha: bool) -> Self {
        let count = width as usize * height as usize;
        Self { width, height, pixels: vec![[0.0; 3]; count], alpha: with_alpha.then(|| vec![0.0; count]) }
    }

    /// Width in pixels.
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Linear radiance, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Linear radiance, to write to.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.pixels
    }

    /// Coverage of each pixel, if the image has it; radiance is premultiplied.
    pub fn alpha(&self) -> Option<&[f32]> {
        self.alpha.as_deref()
    }

    /// Coverage, to write to.
    pub fn alpha_mut(&mut self) -> Option<&mut [f32]> {
        self.alpha.as_deref_mut()
    }

    /// Linear radiance of the pixel in column `x` and row `y`; `None` outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let inside = x < self.width && y < self.height;
        let index = y as usize * self.width as usize + x as usize;
        inside.then(|| Rgb::from(self.pixels[index].map(f64::from)))
    }

    /// Hash of the size and of every bit of radiance and coverage: equal for equal images, and for different ones
    /// with probability 2⁻⁶⁴. Unlike `==`, it distinguishes 0 and −0, and a NaN equals itself.
    pub fn checksum(&self) -> u64 {
        let start = hash(&[u64::from(self.width), u64::from(self.height), u64::from(self.alpha.is_some())]);
        let values = self.pixels.as_flattened().iter().chain(self.alpha.iter().flatten());
        values.fold(start, |state, value| mix(state.rotate_left(23) ^ u64::from(value.to_bits())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_stored_row_by_row() {
        let mut film = Image::new(3, 2, false);
        film.pixels_mut()[4] = [1.0, 2.0, 3.0];
        assert_eq!(film.pixel(1, 1), Some(Rgb::new(1.0, 2.0, 3.0)));
        assert_eq!(film.pixel(1, 0), Some(Rgb::BLACK));
        assert_eq!(film.pixel(3, 0), None);
        assert_eq!(film.pixel(0, 2), None);
        assert_eq!(film.alpha(), None);
    }

    #[test]
    fn checksums_see_every_bit() {
        let film = Image::new(4, 3, true);
        let mut sums = vec![
            film.checksum(),
            Image::new(3, 4, true).checksum(),
            Image::new(4, 3, false).checksum(),
            Image::new(12, 1, true).checksum(),
        ];
        for index in 0..12 {
            for component in 0..3 {
                let mut changed = film.clone();
                changed.pixels_mut()[index][component] = f32::from_bits(1);
                sums.push(changed.checksum());
            }
            let mut changed = film.clone();
            changed.alpha_mut().expect("asked for")[index] = -0.0;
            sums.push(changed.checksum());
        }
        let distinct: std::collections::HashSet<_> = sums.iter().collect();
        assert_eq!(distinct.len(), sums.len());
        assert_eq!(film.checksum(), film.clone().checksum());
    }
}
