//! Watertight ray-triangle test, for single triangles, meshes and accelerators.

use crate::{
    ShapeHit,
    exact_edges::{edge_volumes, edge_weights, point_area},
};
use robust::{Coord3D, orient3d};
use rt_math::DVec3;
use rt_math::float::UNIT_ROUNDOFF;
use rt_math::{Interval, Ray};

/// Ray prepared for many triangle tests: the affine map that takes the ray to the positive z axis.
///
/// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, in `f64`. A vertex is mapped by a
/// function of that vertex and the ray alone. Where rounding could change the side on which the ray passes an edge, it is
/// computed exactly, from the numbers of ray and vertices. So no ray passes through an edge or a vertex of a closed mesh. A ray
/// exactly through an edge hits both of its triangles, at the same `t`. The side of a triangle on which a ray starts is exact as well.
/// So a ray that starts in its plane hits it at 0. All areas of grazing rays and needles are computed exactly. Otherwise
/// rounding changes `t` by at most some 2⁻¹⁷ of the distances of the vertices.
///
/// # When the sides of edges are certain
///
/// Let `u = 2⁻⁵³`. Let `Z` be the largest distance of a vertex from the origin along the main axis, that of the largest direction
/// component. Let `M` be the largest coordinate of a vertex across the ray. Differences are rounded, and so are the
/// shear, its product and the result. So a coordinate across the ray is off by at most `e = u(2M + 5Z)`. An area is a
/// difference of two products of such coordinates: it is off by at most `4M·e + 2e²`, and by `4u·M²` for its own roundings.
/// With `W = M + Z`, that is less than `32u·W(M + 4u·W)` ([`edge_error`](Self::edge_error)).
///
/// # When the side of the plane is certain
///
/// Let `E` be that error and `D` the sum of the areas. `S` is the sum of the ray parameters of the vertices, without signs. `t` is
/// the mean of these distances weighted by the areas. So areas of certain signs that are off by `E` can change the sign of `t` only up to
/// `|t| = S·E/|D|`. Roundings of the distances and of the mean add less than `8u·S`. With `|D|` greater than
/// [2¹⁷](Self::MIN_DETERMINANT)`·E` both are less than [2⁻¹⁶](Self::ORIGIN_SIDE_BOUND)`·S`. Otherwise the areas are computed exactly,
/// with relative errors of less than 2⁻²³.
#[derive(Clone, Copy, Debug)]
pub struct WatertightRay {
    origin: DVec3,
    direction: DVec3,
    /// Axes that become x, y and z: the direction is largest along the last, and the order is cyclic.
    axes: [usize; 3],
    shear_x: f64,
    shear_y: f64,
    scale_z: f64,
}

/// Indexed by the axis that becomes z.
const CYCLIC: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

impl WatertightRay {
    /// Bound on `|t|` over the sum of the distances of the vertices along the ray. Where `t` is smaller, rounding could place the
    /// triangle on the wrong side of the origin, so that its sign is computed exactly.
    pub const ORIGIN_SIDE_BOUND: f64 = 1.0 / (1 << 16) as f64;

    /// Minimum sum of the areas, in [`edge_error`](Self::edge_error)s. With less, the areas are computed exactly.
    pub const MIN_DETERMINANT: f64 = (1 << 17) as f64;

    /// Factors of [`edge_error`](Self::edge_error), and the minimum of an area with a certain sign: products with a depth do not
    /// underflow.
    pub const EDGE_ERROR: [f64; 3] = [32.0 * UNIT_ROUNDOFF, 4.0 * UNIT_ROUNDOFF, 1e-180];

    /// Bound that an area of a triangle in ray space must exceed, so that its sign is certain. It is given the largest coordinate
    /// `across` the ray, and the largest distance `along` the main axis.
    #[inline(always)]
    pub fn edge_error(across: f64, along: f64) -> f64 {
        let [of_product, of_coordinate, min] = Self::EDGE_ERROR;
        let sum = across + along;
        (sum * of_product * (across + sum * of_coordinate)).max(min)
    }

