//! Boxes of `f32` that a ray enters no later and leaves no earlier than the `f64` boxes inside them.
//!
//! # Why the culling is conservative
//!
//! Let `c` be the centre of the tree, `o` the origin of a ray, `v = fl(1/d)` on some axis, and `fl` rounding to the
//! nearest `f64`. [`Aabb::clip`] enters padded bounds through the plane `b` at `fl(fl(b − o)·v)`. A node stores the
//! plane `p`, an `f32`, and the ray a shifted origin `q`. The node is entered at `fl(fl(p − q)·v)`, by the same two
//! operations. Take `v > 0`, where the near plane is the lower one.
//!
//! * [`Aabb32::enclosing`] rounds so that `p ≤ b − c` holds for real numbers.
//! * [`SlabRay32::new`] rounds so that `q ≥ o − c` holds for real numbers. The rounded difference is at most half a
//!   step off, and `q` is one step above it.
//! * So `p − q ≤ b − o`, and as rounding and multiplication by `v > 0` are monotone, the node is entered no later.
//!
//! For `v < 0` and for far planes all signs turn around. The far factor is one more monotone operation, and is applied
//! after the minimum of three for that reason. `0 · ∞` gives NaN, no constraint, where the ray lies in a plane of the
//! padded bounds. Then `p − q` is zero or has the sign of a ray inside the node's slab, which is no constraint either.
//! Hence for every finite ray, **bit for bit**: `enter(node) ≤ enter(padded bounds)` and
//! `leave(node) ≥ leave(padded bounds)`. There is no tolerance to choose. A scene far from the origin is as good as one
//! at it, as `p` and `q` are small numbers there.

use glam::{DVec3, Vec3A};
use rt_math::{Aabb, FAR_FACTOR, Interval, SlabRay};

use crate::binned_sah::{BINS, BuildBounds};
use crate::node_ref::NodeRef;
use crate::top_down::TreeNode;
use crate::traversal::Descent;

/// Far factor behind the origin of a ray.
const BEHIND_FACTOR: f64 = 2.0 - FAR_FACTOR;

/// Box relative to the centre of its tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aabb32 {
    pub(crate) min: Vec3A,
    pub(crate) max: Vec3A,
}

impl Aabb32 {
    /// Neutral element of [`union`](Self::union).
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Smallest box that contains `aabb − centre`, but for a rounding step.
    #[inline]
    pub(crate) fn enclosing(aabb: &Aabb, centre: DVec3) -> Self {
        let (min, max) = (aabb.min - centre, aabb.max - centre);
        Self { min: Vec3A::from_array(min.to_array().map(below)), max: Vec3A::from_array(max.to_array().map(above)) }
    }

    #[inline(always)]
    pub(crate) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline]
    pub(crate) fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Box in world space. Contains all `aabb` that the box was made from: these are `f64`, so that rounding the sums
    /// cannot pass them.
    pub(crate) fn at(&self, centre: DVec3) -> Aabb {
        Aabb::new(centre + self.min.as_dvec3(), centre + self.max.as_dvec3())
    }

    /// True if the box contains `aabb − centre`, without rounding.
    pub(crate) fn encloses(&self, aabb: &Aabb, centre: DVec3) -> bool {
        (0..3).all(|axis| self.encloses_on(axis, aabb, centre) == [true; 2])
    }

    /// Containment at the lower and the upper face of an axis.
    pub(super) fn encloses_on(&self, axis: usize, aabb: &Aabb, centre: DVec3) -> [bool; 2] {
        [
            is_at_most(self.min[axis], aabb.min[axis], centre[axis]),
            is_at_most(-self.max[axis], -aabb.max[axis], -centre[axis]),
        ]
    }

    /// Largest magnitude of any coordinate.
    pub(crate) fn max_abs(&self) -> f64 {
        f64::from(self.min.abs().max(self.max.abs()).max_element())
    }

    /// Half of the surface area: finite for any `f32` corners, meaningless for an empty box.
    pub(crate) fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        x * y + y * z + z * x
    }
}

/// `plane ≤ b − c` for real numbers: the rounded difference decides, or where it is equal, its error.
fn is_at_most(plane: f32, b: f64, c: f64) -> bool {
    let difference = b - c;
    // Knuth's exact error of a difference (TAOCP 2, 4.2.2, theorem B).
    let c_part = b - difference;
    let error = (b - (difference + c_part)) + (c_part - c);
    let plane = f64::from(plane);
    plane < difference || (plane == difference && error >= 0.0)
}

