//! Conservative `f32` test of a triangle, or of two in a plane, with eight rays of any directions.
//!
//! # Why the filter is conservative
//!
//! Positions are relative to the centre of the tree, and directions are scaled so that their maximum component is 1. Let `v = 2⁻²⁴`,
//! let `S` be the size of the tree, and `A` the maximum coordinate of the origin `o`. Let `X = A + S`. Let `n` be the unit
//! normal and `w` its product with a vertex. The plane is crossed at `t = N/D` with `N = w − n·o` and `D = n·d`. Bounds below
//! count roundings of sums of three products as if they were not fused.
//!
//! **`t` of a hit.** Rounding of `n`, `o`, `w` and of the sum changes `N` by at most `16v·X`, and `D` by at most `10v`. A hit
//! lies within the tree, so its true `t` is at most `X`. The computed quotient is off by
//! `(δN + t·δD)/|D| ≤ 26v·X/|D|`, and by two roundings, which are at most `2v·t ≤ 2√3·v·X/|D|` more. So it is off by at most
//! `30v·X·|1/D|`.
//!
//! **Weights of a hit.** The point `p = o + t·d` is then off by at most `30v·X·|1/D|` and `5v·X` for the roundings of `o`, of
//! `d` and of `p`. As `|1/D|` is at least `1/√3`, that is at most `39v·X·|1/D|` on each axis. A weight is the product of
//! `p` and a gradient `g`, plus an offset. It is off by `|g|₁` times this and by `10v·S·|g|₁` for its own roundings: at most
//! `57v·X·|1/D|·|g|₁`. The first of the three weights is 1 minus the others. Its error is the sum of both, and two roundings
//! of at most 3. As `X·|g|₁` is at least ¼ for either gradient, these are less than `21v·X·|1/D|·(|g|₁ + |h|₁)`. So all three
//! weights of a hit are at least `−m`, with `m = 96v·X·|1/D|·(|g|₁ + |h|₁)` ([`EDGE_MARGIN`](FilterTriangle::margin)).
//!
//! **The exact kernel** is off by roundings of `f64`. Its vertices relative to the origin, and therefore its areas, are off by some
//! `16u·X`, with `u = 2⁻⁵³`. No height is less than 2⁻¹² of `S`, and no origin farther than 2¹⁰ of it ([`FARTHEST`]). So its
//! weights are off by less than a millionth of `m`, and its `t` by less than `⅛v·X·|1/D|`.
//!
//! **Rays almost in the plane.** `|1/D|` is limited to 2³⁰. Where that matters, a hit has `|N| ≤ X·(2⁻³⁰ + 26v)`, so that the
//! computed `t` is at most `27v·X·2³⁰`, and the true one is less than `v·X·2³⁰/32`. The bounds above hold with the limit in
//! place of `|1/D|`. No number over- or underflows for the [rays](FilterRays::new) and [triangles](FilterTriangle::new) that the
//! filter applies to. So there is no NaN.
//!
//! **Certain hits.** Let the computed weights be at least `m`, and let `t` be greater than its error bound
//! `48v·X·|1/D|` ([`T_ERROR`]). Then `p` lies within the tree, but for rounding, so that `t` is at most `1.1X`, and
//! `10v·|1/D|` is less than `¼`. The true `t` is off by at most `(16v·X + 1.1X·10v)·|1/D|/(1 − ¼) + 2√3·v·X·|1/D|`, less than the
//! bound. With it, the weights are off by at most `66v·X·|1/D|·|g|₁`, and the first by `21v·X·|1/D|·(|g|₁ + |h|₁)` more. So their
//! signs are those of the true ones, and of those of the kernel.
//! The true hit lies within the padded bounds, and their slab test is off by some 2⁻⁵³ of `t`, which is far less.
//!
//! **Pairs.** The planes of both triangles are equal as stored, so that the bounds of `t` and of `p` hold for both. The greater of
//! the two margins bounds the errors of all weights.

use rt_math::DVec3;

use super::f64x8::{F64x8, max_abs, relative};
use super::ray::RANGE;
use super::ray_soa::RaySoa8;
use super::simd::Simd;
use super::triangle_list::{FilterPair, FilterTriangle};

