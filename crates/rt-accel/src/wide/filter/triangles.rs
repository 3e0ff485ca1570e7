//! Leaves of triangles: the edge functions of the watertight test, in `f32` with an error margin.
//!
//! # Why the filter is conservative
//!
//! Let `v = 2⁻²⁴`, and let `A` be the maximum coordinate of the origin. Let `e` be the maximum extent of a triangle of
//! the leaf along an axis. Let `Z` be the depth of the first vertex along the packet's axis, from the origin. In the
//! space of the ray ([`WatertightRay`](rt_geometry::WatertightRay)) edges are no longer than `(1 + s)e = 2⅛e`. Shears
//! are at most `s = 9/8`: the axis of a packet is that of its first ray ([`MAX_SHEAR`]).
//!
//! **Two kinds of errors.** Rounding the origin and the shear shifts all three vertices alike, by `σ ≤ (1 + s)v·A +
//! s·v·|Z|`. All other errors are independent. Differences, products and sums are each rounded, and are no greater than
//! the vertices in ray space and `s·(|Z| + e)`. The shear is off by `s·v·e` more from vertex to vertex. For vertices
//! within `r` of the ray, all this together is at most `ε = v(3s|Z| + 4s·e + 2r) = v(3⅜|Z| + 4½e + 2r)`.
//!
//! **Effect on an edge function.** The shift changes it by at most `2σ·2⅛e`, the product of the shift and the edge. The
//! independent errors and the rounding of the function itself change it by at most `i = 4r·ε + 2ε² + 4v·r²`. If the ray
//! hits the triangle, the vertices lie within `r = 2⅛e + σ` of it, shifted; `CLOSE` makes it `r = 2⅜e`, as computed.
//! With either, and as the computed `|Z|` is itself off by `v·A`, all changes are at most
//!
//! ```text
//!   9.1 v·e·A + 37 v·e·|Z| + 111 v·e² + (38 |Z|² + 29 A|Z|)v² + 83 v³·A²
//!     <   m = 10 v·e·A + 44 v·e·|Z| + 120 v·e² + (64 |Z|² + 32 A|Z|)v² + 96 v³·A²
//! ```
//!
//! with a twentieth of `m` to spare. The last three terms matter for triangles so small that `σ` is greater than `e`.
//!
//! **Misses.** If the ray hits the triangle, the exact functions are all at least 0 or all at most 0. The computed ones
//! are then all at least `−m`, or all at most `m`.
//!
//! **Hits.** If the vertices lie within `2⅜e` and all three functions are at least `m` or at most `−m`, their signs are
//! exact. So are those of the `f64` kernel, whose vertices are much more accurate. They are also certain there. The
//! functions are at least `m/20`, or eight ninths of that along the kernel's own axis. Rounding changes them by less
//! than `2⁻⁴⁶·e²`. Their sum is at least `2/15·m`, which is more than `2⁻²²·e(|Z| + e)`, and the bound of that rounding
//! ([`edge_error`](rt_geometry::WatertightRay::edge_error)) less than `2⁻⁴⁴·e(|Z| + e)`. So the weights are accurate as well
//! ([`MIN_DETERMINANT`](rt_geometry::WatertightRay::MIN_DETERMINANT)).
//!
//! **Bounds of `t`.** True weights are between 0 and 1, so errors of the functions by `i` change the depth by at most
//! `5i·e/|det|`, with the computed determinant. The shift of the ray changes it by the product of the shift and the
//! triangle's normal, over the true determinant. The components of the normal are at most `e²`, so that the change is
//! at most `3v·e²(A + s|Z| + s·e)/|det|`. There `|det|` is less than the computed one by a factor of at most
//! `(m − i)/m`, and `m − i` is at least `v·e(10A + 11|Z| + 9½e)`. So it is at most `⅜m·e/|det|` of the computed one.
//! Rounding the weighted mean adds less than `v(8|Z| + 16e)`. The padded bounds contain the true hit, and their slab
//! test is off by some 2⁻⁵³ of `t`, which is far less.
//!
//! **Rounded vertices**, relative to a centre, are off by `v·G` each, where `G` is their maximum coordinate, and move
//! by `δ ≤ 2⅛v·G` in ray space, independently. `e` is the extent of the rounded triangle, for which all of the above
//! holds. The exact functions differ from its functions by at most `4(2⅜e + δ + σ + ε)δ + 2δ²`. Where the ray hits the
//! exact triangle, `r` is greater by `δ`, which adds hardly more than `4ε·δ`. Together that is less than the growth of
//! `m` if `|Z| + G` replaces `|Z|`.
//!
//! **Tiny triangles.** Products of edges may lose digits below 2⁻¹²⁶. An example is a triangle of 10⁻¹⁵ at the origin
//! of its coordinates with a ray that starts nearby. `m` includes 2⁻⁸⁰ more, which dwarfs that.
//!
//! **Huge triangles.** No value leaves the range of `f32`: rays and trees that might are not filtered
//! ([`RANGE`](crate::wide::ray::RANGE), [`FARTHEST`](crate::wide::ray::FARTHEST)).
//!
//! **Other primitives** have NaN vertices: they are neither certainly missed nor certainly hit.

