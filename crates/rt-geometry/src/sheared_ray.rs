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
        Self { origin: ray.origin, axis, shear_x: d.x / d.z, shear_y: d.y / d.z, scale_z: 1.0 / d.z }
    }

    /// A point as the ray sees it: x and y across the ray, z the ray parameter.
    #[inline]
    fn map(&self, point: DVec3) -> DVec3 {
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
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
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
