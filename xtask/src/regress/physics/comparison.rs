//! Comparison of our image with a reference: image means and blocks, each as a score of a normal distribution.
//!
//! A run compares up to 300 pairs. Each of the tests below has a false-alarm rate of about one in a million. A run on
//! other seeds would raise a false alarm less than once in 200 times:
//!
//! ```text
//!      test                                    rate       times per run       together
//!      image mean beyond 4.8 (two-sided)       1.6e-6     3 per pair          0.14 %
//!      sum of squares of the blocks            7.9e-7     3 per pair          0.07 %
//!      too many blocks beyond 3                1e-6       3 per pair          0.09 %
//!      a block beyond 6.5                      8e-11      192 per pair        0.0005 %
//! ```
//!
//! Channels are tested one by one: their noise is common, so that blocks of all channels together are not independent.

use super::{
    pair::BlockMeans,
    score::{RelativeTolerance, Score, binomial_tail, score_of_squares},
};

/// Maximum score of an image mean.
pub(super) const MEAN_LIMIT: f64 = 4.8;
/// Score of an image mean that is worth a note: a few in a thousand pairs have it by chance.
const NOTED: f64 = 3.5;
/// Maximum score of the sum of the squares of the blocks' scores.
const SQUARES_LIMIT: f64 = 4.8;
/// Maximum score of a block.
const WORST_LIMIT: f64 = 6.5;
/// Minimum degrees of freedom for tests of a single block. Rare light makes block means skewed, and the errors of few
/// seeds too small.
const ENOUGH_FREEDOM: f64 = 11.0;
/// Score that few blocks exceed.
const FAR: f64 = 3.0;
/// Share of blocks beyond [`FAR`]: a little more than the normal 0.0027, as seeds are few.
const FAR_SHARE: f64 = 0.004;
/// Minimum probability of as many blocks beyond [`FAR`].
const FAR_LIMIT: f64 = 1e-6;

/// Comparison of our image with a reference.
#[derive(Debug)]
pub(super) struct Comparison {
    /// Our image mean divided by that of the reference, by channel; not finite where the reference is black.
    pub ratio: [f64; 3],
    /// Standard errors of the ratios.
    pub ratio_error: [f64; 3],
    /// Scores of the image means.
    pub mean_scores: [f64; 3],
    /// Root mean square of the blocks' scores.
    pub rms: f64,
    /// Maximum score of a block.
    pub worst: f64,
    /// Blocks beyond [`FAR`] standard errors, of all.
    pub far: usize,
    pub blocks: usize,
    /// Minimum relative error of an image mean that would be found, of the channel that finds it first.
    pub notices: f64,
    /// Differences that noise does not explain.
    pub problems: Vec<String>,
    /// Remarks on scores that are large and may still be noise.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Compares means that have the same blocks.
    pub(super) fn of(ours: &BlockMeans, reference: &BlockMeans, tolerance: RelativeTolerance) -> Self {
        let blocks: Vec<f64> =
            ours.blocks.iter().zip(&reference.blocks).map(|(a, b)| Score::of(*a, *b, tolerance).z).collect();
        let image: [Score; 3] =
            std::array::from_fn(|channel| Score::of(ours.image[channel], reference.image[channel], tolerance));
        let per_mean = |f: &dyn Fn(usize) -> f64| -> [f64; 3] {
            std::array::from_fn(|channel| f(channel) / reference.image[channel].mean.abs())
        };
        let found = per_mean(&|channel| image[channel].difference_at(MEAN_LIMIT));
        let squares: f64 = blocks.iter().map(|z| z * z).sum();
        let mut comparison = Self {
            ratio: per_mean(&|channel| ours.image[channel].mean),
            ratio_error: per_mean(&|channel| image[channel].standard_error),
            mean_scores: image.map(|score| score.z),
            rms: (squares / blocks.len().max(1) as f64).sqrt(),
            worst: blocks.iter().fold(0.0, |worst: f64, z| worst.max(z.abs())),
            far: blocks.iter().filter(|z| z.abs() > FAR).count(),
            blocks: blocks.len(),
            notices: found.into_iter().filter(|found| found.is_finite()).fold(f64::INFINITY, f64::min),
            problems: Vec::new(),
            notes: Vec::new(),
        };
        comparison.check(&blocks, ours.image[0].freedom >= ENOUGH_FREEDOM);
        comparison
    }

