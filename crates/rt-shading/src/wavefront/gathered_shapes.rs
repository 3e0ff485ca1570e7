//! Shapes of the primitives that several rays hit, one for each lane.

use crate::{
    lanes::LANES,
    stream_queries::{StreamShape, StreamTriangle},
};
use rt_math::DVec3;

/// Shapes in lanes. Lanes of neither mask are triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct GatheredShapes {
    /// Lanes of spheres, with the centre as first corner and the radius as first coordinate of the normal.
    pub(crate) spheres: u8,
    /// Lanes of planes and polygons, with a point of the plane as first corner.
    pub(crate) planes: u8,
    /// Lanes of triangles with interpolated normals.
    pub(crate) smooth: u8,
    /// Coordinates of vertices.
    pub(crate) corners: [[[f64; LANES]; 3]; 3],
    /// Coordinates of unit normals.
    pub(crate) normal: [[f64; LANES]; 3],
    /// Coordinates of the unit normals of vertices.
    pub(crate) vertex_normals: [[[f64; LANES]; 3]; 3],
}

impl GatheredShapes {
    /// Removes all shapes.
    #[inline(always)]
    pub(crate) const fn clear(&mut self) {
        (self.spheres, self.planes, self.smooth) = (0, 0, 0);
    }

    /// Sets the shape of a lane, once.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, shape: &StreamShape<'_>) {
        let [a, b, c] = &mut self.corners;
        let normal = match shape {
            StreamShape::Sphere(sphere) => {
                self.spheres |= 1 << lane;
                set(a, lane, sphere.centre());
                DVec3::splat(sphere.radius())
            }
            StreamShape::Plane(plane) | StreamShape::Polygon(plane) => {
                self.planes |= 1 << lane;
                set(a, lane, plane.point());
                plane.normal()
            }
            StreamShape::Triangle(StreamTriangle { vertices, normal, vertex_normals }) => {
                set(a, lane, vertices[0]);
                set(b, lane, vertices[1]);
                set(c, lane, vertices[2]);
                if let Some(normals) = vertex_normals {
                    self.smooth |= 1 << lane;
                    for (to, normal) in self.vertex_normals.iter_mut().zip(normals) {
                        set(to, lane, normal.as_dvec3());
                    }
                }
                *normal
            }
        };
        set(&mut self.normal, lane, normal);
    }
}

/// Sets the vector of one lane.
#[inline(always)]
fn set([x, y, z]: &mut [[f64; LANES]; 3], lane: usize, v: DVec3) {
    let lane = lane % LANES;
    (x[lane], y[lane], z[lane]) = (v.x, v.y, v.z);
}
