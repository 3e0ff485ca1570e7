//! A tile, rendered and measured: the unit of the work.

use std::path::Path;

use rt_image::{
    Image,
    metrics::{ImagePair, mean_squared_error},
    read_image,
};
use serde::{Deserialize, Serialize};

use super::lecture_numbers::{SIZE, SPP, TILE_PIXELS, Tile};
use crate::{
    error::TaskError,
    renderer::Renderer,
    statistics::{self, Statistics},
};

/// The sampler of the lecture.
const JITTERED: &str = "jittered";
/// The sampler of ours that reaches an error first.
pub(super) const BEST: &str = "sobol";
/// Its samples per pixel, from which its error is extrapolated.
pub(super) const BEST_SPP: [u32; 3] = [1024, 4096, 16_384];

/// Samples per pixel of the render that counts rays, which is not timed.
const COUNTED_SPP: u32 = 64 * 64;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TileResult {
    pub tile: Tile,
    /// Rays of all kinds that a primary ray leads to, itself among them.
    pub rays_per_sample: f64,
    /// With all of the lecture's samples.
    pub jittered: Measured,
    /// With [`BEST_SPP`].
    pub best: [Measured; BEST_SPP.len()],
}

/// Time and error of a render of a tile, as means of two seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Measured {
    /// CPU seconds of the whole program, from start to written image.
    pub cpu_seconds: f64,
    /// Variance of a channel of a pixel, the mean over all.
    pub mse: f64,
}

#[derive(Debug)]
pub(super) struct TileRenderer<'a> {
    pub renderer: Renderer,
    pub folder: &'a Path,
    pub scene: &'a Path,
}

impl TileResult {
    /// True if all numbers are possible measurements.
    pub(super) fn is_sound(&self) -> bool {
        let sound = |number: f64| number.is_finite() && number > 0.0;
        sound(self.rays_per_sample)
            && self
                .best
                .iter()
                .chain([&self.jittered])
                .all(|it| sound(it.cpu_seconds) && it.mse.is_finite() && it.mse >= 0.0)
    }

    /// Combines each number with the same number of another tile.
    pub(super) fn zip(&self, other: &Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let both = |a: Measured, b: Measured| Measured {
            cpu_seconds: of(a.cpu_seconds, b.cpu_seconds),
            mse: of(a.mse, b.mse),
        };
        Self {
            tile: self.tile,
            rays_per_sample: of(self.rays_per_sample, other.rays_per_sample),
            jittered: both(self.jittered, other.jittered),
            best: std::array::from_fn(|index| both(self.best[index], other.best[index])),
        }
    }
}

impl TileRenderer<'_> {
    /// Measures a tile with all methods.
    pub(super) fn measure(&self, tile: Tile) -> Result<TileResult, TaskError> {
        let [first, second, third] = BEST_SPP;
        Ok(TileResult {
            tile,
            rays_per_sample: self.count(tile)?,
            jittered: self.twice(tile, JITTERED, SPP)?,
            best: [self.twice(tile, BEST, first)?, self.twice(tile, BEST, second)?, self.twice(tile, BEST, third)?],
        })
    }

    fn count(&self, tile: Tile) -> Result<f64, TaskError> {
        let args = arguments(tile, JITTERED, COUNTED_SPP, 0);
        let args: Vec<&str> = args.split(' ').collect();
        let Statistics { rays, .. } = statistics::measure(&self.renderer, self.folder, self.scene, &args)?;
        Ok(rays.total.rays as f64 / f64::from(COUNTED_SPP * TILE_PIXELS))
    }

    /// Two independent renders differ by twice the variance of one.
    fn twice(&self, tile: Tile, sampler: &str, spp: u32) -> Result<Measured, TaskError> {
        let [first, second] = [1, 2].map(|seed| self.render(tile, sampler, spp, seed));
        let ((first_seconds, first), (second_seconds, second)) = (first?, second?);
        let pair = ImagePair::new(&first, &second).map_err(TaskError::other)?;
        Ok(Measured {
            cpu_seconds: 0.5 * (first_seconds + second_seconds),
            mse: 0.5 * mean_squared_error(&pair).mean(),
        })
    }

    /// CPU seconds and image of a render.
    fn render(&self, tile: Tile, sampler: &str, spp: u32, seed: u32) -> Result<(f64, Image), TaskError> {
        const IMAGE: &str = "tile.pfm";
        let scene = self.scene.to_string_lossy();
        let args = arguments(tile, sampler, spp, seed);
        let mut all = vec!["render", &scene, "-o", IMAGE, "--quiet"];
        all.extend(args.split(' '));
        let used = self.renderer.measure(self.folder, &all)?;
        let image = read_image(&self.folder.join(IMAGE));
        Ok((used.cpu_seconds, image.map_err(TaskError::other)?))
    }
}

/// Arguments of a render in one pass, separated by spaces. Each of several passes would have a coarser grid of its own.
fn arguments(tile: Tile, sampler: &str, spp: u32, seed: u32) -> String {
    let crop = tile.crop();
    format!("--size {SIZE}x{SIZE} --crop {crop} --sampler {sampler} --spp {spp} --passes 1 --seed {seed} --threads 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_cannot_be_measured_are_not_sound() {
        let measured = Measured { cpu_seconds: 1.0, mse: 0.0 };
        let tile = Tile::nth(0).unwrap();
        let unit = TileResult { tile, rays_per_sample: 9.0, jittered: measured, best: [measured; 3] };
        assert!(unit.is_sound());
        assert!(!TileResult { rays_per_sample: 0.0, ..unit.clone() }.is_sound());
        assert!(!TileResult { jittered: Measured { mse: -1.0, ..measured }, ..unit.clone() }.is_sound());
        assert!(!TileResult { jittered: Measured { cpu_seconds: f64::NAN, ..measured }, ..unit }.is_sound());
    }
}
