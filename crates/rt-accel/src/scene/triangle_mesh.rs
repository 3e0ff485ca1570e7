//! Indexed triangle meshes as the caller has them.

use std::borrow::Cow;

use glam::DVec3;
use rt_geometry::{
    ClosestPoint, Hit, MAX_COORDINATE, PrimitiveGeometry, Primitives, WatertightRay, nearest_on_triangle,
};
use rt_math::{Aabb, Interval, Ray, Vec3};

use super::error::MeshError;

/// Vertices in one of two precisions, borrowed or owned.
#[derive(Clone, Debug, PartialEq)]
pub enum Vertices<'a> {
    /// In single precision.
    F32(Cow<'a, [[f32; 3]]>),
    /// In double precision.
    F64(Cow<'a, [[f64; 3]]>),
}

impl Vertices<'_> {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(vertices) => vertices.len(),
            Self::F64(vertices) => vertices.len(),
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of the first vertex with a coordinate that is NaN, or of a magnitude above [`MAX_COORDINATE`].
    fn first_out_of_range(&self) -> Option<usize> {
        match self {
            // All finite numbers of single precision are in range.
            Self::F32(vertices) => vertices.iter().position(|vertex| !vertex.iter().all(|c| c.is_finite())),
            Self::F64(vertices) => vertices.iter().position(|vertex| !vertex.iter().all(|c| c.abs() <= MAX_COORDINATE)),
        }
    }

    /// Vertices in single precision, if it represents all of them exactly.
    fn narrowed(self) -> Self {
        let Self::F64(wide) = &self else { return self };
        let is_exact = |c: &f64| f64::from(*c as f32).to_bits() == c.to_bits();
        if wide.iter().flatten().all(is_exact) {
            return Self::F32(wide.iter().map(|vertex| vertex.map(|c| c as f32)).collect());
        }
        self
    }
}

/// Conversions of the containers that hold vertices.
macro_rules! vertices_from {
    ($number:ty, $precision:ident) => {
        impl<'a> From<&'a [[$number; 3]]> for Vertices<'a> {
            fn from(vertices: &'a [[$number; 3]]) -> Self {
                Self::$precision(Cow::Borrowed(vertices))
            }
        }

        impl<'a> From<&'a Vec<[$number; 3]>> for Vertices<'a> {
            fn from(vertices: &'a Vec<[$number; 3]>) -> Self {
                Self::$precision(Cow::Borrowed(vertices))
            }
        }

        impl<'a, const N: usize> From<&'a [[$number; 3]; N]> for Vertices<'a> {
            fn from(vertices: &'a [[$number; 3]; N]) -> Self {
                Self::$precision(Cow::Borrowed(vertices))
            }
        }

        impl From<Vec<[$number; 3]>> for Vertices<'_> {
            fn from(vertices: Vec<[$number; 3]>) -> Self {
                Self::$precision(Cow::Owned(vertices))
            }
        }
    };
}

vertices_from!(f32, F32);
vertices_from!(f64, F64);

/// Triangles over shared vertices, borrowed or owned.
///
/// The mesh is not repaired: primitive `i` is triangle `i` of the caller. Triangles without area are kept and never
/// hit; they can be nearest to a point. Vertices in double precision are used exactly. If single precision holds all of them,
/// the mesh keeps them so, which is faster and gives the same hits. Products of edges that are shorter than some 10⁻¹⁵⁰
/// underflow, so that such triangles may be missed.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh<'a> {
    vertices: Vertices<'a>,
    triangles: Cow<'a, [[u32; 3]]>,
}

impl<'a> TriangleMesh<'a> {
    /// Checks the arrays: slices and references are borrowed, vectors are taken over.
    ///
    /// # Errors
    ///
    /// [`MeshError`] for an index beyond the vertices, a coordinate that is NaN or of a magnitude above
    /// [`MAX_COORDINATE`], and more than 2³² - 1 triangles.
    pub fn new(
        vertices: impl Into<Vertices<'a>>,
        triangles: impl Into<Cow<'a, [[u32; 3]]>>,
    ) -> Result<Self, MeshError> {
        let (vertices, triangles) = (vertices.into(), triangles.into());
        if u32::try_from(triangles.len()).is_err() {
            return Err(MeshError::TooMany { count: triangles.len() });
        }
        if let Some(vertex) = vertices.first_out_of_range() {
            return Err(MeshError::Coordinate { vertex });
        }
        let n_vertices = vertices.len();
        let is_bad = |index: &u32| *index as usize >= n_vertices;
        if let Some(triangle) = triangles.iter().position(|triangle| triangle.iter().any(is_bad)) {
            let index = triangles[triangle].into_iter().find(|index| is_bad(index)).unwrap_or_default();
            return Err(MeshError::VertexIndex { triangle, index, n_vertices });
        }
        Ok(Self { vertices: vertices.narrowed(), triangles })
    }