use glam::DVec3;
use rt_geometry::Hit;
use rt_math::Interval;

use super::leaf_test::{HitBounds, LeafTest};
use crate::wide::WideBvh;
use crate::wide::coherence::MAX_SHEAR;
use crate::wide::exact_triangle::LeafTriangle;
use crate::wide::f64x8::{F64x8, relative as relative_to};
use crate::wide::leaf::{
    Lane, LeafView, TRIANGLE_HEADER, TRIANGLE_NUMBERS, corner, load_coordinates, splat_coordinates,
};
use crate::wide::packet_triangles;
use crate::wide::ray::{RayF32, max_lane, round_up};
use crate::wide::ray_f64::{AXES, RayF64};
use crate::wide::ray_packet::RayPacket;
use crate::wide::simd::Simd;
use crate::wide::t_range::{FilterTRange, SpanLanes};

/// Relative error of one rounding.
const V: f32 = 1.0 / (1 << 24) as f32;

/// Maximum distance of a vertex from the ray for a certain result, in maximum extents.
const CLOSE: f32 = 1.25 + MAX_SHEAR as f32;

/// Terms of the margin: of `e·A`, `e·|Z|`, `e²`, `A·|Z|`, `Z²` and `A²`.
const OF_REACH: f32 = 10.0 * V;
const OF_DEPTH: f32 = 44.0 * V;
const OF_EXTENT: f32 = 120.0 * V;
const OF_REACH_AND_DEPTH: f32 = 32.0 * V * V;
const OF_DEPTH_SQUARED: f32 = 64.0 * V * V;
const OF_REACH_SQUARED: f32 = 96.0 * V * V * V;

/// Added to the margin: tiny triangles, whose edge products may lose digits or vanish, are uncertain.
const MIN_MARGIN: f32 = 1.0 / (1u128 << 80) as f32;

/// The watertight test with three results. Leaves of `EXACT` copies are also intersected exactly.
#[derive(Clone, Copy)]
pub(in crate::wide) struct TriangleTest<const EXACT: bool> {
    /// In the order x, y, z of the ray's space.
    origin: [f32; 4],
    /// Last of the axes.
    axis: usize,
    /// Shear of x and y.
    shear: [f32; 4],
    scale: f32,
    /// Maximum coordinate of the origin.
    reach: f32,
    span: FilterTRange,
}

/// Triangles in lanes: coordinates of their vertices in the order of the axes of the ray.
struct TriangleLanes<S: Simd> {
    x: [S::F32x8; 3],
    y: [S::F32x8; 3],
    z: [S::F32x8; 3],
    /// Maximum extent of a triangle along an axis.
    extent: f32,
    /// Maximum coordinate if they are rounded, otherwise 0.
    rounded: f32,
}

