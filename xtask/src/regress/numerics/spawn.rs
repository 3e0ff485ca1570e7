//! Rays that leave a surface.

use rayon::prelude::*;
use rt_accel::{Accelerator, Bvh};
use rt_geometry::{Cuboid, InteractionFlags, NoProbe, Shape, Sphere};
use rt_math::{DVec3, Interval, Ray};
use rt_tests::{ShapeSet, Spawned, spawn_setups};

use super::{Case, Checks, Conditions, Fallible, cases};

cases! {
    "S33", "rays spawned from a triangle of scale 1e-6…1e6 at offsets 0…1e7, beneath a sheet",
        "no acne, no leaks", "0", spawn_table;
    "S34", "a sphere within another, a gap of 1e-9 apart", "the inner one, at the gap", "0 leaks", gap;
    "S35", "shadows between 100 boxes stacked 1e-7 apart at 1e3", "as the slope of the ray says", "0", stack;
}

fn spawn_table(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let rays = conditions.count(30_000, 1_000_000);
    checks.note("scale | offset | triangle | rays | acne | leaks");
    for setup in spawn_setups() {
        let blocks: Vec<u64> = (0..rays.div_ceil(10_000)).collect();
        let parts: Result<Vec<Spawned>, _> =
            blocks.par_iter().map(|block| setup.spawn(block * 10_000..rays.min((block + 1) * 10_000))).collect();
        let mut sum = Spawned::default();
        for part in parts? {
            sum += part;
        }
        let Spawned { spawned, acne, leaks } = sum;
        let which = if setup.is_level { "level" } else { "oblique" };
        checks.note(format!("{:e} | {:e} | {which} | {spawned} | {acne} | {leaks}", setup.scale, setup.offset));
        checks.check(spawned > rays / 100 * 99, || format!("{setup:?}: only {spawned} rays were spawned"));
        checks.check(acne + leaks == 0, || format!("{setup:?}: {acne} acne, {leaks} leaks"));
        checks.tried += spawned - 2;
    }
    Ok(())
}

fn gap(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const GAP: f64 = 1e-9;
    let outer = Sphere::new(DVec3::ZERO, 1.0)?;
    let inner = Sphere::new(DVec3::ZERO, 1.0 - GAP)?;
    checks.draw_all(conditions.count(50_000, 1_000_000), 34, |draw, checks| {
        let arriving = draw.direction() * 3.0;
        // Near the silhouette the way across the gap grows longer, up to √(2·gap).
        let ray = Ray::new(arriving, draw.point() * 0.5 - arriving);
        let Some(hit) = outer.intersect(&ray, Interval::FORWARD) else {
            checks.check(false, || format!("{ray:?} misses"));
            return;
        };
        let surface = outer.surface(&ray, &hit, InteractionFlags::ALL);
        let direction = -draw.above(surface.geometric_normal, 0.05);
        let entering = surface.spawn_ray(direction, 0.0);
        let across = inner.intersect(&entering, Interval::SPAWNED).map(|hit| hit.t);
        let cosine = -surface.geometric_normal.dot(direction);
        // To first order in the gap, which is all that is left of it in the radius.
        let expected = GAP / cosine;
        let limit = expected * 1e-4 + GAP * expected / (cosine * cosine);
        checks.check(across.is_some_and(|t| (t - expected).abs() <= limit), || {
            format!("{across:?} instead of {expected:e} at cosine {cosine}")
        });
    });
    Ok(())
}

fn stack(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const COINS: usize = 100;
    const FAR: f64 = 1e3;
    const GAP: f64 = 1e-7;
    let heights = |coin: usize| {
        let bottom = FAR + coin as f64 * (0.01 + GAP);
        [bottom, bottom + 0.01]
    };
    let coin = |index: usize| {
        let [bottom, top] = heights(index);
        Cuboid::new(DVec3::new(FAR - 1.0, bottom, FAR - 1.0), DVec3::new(FAR + 1.0, top, FAR + 1.0))
    };
    let coins: Result<Vec<Cuboid>, _> = (0..COINS).map(coin).collect();
    let set = ShapeSet::of_shapes(coins?.into_iter().map(Shape::Cuboid));
    let accelerator = Bvh::build(&set)?;
    checks.draw_all(conditions.count(20_000, 1_000_000), 35, |draw, checks| {
        let at = draw.below(COINS - 1);
        // Points in the gap are a part of the visible ones, from the side.
        let [top, next] = [heights(at)[1], heights(at + 1)[0]];
        let (to_edge, gap) = (draw.between(0.01, 1.0), next - top);
        let point = DVec3::new(FAR + 1.0 - to_edge, top, FAR + draw.between(-0.9, 0.9));
        // A hit from straight above, as if nothing were there.
        let lone = ShapeSet::of_shapes(coin(at).ok().map(Shape::Cuboid));
        let down = Ray::new(point + DVec3::Y, DVec3::NEG_Y);
        let hit = Bvh::build(&lone).ok().and_then(|bvh| bvh.closest(&lone, &down, Interval::FORWARD, &mut NoProbe));
        let Some(surface) = hit.and_then(|hit| lone.surface(&down, &hit, InteractionFlags::ALL)) else {
            checks.check(false, || format!("{down:?} misses"));
            return;
        };
        let factor = draw.pick(&[0.01, 0.5, 0.99, 0.999, 1.001, 1.01, 2.0, 1e3, 1e9]);
        let towards = DVec3::new(1.0, factor * gap / to_edge, 0.0);
        let shadow = surface.spawn_shadow_ray_towards(towards, 0.0);
        let occluded = accelerator.occluded(&set, &shadow, Interval::SPAWNED, &mut NoProbe);
        checks.same(occluded, factor > 1.0, format_args!("coin {at}, rising {factor} gaps on the way out"));
    });
    Ok(())
}
