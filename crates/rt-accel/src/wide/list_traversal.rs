//! Streams of rays of any directions against all triangles of a small tree.
//!
//! The filter leaves for each ray the three triangles that it may hit first. Most rays start on one of them and leave it. The
//! first of the others is intersected exactly, eight rays with a triangle each. That is the result if all others are
//! certainly hit later. The few remaining rays stay open, for a traversal of the tree.
//!
//! Two halves of a quadrilateral share most of the filter. They give one key, that of the half that the ray may hit. A ray that may hit
//! both stays open.

use rt_geometry::{Hit, HitStream, RayStream};
use rt_math::float::UNIT_ROUNDOFF;

use super::WideBvh;
use super::coherence::{are_coherent, are_in_octant, first_octant};
use super::f64x8::{F64x8, PACKET};
use super::list_filter::FilterRays;
use super::packet_triangles::intersect_each;
use super::query::Output;
use super::ray_soa::{PacketHit, RaySoa8};
use super::simd::{DetectedSimd, Simd, WithSimd, take_lane};
use super::stream_rays::N_PACKETS;
use super::triangle_list::{ListOther, ListTriangle, MAX_TRIANGLES, NORMAL_ERROR, TriangleList};

/// Last bits of a key: the number of a triangle. The others are those of a lower bound of `t`.
const NUMBER: u32 = MAX_TRIANGLES as u32 - 1;

/// Error bound of heights per product of normal and vertex: a difference, a product, two sums, and the normal.
const HEIGHT_ERROR: f64 = 4.0 * UNIT_ROUNDOFF + NORMAL_ERROR;

/// Moves the planes of boxes apart by a little more than the roundings of [`Aabb::clip`](rt_math::Aabb::clip).
const BOX_SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// The three first triangles of each ray by their keys, infinite for none.
struct NearestTriangles<S: Simd> {
    keys: [S::F32x8; 3],
    /// A bit for each ray that certainly hits a triangle.
    certain: u32,
    /// A bit for each ray that may hit both triangles of a pair, next to their common edge. One of them is not among the keys.
    ambiguous: u32,
}

/// Lower bound of `t` in a key.
#[inline(always)]
fn t_min<S: Simd>(simd: S, key: S::F32x8) -> S::F32x8 {
    simd.replace_bits(key, NUMBER, 0)
}

/// Inserts a key into the three smallest.
#[inline(always)]
fn insert<S: Simd>(simd: S, [first, second, third]: &mut [S::F32x8; 3], key: S::F32x8) {
    let other = simd.max(*first, key);
    *first = simd.min(*first, key);
    *third = simd.min(*third, simd.max(*second, other));
    *second = simd.min(*second, other);
}

/// Triangles of keys, the first for a key of none.
#[inline(always)]
fn triangles<S: Simd>(simd: S, list: &[ListTriangle], keys: S::F32x8) -> Option<[&ListTriangle; PACKET]> {
    let first = list.first()?;
    let keys = simd.to_array(keys);
    let mut triangles = [first; PACKET];
    for (triangle, key) in triangles.iter_mut().zip(keys) {
        *triangle = list.get((key.to_bits() & NUMBER) as usize).unwrap_or(first);
    }
    Some(triangles)
}

/// Builds a number of eight rays from eight triangles. Not by loops over arrays, which would be cleared first.
macro_rules! by_triangle {
    ($simd:expr, $triangles:expr, |$triangle:ident| $number:expr) => {{
        let [a, b, c, d, e, f, g, h] = $triangles;
        macro_rules! number {
            ($of:expr) => {{
                let $triangle = $of;
                $number
            }};
        }
        F64x8::new(
            $simd,
            [number!(a), number!(b), number!(c), number!(d), number!(e), number!(f), number!(g), number!(h)],
        )
    }};
}