/// One ray in all lanes, or a coherent packet.
pub(in crate::wide) struct TriangleRays<S: Simd> {
    origin: [S::F32x8; 3],
    shear: [S::F32x8; 2],
    scale: S::F32x8,
    reach: S::F32x8,
    span: SpanLanes<S>,
}

impl<S: Simd> TriangleRays<S> {
    #[inline(always)]
    fn test(&self, simd: S, triangles: &TriangleLanes<S>, t_max: S::F32x8, mask: u32) -> HitBounds<S> {
        let z = relative(simd, triangles.z, self.origin[2]);
        let x = sheared(simd, relative(simd, triangles.x, self.origin[0]), z, self.shear[0]);
        let y = sheared(simd, relative(simd, triangles.y, self.origin[1]), z, self.shear[1]);

        let extent = triangles.extent;
        let depth = simd.add(simd.abs(z[0]), simd.splat(triangles.rounded));
        let of_depth = simd.mul_add(self.reach, simd.splat(OF_REACH_AND_DEPTH), simd.splat(OF_DEPTH * extent));
        let of_depth = simd.mul_add(depth, simd.splat(OF_DEPTH_SQUARED), of_depth);
        let independent = simd.mul_add(depth, of_depth, simd.splat(OF_EXTENT * extent * extent + MIN_MARGIN));
        let of_reach = simd.mul_add(self.reach, simd.splat(OF_REACH_SQUARED), simd.splat(OF_REACH * extent));
        let margin = simd.mul_add(self.reach, of_reach, independent);

        let u = edge_function(simd, [x[2], y[2]], [x[1], y[1]]);
        let v = edge_function(simd, [x[0], y[0]], [x[2], y[2]]);
        let w = edge_function(simd, [x[1], y[1]], [x[0], y[0]]);
        let min_uvw = simd.min(simd.min(u, v), w);
        let max_uvw = simd.max(simd.max(u, v), w);
        let negative = simd.sub(simd.splat(0.0), margin);
        // False for NaN.
        let quick_reject = simd.lt(min_uvw, negative) & simd.lt(margin, max_uvw);
        let possible = !quick_reject & mask;
        if possible == 0 {
            return HitBounds { possible, certain: 0, t_min: u, t_max: u };
        }

        let is_close = simd.le(simd.max(farthest(simd, x), farthest(simd, y)), simd.splat(CLOSE * extent));
        let inside = is_close & (simd.le(margin, min_uvw) | simd.le(max_uvw, negative)) & possible;

        let determinant = simd.add(simd.add(u, v), w);
        let inverse = simd.div(simd.splat(1.0), determinant);
        let weighted = simd.mul_add(v, simd.sub(z[1], z[0]), simd.mul(w, simd.sub(z[2], z[0])));
        let t = simd.mul(simd.mul_add(weighted, inverse, z[0]), self.scale);
        let size = simd.abs(self.scale);
        let farthest = simd.mul_add(depth, simd.splat(8.0 * V), simd.splat(extent));
        let of_functions = simd.mul_add(independent, simd.splat(5.0), simd.mul(margin, simd.splat(0.375)));
        let of_weights = simd.mul(of_functions, simd.abs(inverse));
        let of_rounding = simd.mul(simd.mul_add(depth, simd.splat(8.0 * V), simd.splat(16.0 * V * extent)), size);
        let error = simd.mul_add(of_weights, simd.mul(farthest, size), of_rounding);
        let (near, far) = (simd.sub(t, error), simd.add(t, error));

        let is_in_front = simd.le(self.span.min[1], near);
        let is_in_time = simd.le(far, self.span.max);
        let is_not_before = simd.le(self.span.min[0], far);
        let is_not_after = simd.le(near, t_max);
        let possible = possible & (!inside | (is_not_before & is_not_after));
        HitBounds { possible, certain: inside & possible & is_in_front & is_in_time, t_min: near, t_max: far }
    }
}

