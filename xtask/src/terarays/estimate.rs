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
    lecture_numbers::{RAYS, SPP, TILE_PIXELS, TILES},
    tile_job::{BEST_SPP, TileResult},
};
use crate::line_fit::LineFit;

const METHODS: usize = BEST_SPP.len();
const CONFIDENCE: f64 = 0.95;

/// A positive number and the interval that holds what it estimates in 95 of 100 cases; `None` of fewer than two tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileEstimate {
    pub value: f64,
    pub interval: Option<[f64; 2]>,
}

/// Estimates for the whole image.
#[derive(Debug)]
pub(super) struct Whole {
    pub tiles: usize,
    /// CPU seconds of all of the lecture's primary rays and what they lead to.
    pub seconds: TileEstimate,
    /// Rays of all kinds that this takes.
    pub rays: TileEstimate,
    pub rays_per_second: TileEstimate,
    /// CPU seconds of [`RAYS`] rays of all kinds.
    pub claimed_rays_seconds: TileEstimate,
    /// Root of the mean squared error of a channel of a pixel.
    pub rmse: TileEstimate,
    /// RMSE of the best method at each of [`BEST_SPP`].
    pub best_rmse: [TileEstimate; METHODS],
    /// Convergence rate: k of `error ~ N⁻ᵏ`; `None` if the error does not fall.
    pub exponent: Option<TileEstimate>,
    /// Samples per pixel with which the best method reaches `rmse`; `None` if its error does not fall.
    pub best_spp: Option<TileEstimate>,
    /// CPU seconds of these.
    pub best_seconds: Option<TileEstimate>,
}

/// Means over tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Means {
    seconds: f64,
    rays: f64,
    mse: f64,
    best_seconds: [f64; METHODS],
    best_mse: [f64; METHODS],
}

impl TileEstimate {
    /// Quotient of `numerator` and the estimated quantity.
    pub(super) fn inverse(self, numerator: f64) -> Self {
        let interval = self.interval.map(|[low, high]| [numerator / high, numerator / low]);
        Self { value: numerator / self.value, interval }
    }
}

impl Whole {
    /// `None` if nothing was measured.
    pub(super) fn of(units: &[TileResult]) -> Option<Self> {
        let tiles: Vec<Means> = units.iter().map(Means::of).collect();
        let estimate = |of: &dyn Fn(&Means) -> Option<f64>| jackknife(&tiles, of);
        Some(Self {
            tiles: tiles.len(),
            seconds: estimate(&|means| Some(means.seconds * f64::from(TILES)))?,
            rays: estimate(&|means| Some(means.rays * f64::from(TILES)))?,
            rays_per_second: estimate(&|means| Some(means.rays / means.seconds))?,
            claimed_rays_seconds: estimate(&|means| Some(RAYS * means.seconds / means.rays))?,
            rmse: estimate(&|means| Some(means.mse.sqrt()))?,
            best_rmse: {
                let [first, second, third] =
                    [0, 1, 2].map(|index| estimate(&|means| Some(means.best_mse[index].sqrt())));
                [first?, second?, third?]
            },
            exponent: estimate(&|means| means.line().map(|line| -0.5 * line.slope)),
            best_spp: estimate(&Means::best_spp),
            best_seconds: estimate(&Means::best_seconds),
        })
    }
}

impl Means {
    fn of(unit: &TileResult) -> Self {
        Self {
            seconds: unit.jittered.cpu_seconds,
            rays: unit.rays_per_sample * f64::from(SPP * TILE_PIXELS),
            mse: unit.jittered.mse,
            best_seconds: unit.best.map(|best| best.cpu_seconds),
            best_mse: unit.best.map(|best| best.mse),
        }
    }

    /// Combines each number with the same number of `other`.
    fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let each = |a: [f64; METHODS], b: [f64; METHODS]| std::array::from_fn(|index| of(a[index], b[index]));
        Self {
            seconds: of(self.seconds, other.seconds),
            rays: of(self.rays, other.rays),
            mse: of(self.mse, other.mse),
            best_seconds: each(self.best_seconds, other.best_seconds),
            best_mse: each(self.best_mse, other.best_mse),
        }
    }

    /// Log variance of the best method against log samples; `None` if it does not fall.
    fn line(&self) -> Option<LineFit> {
        let points = BEST_SPP.iter().zip(self.best_mse).map(|(&spp, mse)| [log(f64::from(spp)), log(mse)]);
        let line = LineFit::of(&points.collect::<Vec<_>>());
        Some(line).filter(|line| line.slope < 0.0 && line.slope.is_finite() && line.y.is_finite())
    }

    fn best_spp(&self) -> Option<f64> {
        let line = self.line()?;
        Some(exp(line.x + (log(self.mse) - line.y) / line.slope))
    }

    /// A sample takes as long as in the longest of the renders, in which starting counts least.
    fn best_seconds(&self) -> Option<f64> {
        let (seconds, spp) = (self.best_seconds.last()?, BEST_SPP.last()?);
        Some(self.best_spp()? * seconds / f64::from(*spp) * f64::from(TILES))
    }
}

