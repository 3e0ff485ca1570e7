//! Kinds of leaves.

use glam::DVec3;
use rt_geometry::PrimitiveGeometry;

use super::block::LINE;
use super::boxes::BOX_NUMBERS;
use super::spheres::{SPHERE_HEADER, SPHERE_NUMBERS};
use super::triangles::{TRIANGLE_HEADER, TRIANGLE_NUMBERS};

/// Kind of copies in the leaves of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) enum LeafKind {
    /// Exact vertices of triangles, for exact tests; some primitives may be of other types.
    Watertight,
    /// Vertices of triangles relative to the centre of the tree, rounded; some primitives may be of other types.
    Triangles,
    /// Rounded centres, relative to that of the tree, and radii; other primitives have bounding spheres.
    Spheres,
    /// Boxes relative to the centre of the tree, rounded outward.
    Boxes,
}

/// Leaves hold exact vertices up to this distance of the tree from the origin, in sizes of the tree. Farther away,
/// vertices relative to the centre lose fewer digits.
const NEAR: f64 = 64.0;

/// Minimum ratio of triangles, or spheres, to all other primitives of a tree with leaves of that kind.
const MAJORITY_RATIO: u64 = 3;

/// Number of primitives by kind of geometry.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::wide) struct GeometryCounts {
    n_spheres: u64,
    /// Triangles with exact copies.
    n_watertight: u64,
    n_triangles: u64,
    n_others: u64,
}

impl GeometryCounts {
    pub(in crate::wide) const NONE: Self = Self { n_spheres: 0, n_watertight: 0, n_triangles: 0, n_others: 0 };

    #[inline(always)]
    pub(in crate::wide) const fn of(layout: &PrimitiveGeometry) -> Self {
        let n_spheres = matches!(layout, PrimitiveGeometry::Sphere(..) | PrimitiveGeometry::ExactSphere(_)) as u64;
        let n_watertight = matches!(layout, PrimitiveGeometry::ExactTriangle(_)) as u64;
        let n_triangles = matches!(layout, PrimitiveGeometry::Triangle(_)) as u64 + n_watertight;
        Self { n_spheres, n_watertight, n_triangles, n_others: 1 - n_spheres - n_triangles }
    }

    #[inline(always)]
    pub(in crate::wide) const fn and(self, other: Self) -> Self {
        Self {
            n_spheres: self.n_spheres + other.n_spheres,
            n_watertight: self.n_watertight + other.n_watertight,
            n_triangles: self.n_triangles + other.n_triangles,
            n_others: self.n_others + other.n_others,
        }
    }
}

impl LeafKind {
    /// Most specific kind that suits all primitives, or a large majority of triangles or spheres.
    pub(in crate::wide) fn of(layouts: GeometryCounts, centre: DVec3, size: f64) -> Self {
        let GeometryCounts { n_spheres, n_watertight, n_triangles, n_others } = layouts;
        let n = n_spheres + n_triangles + n_others;
        let are_most = |matching: u64| (n - matching) * MAJORITY_RATIO <= matching;
        if are_most(n_spheres) {
            Self::Spheres
        } else if are_most(n_watertight) && centre.abs().max_element() <= NEAR * size {
            Self::Watertight
        } else if are_most(n_triangles) {
            Self::Triangles
        } else {
            Self::Boxes
        }
    }

    pub(super) const fn lines(self, count: usize) -> usize {
        let (header, numbers) = self.shape();
        (header + (numbers + 1) * count).div_ceil(LINE)
    }

    /// Words of the header, and numbers per primitive.
    pub(super) const fn shape(self) -> (usize, usize) {
        match self {
            Self::Watertight | Self::Triangles => (TRIANGLE_HEADER, TRIANGLE_NUMBERS),
            Self::Spheres => (SPHERE_HEADER, SPHERE_NUMBERS),
            Self::Boxes => (0, BOX_NUMBERS),
        }
    }
}
