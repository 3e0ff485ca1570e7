//! Coherent packets of eight rays, prepared for filters.

use super::WideBvh;
use super::f64x8::{F64x8, max_abs, relative};
use super::packet_slabs::{PacketSides, PacketSlabs};
use super::ray::{FARTHEST, RANGE, STEEPEST};
use super::ray_f64::AXES;
use super::ray_soa::RaySoa8;
use super::simd::Simd;
use super::t_range::SpanLanes;

/// A coherent packet of eight rays.
pub(super) struct RayPacket<S: Simd> {
    pub(super) soa: RaySoa8<S>,
    /// Axes in the order x, y, z of the first ray's space; see [`WatertightRay`](rt_geometry::WatertightRay).
    pub(super) axes: [usize; 3],
    /// A bit for each ray with the same axes.
    pub(super) same_axis_mask: u32,
    pub(super) span: SpanLanes<S>,
    /// Initial [`RayState::t_max`](super::query::RayState::t_max) by ray.
    pub(super) t_max: S::F32x8,
    pub(super) boxes: PacketSlabs<S>,
}

impl<S: Simd> RayPacket<S> {
    /// Prepares coherent rays; `None` where the proofs of the filters do not apply.
    #[inline(always)]
    pub(super) fn new(simd: S, tree: &WideBvh, soa: RaySoa8<S>) -> Option<Self> {
        let RaySoa8 { origin, direction, inverse, min, max } = soa;
        let span = SpanLanes { min: [min.round_down(simd), min.round_up(simd)], max: max.round_down(simd) };
        let t_max = max.round_up(simd);
        let q = relative(simd, origin, tree.centre);
        let fastest = max_abs(simd, direction);

        // NaN if anything is not finite.
        let sum = q[0].add(simd, q[1]).add(simd, q[2]).add(simd, min);
        let sum = sum.add(simd, direction[0]).add(simd, direction[1]).add(simd, direction[2]);
        let (zero, all) = (F64x8::splat(simd, 0.0), 0xff);
        let is_proven = sum.mul(simd, zero).le(simd, zero)
            & zero.le(simd, min)
            & max_abs(simd, q).le(simd, F64x8::splat(simd, FARTHEST * tree.size))
            & F64x8::splat(simd, *RANGE.start()).le(simd, fastest)
            & fastest.le(simd, F64x8::splat(simd, *RANGE.end()));
        if is_proven != all || !RANGE.contains(&tree.size) {
            return None;
        }

        let steepest = F64x8::splat(simd, STEEPEST).div(simd, fastest);
        let sides = PacketSides::of(simd, direction);
        let boxes = PacketSlabs::new(simd, q, inverse, steepest, tree.size, sides, span.min[0]);
        let by_axis = soa.by_steepest_axis(simd);
        let axis = if by_axis[0] & 1 != 0 { 0 } else { 2 - (by_axis[1] & 1) as usize };
        let (axes, same_axis_mask) = (AXES[axis], by_axis[axis]);
        Some(Self { soa, axes, same_axis_mask, span, t_max, boxes })
    }

