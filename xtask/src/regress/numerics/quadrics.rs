//! Cylinders and cones, around the y axis.

use rt_geometry::{CappedQuadric, InfiniteQuadric, InteractionFlags, ShapeHit};
use rt_math::{DVec3, Interval, Ray, transcendental::sincos};

use super::{Case, Checks, Conditions, FOUR_U, Fallible, Tolerance, cases};

cases! {
    "S16", "cylinders from afar, thin, and nearly along the axis",
        "999999.133974596218 and others", "4u", far_cylinders;
    "S17", "rays parallel to a cylinder's axis", "caps to and including the rim; sides never", "bits", along_the_axis;
    "S18", "rays at a cylinder's rim, between side and cap", "one hit, there", "0 leaks", rim;
    "S19", "a ray along a cone's generator",
        "t = 1.03125 alone", "bits",
        |_, checks| cone(1.0, [-3.0, 0.5, 1.0], [1.0, 0.0, 1.0], &[1.03125], Tolerance::Bits, checks);
    "S20", "a ray nearly along a cone's generator", "1.031249937572287, −33554432.03125", "4u",
        |_, checks| {
            let direction = [1.0, 0.0, 1.0 + 1.0 / 8_388_608.0];
            let roots = [-33_554_432.031_25, 1.031_249_937_572_287_4];
            cone(1.0, [-3.0, 0.5, 1.0], direction, &roots, FOUR_U, checks)
        };
    "S21", "rays through the apex of a double cone", "one t, a finite normal against the ray", "4u", apex;
    "S22", "a thin cone of slope 1e-4, and one from afar", "0.9999, 1.0001; 999999.031754163", "4u",
        |_, checks| {
            cone(1e-4, [-1.0, 0.0, 1.0], [1.0, 0.0, 0.0], &[0.9999, 1.0001], FOUR_U, checks)?;
            let roots = [999_999.031_754_163_4, 1_000_000.968_245_836_6];
            cone(1.0, [-1e6, 0.25, 1.0], [1.0, 0.0, 0.0], &roots, FOUR_U, checks)
        };
}

const EVERYWHERE: Interval = Interval::new(f64::NEG_INFINITY, f64::INFINITY);

