//! F64x8 rays side by side, a lane each.

use rt_geometry::WatertightRay;
use rt_math::{BOUNDS_PADDING, DVec3, Interval, Ray};

use super::WideBvh;
use super::node::Row;
use super::ray::{RANGE, SLACK, STEEPEST, SlabCoeffs, filter_applies};
use super::simd::Simd;

/// Rays in a packet.
pub(super) const PACKET: usize = 8;

/// One number of eight rays.
#[derive(Clone, Copy)]
pub(super) struct F64x8<S: Simd> {
    low: S::F64x4,
    high: S::F64x4,
}

impl<S: Simd> F64x8<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, [a, b, c, d, e, f, g, h]: [f64; PACKET]) -> Self {
        Self { low: simd.f64x4([a, b, c, d]), high: simd.f64x4([e, f, g, h]) }
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, x: f64) -> Self {
        Self { low: simd.f64x4([x; 4]), high: simd.f64x4([x; 4]) }
    }

    #[inline(always)]
    pub(super) fn sub(self, simd: S, other: Self) -> Self {
        Self { low: simd.sub_f64(self.low, other.low), high: simd.sub_f64(self.high, other.high) }
    }

    #[inline(always)]
    pub(super) fn add(self, simd: S, other: Self) -> Self {
        Self { low: simd.add_f64(self.low, other.low), high: simd.add_f64(self.high, other.high) }
    }

    #[inline(always)]
    pub(super) fn mul(self, simd: S, other: Self) -> Self {
        Self { low: simd.mul_f64(self.low, other.low), high: simd.mul_f64(self.high, other.high) }
    }

    #[inline(always)]
    pub(super) fn div(self, simd: S, other: Self) -> Self {
        Self { low: simd.div_f64(self.low, other.low), high: simd.div_f64(self.high, other.high) }
    }

    #[inline(always)]
    pub(super) fn sqrt(self, simd: S) -> Self {
        Self { low: simd.sqrt_f64(self.low), high: simd.sqrt_f64(self.high) }
    }

    #[inline(always)]
    pub(super) fn abs(self, simd: S) -> Self {
        Self { low: simd.abs_f64(self.low), high: simd.abs_f64(self.high) }
    }

    #[inline(always)]
    pub(super) fn max(self, simd: S, other: Self) -> Self {
        Self { low: simd.max_f64(self.low, other.low), high: simd.max_f64(self.high, other.high) }
    }

    #[inline(always)]
    pub(super) fn min(self, simd: S, other: Self) -> Self {
        Self { low: simd.min_f64(self.low, other.low), high: simd.min_f64(self.high, other.high) }
    }

    /// The numbers, none of which is negative, with the signs of others.
    #[inline(always)]
    pub(super) fn copysign(self, simd: S, by: Self) -> Self {
        by.select_by_sign(simd, self, Self::splat(simd, 0.0).sub(simd, self))
    }

    /// A bit for each of the eight, set where they are at most others; never where one is NaN.
    #[inline(always)]
    pub(super) fn le(self, simd: S, other: Self) -> u32 {
        simd.le_f64(self.low, other.low) | simd.le_f64(self.high, other.high) << 4
    }

    /// A bit for each of the eight, set where they are less than others; never where one is NaN.
    #[inline(always)]
    pub(super) fn lt(self, simd: S, other: Self) -> u32 {
        self.le(simd, other) & !other.le(simd, self)
    }

    /// A bit for each of the eight, set where the sign is negative.
    #[inline(always)]
    fn signs(self, simd: S) -> u32 {
        simd.signs(self.low) | simd.signs(self.high) << 4
    }

    /// `a` where the sign is positive, otherwise `b`.
    #[inline(always)]
    pub(super) fn select_by_sign(self, simd: S, a: Self, b: Self) -> Self {
        Self { low: simd.select_by_sign(self.low, a.low, b.low), high: simd.select_by_sign(self.high, a.high, b.high) }
    }

    /// The numbers by lane.
    #[inline(always)]
    pub(super) fn to_array(self, simd: S) -> [f64; PACKET] {
        let [a, b, c, d] = simd.to_f64_array(self.low);
        let [e, f, g, h] = simd.to_f64_array(self.high);
        [a, b, c, d, e, f, g, h]
    }

    /// The least of the eight; may be any of them if one is NaN.
    #[inline(always)]
    fn reduce_min(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.min_f64(self.low, self.high));
        a.min(b).min(c.min(d))
    }

    /// The greatest of the eight; may be any of them if one is NaN.
    #[inline(always)]
    fn reduce_max(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.max_f64(self.low, self.high));
        a.max(b).max(c.max(d))
    }

    /// The sum of the eight.
    #[inline(always)]
    fn sum(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.add_f64(self.low, self.high));
        a + b + (c + d)
    }

    /// Rounded to single precision.
    #[inline(always)]
    pub(super) fn to_f32(self, simd: S) -> S::F32x8 {
        simd.concat_to_f32(self.low, self.high)
    }

    /// Single precision that is not above the numbers, as [`round_down`](super::ray::round_down) one by one.
    #[inline(always)]
    fn round_down(self, simd: S) -> S::F32x8 {
        let below = self.mul(simd, Self::splat(simd, 1.0 - SLACK)).to_f32(simd);
        simd.max(simd.sub(below, simd.splat(f32::MIN_POSITIVE)), simd.splat(0.0))
    }

    /// Single precision that is not below the numbers, as [`round_up`](super::ray::round_up) one by one.
    #[inline(always)]
    fn round_up(self, simd: S) -> S::F32x8 {
        let above = self.mul(simd, Self::splat(simd, 1.0 + SLACK)).to_f32(simd);
        simd.max(above, simd.splat(f32::MIN_POSITIVE))
    }
}