impl BuildBounds for Aabb32 {
    type Vector = Vec3A;

    const EMPTY: Self = Self::EMPTY;

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        self.union(other)
    }

    #[inline(always)]
    fn include(self, point: Vec3A) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Twice the centre.
    #[inline(always)]
    fn centroid(&self) -> Vec3A {
        self.min + self.max
    }

    fn widest_axis(&self) -> (usize, bool) {
        let extent = self.max - self.min;
        (extent.max_position(), extent.cmpgt(Vec3A::ZERO).any())
    }

    fn coordinate(point: Vec3A, axis: usize) -> f64 {
        f64::from(point[axis])
    }

    fn bin_scale(&self) -> Vec3A {
        Vec3A::splat(BINS as f32) / (self.max - self.min)
    }

    #[inline(always)]
    fn bin(&self, scale: Vec3A, point: Vec3A) -> [usize; 3] {
        ((point - self.min) * scale).to_array().map(|x| (x as usize).min(BINS - 1))
    }
}

/// An `f32` below the real number that rounds to `difference`: no step of an `f32` is shorter than one of an `f64`.
#[inline]
fn below(difference: f64) -> f32 {
    let rounded = difference as f32;
    if f64::from(rounded) < difference { rounded } else { rounded.next_down() }
}

/// An `f32` above the real number that rounds to `difference`.
#[inline]
fn above(difference: f64) -> f32 {
    -below(-difference)
}

/// Bounds and references of both children: one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct BvhNode {
    /// Indexed by axis, side (lower, upper) and child.
    planes: [[[f32; 2]; 2]; 3],
    pub(super) children: [NodeRef; 2],
}

impl BvhNode {
    pub(super) fn new(boxes: [Aabb32; 2], children: [NodeRef; 2]) -> Self {
        let planes = core::array::from_fn(|axis| {
            [[boxes[0].min[axis], boxes[1].min[axis]], [boxes[0].max[axis], boxes[1].max[axis]]]
        });
        Self { planes, children }
    }

    /// Bounds of a child, relative to the centre of the tree.
    pub(super) fn child_box(&self, child: usize) -> Aabb32 {
        let side = |side: usize| Vec3A::from_array(self.planes.map(|axis| axis[side][child]));
        Aabb32 { min: side(0), max: side(1) }
    }
}

impl TreeNode for BvhNode {
    type Payload = [Aabb32; 2];

    fn inner(bounds: [Aabb32; 2]) -> Self {
        Self::new(bounds, [NodeRef::node(0); 2])
    }

    fn link(&mut self, children: [NodeRef; 2]) {
        self.children = children;
    }

    fn shift(&mut self, nodes: u32, indices: u32) {
        self.children = self.children.map(|child| child.shifted(nodes, indices));
    }
}

/// Ray prepared for the slab tests of one tree.
pub(crate) struct SlabRay32 {
    /// Subtracted from near planes.
    near: [f64; 3],
    /// Subtracted from far planes.
    far: [f64; 3],
    inverse: [f64; 3],
    /// 0 where the lower plane is the near one, 1 where it is the upper one.
    near_side: [usize; 3],
}

impl SlabRay32 {
    /// `ray` must be finite.
    #[inline]
    pub(crate) fn new(ray: &SlabRay, centre: DVec3) -> Self {
        let origin = (ray.ray.origin - centre).to_array();
        let inverse = ray.inverse.to_array();
        let shifted = |is_near: bool| {
            core::array::from_fn(|axis| {
                if is_near == inverse[axis].is_sign_negative() {
                    origin[axis].next_down()
                } else {
                    origin[axis].next_up()
                }
            })
        };
        let near_side = inverse.map(|inverse| usize::from(inverse.is_sign_negative()));
        Self { near: shifted(true), far: shifted(false), inverse, near_side }
    }

