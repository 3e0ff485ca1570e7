//! Soft shadows: lights that are partly hidden.

use std::f64::consts::PI;

use rt_math::{DVec3, transcendental::exp};
use rt_scene_io::Integrator;

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::{ALBEDO, AreaLight, Receiver, check_image, tuple},
    cases, closed_form,
};

cases! {
    "S63", "a disk of light cut by an edge, from −.75 to .75 of its radius",
        "(acos x − x √(1 − x²)) / π", "5 σ", penumbra;
    "eclipse", "a disk of light behind disks, one radius aside",
        "1 − lens / π: 0.6089977810, 0.8883475203", "5 σ", eclipse;
    "gel", "a disk of light above a tinted slab that does not refract",
        "2π ∫ exp(−0.7 / c) c dc from 3/√10 to 1: 0.1531666", "5 σ", gel;
    "shadowless", "two disks of light behind a black disk and behind each other, without shadows",
        "π (9 / 13 + 81 / 106): 4.575600", "5 σ", shadowless;
    "clear", "a disk of light behind a slab of glass that hardly refracts, without shadows; and behind a bubble in such glass",
        "π / 10", "5 σ", clear;
    "hollow", "a box without shadow that emits on both sides, before a disk of light",
        "π / 10 + a square's irradiance", "5 σ", hollow;
}

/// Radius of the light, 1 above the receiver: so small that all of it is seen at the same cosine, but for its square.
const RADIUS: f64 = 1e-5;

/// Half way up to the light, things hide twice their size of it.
const HALF_WAY: f64 = 0.5;

