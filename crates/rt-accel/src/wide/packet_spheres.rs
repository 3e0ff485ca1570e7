//! Intersection of eight rays with spheres: the operations of [`SphereKernel::intersect`] in lanes of `f64`, with the same
//! bits.
//!
//! # Why the padded bounds need no test
//!
//! A hit counts if the ray hits the padded bounds, and its `t` is raised to their entry
//! ([`intersect_primitive`](rt_geometry::intersect_primitive)). Both are without effect on rays that start [near](SpherePacket::is_near).
//! With R the largest coordinate of the bounds, such an origin is at most 33√3 R < 58 R from the centre. The computed hit is off the sphere
//! by less than 20 roundings of this distance, which are less than 2⁻⁴² R. The slab test rounds by less than 2⁻⁴² R, too. The padding is
//! 2⁻⁴⁰ R.
//!
//! For other rays: the slab test is monotone in the box. So let `t` lie between entry into and exit from a smaller box
//! within the padded bounds. Then these are hit as well, and entered at `t` or before. The tight bounds widened by half
//! the padding ([`INNER_PAD`]) are such a box. Where that test fails, the scalar test resolves the ray.

use rt_geometry::SphereKernel;

use super::f64x8::{F64x8, PACKET, dot, max_abs, sub3};
use super::ray_soa::{INNER_PAD, PacketHit, RaySoa8};
use super::simd::Simd;

/// Bound on the rounding of squared distances from the centre, relative to the sum of those of the origin and of the surface. It is
/// more than twice the roundings of these tests and of the scalar one together.
const SLACK: f64 = 64.0 * f64::EPSILON;

/// Largest coordinate of [near](SpherePacket::is_near) origins, relative to that of the bounds.
const NEAR: f64 = 32.0;

/// A sphere for each of eight rays.
pub(super) struct SpherePacket<S: Simd> {
    centre: [F64x8<S>; 3],
    radius: F64x8<S>,
}

