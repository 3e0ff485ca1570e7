//! Pictures made by another renderer, with their own noise estimate.
//!
//! The reference images are not part of this repository: where they are missing, the tests say so and pass.

#![allow(clippy::print_stdout, reason = "tests say what they skip")]

use std::path::{Path, PathBuf};

use rt_camera::{Film, read_image};
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::LoadOptions;

fn reference(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference").join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: the reference image {name} is not here");
    None
}

fn render(scene: &str) -> Film {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(scene);
    let scene = rt_scene_io::load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let plan = RenderPlan::compile(&scene, &PlanOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    plan.render(&RunOptions::default(), |_| {}).expect("threads start").film
}

/// Means over blocks of 8×8 pixels, per channel, with the variance of each mean if `square` holds standard errors.
fn block_sums(film: &Film, value: impl Fn(f32) -> f64) -> Vec<f64> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let mut sums = vec![0.0; (width / 8) * (height / 8) * 3];
    for y in 0..height / 8 * 8 {
        for x in 0..width / 8 * 8 {
            let block = (y / 8) * (width / 8) + x / 8;
            for channel in 0..3 {
                sums[block * 3 + channel] += value(film.pixels()[y * width + x][channel]);
            }
        }
    }
    sums
}

#[test]
fn direct_light_of_a_point_light_agrees_with_mitsuba() {
    let (Some(mean), Some(error)) = (reference("point-light-direct.exr"), reference("point-light-direct.stderr.exr"))
    else {
        return;
    };
    let theirs = read_image(&mean).expect("a readable reference");
    let stderr = read_image(&error).expect("readable standard errors");
    let ours = render("lecture/point-light-direct.ron");
    assert_eq!((ours.width(), ours.height()), (theirs.width(), theirs.height()));

    let our_sums = block_sums(&ours, f64::from);
    let their_sums = block_sums(&theirs, f64::from);
    let variances = block_sums(&stderr, |e| f64::from(e) * f64::from(e));
    // Our own noise is counted as none, which makes the test stricter than it need be.
    let scores: Vec<f64> = our_sums
        .iter()
        .zip(&their_sums)
        .zip(&variances)
        .filter(|(_, variance)| **variance > 0.0)
        .map(|((ours, theirs), variance)| (ours - theirs) / variance.sqrt())
        .collect();
    // Two-sided 1 % over all blocks together (Šidák): |z| below 4.6 for some thousand blocks.
    let accepted = scores.iter().filter(|z| z.abs() < 4.6).count();
    let worst = scores.iter().fold(0.0, |worst: f64, z| worst.max(z.abs()));
    println!("{accepted} of {} blocks accept, worst |z| {worst:.2}", scores.len());
    assert!(accepted as f64 >= 0.9975 * scores.len() as f64);

    for channel in 0..3 {
        let pick = |sums: &[f64]| sums.iter().skip(channel).step_by(3).sum::<f64>();
        let difference = pick(&our_sums) - pick(&their_sums);
        let standard_error = pick(&variances).sqrt();
        println!("channel {channel}: the image means differ by {:.2} standard errors", difference / standard_error);
        assert!(difference.abs() < 3.0 * standard_error);
    }
}
