//! Intersection of rays with primitives: the only functions that accept hits.

use crate::{Hit, HitStream, Primitives, Probe, RayStream, ShapeHit, WatertightRay};
use rt_math::DVec3;
use rt_math::{Aabb, Interval, Ray, SlabRay};

/// Padded bounds of a primitive, which the ray of every hit passes. `None` if it is unbounded.
///
/// Accelerators must cull with boxes that contain this one.
pub fn padded_bounds<P: Primitives>(primitives: &P, index: u32) -> Option<Aabb> {
    primitives.bounds(index).map(|bounds| bounds.padded())
}

/// Hit of primitive `index` within `span`.
///
/// The **padded-bounds rule**: a hit counts only if the ray also passes the primitive's [`padded_bounds`]. Its `t` is
/// raised to the entry into that box if rounding put it before. Brute force and all accelerators accept hits through
/// this function alone. As the slab test is monotone in the box, every box around `padded_bounds` is entered at or
/// before the accepted `t`. So an accelerator that prunes only what starts strictly behind the best hit returns the
/// bits of brute force, ties included.
///
/// `t` is not lowered to the exit from that box. So `span.max` is inclusive, and `span.min` up to rounding of `t`. From far away, a `t`
/// behind the rounded exit is no hit of a span that starts there. A hit whose `t` is NaN is a miss.
///
/// The kernel runs first: most tests are misses, and the bounds are tested for hits only.
#[inline(always)]
pub fn intersect_primitive<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    ray: &SlabRay,
    span: Interval,
    probe: &mut S,
) -> Option<Hit> {
    probe.test();
    intersect_primitive_uncounted(primitives, index, &ray.ray, span, probe)
}

/// [`intersect_primitive`] of a primitive that is already counted as tested.
#[inline(always)]
pub fn intersect_primitive_uncounted<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    ray: &Ray,
    span: Interval,
    probe: &mut S,
) -> Option<Hit> {
    let hit = primitives.intersect_with_stats(index, ray, span, probe)?;
    let entry = padded_bounds_entry(primitives, index, ray, span)?;
    if hit.t.is_nan() {
        return None;
    }
    probe.hit();
    Some(Hit { t: max_t(hit.t, entry), ..hit })
}

/// [`intersect_primitive_uncounted`] of a primitive with the geometry
/// [`PrimitiveGeometry::ExactTriangle`](crate::PrimitiveGeometry::ExactTriangle), from a copy of its vertices, with
/// identical results. `watertight_ray` is prepared from the same ray.
#[inline(always)]
pub fn intersect_triangle(
    vertices: [DVec3; 3],
    index: u32,
    ray: &SlabRay,
    watertight_ray: &WatertightRay,
    span: Interval,
) -> Option<Hit> {
    let ShapeHit { t, uv } = watertight_ray.intersect(vertices, span)?;
    let entry = Aabb::from_points(vertices).padded().clip(ray, span)?.min;
    Some(Hit { t: max_t(t, entry), instance: 0, primitive: index, uv })
}

/// Maximum of a hit and the entry into its bounds; the hit if they are equal, as `f64::max` may return either zero.
#[inline(always)]
fn max_t(t: f64, entry: f64) -> f64 {
    if entry > t { entry } else { t }
}

/// True if primitive `index` occludes the ray within `span`: exactly when [`intersect_primitive`] finds a hit, for
/// primitives whose `occludes` agrees with `intersect`.
#[inline(always)]
pub fn occludes_primitive<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    ray: &SlabRay,
    span: Interval,
    probe: &mut S,
) -> bool {
    probe.test();
    occludes_primitive_uncounted(primitives, index, &ray.ray, span, probe)
}

/// [`occludes_primitive`] of a primitive that is already counted as tested.
#[inline(always)]
pub fn occludes_primitive_uncounted<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    ray: &Ray,
    span: Interval,
    probe: &mut S,
) -> bool {
    let occluded = primitives.occludes_with_stats(index, ray, span, probe)
        && padded_bounds_entry(primitives, index, ray, span).is_some();
    if occluded {
        probe.hit();
    }
    occluded
}

/// [`intersect_primitive_uncounted`] for the rays of a stream, with identical results.
pub fn intersect_primitive_stream<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    rays: &RayStream,
    hits: &mut HitStream,
    probe: &mut S,
) {
    primitives.intersect_stream(index, rays, hits, probe);
    for at in 0..rays.len() {
        let Some(hit) = hits.get(at) else { continue };
        let (ray, span) = rays.get(at);
        match padded_bounds_entry(primitives, index, &ray, span) {
            Some(entry) if !hit.t.is_nan() => {
                probe.hit();
                hits.t.set(at, max_t(hit.t, entry));
            }
            _ => hits.set(at, None),
        }
    }
}

