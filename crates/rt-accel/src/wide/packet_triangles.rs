//! Intersection of eight rays with a triangle: the operations of [`WatertightRay::intersect`] in lanes of `f64`, with the
//! same bits.
//!
//! The scalar test resolves
//!
//! * areas whose signs rounding may have changed, or whose sum is too small to be accurate,
//! * rays that start next to the triangle's plane, unless they certainly leave it, and
//! * hits that depend on the padded bounds (see [`packet_spheres`](super::packet_spheres)).
//!
//! [`resolve_certain`] is for hits that a filter has confirmed ([`leaf`](super::leaf)): all signs are certain, all weights
//! accurate, and the ray hits the padded bounds.

use rt_geometry::WatertightRay;
use rt_math::float::UNIT_ROUNDOFF;
use rt_math::{BOUNDS_PADDING, DVec3};

use super::f64x8::{F64x8, max_abs, sub3};
use super::ray_soa::{INNER_PAD, PacketHit, RaySoa8};
use super::simd::Simd;

/// Relative error bound of a volume as a sum of six rounded products. It is more than the 7 roundings of Shewchuk,
/// "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997.
const VOLUME_ERROR_BOUND: f64 = 16.0 * UNIT_ROUNDOFF;

/// A vertex in the space of the rays.
#[derive(Clone, Copy)]
pub(super) struct RaySpaceVertex<S: Simd> {
    pub(super) x: F64x8<S>,
    pub(super) y: F64x8<S>,
    /// Distance from the origin along the main axis.
    pub(super) z: F64x8<S>,
    /// The same as a parameter of the ray.
    depth: F64x8<S>,
}

/// Axes and shear of the space of the rays.
pub(super) struct Shear<S: Simd> {
    axes: [usize; 3],
    x: F64x8<S>,
    y: F64x8<S>,
    scale: F64x8<S>,
}

impl<S: Simd> Shear<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, [x, y, z]: [usize; 3], rays: &RaySoa8<S>) -> Self {
        let scale = rays.inverse[z];
        Self { axes: [x, y, z], x: rays.direction[x].mul(simd, scale), y: rays.direction[y].mul(simd, scale), scale }
    }

    #[inline(always)]
    pub(super) fn in_ray_space(&self, simd: S, rays: &RaySoa8<S>, corner: DVec3) -> RaySpaceVertex<S> {
        self.lanes_in_ray_space(simd, rays, &F64x8::splat3(simd, corner))
    }

    #[inline(always)]
    fn lanes_in_ray_space(&self, simd: S, rays: &RaySoa8<S>, corner: &[F64x8<S>; 3]) -> RaySpaceVertex<S> {
        let [x, y, z] = self.axes;
        let x = corner[x].sub(simd, rays.origin[x]);
        let y = corner[y].sub(simd, rays.origin[y]);
        let z = corner[z].sub(simd, rays.origin[z]);
        RaySpaceVertex {
            x: x.sub(simd, self.x.mul(simd, z)),
            y: y.sub(simd, self.y.mul(simd, z)),
            z,
            depth: z.mul(simd, self.scale),
        }
    }
}

/// Twice the area between ray and edge.
#[inline(always)]
pub(super) fn area<S: Simd>(simd: S, a: &RaySpaceVertex<S>, b: &RaySpaceVertex<S>) -> F64x8<S> {
    a.x.mul(simd, b.y).sub(simd, a.y.mul(simd, b.x))
}

/// SIMD version of [`WatertightRay::edge_error`].
#[inline(always)]
pub(super) fn edge_error<S: Simd>(simd: S, across: F64x8<S>, along: F64x8<S>) -> F64x8<S> {
    let sum = across.add(simd, along);
    let [of_product, of_coordinate, min] = WatertightRay::EDGE_ERROR.map(|bound| F64x8::splat(simd, bound));
    sum.mul(simd, of_product).mul(simd, across.add(simd, sum.mul(simd, of_coordinate))).max(simd, min)
}

