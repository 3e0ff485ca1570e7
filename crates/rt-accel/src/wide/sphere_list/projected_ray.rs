//! Projection of spheres along a ray: they become discs, and the ray a point.
//!
//! # Why the filter is conservative
//!
//! Coordinates are relative to the centre of the list. Let `S` be the greatest coordinate of the spheres, `q` the
//! origin of the ray, and `d` its unit direction. Let `u` and `w` be unit vectors at right angles to `d` and to each
//! other. In the plane of `u` and `w` the ray is the point `(u·q, w·q)`, and a sphere of centre `c` is a disc around
//! `(u·c, w·c)`. The ray hits if these are no farther apart than the radius `r`. Let `v = 2⁻²⁴` and `Q` be the distance
//! of the point from 0.
//!
//! **Distance.** `u` and `c` are rounded, and so are products and sums. Thus `u·c − u·q` is off by less than
//! `v·(11S + 4Q)`, and the distance `ρ` of the two points by less than `16v·(S + Q)`. Computing `u·q` in `f64`, and the
//! `f64` kernel itself, take another 2⁻⁴⁰ of the greatest coordinate of `q` at most. Let `δ` be the sum of both, with
//! 2⁻³⁰ for 2⁻⁴⁰.
//!
//! **Radius.** Instead of `ρ ≤ r + δ` the filter tests `ρ² − k ≤ m` with `k = r²(1 + 2⁻¹⁰)` and `m = 2¹²δ²`, which
//! saves an operation for each sphere. It follows from `ρ ≤ r + δ`, as `2rδ ≤ 2⁻¹¹r² + 2¹¹δ²`; what is left covers the
//! roundings of `k` and of the sum, some `4v` of what they round. Likewise `ρ² − k ≤ −2⁻⁹k − m` implies
//! `ρ² ≤ r²(1 − 2⁻¹⁰) − m`, of which follows `ρ + δ < r`: a certain hit.
//!
//! **Time.** Half the chord squared is `r² − ρ²` to within the same margins: at most `m − (ρ² − k)`, and at least
//! `−(ρ² − k) − 2⁻⁹k − m`. Where the chord has its middle is computed to within `δ`, as a coordinate of the disc is. Distances
//! are measured from the point of the ray nearest to the centre of the list, so that a far origin costs no digits.

use rt_math::{DVec3, Interval, Ray};

use super::block::Block;
use crate::wide::ray::{FARTHEST, RANGE};
use crate::wide::simd::Simd;

/// Relative inflation of squared radii.
const INFLATION: f64 = 1.0 / (1 << 10) as f64;

/// Twice [`INFLATION`].
const CERTAIN_MARGIN: f32 = 1.0 / (1 << 9) as f32;

/// Part of `δ` due to `f32`, relative to the sizes of list and ray.
const OF_F32: f64 = 16.0 / (1 << 24) as f64;

/// Part of `δ` due to the distance of the origin.
const OF_DISTANCE: f64 = 1.0 / (1 << 30) as f64;

/// Inflated square of a radius.
pub(super) fn inflated_r2(radius: f64) -> f32 {
    (radius * radius * (1.0 + INFLATION)) as f32
}

/// A projected ray, with its error bounds.
pub(super) struct ProjectedRay {
    /// Two directions perpendicular to the ray, and that of the ray.
    axes: [[f32; 3]; 3],
    /// Projection of the ray.
    point: [f32; 2],
    /// Error bound of squared distances, `m`.
    margin: f32,
    /// Error bound of distances along the ray.
    slack: f64,
    /// Position of the origin along the ray, from the point nearest to the centre.
    start: f64,
    /// Length of the direction.
    length: f64,
}

/// Two unit vectors at right angles to a unit vector and to each other.
///
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
#[inline(always)]
fn orthonormal_basis(d: DVec3) -> [DVec3; 2] {
    let sign = 1.0f64.copysign(d.z);
    let a = -1.0 / (sign + d.z);
    let b = d.x * d.y * a;
    [DVec3::new(1.0 + sign * d.x * d.x * a, sign * b, -sign * d.x), DVec3::new(b, sign + d.y * d.y * a, -d.y)]
}