/// [`occludes_primitive_uncounted`] for the rays of a stream, with identical results.
pub fn occludes_primitive_stream<P: Primitives, S: Probe>(
    primitives: &P,
    index: u32,
    rays: &RayStream,
    occluded: &mut [bool],
    probe: &mut S,
) {
    primitives.occludes_stream(index, rays, occluded, probe);
    for (at, occluded) in occluded.iter_mut().enumerate().take(rays.len()) {
        let (ray, span) = rays.get(at);
        *occluded = *occluded && padded_bounds_entry(primitives, index, &ray, span).is_some();
        if *occluded {
            probe.hit();
        }
    }
}

/// Parameter at which the ray enters the padded bounds within `span`: its beginning without bounds, `None` on a miss.
///
/// Not inlined into loops over tests, most of which miss. Computes the reciprocals again: a prepared ray would be
/// copied for every test, and few are hits.
#[inline(never)]
fn padded_bounds_entry<P: Primitives>(primitives: &P, index: u32, ray: &Ray, span: Interval) -> Option<f64> {
    match padded_bounds(primitives, index) {
        Some(own) => Some(own.clip(&SlabRay::new(ray), span)?.min),
        None => Some(span.min),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Counters, NoProbe};

    /// Kernel that reports a hit at a fixed `t` for any ray.
    struct Fixed(f64, Option<Aabb>);

    impl Primitives for Fixed {
        fn len(&self) -> usize {
            1
        }
        fn bounds(&self, _: u32) -> Option<Aabb> {
            self.1
        }
        fn intersect(&self, _: u32, _: &Ray, span: Interval) -> Option<Hit> {
            span.contains(self.0).then_some(Hit { t: self.0, instance: 0, primitive: 0, uv: [0.0; 2] })
        }
    }

    const BOX: Option<Aabb> = Some(Aabb::new(DVec3::ONE, DVec3::splat(2.0)));

    fn ask(fixed: &Fixed, direction: DVec3, span: Interval) -> Option<f64> {
        let ray = SlabRay::new(&Ray::new(DVec3::ZERO, direction));
        let hit = intersect_primitive(fixed, 0, &ray, span, &mut NoProbe).map(|hit| hit.t);
        assert_eq!(hit.is_some(), occludes_primitive(fixed, 0, &ray, span, &mut NoProbe));
        hit
    }

    #[test]
    fn a_hit_outside_its_padded_bounds_does_not_count() {
        assert_eq!(ask(&Fixed(1.5, BOX), DVec3::X, Interval::FORWARD), None);
        assert_eq!(ask(&Fixed(1.5, BOX), DVec3::ONE, Interval::FORWARD), Some(1.5));
    }

    #[test]
    fn t_is_raised_to_the_entry_into_the_padded_bounds() {
        let t = ask(&Fixed(0.5, BOX), DVec3::ONE, Interval::FORWARD).expect("a hit");
        assert!((t - 1.0).abs() < 1e-11 && t > 0.5, "{t}");
        assert_eq!(ask(&Fixed(0.5, BOX), DVec3::ONE, Interval::new(0.0, 0.9)), None, "raised out of the span");
    }

    /// Kernel of a user that divides by zero.
    struct NotANumber(Option<Aabb>);

    impl Primitives for NotANumber {
        fn len(&self) -> usize {
            1
        }
        fn bounds(&self, _: u32) -> Option<Aabb> {
            self.0
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            Some(Hit { t: f64::NAN, instance: 0, primitive: 0, uv: [0.0; 2] })
        }
    }

    #[test]
    fn a_hit_without_a_number_is_a_miss() {
        for bounds in [BOX, None] {
            let (kernel, ray) = (NotANumber(bounds), Ray::new(DVec3::ZERO, DVec3::ONE));
            let (slab_ray, span) = (SlabRay::new(&ray), Interval::FORWARD);
            assert_eq!(intersect_primitive(&kernel, 0, &slab_ray, span, &mut NoProbe), None);
            assert!(!occludes_primitive(&kernel, 0, &slab_ray, span, &mut NoProbe));
            let (mut rays, mut hits) = (RayStream::default(), HitStream::default());
            rays.push(&ray, span);
            intersect_primitive_stream(&kernel, 0, &rays, &mut hits, &mut NoProbe);
            assert_eq!(hits.get(0), None);
        }
    }

    #[test]
    fn unbounded_primitives_have_no_box_to_pass() {
        assert_eq!(ask(&Fixed(7.0, None), DVec3::X, Interval::FORWARD), Some(7.0));
    }

    #[test]
    fn offers_and_hits_are_counted() {
        let ray = SlabRay::new(&Ray::new(DVec3::ZERO, DVec3::ONE));
        let mut counters = Counters::default();
        intersect_primitive(&Fixed(1.5, BOX), 0, &ray, Interval::FORWARD, &mut counters);
        intersect_primitive(&Fixed(1.5, BOX), 0, &ray, Interval::new(0.0, 1.0), &mut counters);
        assert_eq!((counters.total().tests, counters.total().hits), (2, 1));
    }
}