/// A bit for each ray that certainly leaves the plane of its triangle, so that the exact test misses.
///
/// The sign of the height is that of a sum with an error bound. The kernel computes `t` with the same sign: next to the plane from
/// the exact side of the origin, and elsewhere by itself. Its determinant has the sign of the slope, and its `t` is that of depths
/// weighted by areas. Their relative error is less than [`WatertightRay::ORIGIN_SIDE_BOUND`](rt_geometry::WatertightRay) for
/// slopes of at least [`min_slope`](super::triangle_list::ListTriangle).
#[inline(always)]
fn leaving<S: Simd>(simd: S, triangles: &[&ListTriangle; PACKET], rays: &RaySoa8<S>, fastest: F64x8<S>) -> u32 {
    let normal = [
        by_triangle!(simd, *triangles, |triangle| triangle.plane.normal[0]),
        by_triangle!(simd, *triangles, |triangle| triangle.plane.normal[1]),
        by_triangle!(simd, *triangles, |triangle| triangle.plane.normal[2]),
    ];
    let x = by_triangle!(simd, *triangles, |triangle| triangle.plane.vertex[0]).sub(simd, rays.origin[0]);
    let y = by_triangle!(simd, *triangles, |triangle| triangle.plane.vertex[1]).sub(simd, rays.origin[1]);
    let z = by_triangle!(simd, *triangles, |triangle| triangle.plane.vertex[2]).sub(simd, rays.origin[2]);
    let min_slope = by_triangle!(simd, *triangles, |triangle| triangle.plane.min_slope[0]);
    let per_distance = by_triangle!(simd, *triangles, |triangle| triangle.plane.min_slope[1]);

    let (of_x, of_y, of_z) = (normal[0].mul(simd, x), normal[1].mul(simd, y), normal[2].mul(simd, z));
    let height = of_x.add(simd, of_y).add(simd, of_z);
    let size = of_x.abs(simd).add(simd, of_y.abs(simd)).add(simd, of_z.abs(simd));
    let error = size.mul(simd, F64x8::splat(simd, HEIGHT_ERROR)).add(simd, F64x8::splat(simd, f64::MIN_POSITIVE));
    let [dx, dy, dz] = rays.direction;
    let slope = normal[0].mul(simd, dx).add(simd, normal[1].mul(simd, dy)).add(simd, normal[2].mul(simd, dz));
    let distance = x.abs(simd).add(simd, y.abs(simd)).add(simd, z.abs(simd));
    let min_slope = min_slope.add(simd, per_distance.mul(simd, distance)).mul(simd, fastest);
    error.lt(simd, height.abs(simd)) & min_slope.lt(simd, slope.abs(simd)) & (height.signs(simd) ^ slope.signs(simd))
}

/// Intersects each ray with its triangle.
#[inline(always)]
fn intersect_candidates<S: Simd>(simd: S, triangles: &[&ListTriangle; PACKET], rays: &RaySoa8<S>) -> PacketHit<S> {
    let (rays, along_x, along_y) = rays.turned(simd);
    let [a, b, c, d, e, f, g, h] = *triangles;
    // Number of the first coordinate by lane: y along x, z along y, and x along z.
    macro_rules! first {
        ($lane:literal) => {
            (along_x >> $lane & 1 | along_y >> $lane << 1 & 2) as usize
        };
    }
    macro_rules! corner {
        ($at:literal) => {
            F64x8::from_f32(
                simd,
                [
                    a.corners[first!(0) + $at],
                    b.corners[first!(1) + $at],
                    c.corners[first!(2) + $at],
                    d.corners[first!(3) + $at],
                    e.corners[first!(4) + $at],
                    f.corners[first!(5) + $at],
                    g.corners[first!(6) + $at],
                    h.corners[first!(7) + $at],
                ],
            )
        };
    }
    let vertices = [
        [corner!(0), corner!(1), corner!(2)],
        [corner!(6), corner!(7), corner!(8)],
        [corner!(12), corner!(13), corner!(14)],
    ];
    intersect_each(simd, &vertices, &rays)
}

/// Tests all triangles of the list.
#[inline(always)]
fn filter<S: Simd, O: Output>(simd: S, list: &TriangleList, rays: &FilterRays<S>) -> NearestTriangles<S> {
    let none = simd.splat(f32::INFINITY);
    let mut nearest = [none; 3];
    let (mut certain, mut ambiguous) = (simd.splat(-1.0), simd.splat(-1.0));
    let mut number = 0;
    for pair in &list.pairs {
        let hits = rays.test_pair(simd, pair);
        let [first, second] = hits.possible;
        let key = simd.replace_bits(hits.t_min, NUMBER, number);
        let key = simd.select_by_sign_f32(first, key, none);
        let of_second = simd.replace_bits(hits.t_min, NUMBER, number + 1);
        insert(simd, &mut nearest, simd.select_by_sign_f32(second, of_second, key));
        ambiguous = simd.max(ambiguous, simd.min(first, second));
        if O::ANY_HIT {
            certain = simd.max(certain, hits.certain);
        }
        number += 2;
    }
    for triangle in &list.filters {
        let hits = rays.test(simd, triangle);
        let key = simd.replace_bits(hits.t_min, NUMBER, number);
        insert(simd, &mut nearest, simd.select_by_sign_f32(hits.possible, key, none));
        if O::ANY_HIT {
            certain = simd.max(certain, hits.certain);
        }
        number += 1;
    }
    let zero = simd.splat(0.0);
    NearestTriangles {
        keys: nearest,
        certain: if O::ANY_HIT { simd.lt(zero, certain) } else { 0 },
        ambiguous: simd.le(zero, ambiguous),
    }
}