impl<S: Simd> SpherePacket<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, spheres: &[SphereKernel; PACKET]) -> Self {
        // Not by loops over arrays, which would be cleared first.
        macro_rules! by_sphere {
            (|$sphere:pat_param| $number:expr) => {{
                let [a, b, c, d, e, f, g, h] = spheres;
                let number = |$sphere: &SphereKernel| $number;
                F64x8::new(
                    simd,
                    [number(a), number(b), number(c), number(d), number(e), number(f), number(g), number(h)],
                )
            }};
        }
        Self {
            centre: [
                by_sphere!(|sphere| sphere.centre.x),
                by_sphere!(|sphere| sphere.centre.y),
                by_sphere!(|sphere| sphere.centre.z),
            ],
            radius: by_sphere!(|sphere| sphere.radius),
        }
    }

    /// One sphere for all rays.
    #[inline(always)]
    pub(super) fn all(simd: S, sphere: &SphereKernel) -> Self {
        Self { centre: F64x8::splat3(simd, sphere.centre), radius: F64x8::splat(simd, sphere.radius) }
    }

    #[inline(always)]
    fn offsets(&self, simd: S, rays: &RaySoa8<S>) -> [F64x8<S>; 3] {
        sub3(simd, rays.origin, self.centre)
    }

    /// Rays in the [safe range](RaySoa8::in_safe_range) that certainly miss.
    #[inline(always)]
    pub(super) fn miss_mask(&self, simd: S, rays: &RaySoa8<S>) -> u32 {
        let f = self.offsets(simd, rays);
        let d = rays.direction;
        let a = dot(simd, d, d);
        let along = dot(simd, f, d);
        let [for_distance, for_radius] = SphereKernel::REJECTION_BOUNDS;
        let excess = dot(simd, f, f)
            .mul(simd, F64x8::splat(simd, for_distance))
            .sub(simd, self.radius.mul(simd, self.radius).mul(simd, F64x8::splat(simd, for_radius)));
        let passes_by = along.mul(simd, along).lt(simd, a.mul(simd, excess));
        let min_subnormal = F64x8::splat(simd, f64::from_bits(1));
        let lies_behind = min_subnormal.le(simd, excess) & min_subnormal.le(simd, along);
        passes_by | lies_behind
    }

    /// Closest hits within the spans of rays in the safe range. Needs no inverse.
    #[inline(always)]
    pub(super) fn intersect(&self, simd: S, rays: &RaySoa8<S>) -> PacketHit<S> {
        let f = self.offsets(simd, rays);
        let d = rays.direction;
        let r = self.radius;
        let a = dot(simd, d, d);
        // A product, as 0 − 0 has another sign.
        let b = dot(simd, f, d).mul(simd, F64x8::splat(simd, -1.0));
        let ratio = b.div(simd, a);
        let closest = [
            f[0].add(simd, d[0].mul(simd, ratio)),
            f[1].add(simd, d[1].mul(simd, ratio)),
            f[2].add(simd, d[2].mul(simd, ratio)),
        ];
        let discriminant = a.mul(simd, r.mul(simd, r).sub(simd, dot(simd, closest, closest)));
        let root = discriminant.sqrt(simd);
        let q = b.add(simd, root.copysign(simd, b));
        let length = dot(simd, f, f).sqrt(simd);
        let c = length.sub(simd, r).mul(simd, length.add(simd, r));
        let zero = F64x8::splat(simd, 0.0);
        let crosses =
            F64x8::splat(simd, f64::MIN_POSITIVE).le(simd, root) & root.le(simd, F64x8::splat(simd, f64::MAX));
        let touches = root.le(simd, zero);
        let (t0, t1) = (c.div(simd, q), q.div(simd, a));
        let (near, far) = (t0.min(simd, t1), t0.max(simd, t1));
        // The sum turns −0 into 0.
        let t = near.sub(simd, rays.min).add(simd, zero).select_by_sign(simd, near, far);
        let within = crosses & rays.min.le(simd, t) & t.le(simd, rays.max);
        let mut hit = within & self.is_near(simd, rays);
        if hit != within {
            let [enter, leave] = self.inner_box(simd, rays);
            hit |= within & enter.le(simd, t) & t.le(simd, leave);
        }
        PacketHit { hit, uncertain: within & !hit | touches, t, uv: [zero; 2] }
    }

    /// Rays in the safe range that certainly hit within their spans, and those that may. Both ends of the span and the closest approach
    /// decide, without roots and quotients.
    #[inline(always)]
    pub(super) fn occlusion(&self, simd: S, rays: &RaySoa8<S>) -> [u32; 2] {
        let f = self.offsets(simd, rays);
        let d = rays.direction;
        let a = dot(simd, d, d);
        let b = dot(simd, f, d).mul(simd, F64x8::splat(simd, -1.0));
        let ff = dot(simd, f, f);
        let rr = self.radius.mul(simd, self.radius);
        let slack = ff.add(simd, rr).mul(simd, F64x8::splat(simd, SLACK));
        let (inner, outer) = (rr.sub(simd, slack), rr.add(simd, slack));
        let start = squared_distance(simd, f, d, rays.min);
        let end = squared_distance(simd, f, d, rays.max);
        let (starts_inside, starts_outside) = (start.lt(simd, inner), outer.lt(simd, start));
        // The end may be at infinity, and its distance NaN.
        let (ends_inside, ends_outside) = (end.lt(simd, inner), 0xff & !end.le(simd, outer));
        let is_outside = starts_outside & ends_outside;

        let has_approach = rays.min.mul(simd, a).lt(simd, b) & b.lt(simd, rays.max.mul(simd, a));
        let bb = b.mul(simd, b);
        let enters = a.mul(simd, ff.sub(simd, inner)).lt(simd, bb);
        let passes_by = bb.lt(simd, a.mul(simd, ff.sub(simd, outer)));

        let leaves = starts_inside & ends_outside | starts_outside & ends_inside;
        let is_span = rays.min.le(simd, rays.max);
        let hit = (leaves | is_outside & has_approach & enters) & is_span & self.is_near(simd, rays);
        let miss = starts_inside & ends_inside | is_outside & (!has_approach | passes_by);
        [hit, 0xff & !(hit | miss)]
    }

    /// Rays whose hits are within the padded bounds without a test.
    #[inline(always)]
    fn is_near(&self, simd: S, rays: &RaySoa8<S>) -> u32 {
        max_abs(simd, rays.origin).le(simd, self.reach(simd).mul(simd, F64x8::splat(simd, NEAR)))
    }

    /// Largest coordinate of the bounds.
    #[inline(always)]
    fn reach(&self, simd: S) -> F64x8<S> {
        max_abs(simd, self.centre).add(simd, self.radius)
    }

    /// Entry into and exit from a box within the padded bounds.
    #[inline(always)]
    fn inner_box(&self, simd: S, rays: &RaySoa8<S>) -> [F64x8<S>; 2] {
        let pad = self.reach(simd).mul(simd, F64x8::splat(simd, INNER_PAD));
        let low = sub3(simd, self.centre, [self.radius; 3]);
        let high = [
            self.centre[0].add(simd, self.radius),
            self.centre[1].add(simd, self.radius),
            self.centre[2].add(simd, self.radius),
        ];
        rays.with_inverse(simd).cross_box(simd, low, high, pad)
    }
}