/// Vertices relative to the origin, along one axis.
#[inline(always)]
fn relative<S: Simd>(simd: S, positions: [S::F32x8; 3], origin: S::F32x8) -> [S::F32x8; 3] {
    [simd.sub(positions[0], origin), simd.sub(positions[1], origin), simd.sub(positions[2], origin)]
}

/// Vertices sheared along the ray.
#[inline(always)]
fn sheared<S: Simd>(simd: S, across: [S::F32x8; 3], along: [S::F32x8; 3], shear: S::F32x8) -> [S::F32x8; 3] {
    [
        simd.neg_mul_add(shear, along[0], across[0]),
        simd.neg_mul_add(shear, along[1], across[1]),
        simd.neg_mul_add(shear, along[2], across[2]),
    ]
}

/// Twice the area between ray and edge.
#[inline(always)]
fn edge_function<S: Simd>(simd: S, from: [S::F32x8; 2], to: [S::F32x8; 2]) -> S::F32x8 {
    simd.mul_sub(from[0], to[1], simd.mul(from[1], to[0]))
}

/// Maximum absolute value of three numbers.
#[inline(always)]
fn farthest<S: Simd>(simd: S, p: [S::F32x8; 3]) -> S::F32x8 {
    simd.max(simd.max(simd.abs(p[0]), simd.abs(p[1])), simd.abs(p[2]))
}

impl<const EXACT: bool> LeafTest for TriangleTest<EXACT> {
    const HEADER: usize = TRIANGLE_HEADER;
    const NUMBERS: usize = TRIANGLE_NUMBERS;

    #[inline(always)]
    fn is_exact(leaf: LeafView<'_>, lane: Lane) -> bool {
        // SAFETY: the first number, and the lane is less than 8.
        EXACT && !unsafe { leaf.number(TRIANGLE_HEADER + lane.index()) }.is_nan()
    }

    #[inline(always)]
    fn new<S: Simd>(simd: S, ray: &RayF64<'_, S>, _: &RayF32, span: FilterTRange, tree: &WideBvh) -> Self {
        let centre = if EXACT { DVec3::ZERO } else { tree.centre };
        let origin = simd.sub_f64(ray.lanes.origin, simd.f64x4([centre.x, centre.y, centre.z, 0.0]));
        Self {
            origin: simd.to_f32(simd.rotate_axis_last(origin, ray.axis)),
            axis: ray.axis,
            shear: simd.to_f32(ray.shear),
            scale: ray.scale as f32,
            reach: round_up(max_lane(simd, simd.abs_f64(origin))),
            span,
        }
    }

    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S> {
        let [x, y, z] = AXES[self.axis & 3];
        // SAFETY: the leaves are of triangles, with two header words, and the axes are from the table.
        let triangles = unsafe {
            TriangleLanes {
                x: load_coordinates(simd, leaf, x),
                y: load_coordinates(simd, leaf, y),
                z: load_coordinates(simd, leaf, z),
                extent: leaf.number(0),
                rounded: if EXACT { 0.0 } else { leaf.number(1) },
            }
        };
        let ray = TriangleRays {
            origin: [simd.splat(self.origin[0]), simd.splat(self.origin[1]), simd.splat(self.origin[2])],
            shear: [simd.splat(self.shear[0]), simd.splat(self.shear[1])],
            scale: simd.splat(self.scale),
            reach: simd.splat(self.reach),
            span: self.span.splat(simd),
        };
        ray.test(simd, &triangles, simd.splat(t_max), leaf.mask())
    }

    type Packet<S: Simd> = ([usize; 3], TriangleRays<S>);

    #[inline(always)]
    fn packet<S: Simd>(simd: S, rays: &RayPacket<S>, tree: &WideBvh) -> Self::Packet<S> {
        let origin = relative_to(simd, rays.soa.origin, if EXACT { DVec3::ZERO } else { tree.centre });
        let [x, y, z] = rays.axes.map(|axis| axis % 3);
        let scale = rays.soa.inverse[z];
        let lanes = TriangleRays {
            origin: [origin[x].to_f32(simd), origin[y].to_f32(simd), origin[z].to_f32(simd)],
            shear: [
                rays.soa.direction[x].mul(simd, scale).to_f32(simd),
                rays.soa.direction[y].mul(simd, scale).to_f32(simd),
            ],
            scale: scale.to_f32(simd),
            reach: RayPacket::reach(simd, origin),
            span: rays.span,
        };
        ([x, y, z], lanes)
    }

