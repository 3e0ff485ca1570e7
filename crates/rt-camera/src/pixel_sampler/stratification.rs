//! Tests of where the samples of one pixel fall.

use super::*;
use crate::{
    sample_lanes::{BELOW_ONE, in_stratum},
    sobol,
};
use proptest::prelude::*;

const STRATIFIED: [SamplerKind; 4] =
    [SamplerKind::Jittered, SamplerKind::MultiJittered, SamplerKind::Sobol, SamplerKind::BlueNoise];

/// The pair number `pair` of all samples of a pixel.
fn pairs(pattern: SamplerKind, spp: u32, pixel: [u32; 2], pair: usize) -> Vec<[f64; 2]> {
    let sampler = PixelSampler::new(pattern, spp, 11);
    assert_eq!(sampler.spp(), spp);
    let draw = |index| {
        let mut sample = sampler.sample(pixel, index);
        (0..pair).for_each(|_| _ = sample.next_2d());
        sample.next_2d()
    };
    (0..spp).map(draw).collect()
}

/// Asserts that each of the `columns` × `rows` boxes of the unit square holds as many points as any other.
fn assert_even(points: &[[f64; 2]], columns: u32, rows: u32, what: &str) {
    let mut counts = vec![0; (columns * rows) as usize];
    for [x, y] in points {
        let (column, row) = ((x * f64::from(columns)) as usize, (y * f64::from(rows)) as usize);
        counts[row * columns as usize + column] += 1;
    }
    let expected = points.len() / counts.len();
    assert!(counts.iter().all(|&count| count == expected), "{what} in {columns} × {rows} boxes: {counts:?}");
}

#[test]
fn centre_and_grid_are_where_they_must_be() {
    assert_eq!(pairs(SamplerKind::Centre, 3, [5, 6], 0), [[0.5; 2]; 3]);
    for pixel in [[0, 0], [7, 1]] {
        let mut points = pairs(SamplerKind::Grid, 9, pixel, 0);
        points.sort_by(|a, b| (a[1], a[0]).partial_cmp(&(b[1], b[0])).expect("no NaN"));
        let lines = [0.5 / 3.0, 1.5 / 3.0, 2.5 / 3.0];
        let expected: Vec<_> = lines.iter().flat_map(|&y| lines.map(|x| [x, y])).collect();
        assert_eq!(points, expected);
    }
}

#[test]
fn half_jittered_points_keep_to_the_middle_of_their_cells() {
    let mut range = [1.0f64, 0.0];
    for pixel in 0..100 {
        let points = pairs(SamplerKind::HalfJittered, 16, [pixel, 0], 0);
        assert_even(&points, 4, 4, "half-jittered");
        for in_cell in points.as_flattened().iter().map(|x| (4.0 * x).fract()) {
            range = [range[0].min(in_cell), range[1].max(in_cell)];
        }
    }
    // 3200 uniform numbers fill the range from ¼ to ¾.
    assert!((0.25..0.252).contains(&range[0]) && (0.748..0.75).contains(&range[1]), "{range:?}");
}

#[test]
fn half_jittered_lights_are_not_biased() {
    let points: Vec<_> = (0..100).flat_map(|x| pairs(SamplerKind::HalfJittered, 16, [x, 0], 1)).collect();
    assert_even(&points, 4, 4, "half-jittered");
    let outside = points.as_flattened().iter().filter(|x| !(0.25..0.75).contains(&(4.0 * **x).fract())).count();
    // Half of 3200, give or take five standard deviations.
    assert!((1460..1740).contains(&outside), "{outside}");
}

#[test]
fn cells_of_the_grid_hold_one_point_each() {
    for pattern in [SamplerKind::Grid, SamplerKind::Jittered, SamplerKind::MultiJittered] {
        for side in [1, 2, 3, 7, 16, 25] {
            for pair in 0..4 {
                assert_even(&pairs(pattern, side * side, [3, 4], pair), side, side, pattern.name());
            }
        }
    }
}

#[test]
fn multi_jittered_rows_and_columns_hold_one_point_each() {
    for side in [1u32, 2, 3, 7, 16, 25] {
        let spp = side * side;
        for pair in 0..4 {
            let points = pairs(SamplerKind::MultiJittered, spp, [9, 2], pair);
            assert_even(&points, spp, 1, "multi-jittered");
            assert_even(&points, 1, spp, "multi-jittered");
        }
    }
}

#[test]
fn sobol_fills_every_elementary_interval() {
    for log_spp in 0..=12 {
        let spp = 1 << log_spp;
        for pixel in [[0, 0], [17, 4]] {
            let points = pairs(SamplerKind::Sobol, spp, pixel, 0);
            for log_columns in 0..=log_spp {
                assert_even(&points, 1 << log_columns, 1 << (log_spp - log_columns), "sobol");
            }
        }
        for pair in 1..6 {
            let points = pairs(SamplerKind::Sobol, spp, [1, 2], pair);
            assert_even(&points, spp, 1, "sobol");
            assert_even(&points, 1, spp, "sobol");
        }
    }
}