    /// Parameters at which the ray enters and leaves a box. It misses the box if the interval is empty or begins after
    /// `span`.
    #[inline(always)]
    pub(crate) fn cross(&self, bounds: &Aabb32, span: Interval) -> Interval {
        let sides = [bounds.min.to_array(), bounds.max.to_array()];
        let (mut enter, mut leave) = (span.min, f64::INFINITY);
        for (axis, near_side) in self.near_side.into_iter().enumerate() {
            let side = near_side & 1;
            let t_near = (f64::from(sides[side][axis]) - self.near[axis]) * self.inverse[axis];
            let t_far = (f64::from(sides[side ^ 1][axis]) - self.far[axis]) * self.inverse[axis];
            enter = if t_near > enter { t_near } else { enter };
            leave = if t_far < leave { t_far } else { leave };
        }
        Interval { min: enter, max: outward(leave) }
    }

    /// Parameters at which the ray enters and leaves both boxes, within `span`. It misses a box if `enter > leave`.
    #[inline(always)]
    pub(super) fn clip(&self, node: &BvhNode, span: Interval) -> ChildHits {
        let mut enter = [span.min; 2];
        let mut leave = [f64::INFINITY; 2];
        for axis in 0..3 {
            let side = self.near_side[axis] & 1;
            let (near, far) = (node.planes[axis][side], node.planes[axis][side ^ 1]);
            for child in 0..2 {
                let t_near = (f64::from(near[child]) - self.near[axis]) * self.inverse[axis];
                let t_far = (f64::from(far[child]) - self.far[axis]) * self.inverse[axis];
                // A NaN fails both comparisons and keeps the old value.
                enter[child] = if t_near > enter[child] { t_near } else { enter[child] };
                leave[child] = if t_far < leave[child] { t_far } else { leave[child] };
            }
        }
        // If the span begins at 0 or later, a box behind the origin is missed with either factor.
        let leave = if span.min >= 0.0 { leave.map(|t_far| t_far * FAR_FACTOR) } else { leave.map(outward) };
        ChildHits { enter, leave, limit: span.max }
    }
}

/// Moves a far parameter outward by a rounding error.
#[inline(always)]
fn outward(t_far: f64) -> f64 {
    t_far * if t_far < 0.0 { BEHIND_FACTOR } else { FAR_FACTOR }
}

/// Intersections of a ray with the boxes of a node.
pub(super) struct ChildHits {
    enter: [f64; 2],
    leave: [f64; 2],
    limit: f64,
}

impl ChildHits {
    /// True if the ray passes the box of `child` within the span. A NaN is a miss.
    #[inline(always)]
    fn hits(&self, child: usize) -> bool {
        (self.enter[child] <= self.leave[child]) & (self.enter[child] <= self.limit)
    }