    /// The vertices, in the precision that holds them.
    pub const fn vertices(&self) -> &Vertices<'a> {
        &self.vertices
    }

    /// The triangles: indices of their vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Vertices of triangle `index`; `None` for an invalid index.
    #[inline]
    pub fn triangle(&self, index: u32) -> Option<[DVec3; 3]> {
        let corners = *self.triangles.get(index as usize)?;
        Some(match &self.vertices {
            Vertices::F32(vertices) => corners.map(|i| Vec3::from(vertices[i as usize]).as_dvec3()),
            Vertices::F64(vertices) => corners.map(|i| DVec3::from(vertices[i as usize])),
        })
    }

    /// Mesh with the triangles of this one and other vertices.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new).
    pub fn with_vertices(&self, vertices: impl Into<Vertices<'a>>) -> Result<Self, MeshError> {
        Self::new(vertices, self.triangles.clone())
    }

    /// Mesh that owns its arrays.
    pub fn into_owned(self) -> TriangleMesh<'static> {
        TriangleMesh {
            vertices: match self.vertices {
                Vertices::F32(vertices) => Vertices::F32(Cow::Owned(vertices.into_owned())),
                Vertices::F64(vertices) => Vertices::F64(Cow::Owned(vertices.into_owned())),
            },
            triangles: Cow::Owned(self.triangles.into_owned()),
        }
    }
}

impl Primitives for TriangleMesh<'_> {
    fn len(&self) -> usize {
        self.triangles.len()
    }

    #[inline]
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.triangle(index).map(Aabb::from_points)
    }

    #[inline]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let hit = WatertightRay::new(ray).intersect(self.triangle(index)?, span)?;
        Some(Hit { t: hit.t, instance: 0, primitive: index, uv: hit.uv })
    }

    #[inline]
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        match (&self.vertices, self.triangles.get(index as usize)) {
            (_, None) => PrimitiveGeometry::Opaque,
            (Vertices::F32(vertices), Some(corners)) => {
                PrimitiveGeometry::ExactTriangle(corners.map(|i| Vec3::from(vertices[i as usize])))
            }
            (Vertices::F64(vertices), Some(corners)) => {
                PrimitiveGeometry::Triangle(corners.map(|i| DVec3::from(vertices[i as usize])))
            }
        }
    }
}

impl ClosestPoint for TriangleMesh<'_> {
    /// Point of the triangle, edges included; `None` for a NaN and for an invalid index.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
        let nearest = nearest_on_triangle(self.triangle(index)?, point);
        point.is_finite().then_some(nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn errors_name_the_offending_index() {
        let bad_index = TriangleMesh::new(&SQUARE, &[[0, 1, 2], [0, 7, 3]]);
        assert_eq!(bad_index, Err(MeshError::VertexIndex { triangle: 1, index: 7, n_vertices: 4 }));
        let mut vertices = SQUARE;
        vertices[2][1] = f32::NAN;
        assert_eq!(TriangleMesh::new(&vertices, &[[0, 1, 2]]), Err(MeshError::Coordinate { vertex: 2 }));
        for bad in [f64::INFINITY, -1.1e60] {
            assert_eq!(TriangleMesh::new(&[[0.0, bad, 0.0]], Vec::new()), Err(MeshError::Coordinate { vertex: 0 }));
        }
        assert!(TriangleMesh::new(&[[0.0, -1e60, 0.0]], Vec::new()).is_ok());
    }

    #[test]
    fn double_precision_is_kept_unless_single_precision_holds_it() {
        let exact = SQUARE.map(|vertex| vertex.map(f64::from));
        let mesh = TriangleMesh::new(&exact, &[[0, 1, 2]]).expect("a mesh");
        assert!(matches!(mesh.geometry(0), PrimitiveGeometry::ExactTriangle(_)));
        let mut vertices = exact;
        vertices[1][0] = 0.1;
        let mesh = TriangleMesh::new(&vertices, &[[0, 1, 2]]).expect("a mesh");
        assert_eq!(mesh.triangle(0).map(|corners| corners[1].x), Some(0.1));
        assert_eq!(mesh.geometry(0), PrimitiveGeometry::Triangle([0, 1, 2].map(|i| DVec3::from(vertices[i]))));
        assert_eq!((mesh.triangle(1), mesh.bounds(1), mesh.geometry(1)), (None, None, PrimitiveGeometry::Opaque));
    }

    #[test]
    fn triangles_without_area_keep_their_place_and_are_never_hit() {
        let mesh = TriangleMesh::new(&SQUARE, &[[0, 1, 1], [0, 1, 2]]).expect("a mesh");
        let ray = Ray::new(DVec3::new(0.5, 0.0, 1.0), DVec3::NEG_Z);
        assert_eq!(mesh.intersect(0, &ray, Interval::FORWARD), None);
        assert_eq!(mesh.intersect(1, &ray, Interval::FORWARD).map(|hit| (hit.t, hit.primitive)), Some((1.0, 1)));
    }
}