#[test]
fn blue_noise_fills_every_elementary_interval_in_every_pair() {
    for log_spp in 0..=9 {
        let spp = 1 << log_spp;
        for pair in 0..4 {
            let points = pairs(SamplerKind::BlueNoise, spp, [130, 77], pair);
            for log_columns in 0..=log_spp {
                assert_even(&points, 1 << log_columns, 1 << (log_spp - log_columns), "blue-noise");
            }
        }
    }
}

/// This is what makes the noise fine: parts that one pixel of a square misses are sampled by the others.
#[test]
fn blue_noise_pixels_share_out_the_unit_square() {
    for (log_spp, side) in [(0, 2), (0, 4), (0, 16), (2, 4), (3, 8), (4, 2)] {
        let spp = 1 << log_spp;
        for corner in [[0, 0], [64, 96], [128 + 2 * side, 3 * side]] {
            for pair in 0..3 {
                let square = (0..side * side).map(|index| [corner[0] + index % side, corner[1] + index / side]);
                let points: Vec<_> = square.flat_map(|pixel| pairs(SamplerKind::BlueNoise, spp, pixel, pair)).collect();
                let log_count = log_spp + 2 * side.ilog2();
                for log_columns in 0..=log_count {
                    assert_even(&points, 1 << log_columns, 1 << (log_count - log_columns), "blue-noise");
                }
            }
        }
    }
}

#[test]
fn halton_fills_boxes_of_its_bases() {
    for (columns, rows) in [(1, 3), (2, 3), (8, 9), (16, 9), (8, 27), (32, 27)] {
        for pixel in [[0, 0], [17, 4]] {
            let points = pairs(SamplerKind::Halton, columns * rows, pixel, 0);
            assert_even(&points, columns, rows, "halton");
        }
    }
    // The second pair has the bases 5 and 7, and any first part of a longer pattern is one too.
    let points = pairs(SamplerKind::Halton, 1000, [3, 9], 1);
    assert_even(&points[..35], 5, 7, "halton");
    assert_even(&points[35..70], 5, 7, "halton");
    assert_even(&points[..875], 25, 7, "halton");
}

#[test]
fn halton_has_no_last_dimension() {
    let sampler = PixelSampler::new(SamplerKind::Halton, 16, 1);
    let late = |index| {
        let mut sample = sampler.sample([2, 2], index);
        (0..200).for_each(|_| _ = sample.next_1d());
        sample.next_2d()
    };
    let points: Vec<_> = (0..4096).map(late).collect();
    assert!(correlation(&points).abs() < 4.0 / 64.0);
    let mean = points.as_flattened().iter().sum::<f64>() / 8192.0;
    // Five standard deviations of 8192 uniform numbers.
    assert!((mean - 0.5).abs() < 0.016, "{mean}");
}

#[test]
fn a_first_part_of_the_sobol_points_is_a_pattern_too() {
    let points = pairs(SamplerKind::Sobol, 1024, [0, 0], 0);
    for (log_columns, log_rows) in [(0, 6), (3, 3), (5, 1)] {
        assert_even(&points[..64], 1 << log_columns, 1 << log_rows, "sobol");
        assert_even(&points[64..128], 1 << log_columns, 1 << log_rows, "sobol");
    }
}

#[test]
fn single_coordinates_are_stratified() {
    for pattern in STRATIFIED.into_iter().chain([SamplerKind::Grid, SamplerKind::HalfJittered]) {
        let sampler = PixelSampler::new(pattern, 64, 3);
        for skipped in 0..5 {
            let draw = |index| {
                let mut sample = sampler.sample([8, 8], index);
                (0..skipped).for_each(|_| _ = sample.next_1d());
                [sample.next_1d(), 0.0]
            };
            assert_even(&(0..64).map(draw).collect::<Vec<_>>(), 64, 1, pattern.name());
        }
    }
}

#[test]
fn samples_beyond_the_pattern_start_a_new_one() {
    for pattern in [SamplerKind::Jittered, SamplerKind::MultiJittered, SamplerKind::BlueNoise] {
        let sampler = PixelSampler::new(pattern, 16, 0);
        let round = |first: u32| (first..first + 16).map(|index| sampler.sample([1, 1], index).next_2d());
        assert_even(&round(16).collect::<Vec<_>>(), 4, 4, pattern.name());
        assert!(round(0).zip(round(16)).all(|(a, b)| a != b));
    }
    let block = 1 << sobol::INDEX_BITS;
    let sampler = PixelSampler::new(SamplerKind::Sobol, 2 * block, 0);
    let second: Vec<_> = (block..block + 256).map(|index| sampler.sample([1, 1], index).next_2d()).collect();
    assert_even(&second, 16, 16, "sobol");
    assert!((0..256).all(|index| sampler.sample([1, 1], index).next_2d() != second[index as usize]));
}

#[test]
fn rounding_up_in_the_last_stratum_stays_below_one() {
    assert_eq!(3.0 + BELOW_ONE, 4.0);
    assert_eq!(in_stratum(3, 4, BELOW_ONE), BELOW_ONE);
    assert_eq!(in_stratum(0, 4, 0.0), 0.0);
}

