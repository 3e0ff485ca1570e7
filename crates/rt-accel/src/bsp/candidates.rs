//! Candidate planes of a primitive.

use glam::DVec3;
use rt_geometry::{PrimitiveGeometry, SphereKernel};
use rt_math::Aabb;

use super::plane::Plane;

/// Candidate plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) plane: Plane,
    /// True if the normal is an axis, so that the cells on both sides are known exactly.
    pub(super) is_axial: bool,
}

/// Visits all candidate planes of a primitive; some face `neighbour`, the centre of another one.
pub(super) fn for_each(layout: PrimitiveGeometry, own: &Aabb, neighbour: DVec3, mut visit: impl FnMut(Candidate)) {
    for plane in DVec3::AXES.into_iter().flat_map(|normal| Plane::around(normal, own)) {
        visit(Candidate { plane, is_axial: true });
    }
    let facing = match layout {
        PrimitiveGeometry::ExactTriangle(vertices) => {
            let [a, b, c] = vertices.map(|vertex| vertex.as_dvec3());
            normal_of([a, b, c]).map(|normal| (normal, a))
        }
        PrimitiveGeometry::Triangle([a, b, c]) => normal_of([a, b, c]).map(|normal| (normal, a)),
        PrimitiveGeometry::Sphere(centre, _) | PrimitiveGeometry::ExactSphere(SphereKernel { centre, .. }) => {
            unit(neighbour - centre).map(|normal| (normal, centre))
        }
        PrimitiveGeometry::Box(_) | PrimitiveGeometry::Opaque => None,
    };
    let Some((normal, point)) = facing else { return };
    let [under, over] = Plane::around(normal, own);
    for plane in [under, Plane { normal, offset: normal.dot(point) }, over] {
        visit(Candidate { plane, is_axial: false });
    }
}

/// Normal of a triangle of any size; `None` without area.
fn normal_of([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    unit(unit(b - a)?.cross(unit(c - a)?))
}

/// Normalizes a vector of any length.
fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    (largest > 0.0).then(|| vector / largest).and_then(DVec3::try_normalize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space_partition::SplitPlane;

    fn suggested(layout: PrimitiveGeometry, own: Aabb, neighbour: DVec3) -> Vec<Candidate> {
        let mut all = Vec::new();
        for_each(layout, &own, neighbour, |candidate| all.push(candidate));
        all
    }

    #[test]
    fn triangles_suggest_their_plane_whatever_their_size() {
        for scale in [1.0, 1e-200, 1e200] {
            let vertices = [DVec3::X, DVec3::Y, DVec3::Z].map(|vertex| vertex * scale);
            let own = Aabb::from_points(vertices).padded();
            let all = suggested(PrimitiveGeometry::Triangle(vertices), own, DVec3::ZERO);
            assert_eq!(all.iter().filter(|candidate| candidate.is_axial).count(), 6);
            let plane = all[7].plane;
            assert!((plane.normal - DVec3::splat(1.0 / 3f64.sqrt())).length() < 1e-15, "{plane:?}");
            assert!((plane.offset / scale - 1.0 / 3f64.sqrt()).abs() < 1e-15, "{plane:?}");
            assert_eq!(plane.classify(&own), [true; 2]);
            assert_eq!(all[6].plane.classify(&own), [false, true]);
            assert_eq!(all[8].plane.classify(&own), [true, false]);
        }
    }

    #[test]
    fn what_has_no_direction_suggests_its_box_only() {
        let own = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let sliver = [DVec3::ZERO, DVec3::ONE, DVec3::splat(0.5)];
        for layout in [
            PrimitiveGeometry::Opaque,
            PrimitiveGeometry::Box(own),
            PrimitiveGeometry::Sphere(DVec3::ONE, 1.0),
            PrimitiveGeometry::Triangle(sliver),
            PrimitiveGeometry::Triangle([DVec3::NAN; 3]),
        ] {
            assert_eq!(suggested(layout, own, DVec3::ONE).len(), 6, "{layout:?}");
        }
    }
}