/// Relative error of one rounding.
const V: f64 = 1.0 / (1 << 24) as f64;

/// Error of `t`, per `X·|1/D|`.
const T_ERROR: f32 = 48.0 * V as f32;

/// Limit of `|1/D|`.
const STEEPEST: f32 = (1 << 30) as f32;

/// Maximum distance of an origin, in sizes of the tree.
const FARTHEST: f64 = (1 << 10) as f64;

/// Eight rays prepared for the filter. Every `t` is that of the scaled direction.
pub(super) struct FilterRays<S: Simd> {
    origin: [S::F32x8; 3],
    direction: [S::F32x8; 3],
    /// `X`
    reach: S::F32x8,
    /// Error of `t`, per `|1/D|`.
    t_error: S::F32x8,
    /// Begin of the spans, rounded down and up.
    pub(super) min: [S::F32x8; 2],
    /// End of the spans, rounded down and up.
    max: [S::F32x8; 2],
    /// Maximum component of the direction.
    pub(super) fastest: F64x8<S>,
    /// A bit for each ray that the filter applies to.
    pub(super) proven: u32,
}

/// Result for eight rays.
pub(super) struct FilterHits<S: Simd> {
    /// Lower bound of `t`, at least 0.
    pub(super) t_min: S::F32x8,
    /// Negative where the triangle is certainly missed.
    pub(super) possible: S::F32x8,
    /// Positive where the triangle is certainly hit.
    pub(super) certain: S::F32x8,
}

/// Result for eight rays and two triangles of a plane.
pub(super) struct FilterPairHits<S: Simd> {
    /// Lower bound of `t`, at least 0.
    pub(super) t_min: S::F32x8,
    /// For each triangle, negative where it is certainly missed.
    pub(super) possible: [S::F32x8; 2],
    /// Positive where one of the triangles is certainly hit.
    pub(super) certain: S::F32x8,
}

/// Points at which eight rays cross a plane.
struct PlaneCrossing<S: Simd> {
    /// Lower bound of `t`, at least 0.
    t_min: S::F32x8,
    point: [S::F32x8; 3],
    /// Error of weights.
    margin: S::F32x8,
    /// Negative where `t` is certainly outside the span.
    in_span: S::F32x8,
    /// Positive where it is certainly inside.
    surely_in_span: S::F32x8,
}