/// Literature has the axis along z: the axes one further.
fn cyclic([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(y, z, x)
}

/// All crossings in order, each found as the first after the one before.
fn crossings(intersect: impl Fn(Interval) -> Option<ShapeHit>) -> Vec<f64> {
    let mut span = EVERYWHERE;
    let mut found = Vec::new();
    while let Some(hit) = intersect(span).filter(|_| found.len() < 9) {
        found.push(hit.t);
        span = Interval::new(hit.t.next_up(), f64::INFINITY);
    }
    found
}

fn compare(found: &[f64], expected: &[f64], tolerance: Tolerance, checks: &mut Checks) {
    checks.check(found.len() == expected.len(), || format!("{found:?} instead of {expected:?}"));
    for (t, exact) in found.iter().zip(expected) {
        checks.near(*t, *exact, tolerance, "t");
    }
}

fn far_cylinders(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let mut try_one = |radius: f64, origin: [f64; 3], direction: [f64; 3], expected: [f64; 2]| {
        let ray = Ray::new(cyclic(origin), cyclic(direction));
        let cylinder = InfiniteQuadric::cylinder(radius)?;
        compare(&crossings(|span| cylinder.intersect(&ray, span)), &expected, FOUR_U, checks);
        Ok::<(), rt_geometry::ShapeError>(())
    };
    let (far, other_side) = (999_999.133_974_596_3, 1_000_000.866_025_403_7);
    try_one(1.0, [-6e5 + 0.4, -8e5 - 0.3, 0.0], [0.6, 0.8, 0.0], [far, other_side])?;
    try_one(1.0, [0.5, 0.0, -10.0], [1e-8, 0.0, 1.0], [-149_999_999.999_999_997, 49_999_999.999_999_999])?;
    let (near, beyond) = (99.999_083_484_861, 100.000_916_515_139);
    try_one(1e-3, [-100.0, 0.0004, 0.0], [1.0, 0.0, 0.0], [near, beyond])?;
    Ok(())
}

fn along_the_axis(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let [closed, open] = [true, false].map(|caps| CappedQuadric::cylinder(1.0, 0.0, 2.0, caps));
    let (closed, open, endless) = (closed?, open?, InfiniteQuadric::cylinder(1.0)?);
    for (distance, on_caps) in [(0.0, true), (0.5, true), (1.0, true), (1f64.next_up(), false), (2.0, false)] {
        for zero in [0.0, -0.0] {
            let ray = Ray::new(DVec3::new(distance, -1.0, 0.0), DVec3::new(zero, 1.0, zero));
            let expected: &[f64] = if on_caps { &[1.0, 3.0] } else { &[] };
            let what = format!("{distance:?} from the axis");
            checks.same(crossings(|span| closed.intersect(&ray, span)).as_slice(), expected, &what);
            checks.same(open.intersect(&ray, EVERYWHERE), None, &what);
            checks.same(endless.intersect(&ray, EVERYWHERE), None, &what);
        }
    }
    Ok(())
}

/// Rays that enter the solid at the rim: however the aim is rounded, the cap or the side is hit within rounding of it.
fn rim(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let cylinder = CappedQuadric::cylinder(0.7, -0.3, 1.1, true)?;
    checks.draw_all(conditions.count(50_000, 1_000_000), 18, |draw, checks| {
        let (sin, cos) = sincos(draw.between(0.0, std::f64::consts::TAU));
        let (height, up) = draw.pick(&[(1.1, 1.0), (-0.3, -1.0)]);
        let aim = DVec3::new(0.7 * cos, height, 0.7 * sin);
        let inwards = -(DVec3::new(cos, 0.0, sin) * draw.between(0.05, 1.0) + DVec3::Y * up * draw.between(0.05, 1.0))
            + DVec3::new(-sin, 0.0, cos) * draw.between(-0.3, 0.3);
        let origin = aim - inwards * draw.pick(&[1.0, 3.0, 1e3]);
        let ray = Ray::new(origin, aim - origin);
        let t = cylinder.intersect(&ray, Interval::FORWARD).map(|hit| hit.t);
        checks.hit(t, 1.0, Tolerance::Absolute(1e-10), format_args!("towards {aim}"));
        let beyond = cylinder.intersect(&ray, Interval::new(1.0 + 1e-10, 1.0 + 1e-6));
        checks.check(beyond.is_none(), || format!("a second hit at {beyond:?}"));
    });
    Ok(())
}

fn cone(
    slope: f64,
    origin: [f64; 3],
    direction: [f64; 3],
    expected: &[f64],
    tolerance: Tolerance,
    checks: &mut Checks,
) -> Fallible<()> {
    let cone = InfiniteQuadric::double_cone(slope)?;
    let ray = Ray::new(cyclic(origin), cyclic(direction));
    compare(&crossings(|span| cone.intersect(&ray, span)), expected, tolerance, checks);
    Ok(())
}

/// From exact origins along exact directions, so that the apex is met exactly.
fn apex(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let cone = InfiniteQuadric::double_cone(1.0)?;
    for x in -4..=4 {
        for y in -4..=4 {
            for z in -4..=4 {
                let direction = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                // Along a generator every point is a crossing, and none is reported.
                if direction == DVec3::ZERO || x * x + z * z == y * y {
                    continue;
                }
                let ray = Ray::new(direction * -3.0, direction);
                let found = crossings(|span| cone.intersect(&ray, span));
                compare(&found, &[3.0], FOUR_U, checks);
                let Some(hit) = cone.intersect(&ray, EVERYWHERE) else { continue };
                let normal = cone.surface(&ray, &hit, InteractionFlags::ALL).geometric_normal;
                let is_usable = (normal.length() - 1.0).abs() < 1e-14 && normal.dot(direction) <= 0.0;
                checks.check(is_usable, || format!("normal {normal} for {direction}"));
            }
        }
    }
    Ok(())
}
