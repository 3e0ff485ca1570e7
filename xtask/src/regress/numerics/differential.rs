//! Differential tests: all accelerators are bit-identical to brute force, on every shape.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{Hit, NoProbe, Primitives};
use rt_math::{Aabb, DVec3, Interval, Ray, Transform};
use rt_tests::{Draw, Seams, ShapeKind, ShapeSet, span_at};

use super::{
    Case, Checks, Conditions, Fallible, cases,
    scenes::{all_accelerators, key},
};

cases! {
    "differential", "all accelerators × all shapes, random and adversarial rays",
        "closest, any and all hits of brute force", "bits", every_shape;
    "S46", "mixed shapes at offsets 0…1e7 and scale 1e-4, adversarial rays",
        "the hits of brute force", "bits", far_and_small;
}

/// Rays per rare ray.
const ALL_HITS_EVERY: u64 = 32;

/// Shapes that can reach out of the unit cube by what they are scaled to.
const AROUND: Aabb = Aabb::new(DVec3::splat(-1.4), DVec3::splat(1.4));

fn every_shape(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let random = conditions.count(2_000, 1_000_000);
    let adversarial = conditions.count(2_000, 100_000);
    for (index, kind) in ShapeKind::ALL.iter().enumerate() {
        let mut draw = Draw::of(33, index as u64);
        let set = ShapeSet::scattered(std::slice::from_ref(kind), 40, &Transform::IDENTITY, &mut draw);
        let seams = Seams::of(&set, AROUND, &mut draw).including(set.corners());
        let trial = RayTrial { set: &set, accelerators: all_accelerators(&set)?, seed: index as u64 };
        checks.of_all(random, |ray, checks| {
            let mut draw = Draw::of(trial.seed + 100, ray);
            trial.compare(ray, &seams.random(&mut draw), kind.name, &mut draw, checks);
        });
        checks.of_all(adversarial, |ray, checks| {
            let mut draw = Draw::of(trial.seed + 200, ray);
            trial.compare(ray, &seams.adversarial(&mut draw), kind.name, &mut draw, checks);
        });
    }
    let kinds = rt_accel::AcceleratorKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
    let shapes = ShapeKind::ALL.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", ");
    checks.note(format!(
        "{random} random and {adversarial} adversarial rays for each of: {kinds}; with each of: {shapes}"
    ));
    Ok(())
}

fn far_and_small(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let rays = conditions.count(4_000, 200_000);
    let direction = DVec3::new(1.0, -0.7, 0.3);
    let small = Transform::scale(DVec3::splat(1e-4))?;
    let moved = |distance: f64| Transform::translate(direction * distance);
    let places = [moved(0.0), moved(1e3), moved(1e5), moved(1e7), small, moved(1e3).compose(&small)];
    for (index, place) in places.iter().enumerate() {
        let mut draw = Draw::of(46, index as u64);
        let set = ShapeSet::scattered(ShapeKind::ALL, 130, place, &mut draw);
        let seams = Seams::of(&set, place.aabb(&AROUND), &mut draw).including(set.corners());
        let trial = RayTrial { set: &set, accelerators: all_accelerators(&set)?, seed: index as u64 };
        checks.of_all(rays, |ray, checks| {
            let mut draw = Draw::of(trial.seed + 300, ray);
            trial.compare(ray, &seams.adversarial(&mut draw), "mixed", &mut draw, checks);
        });
    }
    Ok(())
}

/// Accelerators over one set of shapes.
struct RayTrial<'s> {
    set: &'s ShapeSet,
    /// Brute force first.
    accelerators: Vec<AnyAccelerator>,
    seed: u64,
}

impl RayTrial<'_> {
    fn compare(&self, index: u64, ray: &Ray, what: &str, draw: &mut Draw, checks: &mut Checks) {
        let Some((linear, others)) = self.accelerators.split_first() else { return };
        let ahead = linear.closest(self.set, ray, Interval::FORWARD, &mut NoProbe);
        let span = span_at(|| ahead.map_or(1.0, |hit| hit.t), draw);
        let expected = linear.closest(self.set, ray, span, &mut NoProbe);
        let looks_for_all = index.is_multiple_of(ALL_HITS_EVERY);
        let all_expected = looks_for_all.then(|| all_hits(linear, self.set, ray, span));
        for accelerator in others {
            let found = accelerator.closest(self.set, ray, span, &mut NoProbe);
            let name = accelerator.kind().name();
            checks.check(key(found) == key(expected), || {
                format!("{name}, {what}: {found:?} instead of {expected:?} for {ray:?} {span:?}")
            });
            let occluded = accelerator.occluded(self.set, ray, span, &mut NoProbe);
            checks.check(occluded == expected.is_some(), || {
                format!("{name}, {what}: occluded {occluded} beside {expected:?} for {ray:?} {span:?}")
            });
            if let Some(expected) = &all_expected {
                let found = all_hits(accelerator, self.set, ray, span);
                checks.check(found == *expected, || format!("{name}, {what}: other hits along {ray:?} {span:?}"));
            }
        }
    }
}

/// Bits of all hits, in order.
fn all_hits<P: Primitives>(
    accelerator: &AnyAccelerator,
    primitives: &P,
    ray: &Ray,
    span: Interval,
) -> Vec<Option<[u64; 5]>> {
    let mut hits: Vec<Hit> = Vec::new();
    accelerator.all_hits(primitives, ray, span, &mut hits, &mut NoProbe);
    hits.into_iter().map(|hit| key(Some(hit))).collect()
}