    #[inline(always)]
    fn test_packet<S: Simd>(
        simd: S,
        (axes, rays): &Self::Packet<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        t_max: S::F32x8,
    ) -> HitBounds<S> {
        // SAFETY: as in `test`; `packet` has reduced the axes modulo 3.
        let triangle = unsafe {
            TriangleLanes {
                x: splat_coordinates(simd, leaf, lane, axes[0]),
                y: splat_coordinates(simd, leaf, lane, axes[1]),
                z: splat_coordinates(simd, leaf, lane, axes[2]),
                extent: leaf.number(0),
                rounded: if EXACT { 0.0 } else { leaf.number(1) },
            }
        };
        rays.test(simd, &triangle, t_max, 0xff)
    }

    #[inline(always)]
    fn exact_hit<S: Simd, const CERTAIN: bool>(
        simd: S,
        leaf: LeafView<'_>,
        lane: Lane,
        ray: &RayF64<'_, S>,
        span: Interval,
    ) -> Option<Hit> {
        // SAFETY: the leaves of this test are of triangles.
        unsafe { LeafTriangle::new(leaf, lane, Self::index(leaf, lane)) }.hit::<S, CERTAIN>(simd, ray, span)
    }

    #[inline(always)]
    fn exact_packet_hits<S: Simd>(simd: S, leaf: LeafView<'_>, lane: Lane, rays: &RayPacket<S>) -> [F64x8<S>; 3] {
        // SAFETY: the leaves of this test are of triangles.
        let vertices = [0, 1, 2].map(|vertex| unsafe { corner(leaf, lane, vertex) }.map(f64::from).into());
        packet_triangles::resolve_certain(simd, &vertices, rays.axes, &rays.soa)
    }
}

#[cfg(test)]
mod tests {
    use crate::{brute_force, wide::leaf::LeafKind, wide::query::TravRay};
    use rt_geometry::NoProbe;
    use rt_math::Ray;
    use rt_math::random::{hash, unit};

    use super::*;
    use crate::wide::SimdLevel;
    use crate::wide::coherence::are_coherent;
    use crate::wide::f64x8::PACKET;
    use crate::wide::facets::Facets;
    use crate::wide::ray_soa::RaySoa8;
    use crate::wide::simd::{DetectedSimd, WithSimd};

    /// Number of certain hits, of certain misses, and of uncertain results.
    type Counts = [u32; 3];