fn penumbra(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for cut in [-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75] {
        let edge = HALF_WAY * cut * RADIUS;
        let corners = [[edge, -1.0], [edge, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let corners = corners.map(|[x, y]| tuple(DVec3::new(x, y, HALF_WAY))).join(", ");
        let hides = format!("(shape: polygon(points: [{corners}]), material: \"black\")");
        hold_share(checks, conditions, &format!("cut at {cut}"), &hides, closed_form::cut_disk(cut))?;
    }
    Ok(())
}

fn eclipse(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for radius in [1.0, 0.5] {
        let (size, aside) = (HALF_WAY * radius * RADIUS, HALF_WAY * RADIUS);
        let place = format!("[rotate_x(90), translate({aside:?}, 0, {HALF_WAY:?})]");
        let hides = format!("(shape: disk(radius: {size:?}), transform: {place}, material: \"black\")");
        let share = 1.0 - closed_form::lens(1.0, radius, 1.0) / PI;
        hold_share(checks, conditions, &format!("behind a disk of {radius}"), &hides, share)?;
    }
    Ok(())
}

/// Shadow rays pass a slab with the index of air. Sampled directions pass it as well, and so do those that look for lights behind objects
/// without shadow.
fn gel(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const ABSORPTION: f64 = 0.7;
    let (area_light, receiver) = (AreaLight::disk(1.0, 3.0, 0.0), Receiver::ground(0.5));
    let cos_min = 3.0 / 10f64.sqrt();
    // By the midpoint rule; the integrand is smooth.
    let n = 10_000;
    let integrand = |i: u32| {
        let cos = cos_min + (1.0 - cos_min) * (f64::from(i) + 0.5) / f64::from(n);
        exp(-ABSORPTION / cos) * cos
    };
    let irradiance = 2.0 * PI * (1.0 - cos_min) / f64::from(n) * (0..n).map(integrand).sum::<f64>();
    let slab = format!(
        "(shape: box(min: (-1e3, -1e3, 1), max: (1e3, 1e3, 2)), material: glass(ior: 1, absorption: gray({ABSORPTION})))"
    );
    let image = area_light.scene(&receiver, 1e-6, &slab)?;
    let disk = "(shape: disk(radius: 1.5), transform: [rotate_x(90), translate(0, 0, 0.75)], material: \"black\", casts_shadow: false)";
    let behind_disk = area_light.scene(&receiver, 1e-6, &format!("{slab}, {disk}"))?;
    let clear = "(shape: box(min: (-1e3, -1e3, 1), max: (1e3, 1e3, 2)), material: glass(ior: 1), casts_shadow: false)";
    let through_clear = area_light.scene(&receiver, 1e-6, clear)?;
    for integrator in [Integrator::Direct, Integrator::Path] {
        let what = integrator.name();
        image.hold(checks, what, irradiance, (integrator, PI / ALBEDO), conditions.effort())?;
        let what_behind = format!("behind a disk without shadow, {what}");
        behind_disk.hold(checks, what_behind, irradiance, (integrator, PI / ALBEDO), conditions.effort())?;
        // Both techniques find this light.
        let what = format!("a clear slab without shadow, {what}");
        through_clear.hold(checks, what, 0.1 * PI, (integrator, PI / ALBEDO), conditions.effort())?;
    }
    Ok(())
}

/// Light samples pass the disk; sampled directions end at it, and the light behind counts with the rest of its weight.
fn shadowless(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let receiver = Receiver::ground(0.5);
    // The nearer light casts no shadow either, and hides the middle of the other. It emits downwards.
    let others = "(shape: disk(radius: 1.5), transform: [rotate_x(90), translate(0, 0, 1)], material: \"black\", casts_shadow: false),
        (shape: disk(radius: 3), transform: [rotate_x(-90), translate(0, 0, 2)], material: \"lamp\", casts_shadow: false),";
    let image = AreaLight::disk(4.5, 2.5, 0.0).scene(&receiver, 1e-6, others)?;
    let irradiance = PI * (9.0 / 13.0 + 81.0 / 106.0);
    let both = [Integrator::Direct, Integrator::Path];
    image.hold_by(&both, checks, "two lights", irradiance, PI / ALBEDO, conditions.effort())
}

/// The index of glass whose surface is visible, but hardly refracts and reflects.
const CLEAR_IOR: f64 = 1.0001;

/// Light samples pass the slab, and sampled directions meet its surfaces: the light behind counts once. The bubble occludes light samples.
fn clear(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let (receiver, area_light) = (Receiver::ground(0.5), AreaLight::disk(1.0, 3.0, 0.0));
    let (truth, scale, effort) = (0.1 * PI, PI / ALBEDO, conditions.effort());
    let middle = "(shape: box(min: (-1e3, -1e3, 1), max: (1e3, 1e3, 2))";
    let slab = format!("{middle}, material: glass(ior: {CLEAR_IOR}), casts_shadow: false)");
    let image = area_light.scene(&receiver, 1e-6, &slab)?;
    image.hold_by(&[Integrator::Direct, Integrator::Path], checks, "a slab without shadow", truth, scale, effort)?;
    let bubble = format!(
        "(shape: box(min: (-1e3, -1e3, -1), max: (1e3, 1e3, 4)), material: glass(ior: {CLEAR_IOR})),
        {middle}, material: glass(ior: 1, priority: 1))"
    );
    let image = area_light.scene(&receiver, 1e-6, &bubble)?;
    image.hold(checks, "a bubble", truth, (Integrator::Path, scale), effort)?;
    // Its surface is not visible in the slab, but ends shadow rays.
    let inner = "(shape: box(min: (-1e3, -1e3, 1.2), max: (1e3, 1e3, 1.8)), material: glass(ior: 1.3))";
    let outer = format!("{middle}, material: glass(ior: {CLEAR_IOR}, priority: 1), casts_shadow: false)");
    let image = area_light.scene(&receiver, 1e-6, &format!("{outer}, {inner}"))?;
    image.hold(checks, "a slab without shadow around one with", truth, (Integrator::Path, scale), effort)
}

/// Only the lower side of the box lights the receiver: its other sides are hidden, although it casts no shadow.
fn hollow(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let receiver = Receiver::ground(0.5);
    let hollow = "(shape: box(min: (-0.5, -0.5, 1), max: (0.5, 0.5, 2)), casts_shadow: false,
        material: light(radiance: gray(1), emission_sides: both))";
    let image = AreaLight::disk(1.0, 3.0, 0.0).scene(&receiver, 1e-6, hollow)?;
    let truth = 0.1 * PI + AreaLight::square(1.0, 0.0).irradiance(&receiver);
    let both = [Integrator::Direct, Integrator::Path];
    image.hold_by(&both, checks, "a box and a disk", truth, PI / ALBEDO, conditions.effort())
}

/// Compares the irradiance with the share of it that a node leaves.
fn hold_share(checks: &mut Checks, conditions: &Conditions, what: &str, hides: &str, share: f64) -> Fallible<()> {
    let area_light = AreaLight::disk(RADIUS, 1.0, 0.0);
    let receiver = Receiver::ground(0.25);
    let image = area_light.scene(&receiver, RADIUS * 1e-6, hides)?;
    check_image(checks, what, area_light.irradiance(&receiver) * share, &image, conditions.effort())
}