/// `t` at the plane of three vertices, by the areas opposite of them, and the sum of the areas.
#[inline(always)]
fn crossing<S: Simd>(simd: S, [a, b, c]: [&RaySpaceVertex<S>; 3], [u, v, w]: [F64x8<S>; 3]) -> [F64x8<S>; 2] {
    let determinant = u.add(simd, v).add(simd, w);
    let weighted = u.mul(simd, a.depth).add(simd, v.mul(simd, b.depth)).add(simd, w.mul(simd, c.depth));
    [weighted.div(simd, determinant), determinant]
}

/// Intersects the rays of a mask with a triangle within their spans. All must be in the safe range, with their largest
/// component along `axis`. Results of other rays are meaningless.
#[inline(always)]
pub(super) fn intersect<S: Simd>(
    simd: S,
    vertices: &[DVec3; 3],
    axis: usize,
    rays: &RaySoa8<S>,
    mask: u32,
) -> Option<PacketHit<S>> {
    let [x, y, z] = [(axis + 1) % 3, (axis + 2) % 3, axis % 3];
    let shear = Shear::new(simd, [x, y, z], rays);
    let scale = shear.scale;
    let a = shear.in_ray_space(simd, rays, vertices[0]);
    let b = shear.in_ray_space(simd, rays, vertices[1]);
    let c = shear.in_ray_space(simd, rays, vertices[2]);
    let triangle = RaySpaceTriangle::new(simd, a, b, c);
    let possible = mask & !triangle.missed;
    if possible == 0 {
        return None;
    }
    let in_box = inner_box(simd, vertices, rays);
    let (mut hits, is_certain, determinant) = triangle.intersect(simd, rays, possible, in_box);
    let next_to_the_plane = triangle.has_certain_signs & !is_certain;
    if hits.uncertain & next_to_the_plane != 0 {
        hits.uncertain &= !(next_to_the_plane & origin_beyond_plane(simd, vertices, rays, scale, determinant));
    }
    Some(hits)
}

/// Intersects each ray with a triangle of its own within its span. All must be in the safe range, and
/// [turned](RaySoa8::turned), like the vertices. Results of other rays are meaningless.
#[inline(always)]
pub(super) fn intersect_each<S: Simd>(simd: S, vertices: &[[F64x8<S>; 3]; 3], rays: &RaySoa8<S>) -> PacketHit<S> {
    let shear = Shear::new(simd, [0, 1, 2], rays);
    let [a, b, c] = vertices;
    let triangle = RaySpaceTriangle::new(
        simd,
        shear.lanes_in_ray_space(simd, rays, a),
        shear.lanes_in_ray_space(simd, rays, b),
        shear.lanes_in_ray_space(simd, rays, c),
    );
    let low = [
        a[0].min(simd, b[0]).min(simd, c[0]),
        a[1].min(simd, b[1]).min(simd, c[1]),
        a[2].min(simd, b[2]).min(simd, c[2]),
    ];
    let high = [
        a[0].max(simd, b[0]).max(simd, c[0]),
        a[1].max(simd, b[1]).max(simd, c[1]),
        a[2].max(simd, b[2]).max(simd, c[2]),
    ];
    let reach = max_abs(simd, low).max(simd, max_abs(simd, high));
    let in_box = rays.cross_box(simd, low, high, reach.mul(simd, F64x8::splat(simd, INNER_PAD)));
    triangle.intersect(simd, rays, 0xff & !triangle.missed, in_box).0
}

/// A triangle in the space of the rays.
struct RaySpaceTriangle<S: Simd> {
    vertices: [RaySpaceVertex<S>; 3],
    /// Twice the areas between the ray and the edges opposite of the vertices.
    areas: [F64x8<S>; 3],
    /// See [`WatertightRay::edge_error`].
    edge_error: F64x8<S>,
    /// A bit for each ray for which the signs of all areas are certain.
    has_certain_signs: u32,
    /// A bit for each ray that certainly passes outside.
    missed: u32,
}