    /// Upper bound of the maximum coordinate of each origin.
    #[inline(always)]
    pub(super) fn reach(simd: S, origin: [F64x8<S>; 3]) -> S::F32x8 {
        max_abs(simd, origin).round_up(simd)
    }
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit};
    use rt_math::{Aabb, DVec3, Interval, Ray};

    use super::super::coherence::are_coherent;
    use super::super::f64x8::PACKET;
    use super::super::ray::{RayF32, RayF64x4};
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;
    use crate::Boxes;

    fn number(seed: u64, k: u64) -> f64 {
        2.0 * unit(hash(&[seed, k])) - 1.0
    }

    fn vector(seed: u64, k: u64) -> DVec3 {
        DVec3::new(number(seed, k), number(seed, k + 1), number(seed, k + 2))
    }

    /// Rays close to an axis or a diagonal.
    fn rays(seed: u64) -> [(Ray, Interval); PACKET] {
        let signs = DVec3::new(number(seed, 0), number(seed, 1), number(seed, 2)).signum();
        let along = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)][seed as usize % 5] * signs;
        core::array::from_fn(|lane| {
            let k = 10 * lane as u64;
            let jitter = vector(seed, k + 3) * [0.0, 1e-9, 0.06][seed as usize % 3];
            let direction = (along + jitter) * (1.5 + number(seed, k + 6));
            let signed_zero = DVec3::ZERO.copysign(vector(seed, k + 3));
            let direction = DVec3::select(direction.cmpeq(DVec3::ZERO), signed_zero, direction);
            (Ray::new(vector(seed, k + 7) * 2.0, direction), Interval::FORWARD)
        })
    }

    struct Compared<'a>(&'a WideBvh, &'a mut [u32; 2]);

    impl WithSimd<&[(Ray, Interval); PACKET], ()> for Compared<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval); PACKET], (): ()) {
            let Self(tree, counts) = self;
            let soa = RaySoa8::new(simd, rays);
            let Some(across) = RayPacket::new(simd, tree, soa).filter(|_| are_coherent(simd, soa.direction, PACKET))
            else {
                return;
            };
            // SAFETY: the root of a tree is one of its nodes.
            let node = unsafe { tree.node(tree.root) };
            let is_same_octant = across.boxes.is_same_octant();
            counts[usize::from(is_same_octant)] += 1;
            for lane in 0..8 {
                let plane = |row| node.plane(simd, row, lane);
                let crossed = across.boxes.cross::<false>(simd, plane, across.t_max);
                let [enters, leaves] = [simd.to_array(crossed[0]), simd.to_array(crossed[1])];
                if is_same_octant {
                    let crossed = across.boxes.cross::<true>(simd, plane, across.t_max);
                    assert_eq!([simd.to_array(crossed[0]), simd.to_array(crossed[1])], [enters, leaves]);
                }
                for (i, (ray, span)) in rays.iter().enumerate() {
                    let alone = RayF32::new(simd, &RayF64x4::new(simd, ray), *span, tree.centre, tree.size);
                    let alone = alone.expect("proven with the others");
                    let [min, max] = [simd.to_array(across.span.min[0])[i], simd.to_array(across.t_max)[i]];
                    let [enter, leave] = alone.cross(simd, node, min, max);
                    let expected = [simd.to_array(enter)[lane], simd.to_array(leave)[lane]];
                    assert_eq!([enters[i], leaves[i]].map(f32::to_bits), expected.map(f32::to_bits), "{ray:?}");
                }
            }
        }
    }

    #[test]
    fn packets_cross_boxes_as_single_rays_do() {
        let boxes: Vec<_> = (0..8).map(|i| Aabb::from_points([vector(i, 90), vector(i, 95)])).collect();
        let tree = WideBvh::build(&Boxes(&boxes)).expect("eight boxes");
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            let mut counts = [0; 2];
            for seed in 0..2000 {
                DetectedSimd::new(level).dispatch(Compared(&tree, &mut counts), &rays(seed), ());
            }
            assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
        }
    }

    struct Refused<'a>(&'a WideBvh, &'a mut bool);

    impl WithSimd<&[(Ray, Interval); PACKET], ()> for Refused<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval); PACKET], (): ()) {
            let soa = RaySoa8::new(simd, rays);
            assert!(are_coherent(simd, soa.direction, PACKET), "{rays:?}");
            *self.1 = RayPacket::new(simd, self.0, soa).is_none();
        }
    }

    /// Products of such directions pass [`are_coherent`].
    #[test]
    fn directions_out_of_range_are_rejected() {
        let tree = WideBvh::build(&Boxes(&[Aabb::from_points([DVec3::ZERO, DVec3::ONE])])).expect("one box");
        let refused = |level: SimdLevel, first: DVec3, other: DVec3| {
            let mut rays = [(Ray::new(DVec3::NEG_ONE, first), Interval::FORWARD); PACKET];
            rays[3].0.direction = other;
            let mut refused = false;
            DetectedSimd::new(level).dispatch(Refused(&tree, &mut refused), &rays, ());
            refused
        };
        let plain = DVec3::new(0.01, -0.02, -3.0);
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            assert!(!refused(level, plain, plain));
            for (first, other) in [
                (plain, DVec3::new(0.0, 0.0, f64::NEG_INFINITY)),
                (DVec3::ZERO, DVec3::X),
                (DVec3::Z * 1e-200, DVec3::X * 1e-200),
                (DVec3::Z * 1e200, DVec3::new(1.0, 0.0, 1.0) * 1e200),
            ] {
                assert!(refused(level, first, other), "{level:?}: {first}, {other}");
            }
        }
    }
}