impl<S: Simd> FilterRays<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rays: &RaySoa8<S>, centre: DVec3, size: f64) -> Self {
        let q = relative(simd, rays.origin, centre);
        let [x, y, z] = rays.direction;
        let fastest = max_abs(simd, rays.direction);
        let farthest = max_abs(simd, q);
        // NaN if anything is not finite.
        let sum = q[0].add(simd, q[1]).add(simd, q[2]).add(simd, x).add(simd, y).add(simd, z);
        let zero = F64x8::splat(simd, 0.0);
        let proven = sum.mul(simd, zero).le(simd, zero)
            & zero.le(simd, rays.min)
            & rays.min.le(simd, rays.max)
            & farthest.le(simd, F64x8::splat(simd, FARTHEST * size))
            & F64x8::splat(simd, *RANGE.start()).le(simd, fastest)
            & fastest.le(simd, F64x8::splat(simd, *RANGE.end()));
        let slower = F64x8::splat(simd, 1.0).div(simd, fastest);
        let reach = farthest.add(simd, F64x8::splat(simd, size)).round_up(simd);
        let (min, max) = (rays.min.mul(simd, fastest), rays.max.mul(simd, fastest));
        Self {
            origin: [q[0].to_f32(simd), q[1].to_f32(simd), q[2].to_f32(simd)],
            direction: [
                x.mul(simd, slower).to_f32(simd),
                y.mul(simd, slower).to_f32(simd),
                z.mul(simd, slower).to_f32(simd),
            ],
            reach,
            t_error: simd.mul(reach, simd.splat(T_ERROR)),
            min: [min.round_down(simd), min.round_up(simd)],
            max: [max.round_down(simd), max.round_up(simd)],
            fastest,
            proven,
        }
    }

    /// Tests a triangle.
    #[inline(always)]
    pub(super) fn test(&self, simd: S, triangle: &FilterTriangle) -> FilterHits<S> {
        let plane = self.cross(simd, triangle.plane, triangle.margin);
        let weight = min_weight(simd, [triangle.second, triangle.third], plane.point);
        FilterHits {
            t_min: plane.t_min,
            possible: simd.min(simd.add(weight, plane.margin), plane.in_span),
            certain: simd.min(simd.sub(weight, plane.margin), plane.surely_in_span),
        }
    }

    /// Tests two triangles of one plane.
    #[inline(always)]
    pub(super) fn test_pair(&self, simd: S, pair: &FilterPair) -> FilterPairHits<S> {
        let plane = self.cross(simd, pair.plane, pair.margin);
        let [first, second] = pair.weights;
        let (first, second) = (min_weight(simd, first, plane.point), min_weight(simd, second, plane.point));
        let greater = simd.max(first, second);
        FilterPairHits {
            t_min: plane.t_min,
            possible: [
                simd.min(simd.add(first, plane.margin), plane.in_span),
                simd.min(simd.add(second, plane.margin), plane.in_span),
            ],
            certain: simd.min(simd.sub(greater, plane.margin), plane.surely_in_span),
        }
    }

    /// Crosses a plane, for triangles with this error of a weight per error of a coordinate.
    #[inline(always)]
    fn cross(&self, simd: S, [x, y, z, offset]: [f32; 4], margin: f32) -> PlaneCrossing<S> {
        let (o, d) = (self.origin, self.direction);
        let (x, y, z) = (simd.splat(x), simd.splat(y), simd.splat(z));
        let slope = simd.mul_add(d[2], z, simd.mul_add(d[1], y, simd.mul(d[0], x)));
        let height = simd.neg_mul_add(o[0], x, simd.splat(offset));
        let height = simd.neg_mul_add(o[2], z, simd.neg_mul_add(o[1], y, height));
        let inverse = simd.div(simd.splat(1.0), slope);
        let inverse = simd.max(simd.min(inverse, simd.splat(STEEPEST)), simd.splat(-STEEPEST));
        let steepness = simd.abs(inverse);
        let t = simd.mul(height, inverse);
        let error = simd.mul(steepness, self.t_error);
        let (near, far) = (simd.sub(t, error), simd.add(t, error));
        PlaneCrossing {
            t_min: simd.max(near, simd.splat(0.0)),
            point: [simd.mul_add(t, d[0], o[0]), simd.mul_add(t, d[1], o[1]), simd.mul_add(t, d[2], o[2])],
            margin: simd.mul(simd.mul(self.reach, simd.splat(margin)), steepness),
            in_span: simd.min(simd.sub(far, self.min[0]), simd.sub(self.max[1], near)),
            surely_in_span: simd.min(simd.sub(near, self.min[1]), simd.sub(self.max[0], far)),
        }
    }
}

/// Minimum of the three weights at a point.
#[inline(always)]
fn min_weight<S: Simd>(simd: S, [second, third]: [[f32; 4]; 2], point: [S::F32x8; 3]) -> S::F32x8 {
    let (second, third) = (affine(simd, second, point), affine(simd, third, point));
    let first = simd.sub(simd.sub(simd.splat(1.0), second), third);
    simd.min(simd.min(second, third), first)
}

/// Product of gradient and position, plus an offset.
#[inline(always)]
fn affine<S: Simd>(simd: S, [x, y, z, offset]: [f32; 4], p: [S::F32x8; 3]) -> S::F32x8 {
    let sum = simd.mul_add(p[0], simd.splat(x), simd.splat(offset));
    simd.mul_add(p[2], simd.splat(z), simd.mul_add(p[1], simd.splat(y), sum))
}

#[cfg(test)]
mod tests {
    use rt_geometry::{Hit, WatertightRay, intersect_triangle};
    use rt_math::random::{hash, unit};
    use rt_math::{Interval, Ray, SlabRay, Vec3};

    use super::super::f64x8::PACKET;
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;

    type Rays = [(Ray, Interval); PACKET];