    fn check(&mut self, blocks: &[f64], has_many_seeds: bool) {
        if blocks.iter().chain(&self.mean_scores).any(|z| !z.is_finite()) {
            self.problems.push("a mean is not a number".to_owned());
            return;
        }
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let z = self.mean_scores[channel];
            let (ratio, error) = (self.ratio[channel], self.ratio_error[channel]);
            let line = format!("{name}: image mean {ratio:.5} ± {error:.5} of the reference's, score {z:+.1}");
            if z.abs() > MEAN_LIMIT {
                self.problems.push(line);
            } else if z.abs() > NOTED {
                self.notes.push(line);
            }
            let scores: Vec<f64> = blocks.iter().skip(channel).step_by(3).copied().collect();
            let squares: f64 = scores.iter().map(|z| z * z).sum();
            let rms = (squares / scores.len() as f64).sqrt();
            if score_of_squares(squares, scores.len()) > SQUARES_LIMIT {
                self.problems.push(format!("{name}: the blocks' scores have an RMS of {rms:.2} instead of 1"));
            }
            let far = scores.iter().filter(|z| z.abs() > FAR).count();
            if binomial_tail(scores.len(), far, FAR_SHARE) < FAR_LIMIT {
                self.problems
                    .push(format!("{name}: {far} of {} blocks differ by more than 3 standard errors", scores.len()));
            }
        }
        if has_many_seeds && self.worst > WORST_LIMIT {
            self.problems.push(format!("a block differs by {:.1} standard errors", self.worst));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rt_math::{
        random::{hash, unit},
        transcendental::exp,
    };

    use super::{super::blocks::Blocks, *};

    /// Pairs that the false-alarm rate is stated for, and most blocks of an image of theirs.
    const PAIRS: f64 = 300.0;
    const BLOCKS: f64 = 192.0;

    /// Upper bound of the probability that a normal number exceeds `z` (Mills 1926).
    fn tail(z: f64) -> f64 {
        exp(-0.5 * z * z) / (z * TAU.sqrt())
    }

    #[test]
    fn a_run_raises_a_false_alarm_less_than_once_in_200() {
        let per_channel = 2.0 * tail(MEAN_LIMIT) + tail(SQUARES_LIMIT) + FAR_LIMIT;
        let per_pair = 3.0 * per_channel + BLOCKS * 2.0 * tail(WORST_LIMIT);
        assert!(PAIRS * per_pair < 1.0 / 200.0, "{}", PAIRS * per_pair);
    }

    const NONE: RelativeTolerance = RelativeTolerance { relative: 2e-5, absolute: 0.0 };

    /// Images of 8×8 blocks with this mean and noise, as a renderer's seeds give them: sums of twelve random numbers each.
    fn renders(seeds: u32, first_seed: u64, noise: f64, mean: impl Fn(usize) -> f64) -> Vec<Blocks> {
        (0..u64::from(seeds))
            .map(|seed| {
                let means = (0..192).map(|i| {
                    let sum: f64 = (0..12).map(|d| random(first_seed + seed, i as u64, d)).sum();
                    mean(i) * (1.0 + noise * (sum - 6.0))
                });
                Blocks { rows: 8, columns: 8, means: means.collect(), brightest: 3.0 }
            })
            .collect()
    }

    fn random(seed: u64, i: u64, d: u64) -> f64 {
        unit(hash(&[seed, i, d]))
    }

    fn plain(i: usize) -> f64 {
        0.2 + i as f64 / 100.0
    }

    #[test]
    fn equal_scenes_are_accepted_and_a_hundredth_more_is_not() {
        for trial in 0..200 {
            let ours = BlockMeans::of_seeds(&renders(16, 1000 * trial, 0.02, plain));
            let reference = BlockMeans::of_seeds(&renders(16, 1000 * trial + 500, 0.02, plain));
            let same = Comparison::of(&ours, &reference, NONE);
            assert_eq!(same.problems, Vec::<String>::new(), "{trial}");
            let brighter = Comparison::of(&ours, &reference.scaled([1.01; 3]), NONE);
            assert!(brighter.problems[0].contains("image mean"), "{trial}: {:?}", brighter.problems);
            assert!(same.notices < 0.01, "{}", same.notices);
        }
    }

    #[test]
    fn few_seeds_raise_no_more_false_alarms() {
        for trial in 0..500 {
            let ours = BlockMeans::of_seeds(&renders(6, 1000 * trial, 0.02, plain));
            let exact = BlockMeans::of_seeds(&renders(1, 0, 0.0, plain));
            let comparison = Comparison::of(&ours, &exact, NONE);
            assert_eq!(comparison.problems, Vec::<String>::new(), "{trial}");
        }
    }

    #[test]
    fn faults_of_blocks_are_found() {
        // Half of the blocks lose what the others gain: the scene is mirrored, say.
        let shifted = |i: usize| plain(i) * if (i / 3).is_multiple_of(2) { 1.08 } else { 0.92 };
        let wrong = |i: usize| if i == 40 { 2.0 * plain(i) } else { plain(i) };
        for (mean, expected) in [(&shifted as &dyn Fn(usize) -> f64, "RMS"), (&wrong, "a block differs")] {
            let ours = BlockMeans::of_seeds(&renders(16, 1, 0.05, mean));
            let reference = BlockMeans::of_seeds(&renders(16, 700, 0.05, plain));
            let problems = Comparison::of(&ours, &reference, NONE).problems;
            assert!(problems.iter().any(|problem| problem.contains(expected)), "{expected}: {problems:?}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_refused() {
        let mut broken = renders(16, 1, 0.05, plain);
        broken[3].means[7] = f64::NAN;
        let reference = BlockMeans::of_seeds(&renders(16, 700, 0.05, plain));
        let problems = Comparison::of(&BlockMeans::of_seeds(&broken), &reference, NONE).problems;
        assert_eq!(problems, ["a mean is not a number"]);
    }

    #[test]
    fn scores_of_two_exact_images_are_those_of_the_tolerance() {
        let exact = |factor: f64| BlockMeans::of_seeds(&renders(1, 0, 0.0, |i| factor * plain(i)));
        let tolerance = RelativeTolerance { relative: 0.01, absolute: 0.0 };
        let comparison = Comparison::of(&exact(1.02), &exact(1.0), tolerance);
        assert!(comparison.mean_scores.iter().all(|z| (z - 2.0 / 1.02).abs() < 1e-3), "{comparison:?}");
        assert!((comparison.rms - 2.0 / 1.02).abs() < 1e-3 && comparison.far == 0 && comparison.blocks == 192);
        assert!(comparison.ratio.iter().all(|ratio| (ratio - 1.02).abs() < 1e-12));
    }
}
