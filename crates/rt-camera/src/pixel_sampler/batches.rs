//! Tests of draws for many samples at once, and of the bits of all patterns.

use super::*;
use proptest::{collection::vec, prelude::*};

/// Asserts that draws together and one by one give the same values, and leave the same samplers.
fn assert_same_draws(samplers: &[SampleStream], rounds: &[(bool, Vec<u32>)]) {
    let (mut together, mut one_by_one) = (samplers.to_vec(), samplers.to_vec());
    for (round, (is_pair, which)) in rounds.iter().enumerate() {
        // Values of samplers that do not exist are kept.
        let mut values = vec![[2.0; 2]; which.len()];
        let mut expected = values.clone();
        if *is_pair {
            Sampler::next_2d_batch(&mut together, which, &mut values);
        } else {
            let mut singles = vec![2.0; which.len()];
            Sampler::next_1d_batch(&mut together, which, &mut singles);
            values = singles.into_iter().map(|value| [value, 2.0]).collect();
        }
        for (&index, expected) in which.iter().zip(&mut expected) {
            let Some(sampler) = one_by_one.get_mut(index as usize) else { continue };
            *expected = if *is_pair { sampler.next_2d() } else { [sampler.next_1d(), 2.0] };
        }
        let bits = |values: &[[f64; 2]]| values.iter().map(|pair| pair.map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(&values), bits(&expected), "round {round}, {is_pair}, of {which:?}");
    }
    for (a, b) in together.iter_mut().zip(&mut one_by_one) {
        assert_eq!(a.next_2d(), b.next_2d());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn batches_of_one_pattern_are_draws_one_by_one(
        pattern in 0..SamplerKind::ALL.len(), spp in 1u32..400, seed: u64, corner: [u32; 2], pixels in 1u32..20, first: u32,
        per_pixel in 1usize..40, rounds in vec((any::<bool>(), vec(0u32..300, 0..100)), 1..6),
    ) {
        let sampler = PixelSampler::new(SamplerKind::ALL[pattern], spp, seed);
        let pixels = (0..pixels).map(|x| [corner[0].wrapping_add(x), corner[1]]);
        let samplers: Vec<_> = pixels.flat_map(|pixel| sampler.samples(pixel, first).take(per_pixel)).collect();
        assert_same_draws(&samplers, &rounds);
        // In step, as paths are at their first surface.
        let all: Vec<_> = (0..samplers.len() as u32).collect();
        assert_same_draws(&samplers, &[(true, all.clone()), (false, all.clone()), (true, all)]);
    }

    #[test]
    fn batches_of_mixed_patterns_are_draws_one_by_one(
        samples in vec((0..SamplerKind::ALL.len(), 1u32..40, 0u32..3, any::<u32>(), 1usize..20), 1..12),
        rounds in vec((any::<bool>(), vec(0u32..120, 0..100)), 1..6),
    ) {
        let samplers: Vec<_> = samples.into_iter().flat_map(|(pattern, spp, x, first, count)| {
            PixelSampler::new(SamplerKind::ALL[pattern], spp, 7).samples([x, 9], first).take(count)
        }).collect();
        assert_same_draws(&samplers, &rounds);
    }

    #[test]
    fn runs_of_samples_are_the_samples_one_by_one(
        pattern in 0..SamplerKind::ALL.len(), spp in 1u32..400, seed: u64, pixel: [u32; 2], first in 0u32..u32::MAX - 100,
    ) {
        let sampler = PixelSampler::new(SamplerKind::ALL[pattern], spp, seed);
        for (index, mut sample) in (first..).zip(sampler.samples(pixel, first).take(100)) {
            let mut single = sampler.sample(pixel, index);
            prop_assert_eq!([sample.next_2d(), sample.next_2d()], [single.next_2d(), single.next_2d()]);
        }
    }
}

#[test]
fn runs_of_sobol_points_cross_the_end_of_a_set() {
    let sampler = PixelSampler::new(SamplerKind::Sobol, 16, 3);
    let samplers: Vec<_> = sampler.samples([4, 5], (1 << 16) - 10).take(20).collect();
    let all: Vec<_> = (0..20).collect();
    assert_same_draws(&samplers, &[(true, all.clone()), (true, all)]);
    let mut positions = [[0.0; 2]; 20];
    sampler.positions([4, 5], (1 << 16) - 10, &mut positions);
    for (index, position) in (0u32..).zip(positions) {
        assert_eq!(position, sampler.sample([4, 5], (1 << 16) - 10 + index).next_2d());
    }
}

#[test]
fn samples_whose_position_is_skipped_go_on_with_the_second_pair() {
    for pattern in [SamplerKind::Centre, SamplerKind::MultiJittered, SamplerKind::Sobol, SamplerKind::Halton] {
        let mut drawn = PixelSampler::new(pattern, 16, 3).sample([4, 5], 6);
        let mut skipped = drawn;
        let _position = drawn.next_2d();
        skipped.skip_position();
        assert_eq!([skipped.next_2d(), skipped.next_2d()], [drawn.next_2d(), drawn.next_2d()], "{pattern:?}");
    }
}

#[test]
fn only_as_many_values_are_drawn_as_there_is_room_for() {
    let sampler = PixelSampler::new(SamplerKind::Sobol, 16, 3);
    let mut samplers: Vec<_> = sampler.samples([4, 5], 0).take(8).collect();
    let mut values = [2.0; 6];
    Sampler::next_1d_batch(&mut samplers, &[7, 7, 9, 0], &mut values);
    let mut last = sampler.sample([4, 5], 7);
    let expected = [last.next_1d(), last.next_1d(), 2.0, sampler.sample([4, 5], 0).next_1d(), 2.0, 2.0];
    assert_eq!(values, expected);
    Sampler::next_1d_batch(&mut samplers, &[1; 20], &mut values[..1]);
    Sampler::next_1d_batch(&mut [] as &mut [SampleStream], &[0, 1], &mut values);
    Sampler::next_1d_batch(&mut samplers, &[], &mut values);
    let [second, third] = [0, 1].map(|draw| {
        let mut sample = sampler.sample([4, 5], 1);
        (0..draw).for_each(|_| _ = sample.next_1d());
        sample.next_1d()
    });
    assert_eq!([values[0], samplers[1].next_1d()], [second, third]);
}

/// Images of a version have the bits of those before it. Hashes of coordinates, recorded when draws were made one by one only.
#[test]
fn patterns_keep_their_bits() {
    for (pattern, expected) in [
        (SamplerKind::Centre, 0x7290_39fa_90eb_33e8),
        (SamplerKind::Grid, 0xef75_f4da_5656_9080),
        (SamplerKind::Random, 0x73cb_dfc6_f7de_c0e2),
        (SamplerKind::Jittered, 0x6033_9051_4fa7_59bd),
        (SamplerKind::HalfJittered, 0x82c8_0f20_455a_9676),
        (SamplerKind::MultiJittered, 0x123f_2d85_f222_1005),
        (SamplerKind::Sobol, 0xdab2_0c90_81f6_ed83),
        (SamplerKind::Halton, 0xf7d4_1dd8_8c1e_cd66),
        (SamplerKind::BlueNoise, 0x86a4_e298_b545_8a49),
    ] {
        let mut sum = 0u64;
        for (spp, seed) in
            [1, 5, 16, 20, 64, 100, 300].into_iter().flat_map(|spp| [0, 3, u64::MAX].map(|seed| (spp, seed)))
        {
            let sampler = PixelSampler::new(pattern, spp, seed);
            for pixel in [[0, 0], [17, 4], [130, 4000], [u32::MAX, 7]] {
                for index in [0, 1, 2, 3, 4, 15, 16, 99, 255, 256, 1000, 65535, 65536, 70000, 4_000_000_000] {
                    let mut sample = sampler.sample(pixel, index);
                    for draw in 0..40 {
                        let is_single = hash(&[draw, u64::from(index)]) & 1 == 0;
                        let values = if is_single { vec![sample.next_1d()] } else { sample.next_2d().to_vec() };
                        sum = values.into_iter().fold(sum, |sum, value| mix(sum ^ value.to_bits()).rotate_left(7));
                    }
                    if index == 0 {
                        (0..100).for_each(|_| _ = sample.next_2d());
                        sum = mix(sum ^ sample.next_1d().to_bits());
                    }
                }
                let mut positions = [[0.0; 2]; 50];
                sampler.positions(pixel, 7, &mut positions);
                sum = positions.as_flattened().iter().fold(sum, |sum, value| mix(sum ^ value.to_bits()));
            }
        }
        assert_eq!(sum, expected, "{pattern:?}: {sum:#018x}");
    }
}