/// Hits of eight rays with the triangles of a list.
struct ListHits<'l, S: Simd> {
    /// A bit for each ray that hits a triangle: the closest, or any.
    hit: u32,
    /// A bit for each ray without a result.
    open: u32,
    /// Hits of the last exact test; valid for the closest hits.
    exact: Option<ExactHits<'l, S>>,
}

/// A triangle for each of eight rays, and where it is hit.
struct ExactHits<'l, S: Simd> {
    triangles: [&'l ListTriangle; PACKET],
    t: F64x8<S>,
    uv: [F64x8<S>; 2],
}

impl ListOther {
    /// Rays of a mask that cross the padded bounds within their spans.
    #[inline(always)]
    fn crossed<S: Simd>(&self, simd: S, soa: &RaySoa8<S>, mask: u32) -> (u32, F64x8<S>) {
        let (low, high) = (F64x8::splat3(simd, self.bounds.min), F64x8::splat3(simd, self.bounds.max));
        let zero = F64x8::splat(simd, 0.0);
        let [enter, leave] = soa.cross_box(simd, low, high, zero);
        let enter = enter.mul(simd, F64x8::splat(simd, 1.0 - BOX_SLACK)).max(simd, soa.min);
        let leave = leave.mul(simd, F64x8::splat(simd, 1.0 + BOX_SLACK)).min(simd, soa.max);
        // Planes that a ray lies in are no constraint.
        let [x, y, z] = soa.direction;
        let along_planes = x.abs(simd).le(simd, zero) | y.abs(simd).le(simd, zero) | z.abs(simd).le(simd, zero);
        (mask & (along_planes | enter.le(simd, leave)), enter)
    }

    /// Rays of a mask that may hit it before the triangle that they hit.
    #[inline(always)]
    fn may_be_hit<S: Simd>(&self, simd: S, soa: &RaySoa8<S>, mask: u32, hits: &ListHits<'_, S>) -> u32 {
        let (crossed, enter) = self.crossed(simd, soa, mask);
        match &hits.exact {
            Some(exact) => crossed & (!hits.hit | enter.le(simd, exact.t)),
            None => crossed,
        }
    }
}

/// Finds the hits of `all` of eight rays with the triangles of a list.
#[inline(always)]
fn find<'l, S: Simd, O: Output>(
    simd: S,
    tree: &WideBvh,
    list: &'l TriangleList,
    soa: &RaySoa8<S>,
    all: u32,
) -> ListHits<'l, S> {
    let filter_rays = FilterRays::new(simd, soa, tree.centre, tree.size);
    let proven = filter_rays.proven & all;
    if proven == 0 {
        return ListHits { hit: 0, open: all, exact: None };
    }
    let NearestTriangles { keys: [first, second, third], certain, ambiguous } =
        filter::<S, O>(simd, list, &filter_rays);
    let undecided = ambiguous & !certain;
    let active = proven & !certain & !undecided;
    let none = simd.splat(f32::INFINITY);

    // Skip the triangles that rays start on and leave.
    let (mut candidate, mut next) = (first, second);
    let starts_at = active & simd.le(t_min(simd, first), filter_rays.min[1]);
    if starts_at != 0
        && let Some(of_rays) = triangles(simd, &list.triangles, first)
    {
        let leaving = starts_at & leaving(simd, &of_rays, soa, filter_rays.fastest);
        candidate = simd.select(leaving, second, first);
        next = simd.select(leaving, third, second);
    }

    let mut exact = None;
    let (mut hit, mut open) = (0, 0);
    let possible = active & simd.lt(candidate, none);
    if possible != 0
        && let Some(triangles) = triangles(simd, &list.triangles, candidate)
    {
        let PacketHit { hit: is_hit, uncertain, t, uv } = intersect_candidates(simd, &triangles, soa);
        let t_max = t.mul(simd, filter_rays.fastest).round_up(simd);
        let is_first = simd.lt(t_max, t_min(simd, next));
        let is_last = simd.le(none, next);
        hit = possible & is_hit & if O::ANY_HIT { 0xff } else { is_first };
        let missed = possible & !is_hit & !uncertain & is_last;
        open = possible & !(hit | missed);
        exact = Some(ExactHits { triangles, t, uv });
    }
    if O::ANY_HIT {
        hit |= certain;
    }
    open |= all & (!proven | undecided);
    ListHits { hit: hit & all & !open, open, exact }
}

