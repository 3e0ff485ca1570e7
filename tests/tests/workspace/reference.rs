//! Images made by another renderer, with their own noise estimate.
//!
//! The reference images are not part of this repository: where they are missing, the tests are reported as skipped.

use std::path::Path;

use rt_image::{Image, read_image};
use rt_math::stats::student_t;
use rt_math::transcendental::pow;
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::LoadOptions;
use rt_tests::shared_or_skip;

/// Renders a scene of the repository with these samples per pixel and seed.
fn render(scene: &str, spp: u32, seed: u64) -> Image {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(scene);
    let mut scene = rt_scene_io::load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    scene.settings.spp = spp;
    scene.settings.seed = seed;
    let plan = RenderPlan::compile(&scene, &PlanOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    plan.render(&RunOptions::default(), |_| {}).expect("threads start").film
}

/// An image with the variance of each number of it.
struct Estimate {
    width: usize,
    height: usize,
    mean: Vec<f64>,
    variance: Vec<f64>,
}

impl Estimate {
    /// Theirs, with the standard errors that they state.
    fn of_reference(name: &str) -> Option<Self> {
        let reference = |extension: &str| shared_or_skip(format!("reference/{name}.{extension}"));
        let (mean, stderr) = (reference("exr")?, reference("stderr.exr")?);
        let mean = read_image(&mean).expect("a readable reference");
        let stderr = read_image(&stderr).expect("readable standard errors");
        let numbers = |film: &Image| film.pixels().iter().flatten().map(|c| f64::from(*c)).collect::<Vec<_>>();
        let (width, height) = (mean.width() as usize, mean.height() as usize);
        let variance = numbers(&stderr).iter().map(|e| e * e).collect();
        Some(Self { width, height, mean: numbers(&mean), variance })
    }

    /// Ours, from renders whose seeds are independent.
    fn of_seeds(scene: &str, spp: u32, seeds: u32) -> Self {
        let films: Vec<Image> = (0..seeds).map(|seed| render(scene, spp, u64::from(seed))).collect();
        let (width, height) = (films[0].width() as usize, films[0].height() as usize);
        let n = f64::from(seeds);
        let column = |i: usize| films.iter().map(move |film| f64::from(film.pixels()[i / 3][i % 3]));
        let mean: Vec<f64> = (0..width * height * 3).map(|i| column(i).sum::<f64>() / n).collect();
        let spread = |i: usize| column(i).map(|value| (value - mean[i]) * (value - mean[i])).sum::<f64>();
        let variance = (0..mean.len()).map(|i| spread(i) / (n * (n - 1.0))).collect();
        Self { width, height, mean, variance }
    }
}

/// Sums of `values` over blocks of 8×8 pixels, per channel.
fn block_sums(width: usize, height: usize, values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; (width / 8) * (height / 8) * 3];
    for y in 0..height / 8 * 8 {
        for x in 0..width / 8 * 8 {
            let block = (y / 8) * (width / 8) + x / 8;
            for channel in 0..3 {
                sums[block * 3 + channel] += values[(y * width + x) * 3 + channel];
            }
        }
    }
    sums
}

/// Degrees of freedom of which Student's distribution is the normal one to six digits.
const ALMOST_NORMAL: f64 = 1e8;

/// The z-test over blocks of 8×8 pixels and over whole images, with the errors of both and no floor for them.
fn assert_agree(ours: &Estimate, theirs: &Estimate) {
    assert_eq!((ours.width, ours.height), (theirs.width, theirs.height));
    let sums = |values: &[f64]| block_sums(ours.width, ours.height, values);
    let differences: Vec<f64> = sums(&ours.mean).iter().zip(sums(&theirs.mean)).map(|(a, b)| a - b).collect();
    let variances: Vec<f64> = sums(&ours.variance).iter().zip(sums(&theirs.variance)).map(|(a, b)| a + b).collect();
    let (mut scores, mut exact) = (Vec::new(), 0);
    for ((difference, variance), ours) in differences.iter().zip(&variances).zip(sums(&ours.mean)) {
        if *variance > 0.0 {
            scores.push(difference / variance.sqrt());
        } else {
            assert!(difference.abs() <= 1e-5 * ours.abs(), "{difference} without noise");
            exact += 1;
        }
    }
    // Two-sided at 1 % over all blocks together (Šidák).
    let limit = student_t(pow(0.99, 1.0 / scores.len() as f64), ALMOST_NORMAL);
    let accepted = scores.iter().filter(|z| z.abs() < limit).count();
    let worst = scores.iter().fold(0.0, |worst: f64, z| worst.max(z.abs()));
    let mean_square = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    println!(
        "{accepted} of {} blocks within {limit:.2}, worst |z| {worst:.2}, mean z^2 {mean_square:.2}; {exact} without noise",
        scores.len()
    );
    assert!(accepted as f64 >= 0.9975 * scores.len() as f64);
    // Standard errors that are too large would accept anything.
    assert!((0.5..1.5).contains(&mean_square), "the scores are not those of noise: mean z^2 {mean_square}");
    for channel in 0..3 {
        let pick = |sums: &[f64]| sums.iter().skip(channel).step_by(3).sum::<f64>();
        let score = pick(&differences) / pick(&variances).sqrt();
        println!("channel {channel}: the image means differ by {score:.2} standard errors");
        assert!(score.abs() < 3.0);
    }
}

#[test]
fn direct_light_of_a_point_light_agrees_with_mitsuba() {
    let Some(theirs) = Estimate::of_reference("point-light-direct") else { return };
    assert_agree(&Estimate::of_seeds("lecture/point-light-direct.ron", 16, 4), &theirs);
}

#[test]
fn direct_light_of_an_area_light_agrees_with_mitsuba() {
    let Some(theirs) = Estimate::of_reference("cornell-direct") else { return };
    assert_agree(&Estimate::of_seeds("lecture/cornell-direct.ron", 16, 8), &theirs);
}

#[test]
fn all_light_in_the_cornell_box_agrees_with_mitsuba() {
    let Some(theirs) = Estimate::of_reference("cornell-full") else { return };
    assert_agree(&Estimate::of_seeds("lecture/cornell-full.ron", 16, 8), &theirs);
}