/// Squared distance from the centre of points on rays.
#[inline(always)]
fn squared_distance<S: Simd>(simd: S, f: [F64x8<S>; 3], d: [F64x8<S>; 3], t: F64x8<S>) -> F64x8<S> {
    let p = [f[0].add(simd, d[0].mul(simd, t)), f[1].add(simd, d[1].mul(simd, t)), f[2].add(simd, d[2].mul(simd, t))];
    dot(simd, p, p)
}

#[cfg(test)]
mod tests {
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;
    use rt_geometry::{NoProbe, Sphere, Spheres, intersect_primitive};
    use rt_math::random::{hash, unit};
    use rt_math::transcendental::pow;
    use rt_math::{DVec3, Interval, Ray, SlabRay};

    const SPHERE: SphereKernel = SphereKernel { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.75 };

    type Rays = [(Ray, Interval); PACKET];

    /// Results by ray.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    struct Resolved {
        misses: bool,
        uncertain: bool,
        /// Bits of `t` of a certain hit.
        hit: Option<u64>,
        /// None if it is uncertain.
        occluded: Option<bool>,
    }

    struct Intersect<'s>(&'s SphereKernel);

    impl WithSimd<&Rays, &mut [Resolved; PACKET]> for Intersect<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Rays, resolved: &mut [Resolved; PACKET]) {
            let rays = RaySoa8::new(simd, rays);
            assert_eq!(rays.in_safe_range(simd), 0xff);
            let spheres = SpherePacket::all(simd, self.0);
            let missed = spheres.miss_mask(simd, &rays);
            let PacketHit { hit, uncertain, t, .. } =
                SpherePacket::new(simd, &[*self.0; PACKET]).intersect(simd, &rays);
            let [occluded, open] = spheres.occlusion(simd, &rays);
            assert_eq!((missed & (hit | uncertain | occluded), occluded & open), (0, 0));
            let t = t.to_array(simd);
            let is_in = |bits: u32, lane: usize| bits >> lane & 1 != 0;
            *resolved = core::array::from_fn(|lane| Resolved {
                misses: is_in(missed, lane),
                uncertain: is_in(uncertain, lane),
                hit: is_in(hit, lane).then_some(t[lane].to_bits()),
                occluded: (!is_in(open, lane)).then_some(is_in(occluded, lane)),
            });
        }
    }

    fn resolved(level: SimdLevel, sphere: &SphereKernel, rays: &Rays) -> [Resolved; PACKET] {
        let mut resolved = [Resolved::default(); PACKET];
        DetectedSimd::new(level).dispatch(Intersect(sphere), rays, &mut resolved);
        resolved
    }

    /// Query results would also be right if all rays were uncertain.
    #[test]
    fn certain_results_equal_the_kernel() {
        // From the axis through the centre to beyond the rim, from inside, behind the first hit, and before it.
        let passing = |i: usize| {
            let origin = SPHERE.centre + DVec3::new(0.01 + 0.13 * i as f64, 0.0, 5.0);
            Ray::new(origin, DVec3::new(1e-3, 1e-3, -1.0))
        };
        let within =
            |i: usize| Ray::new(SPHERE.centre + DVec3::new(0.08 * i as f64, 0.1, 0.2), DVec3::new(0.3, -0.5, 0.7));
        let cases: [Rays; 4] = [
            core::array::from_fn(|i| (passing(i), Interval::FORWARD)),
            core::array::from_fn(|i| (within(i), Interval::SPAWNED)),
            core::array::from_fn(|i| (passing(i), Interval::new(5.0, 6.0))),
            core::array::from_fn(|i| (passing(i), Interval::new(0.0, 4.5))),
        ];
        for level in SimdLevel::ALL {
            let (mut n_hits, mut n_misses) = (0, 0);
            for rays in &cases {
                for ((ray, span), resolved) in rays.iter().zip(resolved(*level, &SPHERE, rays)) {
                    let expected = SPHERE.intersect(ray, *span);
                    let Resolved { misses, uncertain, hit, occluded } = resolved;
                    assert_eq!((uncertain, hit), (false, expected.map(f64::to_bits)), "{level:?}, {ray:?} {span:?}");
                    assert_eq!(occluded, Some(expected.is_some()), "{level:?}, {ray:?} {span:?}");
                    n_hits += usize::from(hit.is_some());
                    n_misses += usize::from(misses);
                }
            }
            assert!(n_hits > 16 && n_misses > 4, "{n_hits} hits, {n_misses} misses");
        }
    }

    /// Rays that start anywhere or on the surface, and that may pass the rim. Spans, too, begin and end anywhere or on the surface.
    fn random_rays(sphere: &SphereKernel, seed: u64) -> Rays {
        core::array::from_fn(|lane| {
            let number = |part: u64| unit(hash(&[seed, lane as u64, part]));
            let vector = |part| (DVec3::new(number(part), number(part + 1), number(part + 2)) - 0.5).normalize();
            let distance = match lane % 4 {
                0 => 2.0 * number(0),
                1 => 1.0 + 1e-12 * (number(0) - 0.5),
                2 => pow(10.0, 2.0 * number(0)),
                _ => pow(10.0, 8.0 * number(0)),
            };
            let origin = sphere.centre + vector(1) * (sphere.radius * distance);
            // From far away, the rounding of a hit is seen where the bounds touch the sphere.
            let towards = if lane == 7 { DVec3::AXES[seed as usize % 3] } else { vector(4) };
            let aim = towards * (sphere.radius * [number(7), 1.0][lane / 4]);
            let direction = (sphere.centre + aim - origin) * pow(10.0, 20.0 * number(8) - 10.0);
            let ray = Ray::new(origin, direction);
            let crossing = sphere.intersect(&ray, Interval::FORWARD).unwrap_or(1.0);
            let span = match hash(&[seed, lane as u64]) % 6 {
                0 => Interval::SPAWNED,
                1 => Interval::new(0.0, crossing),
                2 => Interval::new(crossing, 2.0 * crossing),
                3 => Interval::new(0.0, crossing * (0.5 + number(9))),
                4 => Interval::new(1.5 * crossing, crossing * number(9)),
                _ => Interval::new(crossing * 2.0 * number(9), f64::INFINITY),
            };
            (ray, span)
        })
    }

    #[test]
    fn certain_results_are_those_within_padded_bounds() {
        let (mut n_hits, mut n_misses, mut n_uncertain, mut n_open) = (0, 0, 0, 0);
        for seed in 0..10_000 {
            let number = |part: u64| unit(hash(&[seed, part]));
            let size = pow(10.0, 12.0 * number(0) - 6.0);
            let centre = DVec3::new(number(1), number(2), number(3)) * (size * pow(10.0, 4.0 * number(4) - 2.0));
            let sphere = SphereKernel { centre, radius: size * (0.1 + number(5)) };
            let primitive = Spheres::new(vec![Sphere::new(centre, sphere.radius).expect("a sphere")]);
            let rays = random_rays(&sphere, seed);
            for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
                for ((ray, span), resolved) in rays.iter().zip(resolved(level, &sphere, &rays)) {
                    let hit = intersect_primitive(&primitive, 0, &SlabRay::new(ray), *span, &mut NoProbe);
                    let expected = hit.map(|hit| hit.t.to_bits());
                    let Resolved { misses, uncertain, hit, occluded } = resolved;
                    let is_right = !(misses && expected.is_some())
                        && (uncertain || hit == expected)
                        && occluded.is_none_or(|occluded| occluded == expected.is_some());
                    assert!(
                        is_right,
                        "{level:?}, seed {seed}, {sphere:?} {ray:?} {span:?}: {resolved:?}, {expected:?}"
                    );
                    n_hits += usize::from(occluded == Some(true));
                    n_misses += usize::from(occluded == Some(false));
                    n_open += usize::from(occluded.is_none());
                    n_uncertain += usize::from(uncertain);
                }
            }
        }
        let n = n_hits + n_misses + n_open;
        assert!(
            5 * n_hits > n && 5 * n_misses > n && 5 * n_open < 3 * n && 100 * n_uncertain < n,
            "{n_hits} certain hits, {n_misses} misses, {n_open} open; {n_uncertain} uncertain closest hits"
        );
    }

    #[test]
    fn rays_that_leave_the_surface_are_certain_misses() {
        let leaving = core::array::from_fn(|i| {
            let normal = DVec3::new(0.1 * (i + 1) as f64, 0.5, 1.0).normalize();
            (Ray::new(SPHERE.centre + normal * (SPHERE.radius * (1.0 + 1e-14)), normal), Interval::SPAWNED)
        });
        for level in SimdLevel::ALL {
            let resolved = resolved(*level, &SPHERE, &leaving);
            assert!(
                resolved.iter().all(|ray| ray.misses && !ray.uncertain && ray.hit.is_none()),
                "{level:?}: {resolved:?}"
            );
        }
    }

    #[test]
    fn tangents_are_uncertain() {
        let tangent = Ray::new(SPHERE.centre + DVec3::new(SPHERE.radius, 0.0, 5.0), DVec3::NEG_Z);
        let arm = tangent.origin - SPHERE.centre;
        assert_eq!(arm.x * arm.x, SPHERE.radius * SPHERE.radius, "a tangent to the bit");
        for level in SimdLevel::ALL {
            let uncertain = Resolved { misses: false, uncertain: true, hit: None, occluded: None };
            assert_eq!(resolved(*level, &SPHERE, &[(tangent, Interval::FORWARD); PACKET]), [uncertain; PACKET]);
        }
    }
}