/// The greatest absolute value by ray.
#[inline(always)]
pub(super) fn max_abs<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3]) -> F64x8<S> {
    x.abs(simd).max(simd, y.abs(simd)).max(simd, z.abs(simd))
}

/// Spans of eight rays as the filters of leaves see them; see [`FilterTRange`](super::leaf::FilterTRange).
#[derive(Clone, Copy)]
pub(super) struct SpanLanes<S: Simd> {
    pub(super) min: [S::F32x8; 2],
    pub(super) max: S::F32x8,
}

/// By how much, relative to their greatest coordinates, boxes are widened that lie within own boxes.
pub(super) const INNER_PAD: f64 = 0.5 * BOUNDS_PADDING;

/// F64x8 rays, whichever way they go.
#[derive(Clone, Copy)]
pub(super) struct RaySoa8<S: Simd> {
    pub(super) origin: [F64x8<S>; 3],
    pub(super) direction: [F64x8<S>; 3],
    /// As [`SlabRay`](rt_math::SlabRay) has it.
    pub(super) inverse: [F64x8<S>; 3],
    pub(super) min: F64x8<S>,
    pub(super) max: F64x8<S>,
}

impl<S: Simd> RaySoa8<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rays: &[(Ray, Interval); PACKET]) -> Self {
        // One by one, as arrays that are cleared first take longer.
        macro_rules! by_ray {
            (|$ray:pat_param, $span:pat_param| $number:expr) => {{
                let [a, b, c, d, e, f, g, h] = rays;
                let number = |&($ray, $span): &(Ray, Interval)| $number;
                F64x8::new(
                    simd,
                    [number(a), number(b), number(c), number(d), number(e), number(f), number(g), number(h)],
                )
            }};
        }
        let direction =
            [by_ray!(|ray, _| ray.direction.x), by_ray!(|ray, _| ray.direction.y), by_ray!(|ray, _| ray.direction.z)];
        let one = F64x8::splat(simd, 1.0);
        Self {
            origin: [by_ray!(|ray, _| ray.origin.x), by_ray!(|ray, _| ray.origin.y), by_ray!(|ray, _| ray.origin.z)],
            direction,
            inverse: [one.div(simd, direction[0]), one.div(simd, direction[1]), one.div(simd, direction[2])],
            min: by_ray!(|_, span| span.min),
            max: by_ray!(|_, span| span.max),
        }
    }

    /// Where boxes, each side `pad` farther out, are entered and left.
    #[inline(always)]
    pub(super) fn cross_box(&self, simd: S, low: [F64x8<S>; 3], high: [F64x8<S>; 3], pad: F64x8<S>) -> [F64x8<S>; 2] {
        let (mut enter, mut leave) = (F64x8::splat(simd, f64::NEG_INFINITY), F64x8::splat(simd, f64::INFINITY));
        for axis in 0..3 {
            let one = low[axis].sub(simd, pad).sub(simd, self.origin[axis]).mul(simd, self.inverse[axis]);
            let other = high[axis].add(simd, pad).sub(simd, self.origin[axis]).mul(simd, self.inverse[axis]);
            // In this order two NaNs are no constraint. After one the box may seem to be missed, and somebody else decides.
            enter = one.min(simd, other).max(simd, enter);
            leave = one.max(simd, other).min(simd, leave);
        }
        [enter, leave]
    }

    /// By axis: a bit for each ray that is steepest along it, as [`WatertightRay`] has it.
    #[inline(always)]
    pub(super) fn by_steepest_axis(&self, simd: S) -> [u32; 3] {
        let [x, y, z] = [self.direction[0].abs(simd), self.direction[1].abs(simd), self.direction[2].abs(simd)];
        let along_x = y.lt(simd, x) & z.lt(simd, x);
        let along_y = z.lt(simd, y) & !along_x;
        [along_x, along_y, 0xff & !(along_x | along_y)]
    }

    /// A bit for each ray that begins at 0 or later, and whose direction is of a length whose square is nowhere near the
    /// t_max of what `f64` can hold.
    #[inline(always)]
    pub(super) fn in_safe_range(&self, simd: S) -> u32 {
        let [x, y, z] = self.direction;
        let squared = x.mul(simd, x).add(simd, y.mul(simd, y)).add(simd, z.mul(simd, z));
        F64x8::splat(simd, 0.0).le(simd, self.min)
            & F64x8::splat(simd, 1e-100).le(simd, squared)
            & squared.lt(simd, F64x8::splat(simd, 1e100))
    }
}