    /// Children in the order in which the ray enters them, with the distances of entry.
    #[inline(always)]
    pub(super) fn nearer_first(&self, children: [NodeRef; 2]) -> Option<Descent<(f64, NodeRef)>> {
        let hits = [self.hits(0), self.hits(1)];
        let near = usize::from(hits[1] & (!hits[0] | (self.enter[1] < self.enter[0])));
        let [next, deferred] = [near, near ^ 1].map(|side| (self.enter[side], children[side]));
        (hits[0] | hits[1]).then_some(Descent { next, deferred, is_deferred: hits[0] & hits[1] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Ray;
    use rt_math::random::{hash, unit};

    #[test]
    fn a_node_is_a_cache_line() {
        assert_eq!((size_of::<BvhNode>(), align_of::<BvhNode>()), (64, 64));
    }

    #[test]
    fn bounds_are_rounded_outward_and_not_far() {
        for x in [0.0, -0.0, 1.0, 0.1, -0.1, 1e-320, -1e300, 1e300, 16_777_217.0] {
            let (low, high) = (f64::from(below(x)), f64::from(above(x)));
            assert!(low < x && x < high, "{low} {x} {high}");
            if x.abs() < 1e38 {
                assert!(high - low <= x.abs() * 3e-7 + 3e-45, "{low} {x} {high}");
            }
        }
    }

    /// Numbers that make rounding, cancellation and NaN likely.
    fn hostile(words: [u64; 3], scale: f64) -> f64 {
        let bits = hash(&words);
        let x = (unit(hash(&[bits])) * 2.0 - 1.0) * scale;
        match bits % 8 {
            0 => 0.0,
            1 => -0.0,
            2 => x.round(),
            3 => f64::from(x as f32),
            4 => f64::from(x as f32).next_up(),
            5 => x * 1e-12,
            _ => x,
        }
    }

    fn hostile_ray(i: u64, own: &Aabb, scale: f64) -> Ray {
        let vector = |k: u64, scale: f64| DVec3::from_array([0, 1, 2].map(|axis| hostile([i, k, axis], scale)));
        let mut origin = vector(10, scale * [1.0, 1e6, 1e-6][(i % 3) as usize]);
        let mut direction = vector(11, 1.0);
        let bits = hash(&[i, 12]);
        if bits & 1 == 0 {
            // Through a corner.
            direction = own.corners()[(bits >> 8) as usize % 8] - origin;
        }
        for axis in 0..3 {
            match (bits >> (16 + 8 * axis)) % 8 {
                // In the plane of a face, or one step off it.
                0 => origin[axis] = own.min[axis],
                1 => origin[axis] = own.max[axis].next_up(),
                2 => direction[axis] = [0.0, -0.0, 5e-324, -1e-310][(bits >> 40) as usize % 4],
                3 => direction[axis] *= [1e-200, 1e200][(bits >> 40) as usize % 2],
                4 => direction[axis] = direction[axis].next_down(),
                _ => {}
            }
        }
        Ray::new(origin, direction)
    }

    /// The proof at the top of this file, tried on hostile numbers: bit for bit, and without a tolerance.
    #[test]
    fn nodes_are_entered_no_later_and_left_no_earlier_than_padded_bounds() {
        let mut n_hits = 0;
        for i in 0..100_000 {
            let scale = [1.0, 1e-4, 1e3, 1e7, 1e300, 1e-300][(i % 6) as usize];
            let offset = f64::min([0.0, 1.0, 1e7, 1e15][(i / 6 % 4) as usize] * scale, 1e300);
            let point = |k: u64| DVec3::from_array([0, 1, 2].map(|axis| hostile([i, k, axis], scale))) + offset;
            let own = Aabb::from_points([point(0), point(1)]).padded();
            let centre = point(2);
            let ray = hostile_ray(i, &own, scale + offset);
            if !(own.is_finite() && centre.is_finite() && crate::ray_query::is_finite(&ray)) {
                continue;
            }
            let slab_ray = SlabRay::new(&ray);
            let inner = Aabb32::enclosing(&own, centre);
            let outer = inner.union(Aabb32::enclosing(&Aabb::new(point(3), point(3)), centre));
            let node = BvhNode::new([inner, outer], [NodeRef::node(0); 2]);
            for span in [Interval::FORWARD, Interval::new(-3.0, 2.0), Interval::new(f64::NEG_INFINITY, f64::INFINITY)] {
                let Some(expected) = own.clip(&slab_ray, span) else { continue };
                let crossings = SlabRay32::new(&slab_ray, centre).clip(&node, span);
                for child in 0..2 {
                    let (enter, leave) = (crossings.enter[child], crossings.leave[child].min(span.max));
                    assert!(crossings.hits(child), "case {i}: {ray:?} misses what contains {own:?}");
                    assert!(enter <= expected.min && leave >= expected.max, "case {i}: {enter} {leave} {expected:?}");
                }
                n_hits += 1;
            }
        }
        assert!(n_hits > 25_000, "{n_hits} hits");
    }

    #[test]
    fn nodes_cull_well_far_from_the_origin() {
        // A row of unit boxes, 10⁷ away from the origin: a ray through one of them must miss its neighbours.
        let centre = DVec3::splat(1e7);
        let boxes = [0.0, 1.5].map(|x| {
            let corner = centre + DVec3::new(x, 0.0, 0.0);
            Aabb32::enclosing(&Aabb::new(corner, corner + 1.0), centre)
        });
        let node = BvhNode::new(boxes, [NodeRef::node(0); 2]);
        let ray = Ray::new(centre + DVec3::new(1.000_01, 0.5, -3.0), DVec3::Z);
        let crossings = SlabRay32::new(&SlabRay::new(&ray), centre).clip(&node, Interval::FORWARD);
        assert!(crossings.nearer_first(node.children).is_none());
    }

    #[test]
    fn containment_is_decided_without_rounding() {
        // 1 − 2⁻⁶⁰ rounds to 1; the real number is below it.
        let tiny = 1.0 / (1u64 << 60) as f64;
        assert!(!is_at_most(1.0, 1.0, tiny));
        assert!(is_at_most(1.0, 1.0, -tiny) && is_at_most(1.0, 1.0, 0.0));
        assert!(!is_at_most(1.0, f64::NAN, 0.0));
    }
}
