//! Intersection of eight rays with spheres: the operations of [`SphereKernel::intersect`] in lanes of `f64`, with the same
//! bits.
//!
//! # Why the padded bounds need no test
//!
//! A hit counts if the ray hits the padded bounds, and its `t` is raised to their entry
//! ([`intersect_primitive`](rt_geometry::intersect_primitive)). The slab test is monotone in the box. So let `t` lie
//! between entry into and exit from a smaller box within the padded bounds. Then these are hit as well, and entered at
//! `t` or before. The tight bounds widened by half the padding ([`INNER_PAD`]) are such a box. Where that test fails,
//! the scalar test resolves the ray.

use rt_geometry::SphereKernel;

use super::f64x8::{F64x8, PACKET, dot, max_abs, sub3};
use super::ray_soa::{INNER_PAD, PacketHit, RaySoa8};
use super::simd::Simd;

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

    /// Closest hits within the spans of rays in the safe range.
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
        let (t0, t1) = (c.div(simd, q), q.div(simd, a));
        let (near, far) = (t0.min(simd, t1), t0.max(simd, t1));
        // The sum turns −0 into 0.
        let zero = F64x8::splat(simd, 0.0);
        let t = near.sub(simd, rays.min).add(simd, zero).select_by_sign(simd, near, far);

        let [enter, leave] = self.inner_box(simd, rays);
        let crosses =
            F64x8::splat(simd, f64::MIN_POSITIVE).le(simd, root) & root.le(simd, F64x8::splat(simd, f64::MAX));
        let within = crosses & rays.min.le(simd, t) & t.le(simd, rays.max);
        let touches = root.le(simd, zero);
        let hit = within & enter.le(simd, t) & t.le(simd, leave);
        PacketHit { hit, uncertain: within & !hit | touches, t, uv: [zero; 2] }
    }

    /// Entry into and exit from a box within the padded bounds.
    #[inline(always)]
    fn inner_box(&self, simd: S, rays: &RaySoa8<S>) -> [F64x8<S>; 2] {
        let reach = max_abs(simd, self.centre).add(simd, self.radius);
        let pad = reach.mul(simd, F64x8::splat(simd, INNER_PAD));
        let low = sub3(simd, self.centre, [self.radius; 3]);
        let high = [
            self.centre[0].add(simd, self.radius),
            self.centre[1].add(simd, self.radius),
            self.centre[2].add(simd, self.radius),
        ];
        rays.cross_box(simd, low, high, pad)
    }
}

#[cfg(test)]
mod tests {
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;
    use rt_math::{DVec3, Interval, Ray};

    const SPHERE: SphereKernel = SphereKernel { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.75 };

    type Rays = [(Ray, Interval); PACKET];

    /// By ray: certain miss, uncertain, and bits of `t`.
    type Resolved = [(bool, bool, Option<u64>); PACKET];

    struct Intersect;

    impl WithSimd<&Rays, &mut Resolved> for Intersect {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Rays, resolved: &mut Resolved) {
            let rays = RaySoa8::new(simd, rays);
            assert_eq!(rays.in_safe_range(simd), 0xff);
            let missed = SpherePacket::all(simd, &SPHERE).miss_mask(simd, &rays);
            let PacketHit { hit, uncertain, t, .. } = SpherePacket::new(simd, &[SPHERE; PACKET]).intersect(simd, &rays);
            assert_eq!(missed & (hit | uncertain), 0);
            let t = t.to_array(simd);
            let is_in = |bits: u32, lane: usize| bits >> lane & 1 != 0;
            *resolved = core::array::from_fn(|lane| {
                (is_in(missed, lane), is_in(uncertain, lane), is_in(hit, lane).then_some(t[lane].to_bits()))
            });
        }
    }

    fn resolved(level: SimdLevel, rays: &Rays) -> Resolved {
        let mut resolved = [(false, false, None); PACKET];
        DetectedSimd::new(level).dispatch(Intersect, rays, &mut resolved);
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
                for ((ray, span), (missed, uncertain, hit)) in rays.iter().zip(resolved(*level, rays)) {
                    let expected = SPHERE.intersect(ray, *span);
                    assert_eq!((uncertain, hit), (false, expected.map(f64::to_bits)), "{level:?}, {ray:?} {span:?}");
                    n_hits += usize::from(hit.is_some());
                    n_misses += usize::from(missed);
                }
            }
            assert!(n_hits > 16 && n_misses > 4, "{n_hits} hits, {n_misses} misses");
        }
    }

    #[test]
    fn rays_that_leave_the_surface_are_certain_misses() {
        let leaving = core::array::from_fn(|i| {
            let normal = DVec3::new(0.1 * (i + 1) as f64, 0.5, 1.0).normalize();
            (Ray::new(SPHERE.centre + normal * (SPHERE.radius * (1.0 + 1e-14)), normal), Interval::SPAWNED)
        });
        for level in SimdLevel::ALL {
            assert_eq!(resolved(*level, &leaving), [(true, false, None); PACKET], "{level:?}");
        }
    }

    #[test]
    fn tangents_are_uncertain() {
        let tangent = Ray::new(SPHERE.centre + DVec3::new(SPHERE.radius, 0.0, 5.0), DVec3::NEG_Z);
        let arm = tangent.origin - SPHERE.centre;
        assert_eq!(arm.x * arm.x, SPHERE.radius * SPHERE.radius, "a tangent to the bit");
        for level in SimdLevel::ALL {
            let resolved = resolved(*level, &[(tangent, Interval::FORWARD); PACKET]);
            assert_eq!(resolved, [(false, true, None); PACKET], "{level:?}");
        }
    }
}