    struct Bracketed<'a>(&'a WideBvh, &'a Facets, &'a mut Counts);

    impl Bracketed<'_> {
        fn check(&mut self, ray: &Ray, span: Interval, possible: bool, certain: bool, near: f32, far: f32) {
            let hit = brute_force::closest(self.1, ray, span, &mut NoProbe);
            self.2[if certain { 0 } else { 1 + usize::from(possible) }] += 1;
            assert!(possible || hit.is_none(), "missed: {hit:?}, {ray:?}, {:?}", self.1.0);
            if certain {
                let t = hit.map_or(f64::NAN, |hit| hit.t);
                assert!(f64::from(near) <= t && t <= f64::from(far), "{near}, {t}, {far}: {ray:?}, {:?}", self.1.0);
            }
        }

        #[inline(always)]
        fn compare<S: Simd, const EXACT: bool>(&mut self, simd: S, rays: &[(Ray, Interval); PACKET]) {
            let tree = self.0;
            let soa = RaySoa8::new(simd, rays);
            let Some(across) = RayPacket::new(simd, tree, soa).filter(|_| are_coherent(simd, soa.direction, PACKET))
            else {
                return;
            };
            // SAFETY: the root of a tree is one of its nodes, and the first child of this one is its only leaf.
            let leaf = unsafe { tree.leaves.view(tree.node(tree.root).children[0]) };
            let filter = TriangleTest::<EXACT>::packet(simd, &across, tree);
            let together = TriangleTest::<EXACT>::test_packet(simd, &filter, leaf, Lane::new(0), across.t_max);
            let (near, far) = (simd.to_array(together.t_min), simd.to_array(together.t_max));
            for (i, (ray, span)) in rays.iter().enumerate() {
                let (possible, certain) = (together.possible >> i & 1 != 0, together.certain >> i & 1 != 0);
                self.check(ray, *span, possible, certain, near[i], far[i]);
                let trav = TravRay::<S, TriangleTest<EXACT>>::new(simd, tree, ray, *span);
                let alone = trav.expect("proven with the others").leaf_test.test(simd, leaf, round_up(span.max));
                let (near, far) = (simd.to_array(alone.t_min)[0], simd.to_array(alone.t_max)[0]);
                self.check(ray, *span, alone.possible & 1 != 0, alone.certain & 1 != 0, near, far);
            }
        }
    }

    impl WithSimd<&[(Ray, Interval); PACKET], ()> for Bracketed<'_> {
        #[inline(always)]
        fn run<S: Simd>(mut self, simd: S, rays: &[(Ray, Interval); PACKET], (): ()) {
            match self.0.leaves.kind {
                LeafKind::Watertight => self.compare::<S, true>(simd, rays),
                _ => self.compare::<S, false>(simd, rays),
            }
        }
    }

    /// Triangles of all sizes at all distances, and rays to their insides and next to their edges and corners. Packets
    /// are not along the axis of each ray.
    #[test]
    fn filters_rule_out_what_is_missed_and_bracket_what_is_hit() {
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            let mut counts = Counts::default();
            for case in 0..6000 {
                let at = |k: u64| 2.0 * unit(hash(&[case, k])) - 1.0;
                let point = |k: u64| DVec3::new(at(k), at(k + 1), at(k + 2));
                let pick = |k: u64, from: &[f64]| from[(hash(&[case, k]) % from.len() as u64) as usize];
                let size = pick(1, &[1.0, 1e-2, 1e-4, 1e-6]);
                let flat = DVec3::new(1.0, 1.0, pick(2, &[1.0, 1e-3, 0.0]));
                let corner = point(3) * pick(4, &[0.0, 1.0, 10.0, 1e4]);
                let facet = [0, 3, 6].map(|k| (corner + point(10 + k) * flat * size).as_vec3());
                let facets = Facets(vec![facet]);
                let Ok(tree) = WideBvh::build(&facets) else { continue };
                let way =
                    [DVec3::X, DVec3::Z, DVec3::new(1.0, 1.0, 0.1), DVec3::ONE][case as usize % 4] + point(30) * 0.1;
                let distance = pick(5, &[1e-6, 1e-3, 1.0, 100.0]) * pick(6, &[1.0, size]);
                let spread = pick(7, &[0.0, 1e-3, 0.04]);
                let rays = core::array::from_fn(|lane| {
                    let k = 40 + 20 * lane as u64;
                    // On the triangle, or on one of its edges, or next to it.
                    let v = pick(k, &[0.0, 1e-6, 0.3, 0.5, 0.999_999, -1e-6]);
                    let w = pick(k + 1, &[0.0, 1e-6, 0.3, 0.4]);
                    let [a, b, c] = facet.map(|vertex| vertex.as_dvec3());
                    let target = a + (b - a) * v + (c - a) * w;
                    let direction = (way + point(k + 2) * spread) * pick(k + 5, &[1.0, 0.3]);
                    (Ray::new(target - direction * distance * (1.0 + at(k + 6)), direction), Interval::FORWARD)
                });
                DetectedSimd::new(level).dispatch(Bracketed(&tree, &facets, &mut counts), &rays, ());
            }
            assert!(counts.iter().all(|count| *count > 4000), "{}: {counts:?}", level.name());
        }
    }
}
