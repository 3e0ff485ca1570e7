//! Settings of the film: size, sample position, reconstruction filter, development.

use crate::Filter;
use rt_image::{Development, DevelopmentError, Image};
use rt_math::DVec2;

/// Settings of the image: its size, filter, sample positions and development.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Position of the pattern's centre in the pixel: (0.5, 0.5) is the middle, (0, 0) the upper left corner.
    pub sample_offset: DVec2,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Mapping from radiance to bytes.
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

/// Error of [`FilmSettings::validate`]: settings with which no image can be exposed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// A side (width, height) is 0.
    #[error("the image is {0}x{1} pixels; both sides must be at least 1")]
    Empty(u32, u32),
    /// The image (width, height) has more than [`Image::MAX_PIXELS`].
    #[error("the image is {0}x{1} pixels; at most {max} pixels are possible", max = Image::MAX_PIXELS)]
    TooLarge(u32, u32),
    /// The sample offset is NaN or infinite.
    #[error("the sample offset ({}, {}) must be finite", .0.x, .0.y)]
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
        if u64::from(self.width) * u64::from(self.height) > Image::MAX_PIXELS {
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

#[cfg(test)]
mod tests {
    use super::*;
    use rt_image::Encoding;

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
}
