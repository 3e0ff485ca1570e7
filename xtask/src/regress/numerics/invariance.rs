//! Invariance under scaling and translation of a scene, which is shaded in `f64`.
//!
//! A thousandth of a number is rounded, so a scene at scale 10⁻³ is not quite the same scene. Most pixels do not
//! change. Two kinds do in any program. Where a ray goes from small sphere to small sphere, each mirror multiplies
//! earlier rounding by twice the distance over the radius. Elsewhere a sample lies within rounding of an edge.
//! Such pixels are found without the code under test: in the unmoved scene, larger and smaller by a few units in the
//! last place ([`ULPS`]). The maximum change of a pixel over these is its *spread*. A pixel that is off by more than
//! [`LIMIT`] fails, unless it is off by at most [`SPREADS`] times its spread. Then it counts as ill-conditioned and is
//! reported. More than one of these in [`PIXELS_OF_ONE`] pixels is a failure, or a renderer with random results would
//! pass.

use rayon::prelude::*;
use rt_math::{DVec3, Rgb, Transform};
use rt_render::{PlanOptions, Precision, RenderPlan};
use rt_scene_io::Scene;
use rt_shading::DeltaLightKind;
use rt_tests::moved;

use super::{Case, Checks, Conditions, Fallible, cases, images::small};

cases! {
    "S80", "scene files scaled by 1e-3…1e3 and moved by 1e6",
        "the same radiance; at most 1 pixel in 1e5 ill-conditioned",
        "1e-9 abs, ill-conditioned 4 × what ±4 ulp of scale do", invariance;
}

/// Maximum difference of the radiance in any component.
const LIMIT: f64 = 1e-9;

/// Changes of the scale 1, in units in the last place, that show the effect of rounding on a pixel.
const ULPS: [f64; 8] = [-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0];

/// Maximum deviation of an ill-conditioned pixel, in spreads.
const SPREADS: f64 = 4.0;

/// One of so many pixels may be ill-conditioned.
const PIXELS_OF_ONE: u64 = 100_000;

/// Comparison of a pixel with the same pixel of the unchanged scene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PixelVerdict {
    Same,
    /// Off by no more than rounding explains.
    IllConditioned,
    Different,
}

impl PixelVerdict {
    fn of(off: f64, spread: f64) -> Self {
        if off <= LIMIT {
            Self::Same
        } else if off <= SPREADS * spread {
            Self::IllConditioned
        } else {
            Self::Different
        }
    }
}

fn invariance(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let mut ill_conditioned = 0;
    let (width, spp) = if conditions.full { (96, 4) } else { (16, 1) };
    for file in conditions.workspace.files("scenes", ".ron")? {
        let mut scene = small(&file, width, spp)?;
        with_few_digits(&mut scene)?;
        if scene.settings.integrator.is_stochastic() {
            // Each bounce of a path multiplies earlier rounding errors; after a dozen bounces another wall is hit.
            scene.settings.depth = 0;
        }
        ill_conditioned += compare(&scene, checks)?;
    }
    let tried = checks.tried;
    checks.note(format!("ill-conditioned: {ill_conditioned} of {tried} pixels"));
    checks
        .check(are_few(ill_conditioned, tried), || format!("{ill_conditioned} of {tried} pixels are ill-conditioned"));
    Ok(())
}

const fn are_few(ill_conditioned: u64, pixels: u64) -> bool {
    ill_conditioned * PIXELS_OF_ONE <= pixels
}