    /// Prepares a ray. A ray of direction zero has no hits.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        // Branch-free, as directions are random.
        let axis = if size.y > size.z { 1 } else { 2 };
        let axis = if (size.x > size.y) & (size.x > size.z) { 0 } else { axis };
        let axes = CYCLIC[axis];
        let d = permuted(ray.direction, axes);
        let scale_z = 1.0 / d.z;
        let Ray { origin, direction, .. } = *ray;
        Self { origin, direction, axes, shear_x: d.x * scale_z, shear_y: d.y * scale_z, scale_z }
    }

    /// Side of the directed edge between two vertices on which the ray passes, with the exact sign, and 0 only on the edge. Also given are
    /// their [sheared](Self::shear_point) positions.
    pub(crate) fn side_of_edge(&self, [from, to]: [DVec3; 2], [a, b]: [DVec3; 2]) -> f64 {
        let side = a.x * b.y - a.y * b.x;
        let size = a.abs().max(b.abs());
        if side.abs() > Self::edge_error(size.x.max(size.y), size.z) {
            return side;
        }
        let [volume] = edge_volumes(self.origin, self.direction, [[from, to]]);
        volume * self.scale_z.signum()
    }

    /// True if the second coordinate of a vertex across the ray is positive, without rounding. Also given is its
    /// [sheared](Self::shear_point) position.
    pub(crate) fn is_above(&self, vertex: DVec3, sheared: DVec3) -> bool {
        let size = sheared.abs();
        // More than the error bound of a coordinate.
        if sheared.y.abs() > Self::EDGE_ERROR[0] * (size.x.max(size.y) + size.z) {
            return sheared.y > 0.0;
        }
        let coordinates = |v: DVec3| {
            let v = permuted(v, self.axes);
            [v.y, v.z]
        };
        point_area(coordinates(self.origin), coordinates(self.direction), coordinates(vertex)) * self.scale_z.signum()
            > 0.0
    }

    /// Point relative to the origin, with x and y across the ray, and z along the main axis of the direction. Rounded.
    #[inline(always)]
    pub(crate) fn shear_point(&self, point: DVec3) -> DVec3 {
        let p = permuted(point - self.origin, self.axes);
        DVec3::new(p.x - self.shear_x * p.z, p.y - self.shear_y * p.z, p.z)
    }

    /// Hit on a triangle within the closed `span`, with the barycentric weights of the second and third vertex. Edges
    /// and vertices belong to the triangle; both sides are hit; `None` exactly edge-on.
    #[inline(always)]
    pub fn intersect(&self, vertices: [DVec3; 3], span: Interval) -> Option<ShapeHit> {
        let [a, b, c] = [self.shear_point(vertices[0]), self.shear_point(vertices[1]), self.shear_point(vertices[2])];
        // Side by side, as vectors: each coordinate of the three vertices twice, turned by one and by two.
        let (x_one, y_one) = ([c.x, a.x, b.x, 0.0], [c.y, a.y, b.y, 0.0]);
        let (x_two, y_two) = ([b.x, c.x, a.x, 0.0], [b.y, c.y, a.y, 0.0]);
        let [u, v, w, spare] = differences(products(x_one, y_two), products(y_one, x_two));
        let size = a.abs().max(b.abs()).max(c.abs());
        let error = Self::edge_error(size.x.max(size.y), size.z);
        let is_certain = (u.abs() > error) & (v.abs() > error) & (w.abs() > error) & (spare == 0.0);
        // Rare cases return by themselves, from numbers that they compute anew. Areas or hits that they could change would be written
        // to memory and read again for all triangles.
        if !is_certain {
            return self.intersect_exactly(vertices, span);
        }
        let depths = [a.z * self.scale_z, b.z * self.scale_z, c.z * self.scale_z];
        let triangle = RaySpaceTriangle { areas: [u, v, w], determinant: u + v + w, depths };
        if triangle.is_missed() {
            return None;
        }
        if triangle.determinant.abs() <= error * Self::MIN_DETERMINANT {
            return self.intersect_exactly(vertices, span);
        }
        self.hit_within(vertices, &triangle, span)
    }

    /// Version of [`intersect`](Self::intersect) with exact signs of the areas and accurate weights.
    #[cold]
    #[inline(never)]
    fn intersect_exactly(&self, vertices: [DVec3; 3], span: Interval) -> Option<ShapeHit> {
        let depths = vertices.map(|vertex| self.shear_point(vertex).z * self.scale_z);
        let areas = self.exact_areas(vertices);
        let triangle = RaySpaceTriangle { areas, determinant: areas[0] + areas[1] + areas[2], depths };
        if triangle.is_missed() { None } else { self.hit_within(vertices, &triangle, span) }
    }

    /// The hit on a triangle that is not missed, if it is within the span.
    #[inline(always)]
    fn hit_within(&self, vertices: [DVec3; 3], triangle: &RaySpaceTriangle, span: Interval) -> Option<ShapeHit> {
        let ([u, v, w], [a, b, c]) = (triangle.areas, triangle.depths);
        let t = (u * a + v * b + w * c) / triangle.determinant;
        let uv = [v / triangle.determinant, w / triangle.determinant];
        // Rounding may change the side of the triangle on which the ray starts.
        let is_near_origin = t.abs() <= Self::ORIGIN_SIDE_BOUND * (a.abs() + b.abs() + c.abs());
        let t = if is_near_origin { self.exact_origin_side(vertices, t, triangle.determinant) } else { t };
        (span.contains(t) & t.is_finite()).then_some(ShapeHit { t, uv })
    }

    /// Parameter of a plane next to the origin of the ray, on the correct side: 0 if the ray starts in the plane.
    #[cold]
    #[inline(never)]
    fn exact_origin_side(&self, vertices: [DVec3; 3], t: f64, determinant: f64) -> f64 {
        let coordinates = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        let (a, b, c) = (coordinates(vertices[0]), coordinates(vertices[1]), coordinates(vertices[2]));
        // Exact: the sign of the volume between the plane and the origin (Shewchuk 1997).
        let side = -orient3d(a, b, c, coordinates(self.origin)) * self.scale_z.signum() * determinant.signum();
        if side == 0.0 {
            0.0
        } else if side > 0.0 {
            t.max(0.0)
        } else if side < 0.0 {
            t.min(-f64::MIN_POSITIVE)
        } else {
            t
        }
    }

    /// Areas with exact signs, times a common factor. The ray passes exactly through edges of area 0. The other areas are then those of
    /// the edge or vertex alone, so that all of its triangles are hit at the same `t`.
    fn exact_areas(&self, vertices: [DVec3; 3]) -> [f64; 3] {
        let [a, b, c] = vertices;
        let volumes = edge_volumes(self.origin, self.direction, [[c, b], [a, c], [b, a]]);
        let mut areas = volumes.map(|volume| volume * self.scale_z.signum());
        let is_inside = areas.iter().all(|area| *area >= 0.0) | areas.iter().all(|area| *area <= 0.0);
        let n_zero = areas.iter().filter(|area| **area == 0.0).count();
        if is_inside && n_zero == 2 {
            areas = areas.map(|area| if area == 0.0 { area } else { area.signum() });
        } else if is_inside && n_zero == 1 {
            let zero = areas.iter().position(|area| *area == 0.0).unwrap_or(0);
            let (one, other) = ((zero + 1) % 3, (zero + 2) % 3);
            let weights = edge_weights(self.origin, self.direction, [vertices[one], vertices[other]]);
            let sign = areas[one].signum();
            [areas[one], areas[other]] = weights.map(|weight| sign * weight);
        }
        areas
    }

    /// Permuted axes (kx, ky, kz) and shear constants (Sx, Sy, Sz) of Woop, Benthin and Wald 2013. For SIMD tests of lower
    /// precision.
    #[inline(always)]
    pub const fn shear(&self) -> ([usize; 3], [f64; 3]) {
        (self.axes, [self.shear_x, self.shear_y, self.scale_z])
    }
}

#[inline(always)]
fn products(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]]
}

#[inline(always)]
fn differences(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

/// Triangle in ray space.
struct RaySpaceTriangle {
    /// Twice the areas of the triangles between the ray and the edges, with exact signs.
    areas: [f64; 3],
    /// Sum of the areas.
    determinant: f64,
    /// Ray parameters of the vertices.
    depths: [f64; 3],
}

impl RaySpaceTriangle {
    /// True if the ray passes outside of an edge, or edge-on.
    #[inline(always)]
    fn is_missed(&self) -> bool {
        let [u, v, w] = self.areas;
        // No early exit: the signs are random, and a mispredicted branch costs more than the test.
        let outside = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        outside | (self.determinant == 0.0)
    }
}

/// The components in this order.
#[inline(always)]
fn permuted(v: DVec3, [x, y, z]: [usize; 3]) -> DVec3 {
    // Four, so that the remainder is a mask.
    let v = [v.x, v.y, v.z, 0.0];
    DVec3::new(v[x & 3], v[y & 3], v[z & 3])
}
