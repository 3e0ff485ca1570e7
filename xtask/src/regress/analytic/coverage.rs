//! Coverage of a pixel by a shape.

use std::f64::consts::{FRAC_PI_4, PI};

use rt_camera::SamplerKind;
use rt_math::transcendental::{acos, atan, sincos, tan};
use rt_scene_io::Integrator;

use super::{
    Case, Checks, Conditions, Fallible, cases, closed_form,
    estimate::{Estimate, MAX_Z},
    test_image::{DARK, TestImage},
};

cases! {
    "coverage", "half-planes, disks and spheres in a pixel", "½ tan 10°; 0.4; π/4; 0.9509111308; π/60", "5 σ", coverage;
    "S66", "a sphere off the axis (its slope is among those of S67)", "0.0750433996", "5 σ", off_axis;
    "S68", "an edge along the axis by half-jittered and jittered samples",
        "the first is biased, the second is not", "> 5 σ; 5 σ", half_jittered;
    "lambert-sphere", "a diffuse sphere in light from the eye",
        "2/3 ρ in the mean over its disk", "5 σ", lambert_sphere;
}

/// Integrators that show emission.
const SHOWING: [Integrator; 4] = [Integrator::Whitted, Integrator::Direct, Integrator::Path, Integrator::Distributed];

/// The unit square with its corner in the origin, as one pixel.
const UNIT_SQUARE: &str = "(look_from: (0.5, 0.5, 1), look_at: (0.5, 0.5, 0), orthographic: 1)";

/// The square [−1, 1]² at a distance of 1, from the origin.
const PINHOLE: &str = "(look_from: (0, 0, 0), look_at: (0, 0, -1), fov: 90)";

/// A shape of radiance 1 before black, seen by one pixel.
pub(super) fn emissive(camera: &str, shape: &str, place: &str) -> Fallible<TestImage> {
    TestImage::of(&format!(
        "camera: {camera},
            {DARK},
            materials: {{\"lamp\": light(radiance: gray(1), emission_sides: both)}},
            nodes: [(shape: {shape}, transform: [{place}], material: \"lamp\")],"
    ))
}

/// Half-plane below y = `at_zero` + `slope` · x.
pub(super) fn half_plane(at_zero: f64, slope: f64) -> Fallible<TestImage> {
    let edge = |x: f64| format!("({x}, {:?}, 0)", at_zero + slope * x);
    emissive(UNIT_SQUARE, &format!("polygon(points: [{}, (0, -20, 0), {}])", edge(-9.0), edge(9.0)), "")
}

/// Half-plane left of x = `edge`.
pub(super) fn left_of(edge: f64) -> Fallible<TestImage> {
    emissive(UNIT_SQUARE, &format!("polygon(points: [({edge:?}, -9, 0), ({edge:?}, 9, 0), (-9, 0.5, 0)])"), "")
}

/// A disk in the plane of the pixel.
pub(super) fn disk(radius: f64, centre: f64) -> Fallible<TestImage> {
    let place = format!("rotate_x(90), translate({centre:?}, {centre:?}, 0)");
    emissive(UNIT_SQUARE, &format!("disk(radius: {radius:?})"), &place)
}

/// A sphere of radius 1 at a distance of 4, so far from the axis in radians.
pub(super) fn sphere_aside(angle: f64) -> Fallible<TestImage> {
    let (sin, cos) = sincos(angle);
    emissive(PINHOLE, &format!("sphere(center: ({:?}, 0, {:?}))", 4.0 * sin, -4.0 * cos), "")
}

fn coverage(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let ten = tan(10f64.to_radians());
    // The parts of a disk of radius .6 beyond the four sides.
    let beyond = 0.36 * acos(0.5 / 0.6) - 0.5 * 0.11f64.sqrt();
    let sphere = "sphere(center: (0.5, 0.5, -2), radius: 0.5)";
    for (what, truth, image) in [
        ("y < x tan 10°", 0.5 * ten, half_plane(0.0, ten)?),
        ("y < .3 + .2 x", 0.4, half_plane(0.3, 0.2)?),
        ("disk of .5", FRAC_PI_4, disk(0.5, 0.5)?),
        ("quarter disk", FRAC_PI_4, disk(1.0, 0.0)?),
        ("disk of .6", 0.36 * PI - 4.0 * beyond, disk(0.6, 0.5)?),
        ("sphere in parallel light", FRAC_PI_4, emissive(UNIT_SQUARE, sphere, "")?),
        ("sphere at 4", PI / 60.0, sphere_aside(0.0)?),
    ] {
        image.hold_by(&SHOWING, checks, what, truth, 1.0, conditions.effort())?;
    }
    Ok(())
}

fn off_axis(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let angle = atan(0.5);
    let truth = 0.25 * closed_form::projected_sphere(0.25, angle);
    sphere_aside(angle)?.hold_by(&SHOWING, checks, "sphere at 4, atan ½ aside", truth, 1.0, conditions.effort())
}

fn half_jittered(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let seeds = conditions.count(256, 1024);
    let image = left_of(1.0 / 3.0)?;
    for pattern in [SamplerKind::HalfJittered, SamplerKind::Jittered] {
        let of_seed = |seed| image.mean(Integrator::Whitted, pattern, 16, seed);
        let name = pattern.name();
        let z = Estimate::of_seeds(name, seeds, of_seed)?.z(1.0 / 3.0);
        checks.note(format!("x < 1/3 by 16 {name} samples: z = {z:+.2}"));
        checks.check((z.abs() > MAX_Z) == pattern.is_biased(), || format!("{name}: z = {z}"));
    }
    Ok(())
}

/// Its disk fills a square but for the corners.
fn lambert_sphere(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let image = TestImage::of(&format!(
        "camera: {UNIT_SQUARE},
            lights: [directional(direction: (0, 0, -1))],
            background: constant(gray(0)),
            materials: {{\"chalk\": phong(diffuse: gray(0.8), ambient: gray(0))}},
            nodes: [(shape: sphere(center: (0.5, 0.5, -2), radius: 0.5), material: \"chalk\")],"
    ))?;
    let truth = FRAC_PI_4 * 2.0 / 3.0 * 0.8;
    image.hold_by(&SHOWING, checks, "π/4 · 2/3 · .8", truth, 1.0, conditions.effort())
}
