//! Spheres decided about for eight rays at a time: the operations of [`RoundSphere::intersect`] in lanes of `f64`, and so
//! its bits.
//!
//! # Why the own box need not be looked at
//!
//! A hit counts if the ray passes the own box, and its `t` is raised to where that is entered
//! ([`decide`](rt_math::decide)). The slab test is monotone in the box. So where `t` lies between the times at which a
//! smaller box within the own one is entered and left, the own box is passed as well, and is entered at `t` or before. The
//! sphere's box widened by half of what own boxes are widened by is such a box; where the test fails, somebody else
//! decides.

use rt_math::{DVec3, OWN_BOX_PAD, RoundSphere};

use super::across::{Across, Eight, PACKET};
use super::simd::Simd;

/// A sphere for each of eight rays.
pub(super) struct RoundSpheres<S: Simd> {
    centre: [Eight<S>; 3],
    radius: Eight<S>,
}

impl<S: Simd> RoundSpheres<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, spheres: &[RoundSphere; PACKET]) -> Self {
        // One by one, as arrays that are cleared first take longer.
        macro_rules! by_sphere {
            (|$sphere:pat_param| $number:expr) => {{
                let [a, b, c, d, e, f, g, h] = spheres;
                let number = |$sphere: &RoundSphere| $number;
                Eight::new(
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

    /// The same sphere for all rays.
    #[inline(always)]
    pub(super) fn all(simd: S, sphere: &RoundSphere) -> Self {
        let DVec3 { x, y, z } = sphere.centre;
        Self {
            centre: [Eight::splat(simd, x), Eight::splat(simd, y), Eight::splat(simd, z)],
            radius: Eight::splat(simd, sphere.radius),
        }
    }

    /// From the centres to the origins.
    #[inline(always)]
    fn arms(&self, simd: S, rays: &Across<S>) -> [Eight<S>; 3] {
        let [x, y, z] = rays.origin;
        [x.sub(simd, self.centre[0]), y.sub(simd, self.centre[1]), z.sub(simd, self.centre[2])]
    }

    /// A bit for each ray that misses beyond doubt. Rays are proven, so that they begin at 0 or later and that their
    /// directions are of ordinary length.
    #[inline(always)]
    pub(super) fn missed(&self, simd: S, rays: &Across<S>) -> u32 {
        let f = self.arms(simd, rays);
        let d = rays.direction;
        let a = dot(simd, d, d);
        let along = dot(simd, f, d);
        let [for_distance, for_radius] = RoundSphere::REJECTION;
        let excess = dot(simd, f, f)
            .mul(simd, Eight::splat(simd, for_distance))
            .sub(simd, self.radius.mul(simd, self.radius).mul(simd, Eight::splat(simd, for_radius)));
        let passes_by = along.mul(simd, along).sub(simd, a.mul(simd, excess)).signs(simd);
        let nothing = Eight::splat(simd, 0.0);
        let lies_behind = nothing.sub(simd, excess).signs(simd) & nothing.sub(simd, along).signs(simd);
        passes_by | lies_behind
    }

    /// Where rays meet the spheres first, where that is beyond doubt: NaN elsewhere. Whether it is within their spans is for
    /// the caller to see.
    #[inline(always)]
    pub(super) fn first_crossings(&self, simd: S, rays: &Across<S>) -> [f64; PACKET] {
        let f = self.arms(simd, rays);
        let d = rays.direction;
        let r = self.radius;
        let a = dot(simd, d, d);
        // Not subtracted from 0, which has another sign.
        let b = dot(simd, f, d).mul(simd, Eight::splat(simd, -1.0));
        let ratio = b.div(simd, a);
        let closest = [
            f[0].add(simd, d[0].mul(simd, ratio)),
            f[1].add(simd, d[1].mul(simd, ratio)),
            f[2].add(simd, d[2].mul(simd, ratio)),
        ];
        let discriminant = a.mul(simd, r.mul(simd, r).sub(simd, dot(simd, closest, closest)));
        let root = discriminant.sqrt(simd);
        let q = b.add(simd, root.with_sign_of(simd, b));
        let length = dot(simd, f, f).sqrt(simd);
        let c = length.sub(simd, r).mul(simd, length.add(simd, r));
        let near = c.div(simd, q).min(simd, q.div(simd, a));

        let [enter, leave] = self.inner_box(simd, rays);
        let near = near.to_array(simd);
        let (enter, leave) = (enter.to_array(simd), leave.to_array(simd));
        let root = root.to_array(simd);
        core::array::from_fn(|lane| {
            let t = near[lane];
            // None of these is true of a NaN.
            let is_certain = (root[lane] > 0.0) & (enter[lane] <= t) & (t <= leave[lane]);
            if is_certain { t } else { f64::NAN }
        })
    }

    /// Where boxes within the own boxes are entered and left.
    #[inline(always)]
    fn inner_box(&self, simd: S, rays: &Across<S>) -> [Eight<S>; 2] {
        let reach = [self.centre[0].abs(simd), self.centre[1].abs(simd), self.centre[2].abs(simd)];
        let reach = reach[0].max(simd, reach[1]).max(simd, reach[2]).add(simd, self.radius);
        let pad = reach.mul(simd, Eight::splat(simd, 0.5 * OWN_BOX_PAD));
        let (mut enter, mut leave) = (Eight::splat(simd, f64::NEG_INFINITY), Eight::splat(simd, f64::INFINITY));
        for axis in 0..3 {
            let low = self.centre[axis].sub(simd, self.radius).sub(simd, pad);
            let high = self.centre[axis].add(simd, self.radius).add(simd, pad);
            let one = low.sub(simd, rays.origin[axis]).mul(simd, rays.inverse[axis]);
            let other = high.sub(simd, rays.origin[axis]).mul(simd, rays.inverse[axis]);
            enter = enter.max(simd, one.min(simd, other));
            leave = leave.min(simd, one.max(simd, other));
        }
        [enter, leave]
    }
}

/// As `DVec3::dot` adds up.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: [Eight<S>; 3], b: [Eight<S>; 3]) -> Eight<S> {
    a[0].mul(simd, b[0]).add(simd, a[1].mul(simd, b[1])).add(simd, a[2].mul(simd, b[2]))
}

#[cfg(test)]
mod tests {
    use super::super::simd::{Available, Kernel, SimdLevel};
    use super::*;
    use crate::WideBvh;
    use rt_math::{Aabb, Hit, Interval, LeafLayout, Primitives, Ray};

    /// One sphere.
    struct Ball(RoundSphere);

    impl Primitives for Ball {
        fn len(&self) -> usize {
            1
        }
        fn bounds(&self, _: u32) -> Option<Aabb> {
            Some(Aabb::new(self.0.centre - self.0.radius, self.0.centre + self.0.radius))
        }
        fn intersect(&self, _: u32, ray: &Ray, span: Interval) -> Option<Hit> {
            let t = self.0.intersect(ray, span)?;
            Some(Hit { t, instance: 0, primitive: 0, uv: [0.0; 2] })
        }
        fn leaf_layout(&self, _: u32) -> LeafLayout {
            LeafLayout::Round(self.0)
        }
    }

    struct Asked<'a>(&'a WideBvh, RoundSphere);

    impl Kernel<&[(Ray, Interval); PACKET], &mut Option<(u32, [f64; PACKET])>> for Asked<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval); PACKET], answer: &mut Option<(u32, [f64; PACKET])>) {
            *answer = Across::new(simd, self.0, rays).map(|rays| {
                let missed = RoundSpheres::all(simd, &self.1).missed(simd, &rays);
                (missed, RoundSpheres::new(simd, &[self.1; PACKET]).first_crossings(simd, &rays))
            });
        }
    }

    /// If lanes left all to others, the answers of trees would still be right.
    #[test]
    fn lanes_settle_what_is_beyond_doubt_as_the_kernel_does() {
        let ball = RoundSphere { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.75 };
        let tree = WideBvh::build(&Ball(ball)).expect("a tree");
        // From the axis through the centre to beyond the rim, and from the surface.
        let outside = core::array::from_fn(|i| {
            let origin = ball.centre + DVec3::new(0.01 + 0.13 * i as f64, 0.0, 5.0);
            (Ray::new(origin, DVec3::new(1e-3, 1e-3, -1.0)), Interval::FORWARD)
        });
        let leaving = core::array::from_fn(|i| {
            let normal = DVec3::new(0.1 * (i + 1) as f64, 0.5, 1.0).normalize();
            (Ray::new(ball.centre + normal * (ball.radius * (1.0 + 1e-14)), normal), Interval::SPAWNED)
        });
        for level in SimdLevel::ALL {
            let settled = |rays: &[(Ray, Interval); PACKET]| {
                let mut answer = None;
                Available::new(*level).dispatch(Asked(&tree, ball), rays, &mut answer);
                answer.expect("rays in proportion")
            };
            let (missed, crossings) = settled(&outside);
            for (lane, (ray, span)) in outside.iter().enumerate() {
                let expected = ball.intersect(ray, *span);
                assert_eq!(missed >> lane & 1 == 1, expected.is_none(), "{level:?}, lane {lane}");
                let t = Some(crossings[lane]).filter(|t| !t.is_nan());
                assert_eq!(t.map(f64::to_bits), expected.map(f64::to_bits), "{level:?}, lane {lane}");
            }
            assert_eq!((missed & 1, missed >> 7), (0, 1), "some hit and some miss");
            assert_eq!(settled(&leaving).0, 0xff, "{level:?}: rays that lead away");
        }
    }
}