/// Value of `of` for the means over all tiles, with an interval of its logarithm. `None` unless the value is positive.
fn jackknife(tiles: &[Means], of: &dyn Fn(&Means) -> Option<f64>) -> Option<TileEstimate> {
    let count = tiles.len() as f64;
    let sum = tiles.iter().copied().reduce(|sum, tile| sum.zip(tile, |a, b| a + b))?;
    let positive = |means: &Means| of(means).filter(|value| value.is_finite() && *value > 0.0);
    let value = positive(&sum.zip(sum, |a, _| a / count))?;
    let without = |tile: &Means| positive(&sum.zip(*tile, |a, b| (a - b) / (count - 1.0))).map(log);
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

    fn is_near(estimate: TileEstimate, expected: f64) -> bool {
        (estimate.value / expected - 1.0).abs() < 1e-12
    }

    #[test]
    fn tiles_that_are_all_alike_leave_no_doubt() {
        let whole = Whole::of(&[(); 3].map(|()| unit(2.0, 1.0 / f64::from(SPP), 1.0))).unwrap();
        let tiles = f64::from(TILES);
        assert!(is_near(whole.seconds, 2.0 * tiles));
        assert!(is_near(whole.rays, 10.0 * f64::from(SPP * TILE_PIXELS) * tiles));
        assert!(is_near(whole.rays_per_second, 5.0 * f64::from(SPP * TILE_PIXELS)));
        assert!(is_near(whole.claimed_rays_seconds, 1e12 / (5.0 * f64::from(SPP * TILE_PIXELS))));
        assert!(is_near(whole.rmse, 1.0 / 317.0));
        assert!(is_near(whole.exponent.unwrap(), 0.5));
        assert!((whole.best_spp.unwrap().value / f64::from(SPP) - 1.0).abs() < 1e-9);
        assert!((whole.best_seconds.unwrap().value / (4.0 * tiles) - 1.0).abs() < 1e-9);
        let [low, high] = whole.seconds.interval.unwrap();
        assert!(high - low < 1e-6 * low, "{low} {high}");
    }

    #[test]
    fn a_steeper_method_takes_the_root_of_the_samples() {
        let whole = Whole::of(&[unit(1.0, 1e-8, 2.0), unit(1.0, 1e-8, 2.0)]).unwrap();
        assert!((whole.exponent.unwrap().value - 1.0).abs() < 1e-12);
        assert!((whole.best_spp.unwrap().value / 1e4 - 1.0).abs() < 1e-9);
        assert!((whole.best_rmse[0].value * 1024.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_tile_has_no_interval_and_none_no_estimate() {
        assert!(Whole::of(&[]).is_none());
        assert_eq!(Whole::of(&[unit(1.0, 1e-8, 1.0)]).unwrap().seconds.interval, None);
    }

    #[test]
    fn an_error_that_does_not_fall_is_never_reached() {
        let whole = Whole::of(&[unit(1.0, 1e-8, 0.0), unit(1.0, 1e-8, -1.0)]).unwrap();
        assert_eq!((whole.exponent, whole.best_spp, whole.best_seconds), (None, None, None));
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        const TRIALS: u64 = 1000;
        // Seconds from 1 to 3, evenly: the mean is 2.
        let seconds = |trial: u64, tile: u64| 1.0 + 2.0 * random(hash(&[trial, tile]));
        let holds = |trial: &u64| {
            let units: Vec<TileResult> = (0..10).map(|tile| unit(seconds(*trial, tile), 1e-8, 1.0)).collect();
            let [low, high] = Whole::of(&units).unwrap().seconds.interval.unwrap();
            (low..high).contains(&(2.0 * f64::from(TILES)))
        };
        let held = (0..TRIALS).filter(holds).count();
        // 950 are expected with a standard deviation of 7.
        assert!((920..=980).contains(&held), "{held}");
    }
}
