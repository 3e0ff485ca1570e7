//! Estimates for the whole image from a sample of tiles.
//!
//! ```text
//!   whole = tiles · mean of a tile        error(N) ~ Nᵏ, fitted to log variance against log N
//! ```
//!
//! All results are functions of means over tiles. Their intervals are by the jackknife (Quenouille 1956, Tukey 1958),
//! from the values without each tile in turn. All tiles together are the image, without further variance. The variance
//! is therefore reduced by the finished part of the image (Cochran, Sampling Techniques, 1977, 2.6).

use rt_math::stats::student_t;
use rt_math::transcendental::{exp, log};

use super::{
    lecture_numbers::{SPP, TILE_PIXELS, TILES},
    tile_job::{BEST_SPP, TileResult},
};
use crate::line_fit::LineFit;

const CONFIDENCE: f64 = 0.95;

/// A positive number and the interval that holds what it estimates in 95 of 100 cases; `None` of fewer than two tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileEstimate {
    pub value: f64,
    pub interval: Option<[f64; 2]>,
}

/// A quantity of the whole image by means over tiles; NaN if they do not give it.
pub(super) type Quantity<'q> = &'q dyn Fn(&TileResult) -> f64;

/// CPU seconds of all of the lecture's primary rays and what they lead to.
pub(super) fn seconds(means: &TileResult) -> f64 {
    means.jittered.cpu_seconds * f64::from(TILES)
}

/// Rays of all kinds that this takes.
pub(super) fn rays(means: &TileResult) -> f64 {
    means.rays_per_sample * f64::from(SPP * TILE_PIXELS) * f64::from(TILES)
}

/// Log variance of the best method against log samples. The slope is NaN unless the variance falls.
fn line(means: &TileResult) -> LineFit {
    let points = BEST_SPP.iter().zip(means.best).map(|(&spp, best)| [log(f64::from(spp)), log(best.mse)]);
    let line = LineFit::of(&points.collect::<Vec<_>>());
    LineFit { slope: if line.slope < 0.0 { line.slope } else { f64::NAN }, ..line }
}

/// Convergence rate of the best method: k of `error ~ N⁻ᵏ`.
pub(super) fn exponent(means: &TileResult) -> f64 {
    -0.5 * line(means).slope
}

/// Samples per pixel with which the best method reaches the error of the lecture's image.
pub(super) fn best_spp(means: &TileResult) -> f64 {
    let line = line(means);
    exp(line.x + (log(means.jittered.mse) - line.y) / line.slope)
}

/// CPU seconds of these. A sample takes as long as in the longest of the renders, in which starting counts least.
pub(super) fn best_seconds(means: &TileResult) -> f64 {
    let ([.., longest], [.., spp]) = (means.best, BEST_SPP);
    best_spp(means) * longest.cpu_seconds / f64::from(spp) * f64::from(TILES)
}

/// Value of `of` for the means over all tiles, with an interval of its logarithm. `None` unless the value is positive.
pub(super) fn jackknife(tiles: &[TileResult], of: Quantity<'_>) -> Option<TileEstimate> {
    let count = tiles.len() as f64;
    let sum = tiles.iter().cloned().reduce(|sum, tile| sum.zip(&tile, |a, b| a + b))?;
    let positive = |means: &TileResult| Some(of(means)).filter(|value| value.is_finite() && *value > 0.0);
    let value = positive(&sum.zip(&sum, |a, _| a / count))?;
    let without = |tile: &TileResult| positive(&sum.zip(tile, |a, b| (a - b) / (count - 1.0))).map(log);
    let interval = || {
        let logs: Vec<f64> = tiles.iter().map(without).collect::<Option<_>>()?;
        let mean = logs.iter().sum::<f64>() / count;
        let squares: f64 = logs.iter().map(|log| (log - mean) * (log - mean)).sum();
        let still_open = 1.0 - count / f64::from(TILES);
        let error = (squares * (count - 1.0) / count * still_open).sqrt();
        let half = student_t(CONFIDENCE, count - 1.0) * error;
        Some([value * exp(-half), value * exp(half)])
    };
    Some(TileEstimate { value, interval: if tiles.len() < 2 { None } else { interval() } })
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit as random};

    use super::{
        super::{lecture_numbers::Tile, tile_job::Measured},
        *,
    };

    /// A tile of which the best method is half as fast, and reaches with `N` samples the variance `1 / N^power`.
    fn unit(seconds: f64, mse: f64, power: f64) -> TileResult {
        let best = BEST_SPP.map(|spp| Measured {
            cpu_seconds: 2.0 * seconds * f64::from(spp) / f64::from(SPP),
            mse: exp(-power * log(f64::from(spp))),
        });
        let jittered = Measured { cpu_seconds: seconds, mse };
        TileResult { tile: Tile::nth(0).unwrap(), rays_per_sample: 10.0, jittered, best }
    }

    #[test]
    fn estimates_of_equal_tiles_are_exact() {
        let alike = [(); 3].map(|()| unit(2.0, 1.0 / f64::from(SPP), 1.0));
        let steep = [(); 2].map(|()| unit(1.0, 1e-8, 2.0));
        let image = f64::from(TILES);
        let cases: [(&str, &[TileResult], Quantity<'_>, f64); 7] = [
            ("seconds", &alike, &seconds, 2.0 * image),
            ("rays", &alike, &rays, 10.0 * f64::from(SPP * TILE_PIXELS) * image),
            ("exponent", &alike, &exponent, 0.5),
            ("samples", &alike, &best_spp, f64::from(SPP)),
            ("seconds of the best", &alike, &best_seconds, 4.0 * image),
            ("exponent of a steeper method", &steep, &exponent, 1.0),
            ("its samples, the root of those", &steep, &best_spp, 1e4),
        ];
        for (what, tiles, of, expected) in cases {
            let value = jackknife(tiles, of).unwrap().value;
            assert!((value / expected - 1.0).abs() < 1e-9, "{what}: {value} instead of {expected}");
        }
        let [low, high] = jackknife(&alike, &seconds).unwrap().interval.unwrap();
        assert!(high - low < 1e-6 * low, "{low} {high}");
    }

    #[test]
    fn one_tile_has_no_interval_and_none_no_estimate() {
        assert_eq!(jackknife(&[], &seconds), None);
        assert_eq!(jackknife(&[unit(1.0, 1e-8, 1.0)], &seconds).unwrap().interval, None);
    }

    #[test]
    fn an_error_that_does_not_fall_is_never_reached() {
        let tiles = [unit(1.0, 1e-8, 0.0), unit(1.0, 1e-8, -1.0)];
        let quantities: [Quantity<'_>; 3] = [&exponent, &best_spp, &best_seconds];
        assert_eq!(quantities.map(|of| jackknife(&tiles, of)), [None; 3]);
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        const TRIALS: u64 = 1000;
        // Seconds from 1 to 3, evenly: the mean is 2.
        let of_tile = |trial: u64, tile: u64| 1.0 + 2.0 * random(hash(&[trial, tile]));
        let holds = |trial: &u64| {
            let units: Vec<TileResult> = (0..10).map(|tile| unit(of_tile(*trial, tile), 1e-8, 1.0)).collect();
            let [low, high] = jackknife(&units, &seconds).unwrap().interval.unwrap();
            (low..high).contains(&(2.0 * f64::from(TILES)))
        };
        let held = (0..TRIALS).filter(holds).count();
        // 950 are expected with a standard deviation of 7.
        assert!((920..=980).contains(&held), "{held}");
    }
}