/// What becomes of eight rays where they may meet a primitive, the same or each another.
pub(super) struct PacketHit<S: Simd> {
    /// A bit for each ray that hits at `t`.
    pub(super) hit: u32,
    /// A bit for each ray that somebody else must decide about; the others miss.
    pub(super) uncertain: u32,
    pub(super) t: F64x8<S>,
    /// As a [`Hit`](rt_geometry::Hit) has them.
    pub(super) uv: [F64x8<S>; 2],
}

/// F64x8 rays that go about the same way.
pub(super) struct RayPacket<S: Simd> {
    pub(super) soa: RaySoa8<S>,
    /// Axes in the order x, y, z of the first ray's own space.
    pub(super) axes: [usize; 3],
    /// A bit for each ray whose own space it is.
    pub(super) same_axis_mask: u32,
    pub(super) span: SpanLanes<S>,
    /// What is entered after these does not matter, as [`Goal::limit`](super::query::Goal::limit) has it at first.
    pub(super) t_max: S::F32x8,
    pub(super) boxes: PacketSlabs<S>,
}

/// Some rays, eight at most and one at least, a lane each; lanes without a ray repeat the first.
#[inline(always)]
pub(super) fn pad_to_packet(rays: &[(Ray, Interval)]) -> [(Ray, Interval); PACKET] {
    let mut lanes = [rays[0]; PACKET];
    for (lane, ray) in lanes.iter_mut().zip(rays) {
        *lane = *ray;
    }
    lanes
}