#[inline(always)]
fn rounded(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl ProjectedRay {
    /// `None` where the proof does not apply.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, span: Interval, centre: DVec3, size: f64) -> Option<Self> {
        let q = ray.origin - centre;
        let fastest = ray.direction.abs().max_element();
        let farthest = q.abs().max_element();
        let zero = (q + ray.direction) * 0.0;
        let filter_applies = RANGE.contains(&fastest)
            & RANGE.contains(&size)
            & (farthest <= FARTHEST * size)
            & (span.min >= 0.0)
            & (zero.x + zero.y + zero.z == 0.0);
        if !filter_applies {
            return None;
        }
        let length = ray.direction.length();
        let d = ray.direction * (1.0 / length);
        let [u, w] = orthonormal_basis(d);
        let (x, y) = (u.dot(q), w.dot(q));
        let error = OF_F32 * (size + x.abs() + y.abs()) + OF_DISTANCE * farthest;
        Some(Self {
            axes: [rounded(u), rounded(w), rounded(d)],
            point: [x as f32, y as f32],
            margin: (4096.0 * error * error) as f32,
            slack: 2.0 * error,
            start: d.dot(q),
            length,
        })
    }

    /// Bounds of the position of `t` along the ray.
    #[inline(always)]
    pub(super) fn interval_at(&self, t: f64) -> [f32; 2] {
        let position = self.start + t * self.length;
        let slack = self.slack + position.abs() * (1.0 / (1 << 23) as f64);
        [(position - slack) as f32, (position + slack) as f32]
    }

    /// Coordinates of the centres along an axis, added to `from`.
    #[inline(always)]
    fn project<S: Simd>(&self, simd: S, block: &Block, axis: usize, from: S::F32x8) -> S::F32x8 {
        let [x, y, z] = self.axes[axis];
        let [xs, ys, zs] = &block.centres;
        let sum = simd.mul_add(simd.splat(x), simd.load(xs), from);
        simd.mul_add(simd.splat(z), simd.load(zs), simd.mul_add(simd.splat(y), simd.load(ys), sum))
    }

    /// Squared distances from the ray less the squared radii, `ρ² − k`.
    #[inline(always)]
    pub(super) fn distance_excess<S: Simd>(&self, simd: S, block: &Block) -> S::F32x8 {
        let x = self.project(simd, block, 0, simd.splat(-self.point[0]));
        let y = self.project(simd, block, 1, simd.splat(-self.point[1]));
        simd.mul_add(y, y, simd.mul_sub(x, x, simd.load(&block.inflated_r2)))
    }

    /// Blocks, of up to 64, in which the line of the ray may hit a sphere. Branch-free, so that no branch is mispredicted
    /// and the numbers of the ray stay in registers.
    #[inline(always)]
    pub(super) fn hit_blocks<S: Simd>(&self, simd: S, blocks: &[Block]) -> u64 {
        let mut bits = 0;
        for (at, block) in blocks.iter().enumerate() {
            let hit = self.hit_by_line(simd, self.distance_excess(simd, block));
            bits |= u64::from(hit != 0) << (at & 63);
        }
        bits
    }

    /// Spheres that the line of the ray may hit.
    #[inline(always)]
    pub(super) fn hit_by_line<S: Simd>(&self, simd: S, excess: S::F32x8) -> u32 {
        simd.le(excess, simd.splat(self.margin))
    }

    /// Spheres that may be hit between two positions along the ray.
    #[inline(always)]
    pub(super) fn possible_hits<S: Simd>(&self, simd: S, block: &Block, [begin, end]: [f32; 2]) -> u32 {
        let excess = self.distance_excess(simd, block);
        let middle = self.project(simd, block, 2, simd.splat(0.0));
        let longest = simd.sqrt(simd.max(simd.sub(simd.splat(self.margin), excess), simd.splat(0.0)));
        let [first, last] = [simd.sub(middle, longest), simd.add(middle, longest)];
        self.hit_by_line(simd, excess) & simd.le(first, simd.splat(end)) & simd.le(simd.splat(begin), last)
    }

    /// Spheres whose first hit is certainly between two positions along the ray.
    #[inline(always)]
    pub(super) fn certain_hits<S: Simd>(&self, simd: S, block: &Block, [begin, end]: [f32; 2]) -> u32 {
        let excess = self.distance_excess(simd, block);
        let middle = self.project(simd, block, 2, simd.splat(0.0));
        let margin = simd.splat(self.margin);
        let max_excess =
            simd.add(simd.mul_add(simd.splat(CERTAIN_MARGIN), simd.load(&block.inflated_r2), margin), excess);
        let shortest = simd.sqrt(simd.max(simd.sub(simd.splat(0.0), max_excess), simd.splat(0.0)));
        let longest = simd.sqrt(simd.max(simd.sub(margin, excess), simd.splat(0.0)));
        let [first, last] = [simd.sub(middle, longest), simd.sub(middle, shortest)];
        simd.le(max_excess, simd.splat(0.0)) & simd.le(simd.splat(begin), first) & simd.le(last, simd.splat(end))
    }
}