    /// A triangle in a tree of some size around a centre, and the numbers of certain hits, certain misses and others.
    struct Bracketed<'a> {
        vertices: [Vec3; 3],
        centre: DVec3,
        size: f64,
        counts: &'a mut [u32; 3],
    }

    impl WithSimd<&Rays, ()> for Bracketed<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Rays, (): ()) {
            let Some(triangle) = FilterTriangle::new(self.vertices, self.centre, self.size) else { return };
            let filter = FilterRays::new(simd, &RaySoa8::new(simd, rays), self.centre, self.size);
            let hits = filter.test(simd, &triangle);
            let fastest = filter.fastest.to_array(simd);
            let [t_min, possible, certain] =
                [hits.t_min, hits.possible, hits.certain].map(|numbers| simd.to_array(numbers));
            for (lane, (ray, span)) in rays.iter().enumerate() {
                if filter.proven >> lane & 1 == 0 {
                    continue;
                }
                let vertices = self.vertices.map(|vertex| vertex.as_dvec3());
                let hit: Option<Hit> =
                    intersect_triangle(vertices, 0, &SlabRay::new(ray), &WatertightRay::new(ray), *span);
                let text = || format!("{ray:?}, {span:?}, {vertices:?}, {hit:?}");
                if let Some(hit) = hit {
                    assert!(possible[lane] >= 0.0 && f64::from(t_min[lane]) <= hit.t * fastest[lane], "{}", text());
                }
                assert!(certain[lane] <= 0.0 || hit.is_some(), "{}", text());
                let is_certain = [certain[lane] > 0.0, possible[lane] < 0.0];
                self.counts[is_certain.iter().position(|is| *is).unwrap_or(2)] += 1;
            }
        }
    }

    /// Quadrilateral `a`, `b`, `c`, `d` as two triangles, and whether each of eight rays certainly hits one of them, or neither.
    struct BracketedPair<'a> {
        corners: [Vec3; 4],
        size: f64,
        counts: &'a mut [u32; 3],
    }

    impl WithSimd<&Rays, ()> for BracketedPair<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Rays, (): ()) {
            let [a, b, c, d] = self.corners;
            let halves = [[a, b, c], [a, c, d]];
            let filters = halves.map(|vertices| FilterTriangle::new(vertices, DVec3::ZERO, self.size));
            let [Some(first), Some(second)] = filters else { return };
            let Some(pair) = FilterPair::new([(&first, halves[0]), (&second, halves[1])]) else { return };
            let filter = FilterRays::new(simd, &RaySoa8::new(simd, rays), DVec3::ZERO, self.size);
            let hits = filter.test_pair(simd, &pair);
            let fastest = filter.fastest.to_array(simd);
            let [t_min, certain] = [hits.t_min, hits.certain].map(|numbers| simd.to_array(numbers));
            let possible = hits.possible.map(|numbers| simd.to_array(numbers));
            for (lane, (ray, span)) in rays.iter().enumerate() {
                let mut is_hit = false;
                for (half, vertices) in halves.iter().enumerate() {
                    let vertices = vertices.map(|vertex| vertex.as_dvec3());
                    let hit: Option<Hit> =
                        intersect_triangle(vertices, 0, &SlabRay::new(ray), &WatertightRay::new(ray), *span);
                    let Some(hit) = hit else { continue };
                    is_hit = true;
                    let is_bracketed = possible[half][lane] >= 0.0 && f64::from(t_min[lane]) <= hit.t * fastest[lane];
                    assert!(is_bracketed, "{ray:?}, {span:?}, {vertices:?}, {hit:?}");
                }
                assert!(certain[lane] <= 0.0 || is_hit, "{ray:?}, {span:?}, {:?}", self.corners);
                let is_missed = possible[0][lane] < 0.0 && possible[1][lane] < 0.0;
                self.counts[[certain[lane] > 0.0, is_missed].iter().position(|is| *is).unwrap_or(2)] += 1;
            }
        }
    }

    #[test]
    fn pairs_rule_out_what_is_missed_and_bracket_what_is_hit() {
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            let mut counts = [0; 3];
            for case in 0..20_000 {
                let at = |k: u64| 2.0 * unit(hash(&[7, case, k])) - 1.0;
                let point = |k: u64| Vec3::new(at(k) as f32, at(k + 1) as f32, at(k + 2) as f32);
                // Numbers of few digits, so that all four corners lie in one plane.
                let round = |v: Vec3| (v * 16.0).round() / 16.0;
                let (a, u, v) = (round(point(0)), round(point(3)), round(point(6)));
                let corners = [a, a + u, a + u + v * 0.5, a + v];
                let rays = core::array::from_fn(|lane| {
                    let k = 20 + 10 * lane as u64;
                    let pick = |k: u64, from: &[f64]| from[(hash(&[7, case, k]) % from.len() as u64) as usize];
                    // Also to points of the common edge and next to it.
                    let along = corners[0].as_dvec3().lerp(corners[2].as_dvec3(), at(k).abs());
                    let aside = (corners[1] - corners[3]).as_dvec3() * pick(k + 1, &[0.0, 1e-7, -1e-7, 0.2, -0.2, 0.6]);
                    let out = point(k + 2).as_dvec3() + DVec3::splat(1e-3);
                    let distance = pick(k + 5, &[0.1, 1.0, 30.0]);
                    (Ray::new(along + aside - out * distance, out), Interval::FORWARD)
                });
                let bracketed = BracketedPair { corners, size: 4.0, counts: &mut counts };
                DetectedSimd::new(level).dispatch(bracketed, &rays, ());
            }
            assert!(counts.iter().all(|count| *count > 1000), "{}: {counts:?}", level.name());
        }
    }

    /// Rays of any directions from near and far to the insides, edges and corners of triangles, or next to them.
    #[test]
    fn filters_rule_out_what_is_missed_and_bracket_what_is_hit() {
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            let mut counts = [0; 3];
            for case in 0..20_000 {
                let at = |k: u64| 2.0 * unit(hash(&[case, k])) - 1.0;
                let point = |k: u64| DVec3::new(at(k), at(k + 1), at(k + 2));
                let pick = |k: u64, from: &[f64]| from[(hash(&[case, k]) % from.len() as u64) as usize];
                let size = pick(1, &[1.0, 1e-6, 1e6]);
                let centre = point(2) * size * pick(5, &[0.0, 1.0, 50.0]);
                let small = DVec3::ONE * pick(6, &[0.5, 0.5, 0.02]) * size;
                let flat = DVec3::new(1.0, 1.0, pick(7, &[1.0, 1e-2, 0.0]));
                let corner = centre + point(8) * size * 0.4;
                let vertices = [0, 3, 6].map(|k| (corner + point(10 + k) * small * flat).as_vec3());
                let rays = core::array::from_fn(|lane| {
                    let k = 40 + 20 * lane as u64;
                    let v = pick(k, &[0.0, 1e-6, 0.3, 0.5, 0.999_999, -1e-6]);
                    let w = pick(k + 1, &[0.0, 1e-6, 0.3, 0.4, 2.0]);
                    let [a, b, c] = vertices.map(|vertex| vertex.as_dvec3());
                    let target = a + (b - a) * v + (c - a) * w;
                    let along = (b - a) * at(k + 2) + (c - a) * at(k + 3);
                    // At all angles to the plane, also in it.
                    let out = along.normalize_or(DVec3::X) + point(k + 4) * pick(k + 7, &[1.0, 1.0, 1e-3, 1e-6, 0.0]);
                    let distance = size * pick(k + 8, &[1e-14, 1e-6, 0.1, 1.0, 500.0]);
                    let origin = target - out * distance;
                    let span = match hash(&[case, k + 9]) % 4 {
                        0 => Interval::SEGMENT,
                        1 => Interval::new(0.0, distance * pick(k + 10, &[0.999_999, 1.0, 1.000_001])),
                        2 => Interval::new(distance * pick(k + 10, &[0.999_999, 1.0, 1.000_001]), f64::INFINITY),
                        _ => Interval::FORWARD,
                    };
                    (Ray::new(origin, out), span)
                });
                let bracketed = Bracketed { vertices, centre, size, counts: &mut counts };
                DetectedSimd::new(level).dispatch(bracketed, &rays, ());
            }
            assert!(counts.iter().all(|count| *count > 1000), "{}: {counts:?}", level.name());
        }
    }
}