/// How far directions that go about the same way may be apart, on each of the two axes across the steepest of one of them,
/// where both are one along it.
const MAX_SPREAD: f64 = 0.125;

/// Greatest component of a direction across the steepest axis of one with which it [`is_coherent`]s, relative to that along it.
pub(super) const MAX_SHEAR: f64 = 1.0 + MAX_SPREAD;

/// True if rays go about the same way. Signs of their directions are not asked for: of rays that go along an axis, hardly two
/// have the same. Where products leave their range it may be true of others; [`RayPacket::new`] refuses those.
#[inline(always)]
pub(super) fn is_coherent(rays: &[(Ray, Interval); PACKET]) -> bool {
    let size = rays[0].0.direction.abs();
    if size.x > size.y && size.x > size.z {
        is_coherent_along(rays, |d| [d.y, d.z, d.x])
    } else if size.y > size.z {
        is_coherent_along(rays, |d| [d.z, d.x, d.y])
    } else {
        is_coherent_along(rays, |d| [d.x, d.y, d.z])
    }
}

/// True if rays go about the same way along the axis that `turned` puts last.
#[inline(always)]
fn is_coherent_along(rays: &[(Ray, Interval); PACKET], turned: impl Fn(DVec3) -> [f64; 3]) -> bool {
    let [x, y, z] = turned(rays[0].0.direction);
    rays[1..].iter().all(|(ray, _)| {
        let [other_x, other_y, other_z] = turned(ray.direction);
        // Not where one is no number.
        let most = MAX_SPREAD * (z * other_z);
        ((other_x * z - x * other_z).abs() <= most) & ((other_y * z - y * other_z).abs() <= most)
    })
}

/// The signs of a direction: through which sides it passes boxes.
#[inline(always)]
pub(super) fn signs(d: DVec3) -> u32 {
    ((d.x.to_bits() >> 63) | (d.y.to_bits() >> 63) << 1 | (d.z.to_bits() >> 63) << 2) as u32
}

impl<S: Simd> RayPacket<S> {
    /// Of rays that [`is_coherent`]; `None` where the filters are not proven.
    #[inline(always)]
    pub(super) fn new(simd: S, tree: &WideBvh, rays: &[(Ray, Interval); PACKET]) -> Option<Self> {
        let soa = RaySoa8::new(simd, rays);
        let RaySoa8 { origin, direction, inverse, min, max } = soa;
        let span = SpanLanes { min: [min.round_down(simd), min.round_up(simd)], max: max.round_down(simd) };
        let t_max = max.round_up(simd);
        let q = relative(simd, origin, tree.centre);
        let fastest = max_abs(simd, direction);

        // What is not finite makes a NaN of this.
        let sum = q[0].add(simd, q[1]).add(simd, q[2]).add(simd, min);
        let sum = sum.add(simd, direction[0]).add(simd, direction[1]).add(simd, direction[2]);
        let nothing = sum.mul(simd, F64x8::splat(simd, 0.0)).sum(simd);
        let farthest = max_abs(simd, q).reduce_max(simd);
        let begin = Interval { min: min.reduce_min(simd), max: f64::INFINITY };
        let is_all_proven = filter_applies(fastest.reduce_min(simd), farthest, nothing, begin, tree.size)
            & RANGE.contains(&fastest.reduce_max(simd));
        if !is_all_proven {
            return None;
        }

        let (first, _) = &rays[0];
        let steepest = F64x8::splat(simd, STEEPEST).div(simd, fastest);
        let (axes, _) = WatertightRay::new(first).shear();
        let sides = Sides::of(simd, direction);
        let boxes = PacketSlabs::new(simd, q, inverse, steepest, tree.size, sides, span.min[0]);
        let same_axis_mask = soa.by_steepest_axis(simd)[axes[2] % 3];
        Some(Self { soa, axes, same_axis_mask, span, t_max, boxes })
    }

