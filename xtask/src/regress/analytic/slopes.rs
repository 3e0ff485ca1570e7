//! Convergence rate of the error of a pixel.

use rayon::prelude::*;
use rt_camera::SamplerKind;
use rt_math::transcendental::{atan, log2};
use rt_scene_io::Integrator;

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::ALBEDO,
    cases, closed_form,
    coverage::{disk, half_plane, left_of, sphere_aside},
    irradiance::under_point_light,
};
use crate::line_fit::LineFit;

cases! {
    "S67", "slopes of RMSE over N of each pattern: edges, disks, spheres, smooth light",
        "−½ by random, −¾ at edges, −1 at upright ones, −1 and −1½ where it is smooth", "0.1 abs", slopes;
}

pub(super) const TOLERANCE: f64 = 0.1;

/// Slopes at an oblique edge, an edge along the axis, a quarter disk, a sphere off the axis, and a smooth function.
/// They are theoretical (Mitchell 1996, Owen 1997); where theory gives a bound, they were measured with many more
/// samples.
const EXPECTED: [(SamplerKind, [f64; 5]); 6] = [
    (SamplerKind::Random, [-0.5, -0.5, -0.5, -0.5, -0.5]),
    (SamplerKind::Jittered, [-0.75, -0.75, -0.75, -0.75, -1.0]),
    (SamplerKind::MultiJittered, [-0.75, -1.0, -0.75, -0.75, -1.0]),
    (SamplerKind::Sobol, [-0.75, -1.0, -0.75, -0.75, -1.5]),
    (SamplerKind::Halton, [-0.75, -1.0, -0.75, -0.75, -1.0]),
    (SamplerKind::BlueNoise, [-0.75, -1.0, -0.75, -0.75, -1.5]),
];

/// Root mean square error of an image over seeds.
pub(super) fn rmse(seeds: u64, truth: f64, of_seed: &(dyn Fn(u64) -> Fallible<f64> + Sync)) -> Fallible<f64> {
    let values = (0..seeds).into_par_iter().map(of_seed).collect::<Fallible<Vec<f64>>>()?;
    Ok((values.iter().map(|value| (value - truth) * (value - truth)).sum::<f64>() / seeds as f64).sqrt())
}

/// Slope of log RMSE over log N by least squares, for `rmse(N)` at some powers of 4.
pub(super) fn slope(counts: &[u32], rmse: impl Fn(u32) -> Fallible<f64>) -> Fallible<f64> {
    let points = counts.iter().map(|&spp| Ok([log2(f64::from(spp)), log2(rmse(spp)?)]));
    Ok(LineFit::of(&points.collect::<Fallible<Vec<_>>>()?).slope)
}

fn slopes(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let seeds = conditions.count(256, 1024);
    let counts: &[u32] = if conditions.full { &[16, 64, 256, 1024, 4096] } else { &[16, 64, 256, 1024] };
    let aside = atan(0.5);
    let images = [
        ("y < .3 + .2 x", 0.4, half_plane(0.3, 0.2)?),
        ("x < 1/3", 1.0 / 3.0, left_of(1.0 / 3.0)?),
        ("quarter disk", std::f64::consts::FRAC_PI_4, disk(1.0, 0.0)?),
        ("sphere aside", 0.25 * closed_form::projected_sphere(0.25, aside), sphere_aside(aside)?),
        ("smooth", ALBEDO * closed_form::point_light_over_rectangle(1.0, 1.0, 1.0), under_point_light(0.5, 0.5, 1.0)?),
    ];
    for (pattern, expected) in EXPECTED {
        let mut note = format!("{}:", pattern.name());
        for ((what, truth, image), expected) in images.iter().zip(expected) {
            let slope =
                slope(counts, |spp| rmse(seeds, *truth, &|seed| image.mean(Integrator::Whitted, pattern, spp, seed)))?;
            note.push_str(&format!(" {what} {slope:+.3}"));
            let name = pattern.name();
            let what = format_args!("{name}, {what}: slope {slope:.3} instead of {expected}");
            checks.limit(slope - expected, TOLERANCE, what);
        }
        checks.note(note);
    }
    Ok(())
}
