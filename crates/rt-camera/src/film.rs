//! The film: linear radiance, one value a pixel.

use crate::{Development, Filter};
use rt_math::DVec2;

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

/// Linear radiance of each pixel, row by row from the top, with optional coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    alpha: Option<Vec<f32>>,
}

impl Film {
    /// A black film, with an alpha channel of zeros if asked for.
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
}
