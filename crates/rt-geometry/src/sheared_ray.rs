//! The watertight triangle test, shared by single triangles and meshes.

use crate::ShapeHit;
use rt_math::float::difference_of_products;
use rt_math::{DVec3, Interval, Ray};

/// A ray prepared for many triangle tests: the affine map that takes the ray to the positive z axis.
///
/// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, in `f64`. A vertex is mapped by a
/// function of that vertex and the ray alone, so triangles that share it agree on where it lies, and the sides of the
/// edges are decided with exact signs: no ray slips through an edge or a vertex of a closed mesh.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    origin: DVec3,
    /// The axis along which the direction is largest; it becomes z, the two after it x and y.
    axis: usize,
    shear_x: f64,
    shear_y: f64,
    scale_z: f64,
}

impl ShearedRay {
    /// Prepares a ray. One without a direction misses everything.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        let axis = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let d = rotated(ray.direction, axis);
        let scale_z = 1.0 / d.z;
        Self { origin: ray.origin, axis, shear_x: d.x * scale_z, shear_y: d.y * scale_z, scale_z }
    }

    /// A point as the ray sees it: x and y across the ray, z the ray parameter.
    #[inline]
    pub(crate) fn map(&self, point: DVec3) -> DVec3 {
        let p = rotated(point - self.origin, self.axis);
        DVec3::new(p.x - self.shear_x * p.z, p.y - self.shear_y * p.z, p.z * self.scale_z)
    }

    /// The hit on a triangle within the closed `span`, with the barycentric weights of the second and third vertex.
    /// Edges and vertices belong to the triangle; both sides are hit; `None` if it is seen exactly edge-on.
    #[inline]
    pub fn intersect(&self, vertices: [DVec3; 3], span: Interval) -> Option<ShapeHit> {
        let [a, b, c] = vertices.map(|v| self.map(v));
        let u = difference_of_products(c.x, b.y, c.y, b.x);
        let v = difference_of_products(a.x, c.y, a.y, c.x);
        let w = difference_of_products(b.x, a.y, b.y, a.x);
        // Without short cuts: the signs are as good as random, and a mispredicted branch costs more than the test.
        let outside = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        if outside {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let t = (u * a.z + v * b.z + w * c.z) / determinant;
        (span.contains(t) && t.is_finite()).then(|| ShapeHit { t, uv: [v / determinant, w / determinant] })
    }
}

/// The components in cyclic order, such that `axis` comes last.
#[inline]
fn rotated(v: DVec3, axis: usize) -> DVec3 {
    match axis {
        0 => DVec3::new(v.y, v.z, v.x),
        1 => DVec3::new(v.z, v.x, v.y),
        _ => v,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random;
    use rt_tests::icosphere;

    const GRID: f64 = (1u32 << 18) as f64;

    /// What the rays are aimed at.
    #[derive(Clone, Copy, Debug)]
    enum Target {
        EdgeMiddle,
        Vertex,
    }

    /// The usual test (Möller, Trumbore 1997), which decides with rounded products.
    fn plain_test([a, b, c]: [DVec3; 3], ray: &Ray) -> bool {
        let (e, f) = (b - a, c - a);
        let p = ray.direction.cross(f);
        let inverse = 1.0 / e.dot(p);
        let s = ray.origin - a;
        let v = s.dot(p) * inverse;
        let q = s.cross(e);
        let (w, t) = (ray.direction.dot(q) * inverse, f.dot(q) * inverse);
        v >= 0.0 && w >= 0.0 && v + w <= 1.0 && t >= 0.0
    }

    /// Rays from inside a closed mesh that miss all of its triangles: with the watertight test, with the plain one.
    fn leaks(offset: f64, scale: f64, target: Target, rays: u64) -> (usize, usize) {
        let (vertices, triangles) = icosphere(1);
        assert_eq!((vertices.len(), triangles.len()), (42, 80));
        let centre = DVec3::new(offset, offset * 0.75, -offset);
        // On a grid coarse enough for the middles of edges to be exact as well.
        let place = |v: &DVec3| (*v * GRID).round() / GRID * scale + centre;
        let vertices: Vec<DVec3> = vertices.iter().map(place).collect();
        let draw = |ray: u64, k: u64| random::unit(random::hash(&[ray, k]));
        let (mut watertight, mut plain) = (0, 0);
        for ray in 0..rays {
            let origin = centre + (DVec3::new(draw(ray, 0), draw(ray, 1), draw(ray, 2)) - 0.5) * scale;
            let triangle = triangles[(draw(ray, 3) * triangles.len() as f64) as usize];
            let along = match target {
                Target::EdgeMiddle => 0.5,
                Target::Vertex => 0.0,
            };
            let aim = vertices[triangle[0]].lerp(vertices[triangle[1]], along);
            let ray = Ray::new(origin, aim - origin);
            let sheared = ShearedRay::new(&ray);
            let corners = || triangles.iter().map(|t| t.map(|i| vertices[i]));
            watertight += usize::from(!corners().any(|t| sheared.intersect(t, Interval::FORWARD).is_some()));
            plain += usize::from(!corners().any(|t| plain_test(t, &ray)));
        }
        (watertight, plain)
    }

    #[test]
    fn no_ray_leaves_a_closed_mesh() {
        const RAYS: u64 = 20_000;
        let small = 1.0 / 1024.0;
        for target in [Target::EdgeMiddle, Target::Vertex] {
            for (offset, scale) in [(0.0, 1.0), (100.0, 1.0), (1e4, 1.0), (1e7, 1.0), (0.0, 1e-6), (1e7, small)] {
                let (watertight, plain) = leaks(offset, scale, target, RAYS);
                assert_eq!(watertight, 0, "{target:?} at offset {offset}, scale {scale}");
                // The rays are hard: some slip through a test that rounds.
                assert!(plain > 0, "{target:?} at offset {offset}, scale {scale}");
            }
        }
    }
}
