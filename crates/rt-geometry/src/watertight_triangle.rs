//! Watertight ray-triangle test, for single triangles, meshes and accelerators.

use crate::ShapeHit;
use robust::{Coord3D, orient3d};
use rt_math::DVec3;
use rt_math::float::{difference_of_products, is_sign_certain};
use rt_math::{Interval, Ray};

/// Ray prepared for many triangle tests: the affine map that takes the ray to the positive z axis.
///
/// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, in `f64`. A vertex is mapped by a
/// function of that vertex and the ray alone, so that triangles with a common vertex agree on its position. The sides
/// of edges are computed with exact signs: no ray passes through an edge or a vertex of a closed mesh. The side of a
/// triangle on which a ray starts is exact as well. So a ray that starts in its plane hits it at 0.
#[derive(Clone, Copy, Debug)]
pub struct WatertightRay {
    origin: DVec3,
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

    /// Prepares a ray. A ray of direction zero has no hits.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        Self::with_inverse(ray, ray.direction.recip())
    }

    /// Prepares a ray with known reciprocals of the direction.
    #[inline(always)]
    pub fn with_inverse(ray: &Ray, inverse: DVec3) -> Self {
        let size = ray.direction.abs();
        // Branch-free, as directions are random.
        let axis = if size.y > size.z { 1 } else { 2 };
        let axis = if (size.x > size.y) & (size.x > size.z) { 0 } else { axis };
        let axes = CYCLIC[axis];
        let d = permuted(ray.direction, axes);
        let scale_z = permuted(inverse, axes).z;
        Self { origin: ray.origin, axes, shear_x: d.x * scale_z, shear_y: d.y * scale_z, scale_z }
    }

    /// Point in ray space: x and y across the ray, z the ray parameter.
    #[inline(always)]
    pub fn map(&self, point: DVec3) -> DVec3 {
        let p = permuted(point - self.origin, self.axes);
        DVec3::new(p.x - self.shear_x * p.z, p.y - self.shear_y * p.z, p.z * self.scale_z)
    }

    /// Hit on a triangle within the closed `span`, with the barycentric weights of the second and third vertex. Edges
    /// and vertices belong to the triangle; both sides are hit; `None` exactly edge-on.
    #[inline(always)]
    pub fn intersect(&self, vertices: [DVec3; 3], span: Interval) -> Option<ShapeHit> {
        let ray_space = self.in_ray_space(vertices);
        let [u, v, w] = ray_space.areas;
        // No early exit: the signs are random, and a mispredicted branch costs more than the test.
        let outside = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        if outside | (ray_space.determinant == 0.0) {
            return None;
        }
        let mut hit = ray_space.hit();
        if ray_space.origin_side_uncertain(hit.t) {
            hit.t = self.exact_origin_side(vertices, hit.t, ray_space.determinant);
        }
        (span.contains(hit.t) & hit.t.is_finite()).then_some(hit)
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

    #[inline(always)]
    fn in_ray_space(&self, vertices: [DVec3; 3]) -> RaySpaceTriangle {
        let [a, b, c] = [self.map(vertices[0]), self.map(vertices[1]), self.map(vertices[2])];
        // Side by side, as vectors: each coordinate of the three vertices twice, turned by one and by two.
        let (x_one, y_one) = ([c.x, a.x, b.x, 0.0], [c.y, a.y, b.y, 0.0]);
        let (x_two, y_two) = ([b.x, c.x, a.x, 0.0], [b.y, c.y, a.y, 0.0]);
        let (minuends, subtrahends) = (products(x_one, y_two), products(y_one, x_two));
        let [u, v, w, spare] = differences(minuends, subtrahends);
        let is_certain = |i: usize, area: f64| is_sign_certain(area, minuends[i], subtrahends[i]);
        let areas = if is_certain(0, u) & is_certain(1, v) & is_certain(2, w) & (spare == 0.0) {
            [u, v, w]
        } else {
            exact_areas([c.x, c.y, a.x, a.y, b.x, b.y])
        };
        let [u, v, w] = areas;
        RaySpaceTriangle { areas, determinant: u + v + w, depths: [a.z, b.z, c.z] }
    }

    /// Axes that become x, y and z, multiples of z that x and y lose, and factor of z. For SIMD tests of lower
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

/// Exact computation of uncertain signs.
#[cold]
#[inline(never)]
fn exact_areas([cx, cy, ax, ay, bx, by]: [f64; 6]) -> [f64; 3] {
    [
        difference_of_products(cx, by, cy, bx),
        difference_of_products(ax, cy, ay, cx),
        difference_of_products(bx, ay, by, ax),
    ]
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
    /// True if rounding may change the side of the triangle on which the ray starts.
    #[inline(always)]
    fn origin_side_uncertain(&self, t: f64) -> bool {
        let [a, b, c] = self.depths;
        t.abs() <= WatertightRay::ORIGIN_SIDE_BOUND * (a.abs() + b.abs() + c.abs())
    }

    #[inline(always)]
    fn hit(&self) -> ShapeHit {
        let ([u, v, w], [a, b, c]) = (self.areas, self.depths);
        let t = (u * a + v * b + w * c) / self.determinant;
        ShapeHit { t, uv: [v / self.determinant, w / self.determinant] }
    }
}

/// The components in this order.
#[inline(always)]
fn permuted(v: DVec3, [x, y, z]: [usize; 3]) -> DVec3 {
    // Four, so that the remainder is a mask.
    let v = [v.x, v.y, v.z, 0.0];
    DVec3::new(v[x & 3], v[y & 3], v[z & 3])
}