impl<S: Simd> RaySpaceTriangle<S> {
    #[inline(always)]
    fn new(simd: S, a: RaySpaceVertex<S>, b: RaySpaceVertex<S>, c: RaySpaceVertex<S>) -> Self {
        let (u, v, w) = (area(simd, &c, &b), area(simd, &a, &c), area(simd, &b, &a));
        let smallest = u.abs(simd).min(simd, v.abs(simd)).min(simd, w.abs(simd));
        // NaN is uncertain: its comparison with the least bound fails, also after the minimum.
        let across = max_abs(simd, [a.x, b.x, c.x]).max(simd, max_abs(simd, [a.y, b.y, c.y]));
        let edge_error = edge_error(simd, across, max_abs(simd, [a.z, b.z, c.z]));
        let has_certain_signs = edge_error.lt(simd, smallest);
        let zero = F64x8::splat(simd, 0.0);
        let has_negative = u.lt(simd, zero) | v.lt(simd, zero) | w.lt(simd, zero);
        let has_positive = zero.lt(simd, u) | zero.lt(simd, v) | zero.lt(simd, w);
        let missed = has_certain_signs & has_negative & has_positive;
        Self { vertices: [a, b, c], areas: [u, v, w], edge_error, has_certain_signs, missed }
    }

    /// Hits within spans and boxes, a bit for each ray with a certain side of the plane, and the sum of the areas.
    #[inline(always)]
    fn intersect(
        &self,
        simd: S,
        rays: &RaySoa8<S>,
        possible: u32,
        [enter, leave]: [F64x8<S>; 2],
    ) -> (PacketHit<S>, u32, F64x8<S>) {
        let [a, b, c] = &self.vertices;
        let [_, v, w] = self.areas;
        let [t, determinant] = crossing(simd, [a, b, c], self.areas);
        let depths = a.depth.abs(simd).add(simd, b.depth.abs(simd)).add(simd, c.depth.abs(simd));
        // NaN is uncertain.
        let [min_determinant, origin_side_bound] =
            [WatertightRay::MIN_DETERMINANT, WatertightRay::ORIGIN_SIDE_BOUND].map(|bound| F64x8::splat(simd, bound));
        let is_accurate = self.edge_error.mul(simd, min_determinant).lt(simd, determinant.abs(simd));
        let is_certain = is_accurate & depths.mul(simd, origin_side_bound).lt(simd, t.abs(simd));
        let within = rays.min.le(simd, t) & t.le(simd, rays.max) & t.abs(simd).le(simd, F64x8::splat(simd, f64::MAX));
        let in_box = enter.le(simd, t) & t.le(simd, leave);
        let resolved = possible & self.has_certain_signs & is_certain;
        let hits = PacketHit {
            hit: resolved & within & in_box,
            uncertain: possible & !resolved | resolved & within & !in_box,
            t,
            uv: [v.div(simd, determinant), w.div(simd, determinant)],
        };
        (hits, is_certain, determinant)
    }
}

/// `t` and barycentric coordinates of coherent rays that certainly hit: the operations of
/// [`intersect_triangle`](rt_geometry::intersect_triangle) without its rejections.
#[inline(always)]
pub(super) fn resolve_certain<S: Simd>(
    simd: S,
    vertices: &[DVec3; 3],
    axes: [usize; 3],
    rays: &RaySoa8<S>,
) -> [F64x8<S>; 3] {
    let [x, y, z] = axes.map(|axis| axis % 3);
    let shear = Shear::new(simd, [x, y, z], rays);
    let a = shear.in_ray_space(simd, rays, vertices[0]);
    let b = shear.in_ray_space(simd, rays, vertices[1]);
    let c = shear.in_ray_space(simd, rays, vertices[2]);
    let (u, v, w) = (area(simd, &c, &b), area(simd, &a, &c), area(simd, &b, &a));
    let [mut t, determinant] = crossing(simd, [&a, &b, &c], [u, v, w]);
    // No hit precedes the entry into the padded bounds.
    let [a, b, c] = vertices;
    let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
    let pad = low.abs().max(high.abs()).max_element() * BOUNDS_PADDING;
    let (low, high) = (low - pad, high + pad);
    for axis in 0..3 {
        let inverse = rays.inverse[axis];
        let near = inverse.select_by_sign(simd, F64x8::splat(simd, low[axis]), F64x8::splat(simd, high[axis]));
        t = near.sub(simd, rays.origin[axis]).mul(simd, inverse).max(simd, t);
    }
    [t, v.div(simd, determinant), w.div(simd, determinant)]
}