    /// The greatest coordinate of each origin, or more.
    #[inline(always)]
    pub(super) fn reach(simd: S, origin: [F64x8<S>; 3]) -> S::F32x8 {
        max_abs(simd, origin).round_up(simd)
    }
}

/// Positions relative to a centre.
#[inline(always)]
pub(super) fn relative<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3], centre: DVec3) -> [F64x8<S>; 3] {
    [
        x.sub(simd, F64x8::splat(simd, centre.x)),
        y.sub(simd, F64x8::splat(simd, centre.y)),
        z.sub(simd, F64x8::splat(simd, centre.z)),
    ]
}

/// Through which sides eight rays pass boxes.
#[derive(Clone, Copy)]
struct Sides {
    /// By axis: the row of the planes that are near for the first ray.
    near_row: [Row; 3],
    /// By axis: a bit for each ray for which these are the far ones.
    turned: [u32; 3],
}

impl Sides {
    #[inline(always)]
    fn of<S: Simd>(simd: S, direction: [F64x8<S>; 3]) -> Self {
        let (x, y, z) = (direction[0].signs(simd), direction[1].signs(simd), direction[2].signs(simd));
        Self {
            near_row: Row::near([x as usize, y as usize, z as usize]),
            turned: [unlike_first(x), unlike_first(y), unlike_first(z)],
        }
    }
}

/// The lanes whose bit is not that of the first.
#[inline(always)]
const fn unlike_first(bits: u32) -> u32 {
    if bits & 1 == 0 { bits } else { 0xff & !bits }
}

/// F64x8 rays as the filter of boxes sees them.
#[derive(Clone, Copy)]
pub(super) struct PacketSlabs<S: Simd> {
    scale: [S::F32x8; 3],
    near_shift: [S::F32x8; 3],
    far_shift: [S::F32x8; 3],
    sides: Sides,
    min: S::F32x8,
}

impl<S: Simd> PacketSlabs<S> {
    #[inline(always)]
    fn new(
        simd: S,
        q: [F64x8<S>; 3],
        inverse: [F64x8<S>; 3],
        steepest: F64x8<S>,
        size: f64,
        sides: Sides,
        min: S::F32x8,
    ) -> Self {
        let nothing = simd.splat(0.0);
        let mut this = Self { scale: [nothing; 3], near_shift: [nothing; 3], far_shift: [nothing; 3], sides, min };
        for axis in 0..3 {
            let low = SlabCoeffs::new(simd, q[axis].low, inverse[axis].low, steepest.low, size);
            let high = SlabCoeffs::new(simd, q[axis].high, inverse[axis].high, steepest.high, size);
            this.scale[axis] = simd.concat_to_f32(low.scale, high.scale);
            this.near_shift[axis] = simd.concat_to_f32(low.near_shift, high.near_shift);
            this.far_shift[axis] = simd.concat_to_f32(low.far_shift, high.far_shift);
        }
        this
    }

    /// True if all rays pass boxes through the same sides.
    #[inline(always)]
    pub(super) fn is_same_octant(&self) -> bool {
        let [x, y, z] = self.sides.turned;
        x | y | z == 0
    }

