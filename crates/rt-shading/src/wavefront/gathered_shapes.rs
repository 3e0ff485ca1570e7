//! Shapes of the primitives that several rays hit, one for each lane.

use crate::{
    lanes::LANES,
    stream_queries::{StreamShape, StreamTriangle},
};
use rt_geometry::{SurfaceInteraction, TriangleMesh};
use rt_math::{DVec3, Vec3};

/// Shapes in lanes. Lanes of no mask are triangles without interpolated normals.
#[derive(Clone, Debug, Default)]
pub(crate) struct GatheredShapes {
    /// Lanes of spheres, with the centre as first corner and the radius as first coordinate of the normal.
    pub(crate) spheres: u8,
    /// Lanes of planes and polygons, with a point of the plane as first corner.
    pub(crate) planes: u8,
    /// Lanes of triangles with interpolated normals.
    pub(crate) smooth: u8,
    /// Lanes of triangles whose normal is not known.
    pub(crate) meshes: u8,
    /// Lanes of surfaces that are known. They have the point, its error and the point for shadow rays as corners, and the shading normal
    /// as first normal of a vertex.
    pub(crate) surfaces: u8,
    /// Coordinates of vertices.
    pub(crate) corners: [[[f64; LANES]; 3]; 3],
    /// Coordinates of unit normals.
    pub(crate) normal: [[f64; LANES]; 3],
    /// Coordinates of the unit normals of vertices.
    pub(crate) vertex_normals: [[[f64; LANES]; 3]; 3],
    /// Texture coordinates u and v of vertices.
    pub(crate) vertex_uvs: [[[f64; LANES]; 3]; 2],
}

impl GatheredShapes {
    /// Removes all shapes.
    #[inline(always)]
    pub(crate) const fn clear(&mut self) {
        (self.spheres, self.planes, self.smooth, self.meshes, self.surfaces) = (0, 0, 0, 0, 0);
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
                    self.set_normals(lane, normals);
                }
                *normal
            }
            StreamShape::MeshTriangle(mesh, index) => return self.set_triangle(lane, mesh, *index),
        };
        set(&mut self.normal, lane, normal);
    }

    /// Sets a triangle of a mesh; one without area if there is none of this index.
    #[inline(always)]
    fn set_triangle(&mut self, lane: usize, mesh: &TriangleMesh, index: u32) {
        self.meshes |= 1 << lane;
        let vertices = mesh.vertices(index).unwrap_or_default();
        for (to, vertex) in self.corners.iter_mut().zip(vertices) {
            set(to, lane, vertex);
        }
        if let Some(normals) = &mesh.vertex_normals(index) {
            self.set_normals(lane, normals);
        }
    }

    #[inline(always)]
    fn set_normals(&mut self, lane: usize, normals: &[Vec3; 3]) {
        self.smooth |= 1 << lane;
        for (to, normal) in self.vertex_normals.iter_mut().zip(normals) {
            set(to, lane, normal.as_dvec3());
        }
    }

    /// Sets the texture coordinates of the vertices of a triangle.
    #[inline(always)]
    pub(crate) fn set_uvs(&mut self, lane: usize, vertex_uvs: [[f32; 2]; 3]) {
        let [us, vs] = &mut self.vertex_uvs;
        for ((u, v), uv) in us.iter_mut().zip(vs).zip(vertex_uvs) {
            (u[lane % LANES], v[lane % LANES]) = (f64::from(uv[0]), f64::from(uv[1]));
        }
    }

    /// Sets the surface of a lane, once.
    pub(crate) fn set_surface(&mut self, lane: usize, surface: &SurfaceInteraction) {
        self.surfaces |= 1 << lane;
        for (to, v) in self.corners.iter_mut().zip([surface.point, surface.point_error, surface.shadow_point]) {
            set(to, lane, v);
        }
        set(&mut self.normal, lane, surface.geometric_normal);
        set(&mut self.vertex_normals[0], lane, surface.shading_normal);
    }
}

#[inline(always)]
fn set([x, y, z]: &mut [[f64; LANES]; 3], lane: usize, v: DVec3) {
    let lane = lane % LANES;
    (x[lane], y[lane], z[lane]) = (v.x, v.y, v.z);
}