/// Entry into and exit from a box within the padded bounds.
#[inline(always)]
fn inner_box<S: Simd>(simd: S, &[a, b, c]: &[DVec3; 3], rays: &RaySoa8<S>) -> [F64x8<S>; 2] {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = low.abs().max(high.abs()).max_element() * INNER_PAD;
    rays.cross_box(simd, F64x8::splat3(simd, low), F64x8::splat3(simd, high), F64x8::splat(simd, pad))
}

/// Rays whose origin is certainly beyond the triangle's plane, so that the scalar test misses. Only for certain signs of areas.
#[inline(always)]
fn origin_beyond_plane<S: Simd>(
    simd: S,
    vertices: &[DVec3; 3],
    rays: &RaySoa8<S>,
    scale: F64x8<S>,
    determinant: F64x8<S>,
) -> u32 {
    let a = rel_vertex(simd, vertices[0], rays);
    let b = rel_vertex(simd, vertices[1], rays);
    let c = rel_vertex(simd, vertices[2], rays);
    let (of_a, size_of_a) = product(simd, a[2], b, c);
    let (of_b, size_of_b) = product(simd, b[2], c, a);
    let (of_c, size_of_c) = product(simd, c[2], a, b);
    let volume = of_a.add(simd, of_b).add(simd, of_c);
    let size = size_of_a.add(simd, size_of_b).add(simd, size_of_c);
    // Positive where volume, scale and determinant have an even number of minus signs.
    let turned = scale.select_by_sign(simd, determinant, F64x8::splat(simd, 0.0).sub(simd, determinant));
    let turned = turned.select_by_sign(simd, volume, F64x8::splat(simd, 0.0).sub(simd, volume));
    // The scalar test resolves numbers that may over- or underflow.
    let is_ordinary = F64x8::splat(simd, 1e-200).lt(simd, size) & size.lt(simd, F64x8::splat(simd, 1e200));
    is_ordinary & size.mul(simd, F64x8::splat(simd, VOLUME_ERROR_BOUND)).lt(simd, turned)
}

/// A vertex relative to the origins.
#[inline(always)]
fn rel_vertex<S: Simd>(simd: S, corner: DVec3, rays: &RaySoa8<S>) -> [F64x8<S>; 3] {
    sub3(simd, F64x8::splat3(simd, corner), rays.origin)
}

/// `z·(p × q)` of the first two coordinates, and the sum of the absolute products.
#[inline(always)]
fn product<S: Simd>(simd: S, z: F64x8<S>, p: [F64x8<S>; 3], q: [F64x8<S>; 3]) -> (F64x8<S>, F64x8<S>) {
    let (minuend, subtrahend) = (p[0].mul(simd, q[1]), q[0].mul(simd, p[1]));
    let size = minuend.abs(simd).add(simd, subtrahend.abs(simd)).mul(simd, z.abs(simd));
    (z.mul(simd, minuend.sub(simd, subtrahend)), size)
}

#[cfg(test)]
mod tests {
    use rt_geometry::{Hit, intersect_triangle};
    use rt_math::random::{hash, unit};
    use rt_math::{Interval, Ray, SlabRay};

    use super::super::f64x8::PACKET;
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;