    /// Where the rays enter and leave one box, of which `plane` returns a row, as
    /// [`RayF32::cross`](super::ray::RayF32::cross) has it. `SAME_OCTANT` takes fewer instructions, and is right only where
    /// rays are.
    #[inline(always)]
    pub(super) fn cross<const SAME_OCTANT: bool>(
        &self,
        simd: S,
        plane: impl Fn(Row) -> S::F32x8,
        t_max: S::F32x8,
    ) -> [S::F32x8; 2] {
        let [x, y, z] = self.sides.near_row;
        let mut near = [plane(x), plane(y), plane(z)];
        let mut far = [plane(x.opposite()), plane(y.opposite()), plane(z.opposite())];
        if !SAME_OCTANT {
            for axis in 0..3 {
                let (one, other) = (near[axis], far[axis]);
                near[axis] = simd.select(self.sides.turned[axis], other, one);
                far[axis] = simd.select(self.sides.turned[axis], one, other);
            }
        }
        let enter_x = simd.mul_add(near[0], self.scale[0], self.near_shift[0]);
        let enter_y = simd.mul_add(near[1], self.scale[1], self.near_shift[1]);
        let enter_z = simd.mul_add(near[2], self.scale[2], self.near_shift[2]);
        let leave_x = simd.mul_add(far[0], self.scale[0], self.far_shift[0]);
        let leave_y = simd.mul_add(far[1], self.scale[1], self.far_shift[1]);
        let leave_z = simd.mul_add(far[2], self.scale[2], self.far_shift[2]);
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, self.min));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, t_max));
        [enter, leave]
    }
}

#[cfg(test)]
mod tests {
    use rt_math::Aabb;
    use rt_math::random::{hash, unit};

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

    /// Rays about along an axis or a diagonal.
    fn rays(seed: u64) -> [(Ray, Interval); PACKET] {
        let signs = DVec3::new(number(seed, 0), number(seed, 1), number(seed, 2)).signum();
        let along = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)][seed as usize % 5] * signs;
        core::array::from_fn(|lane| {
            let k = 10 * lane as u64;
            let jitter = vector(seed, k + 3) * [0.0, 1e-9, 0.06][seed as usize % 3];
            let direction = (along + jitter) * (1.5 + number(seed, k + 6));
            let of_any_sign = DVec3::ZERO.copysign(vector(seed, k + 3));
            let direction = DVec3::select(direction.cmpeq(DVec3::ZERO), of_any_sign, direction);
            (Ray::new(vector(seed, k + 7) * 2.0, direction), Interval::FORWARD)
        })
    }

    struct Compared<'a>(&'a WideBvh, &'a mut [u32; 2]);

    impl WithSimd<&[(Ray, Interval); PACKET], ()> for Compared<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval); PACKET], (): ()) {
            let Self(tree, counts) = self;
            let Some(across) = RayPacket::new(simd, tree, rays).filter(|_| is_coherent(rays)) else { return };
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
    fn rays_of_any_signs_cross_boxes_as_each_by_itself() {
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
            *self.1 = RayPacket::new(simd, self.0, rays).is_none();
        }
    }

    /// Their products say that they agree.
    #[test]
    fn directions_out_of_all_range_make_no_packet() {
        let tree = WideBvh::build(&Boxes(&[Aabb::from_points([DVec3::ZERO, DVec3::ONE])])).expect("one box");
        let refused = |level: SimdLevel, first: DVec3, other: DVec3| {
            let mut rays = [(Ray::new(DVec3::NEG_ONE, first), Interval::FORWARD); PACKET];
            rays[3].0.direction = other;
            let mut refused = false;
            DetectedSimd::new(level).dispatch(Refused(&tree, &mut refused), &rays, ());
            assert!(is_coherent(&rays), "{first}, {other}");
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

    #[test]
    fn rays_agree_wherever_signs_change_and_not_where_they_part() {
        let with = |other: DVec3| {
            let mut rays = [(Ray::new(DVec3::ZERO, DVec3::new(0.01, -0.02, -3.0)), Interval::FORWARD); PACKET];
            rays[5].0.direction = other;
            is_coherent(&rays)
        };
        assert!(with(DVec3::new(-0.01, 0.02, -1.0)) && with(DVec3::new(0.1, -0.1, -1.0)));
        assert!(!with(DVec3::new(0.01, -0.02, 3.0)) && !with(DVec3::new(0.2, 0.0, -1.0)));
        assert!(!with(DVec3::new(f64::NAN, 0.0, -1.0)) && !with(DVec3::new(0.0, 0.0, f64::NAN)));
        assert!(!with(DVec3::X) && !with(DVec3::new(0.0, f64::INFINITY, -1.0)));
    }
}