/// Compares a scene with its moved copy; returns the number of ill-conditioned pixels.
fn compare(scene: &Scene, checks: &mut Checks) -> Fallible<u64> {
    // Numbers must stay exact under the move: powers of two near 1e±3, and a million of the units of the scaled scene.
    let million = DVec3::new(1e6, -1e6, 1e6);
    let sizes = [1e-3, 0.1, 7.0, 1e3].map(|scale| (scale, 0.0));
    let moves = [(1.0 / 1024.0, 1.0), (1.0 / 1024.0, 1.0 / 1024.0), (1.0, 1.0), (1024.0, 1024.0)];
    let expected = radiance(scene)?;
    let mut spreads = None;
    let (mut worst, mut ill_conditioned) = (0f64, 0);
    for (scale, shift) in sizes.into_iter().chain(moves) {
        let differences = differences(&moved(scene, scale, million * shift)?, &expected)?;
        if spreads.is_none() && differences.iter().any(|off| PixelVerdict::of(*off, 0.0) == PixelVerdict::Different) {
            spreads = Some(spreads_of(scene, &expected)?);
        }
        for (index, off) in differences.into_iter().enumerate() {
            worst = worst.max(off);
            let spread = spreads.as_ref().map_or(0.0, |spreads: &Vec<f64>| spreads[index]);
            let place = format_args!("{}, scale {scale}, moved {shift}·1e6, pixel {index}", scene.name);
            if PixelVerdict::of(off, spread) == PixelVerdict::IllConditioned {
                ill_conditioned += 1;
                checks.check(true, String::new);
                checks.note(format!("{place}: off by {off:.1e}, ill-conditioned with a spread of {spread:.1e}"));
            } else {
                checks.limit(off, LIMIT, place);
            }
        }
    }
    checks.note(format!("{}: {worst:.1e}", scene.name));
    Ok(ill_conditioned)
}

/// The spread of each pixel: how far it is from `expected` in scenes a few units in the last place larger or smaller.
fn spreads_of(scene: &Scene, expected: &[Rgb]) -> Fallible<Vec<f64>> {
    let mut spreads = vec![0f64; expected.len()];
    for ulps in ULPS {
        let neighbour = moved(scene, 1.0 + ulps * f64::EPSILON, DVec3::ZERO)?;
        for (spread, off) in spreads.iter_mut().zip(differences(&neighbour, expected)?) {
            *spread = spread.max(off);
        }
    }
    Ok(spreads)
}

/// Cameras and lights at positions that keep their numbers when they are moved by a million.
fn with_few_digits(scene: &mut Scene) -> Fallible<()> {
    let rounded = |position: DVec3| (position * 256.0).round() / 256.0;
    for camera in &mut scene.cameras {
        let settings = &mut camera.settings;
        for place in [&mut settings.world_from_camera].into_iter().chain(&mut settings.moves_to) {
            *place = Transform::from_linear(place.linear(), rounded(place.translation()))?;
        }
    }
    for light in &mut scene.appearance.lights {
        if let DeltaLightKind::Point { position, .. } | DeltaLightKind::Spot { position, .. } = &mut light.kind {
            *position = rounded(*position);
        }
    }
    Ok(())
}

/// The maximum difference from `expected` in any component, for each pixel.
fn differences(scene: &Scene, expected: &[Rgb]) -> Fallible<Vec<f64>> {
    let off = |(found, expected): (&Rgb, &Rgb)| {
        (*found - *expected).to_array().into_iter().fold(0f64, |worst, component| worst.max(component.abs()))
    };
    Ok(radiance(scene)?.iter().zip(expected).map(off).collect())
}

/// The radiance of all pixels, before the film rounds it.
fn radiance(scene: &Scene) -> Fallible<Vec<Rgb>> {
    let plan = RenderPlan::compile(scene, &PlanOptions { precision: Precision::F64, ..PlanOptions::default() })?;
    let (width, height) = (scene.film.width, scene.film.height);
    let pixel = |index: u32| plan.pixel(index % width, index / width).ok_or("a pixel outside of the image");
    Ok((0..width * height).into_par_iter().map(pixel).collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pixels_that_are_off_where_the_scene_stands_are_ill_conditioned() {
        assert_eq!(PixelVerdict::of(1e-9, 0.0), PixelVerdict::Same);
        assert_eq!(PixelVerdict::of(1e-9, 1.0), PixelVerdict::Same);
        assert_eq!(PixelVerdict::of(1.1e-9, 0.0), PixelVerdict::Different);
        assert_eq!(PixelVerdict::of(4e-7, 1e-7), PixelVerdict::IllConditioned);
        assert_eq!(PixelVerdict::of(4.1e-7, 1e-7), PixelVerdict::Different);
        assert_eq!(PixelVerdict::of(f64::NAN, 1.0), PixelVerdict::Different);
    }

    #[test]
    fn one_pixel_of_a_hundred_thousand_may_be_ill_conditioned() {
        assert!(are_few(0, 0) && are_few(1, 100_000) && are_few(8, 871_680));
        assert!(!are_few(1, 99_999) && !are_few(9, 871_680));
    }
}