/// Traces the incoherent packets of a stream through the list of a tree. A ray that may hit a primitive that is no triangle has no
/// result.
pub(super) struct ListStream<'q> {
    pub(super) tree: &'q WideBvh,
    pub(super) list: &'q TriangleList,
    /// Receives a bit for each ray without a result, by packet.
    pub(super) open: &'q mut [u8; N_PACKETS],
    /// Receives a bit for each coherent packet. Its rays have no result.
    pub(super) coherent: &'q mut u32,
}

impl ListStream<'_> {
    #[inline(always)]
    fn trace<S: Simd, O: Output>(self, simd: S, rays: &RayStream, mut write: impl FnMut(usize, ListHits<'_, S>)) {
        for (packet, open) in self.open.iter_mut().enumerate().take(rays.len().div_ceil(PACKET)) {
            let at = packet * PACKET;
            let n = (rays.len() - at).min(PACKET);
            let all = (1 << n) - 1;
            let soa = RaySoa8::load(simd, rays, at, true);
            // Rays of any directions are rarely in one octant, so that this branch is predicted.
            let octant = first_octant(simd, soa.direction);
            if n == PACKET && are_in_octant(simd, soa.direction, octant) && are_coherent(simd, soa.direction, PACKET) {
                *self.coherent |= 1 << packet;
                continue;
            }
            let mut hits = find::<S, O>(simd, self.tree, self.list, &soa, all);
            for other in &self.list.others {
                if !O::ANY_HIT || other.casts_shadow {
                    let decided = all & !hits.open & if O::ANY_HIT { !hits.hit } else { !0 };
                    hits.open |= other.may_be_hit(simd, &soa, decided, &hits);
                }
            }
            hits.hit &= !hits.open;
            *open = hits.open as u8;
            write(at, hits);
        }
    }
}

/// Queries of a list. Compiled here, and not in every crate that traces rays.
pub(super) trait TriangleListQuery: Output {
    /// Traces a stream. False, without a result, if kernels for lists are not compiled for this level.
    fn trace_list(list: ListStream<'_>, level: DetectedSimd, rays: &RayStream, outputs: &mut Self::OfStream) -> bool;
}

impl TriangleListQuery for Option<Hit> {
    #[inline(never)]
    fn trace_list(list: ListStream<'_>, level: DetectedSimd, rays: &RayStream, hits: &mut HitStream) -> bool {
        level.dispatch_lists(list, rays, hits)
    }
}

impl TriangleListQuery for bool {
    #[inline(never)]
    fn trace_list(list: ListStream<'_>, level: DetectedSimd, rays: &RayStream, occluded: &mut [bool]) -> bool {
        level.dispatch_lists(list, rays, occluded)
    }
}

impl WithSimd<&RayStream, &mut HitStream> for ListStream<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &RayStream, hits: &mut HitStream) {
        self.trace::<S, Option<Hit>>(
            simd,
            rays,
            #[inline(always)]
            |at, ListHits { hit, exact, .. }| {
                let mut primitives = [HitStream::NONE; PACKET];
                if let Some(ExactHits { triangles, t, uv: [v, w] }) = exact {
                    let ([of_v, of_w], mut hit) = (&mut hits.uv, hit);
                    *hits.t.vector_mut(at) = t.to_array(simd);
                    *of_v.vector_mut(at) = v.to_array(simd);
                    *of_w.vector_mut(at) = w.to_array(simd);
                    while hit != 0 {
                        let lane = take_lane(&mut hit);
                        primitives[lane] = triangles[lane].index;
                    }
                }
                *hits.instance.vector_mut(at) = [0; PACKET];
                *hits.primitive.vector_mut(at) = primitives;
            },
        );
    }
}

impl WithSimd<&RayStream, &mut [bool]> for ListStream<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &RayStream, occluded: &mut [bool]) {
        self.trace::<S, bool>(
            simd,
            rays,
            #[inline(always)]
            |at, ListHits { hit, .. }| {
                for (lane, occluded) in occluded.iter_mut().take(rays.len()).skip(at).take(PACKET).enumerate() {
                    *occluded = hit >> lane & 1 == 1;
                }
            },
        );
    }
}