    type Rays = [(Ray, Interval); PACKET];
    type Certain = [[u64; 3]; PACKET];

    struct Resolve<'a>(&'a [DVec3; 3], &'a mut Certain);

    impl WithSimd<&Rays, ()> for Resolve<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Rays, (): ()) {
            let (axes, _) = WatertightRay::new(&rays[0].0).shear();
            let [t, v, w] = resolve_certain(simd, self.0, axes, &RaySoa8::new(simd, rays));
            let (t, v, w) = (t.to_array(simd), v.to_array(simd), w.to_array(simd));
            *self.1 = core::array::from_fn(|lane| [t[lane], v[lane], w[lane]].map(f64::to_bits));
        }
    }

    /// Permutes and flips the axes in one of 24 ways.
    fn turned(p: DVec3, way: u64) -> DVec3 {
        let signs = [1, 2, 4].map(|bit| if (way / 3) & bit == 0 { 1.0 } else { -1.0 });
        let [x, y, z] = [0, 1, 2].map(|axis| p[(axis + way as usize) % 3]);
        DVec3::new(x, y, z) * DVec3::from(signs)
    }

    /// Rays to the inside of a triangle from a distance; some parallel to a plane of two axes.
    fn rays_to([a, b, c]: &[DVec3; 3], distance: f64, seed: u64) -> Rays {
        let at = |lane: usize, k: u64| unit(hash(&[seed, lane as u64, k]));
        core::array::from_fn(|lane| {
            let target = *a + (*b - *a) * (0.1 + 0.4 * at(lane, 0)) + (*c - *a) * (0.1 + 0.4 * at(lane, 1));
            let aside = if seed.is_multiple_of(5) { 0.0 } else { -0.5 - at(lane, 2) };
            let out = distance * DVec3::new(aside, -0.5 - at(lane, 3), 2.0 + at(lane, 4));
            (Ray::new(target + out, -out), Interval::FORWARD)
        })
    }

    #[test]
    fn certain_hits_equal_the_kernel() {
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            let (mut n_hits, mut n_raised) = (0, 0);
            for i in 0..4000 {
                let at = |k: u64| unit(hash(&[i, k]));
                let corner = |k: u64| DVec3::new(at(k), at(k + 1), at(k + 2));
                let triangle =
                    [corner(0), corner(0) + DVec3::X + 0.5 * corner(3), corner(0) + DVec3::Y + 0.5 * corner(6)];
                // From so far away, rounding puts hits on flat small triangles before the padded bounds.
                let (size, distance) = if i % 2 == 0 { (DVec3::ONE, 1.0) } else { (DVec3::new(1.0, 1.0, 0.0), 1e5) };
                let triangle = triangle.map(|vertex| (vertex * size).as_vec3().as_dvec3());
                let way = i / 2 % 24;
                let rays = rays_to(&triangle, distance, i)
                    .map(|(ray, span)| (Ray::new(turned(ray.origin, way), turned(ray.direction, way)), span));
                let triangle = triangle.map(|vertex| turned(vertex, way));
                let mut certain = [[0; 3]; PACKET];
                DetectedSimd::new(level).dispatch(Resolve(&triangle, &mut certain), &rays, ());
                for ((ray, span), bits) in rays.iter().zip(certain) {
                    let sheared = WatertightRay::new(ray);
                    let decided = intersect_triangle(triangle, 0, &SlabRay::new(ray), &sheared, *span);
                    let Some(Hit { t, uv: [v, w], .. }) = decided else { continue };
                    assert_eq!(bits, [t, v, w].map(f64::to_bits), "{level:?}: {ray:?}, {triangle:?}");
                    n_hits += 1;
                    n_raised += usize::from(sheared.intersect(triangle, *span).is_some_and(|hit| hit.t < t));
                }
            }
            assert!(n_hits > 10_000 && n_raised > 10, "{n_hits} hits, {n_raised} raised");
        }
    }
}