/// Pearson's correlation coefficient.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let count = pairs.len() as f64;
    let mean = [0, 1].map(|axis| pairs.iter().map(|pair| pair[axis]).sum::<f64>() / count);
    let covariance = |a: usize, b: usize| pairs.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>();
    covariance(0, 1) / (covariance(0, 0) * covariance(1, 1)).sqrt()
}

#[test]
fn neighbouring_pixels_seeds_and_dimensions_are_uncorrelated() {
    let count = 4096u32;
    for pattern in SamplerKind::unbiased() {
        let draws = |seed, pixel, index| {
            let mut sample = PixelSampler::new(pattern, 16, seed).sample(pixel, index);
            [sample.next_2d(), sample.next_2d(), sample.next_2d()]
        };
        let at = |seed, x: u32, y, index, draw: usize| draws(seed, [x % 64, x / 64 + y], index)[draw][0];
        type Other<'a> = (&'a str, &'a dyn Fn(u32) -> f64);
        let others: [Other<'_>; 7] = [
            ("the pixel below", &|i| at(0, i, 1, 5, 0)),
            ("the pixel on the right", &|i| at(0, i + 1, 0, 5, 0)),
            ("the next seed", &|i| at(1, i, 0, 5, 0)),
            ("the next sample but one round", &|i| at(0, i, 0, 21, 0)),
            ("the next pair", &|i| at(0, i, 0, 5, 1)),
            ("the third pair", &|i| at(0, i, 0, 5, 2)),
            ("the other axis", &|i| draws(0, [i % 64, i / 64], 5)[0][1]),
        ];
        // Pixels of a block complement each other.
        let skipped = if pattern == SamplerKind::BlueNoise { 2 } else { 0 };
        for (name, other) in others.into_iter().skip(skipped) {
            let pairs: Vec<_> = (0..count).map(|i| [at(0, i, 0, 5, 0), other(i)]).collect();
            let r = correlation(&pairs);
            assert!(r.abs() < 4.0 / f64::from(count).sqrt(), "{pattern:?} against {name}: r = {r}");
        }
    }
}

#[test]
fn every_sample_of_a_pattern_is_uniform_over_the_pixel() {
    let (bins, pixels) = (16usize, 25_600u32);
    for pattern in SamplerKind::unbiased() {
        let sampler = PixelSampler::new(pattern, 16, 5);
        for index in [0, 1, 7, 15] {
            for pair in 0..2 {
                let mut counts = vec![0.0; bins * bins];
                for pixel in 0..pixels {
                    let mut sample = sampler.sample([pixel % 160, pixel / 160], index);
                    (0..pair).for_each(|_| _ = sample.next_2d());
                    let [x, y] = sample.next_2d().map(|x| (x * bins as f64) as usize);
                    counts[y * bins + x] += 1.0;
                }
                let expected = f64::from(pixels) / counts.len() as f64;
                let chi2: f64 = counts.iter().map(|c| (c - expected) * (c - expected) / expected).sum();
                // 255 degrees of freedom: mean 255, standard deviation 22.6.
                assert!((165.0..365.0).contains(&chi2), "{pattern:?}, sample {index}, pair {pair}: chi² = {chi2}");
            }
        }
    }
}

#[test]
fn positions_are_the_first_pairs_of_the_samples() {
    for pattern in SamplerKind::ALL {
        for (spp, first, count) in [(1, 0, 5), (5, 0, 30), (16, 0, 16), (16, 13, 40), (49, 4_000_000_000, 64)] {
            let sampler = PixelSampler::new(pattern, spp, 3);
            let mut positions = vec![[0.0; 2]; count];
            sampler.positions([17, 4], first, &mut positions);
            let single: Vec<_> = (first..).take(count).map(|index| sampler.sample([17, 4], index).next_2d()).collect();
            assert_eq!(positions, single, "{pattern:?}, {spp} from {first}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn coordinates_are_a_pure_function_within_the_unit_interval(
        pattern in 0..SamplerKind::ALL.len(), spp in 1u32..5000, seed in any::<u64>(), x in any::<u32>(), y in any::<u32>(),
        index in any::<u32>(), is_pair in proptest::collection::vec(any::<bool>(), 12),
    ) {
        let sampler = PixelSampler::new(SamplerKind::ALL[pattern], spp, seed);
        let draw = |mut sample: SampleStream| -> Vec<f64> {
            is_pair.iter().flat_map(|&pair| if pair { sample.next_2d().to_vec() } else { vec![sample.next_1d()] }).collect()
        };
        let first = draw(sampler.sample([x, y], index));
        prop_assert!(first.iter().all(|value| (0.0..1.0).contains(value)), "{first:?}");
        let mut elsewhere = sampler.sample([y, x], index.wrapping_add(1));
        elsewhere.next_2d();
        prop_assert_eq!(first, draw(sampler.sample([x, y], index)));
    }
}
