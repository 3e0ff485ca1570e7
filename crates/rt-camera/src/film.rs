//! The film: linear radiance, one value a pixel.

use crate::{Development, DevelopmentError, Filter};
use rt_math::{
    DVec2, Rgb,
    random::{hash, mix},
};

/// What the image is like: its size, where samples fall, and how it is developed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Where in the pixel the pattern's centre falls: (0.5, 0.5) is the middle, (0, 0) the upper left corner.
    pub sample_offset: DVec2,
    /// Reconstruction filter.
    pub filter: Filter,
    /// How radiance becomes bytes.
    pub development: Development,
}

impl Default for FilmSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            sample_offset: DVec2::splat(0.5),
            filter: Filter::Box,
            development: Development::default(),
        }
    }
}

/// Why an image cannot be exposed with these settings.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// A side (width, height) is 0.
    #[error("the image is {0} by {1} pixels; both sides must be at least 1")]
    Empty(u32, u32),
    /// The image (width, height) has more than [`Film::MAX_PIXELS`].
    #[error("the image is {0} by {1} pixels; at most {max} pixels are possible", max = Film::MAX_PIXELS)]
    TooLarge(u32, u32),
    /// The sample offset is NaN or infinite.
    #[error("the sample offset ({}, {}) is not finite", .0.x, .0.y)]
    SampleOffset(DVec2),
    /// The standard deviation of the Gaussian filter (the value, in pixels) is not usable.
    #[error("the Gaussian filter's standard deviation is {0}; it must be positive and finite")]
    Sigma(f64),
    /// The development is not possible.
    #[error(transparent)]
    Development(#[from] DevelopmentError),
}

impl FilmSettings {
    /// Checks all of the settings.
    ///
    /// # Errors
    /// The first [`FilmError`] found.
    pub fn validate(&self) -> Result<(), FilmError> {
        if self.width == 0 || self.height == 0 {
            return Err(FilmError::Empty(self.width, self.height));
        }
        if u64::from(self.width) * u64::from(self.height) > Film::MAX_PIXELS {
            return Err(FilmError::TooLarge(self.width, self.height));
        }
        if !self.sample_offset.is_finite() {
            return Err(FilmError::SampleOffset(self.sample_offset));
        }
        if let Filter::Gaussian { sigma } = self.filter
            && !(sigma.is_normal() && sigma > 0.0)
        {
            return Err(FilmError::Sigma(sigma));
        }
        Ok(self.development.validate()?)
    }
}

/// Linear radiance of each pixel, row by row from the top, with optional coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    alpha: Option<Vec<f32>>,
}

impl Film {
    /// Pixels of the largest image that [`FilmSettings::validate`] accepts: 2²⁸, four gigabytes with coverage.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// A black film, with an alpha channel of zeros if asked for. It allocates all of its pixels: check sizes that
    /// come from outside with [`FilmSettings::validate`] first.
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

    /// Coverage of each pixel, if the film has it; radiance is premultiplied.
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

    /// A hash of the size and of every bit of radiance and coverage: equal for equal images, and for different ones
    /// with probability 2⁻⁶⁴. Unlike `==`, it tells 0 from −0 and finds a NaN equal to itself.
    pub fn checksum(&self) -> u64 {
        let start = hash(&[u64::from(self.width), u64::from(self.height), u64::from(self.alpha.is_some())]);
        let values = self.pixels.as_flattened().iter().chain(self.alpha.iter().flatten());
        values.fold(start, |state, value| mix(state.rotate_left(23) ^ u64::from(value.to_bits())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Encoding;

    #[test]
    fn useless_settings_are_refused() {
        let sound = FilmSettings::default();
        assert_eq!(sound.validate(), Ok(()));
        assert_eq!(FilmSettings { width: 0, ..sound }.validate(), Err(FilmError::Empty(0, 480)));
        assert_eq!(FilmSettings { height: 0, ..sound }.validate(), Err(FilmError::Empty(640, 0)));
        let side = 1 << 14;
        assert_eq!(FilmSettings { width: side, height: side, ..sound }.validate(), Ok(()));
        let too_large = FilmSettings { width: side, height: side + 1, ..sound };
        assert_eq!(too_large.validate(), Err(FilmError::TooLarge(side, side + 1)));
        let largest = FilmSettings { width: u32::MAX, height: u32::MAX, ..sound };
        assert_eq!(largest.validate(), Err(FilmError::TooLarge(u32::MAX, u32::MAX)));
        let offset = DVec2::new(0.0, f64::INFINITY);
        assert_eq!(FilmSettings { sample_offset: offset, ..sound }.validate(), Err(FilmError::SampleOffset(offset)));
        for sigma in [0.0, -1.0, f64::INFINITY] {
            let filter = Filter::Gaussian { sigma };
            assert_eq!(FilmSettings { filter, ..sound }.validate(), Err(FilmError::Sigma(sigma)));
        }
        let development = Development { encoding: Encoding::Power(0.0), ..Development::default() };
        assert_eq!(
            FilmSettings { development, ..sound }.validate(),
            Err(FilmError::Development(DevelopmentError::Gamma(0.0)))
        );
    }

    #[test]
    fn pixels_are_stored_row_by_row() {
        let mut film = Film::new(3, 2, false);
        film.pixels_mut()[4] = [1.0, 2.0, 3.0];
        assert_eq!(film.pixel(1, 1), Some(Rgb::new(1.0, 2.0, 3.0)));
        assert_eq!(film.pixel(1, 0), Some(Rgb::BLACK));
        assert_eq!(film.pixel(3, 0), None);
        assert_eq!(film.pixel(0, 2), None);
        assert_eq!(film.alpha(), None);
    }

    #[test]
    fn checksums_see_every_bit() {
        let film = Film::new(4, 3, true);
        let mut sums = vec![
            film.checksum(),
            Film::new(3, 4, true).checksum(),
            Film::new(4, 3, false).checksum(),
            Film::new(12, 1, true).checksum(),
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
