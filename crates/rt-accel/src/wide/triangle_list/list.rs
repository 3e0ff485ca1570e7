//! The list, and its construction.

use glam::Vec3;
use rt_geometry::{PrimitiveGeometry, Primitives, padded_bounds};
use rt_math::DVec3;

use super::entry::{ExactPlane, FilterPair, FilterTriangle, ListOther, ListTriangle, corners};
use crate::wide::leaf::LeafKind;
use crate::wide::ray::RANGE;

/// Most triangles of a list: their numbers replace the last bits of keys.
pub(in crate::wide) const MAX_TRIANGLES: usize = 64;

/// Most other primitives of a list.
const MAX_OTHERS: usize = 4;

/// All primitives of a small tree that are mostly exact triangles.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct TriangleList {
    /// Triangles that follow each other in the tree and share a plane: most halves of quadrilaterals.
    pub(in crate::wide) pairs: Vec<FilterPair>,
    /// All other triangles.
    pub(in crate::wide) filters: Vec<FilterTriangle>,
    /// Exact data of the triangles of all pairs, and then of the others.
    pub(in crate::wide) triangles: Vec<ListTriangle>,
    pub(in crate::wide) others: Vec<ListOther>,
}

impl TriangleList {
    /// Lists all primitives of a tree. `None` if there are too many, or if too few are triangles that the filter applies
    /// to.
    pub(in crate::wide) fn of<P: Primitives>(primitives: &P, kind: LeafKind, centre: DVec3, size: f64) -> Option<Self> {
        let count = primitives.len();
        if kind != LeafKind::Watertight || count > MAX_TRIANGLES || !RANGE.contains(&size) {
            return None;
        }
        let (mut triangles, mut others) = (Vec::with_capacity(count), Vec::new());
        for index in 0..count as u32 {
            if let PrimitiveGeometry::ExactTriangle(vertices) = primitives.geometry(index)
                && let Some(filter) = FilterTriangle::new(vertices, centre, size)
            {
                // Of equal triangles, the first is the closest.
                if triangles.iter().all(|(_, earlier, _)| *earlier != vertices) {
                    triangles.push((filter, vertices, index));
                }
                continue;
            }
            others.push(ListOther {
                bounds: padded_bounds(primitives, index)?,
                index,
                casts_shadow: primitives.casts_shadow(index),
            });
        }
        (others.len() <= MAX_OTHERS).then(|| Self::of_triangles(&triangles, others))
    }

    /// List of triangles with their vertices and numbers in the tree, and of other primitives.
    fn of_triangles(triangles: &[(FilterTriangle, [Vec3; 3], u32)], others: Vec<ListOther>) -> Self {
        let (mut pairs, mut filters) = (Vec::new(), Vec::new());
        let (mut of_pairs, mut single) = (Vec::with_capacity(triangles.len()), Vec::new());
        let mut rest = triangles;
        while let [first, later @ ..] = rest {
            let exact = |&(_, vertices, index): &(FilterTriangle, [Vec3; 3], u32)| ListTriangle {
                corners: corners(vertices),
                plane: ExactPlane::new(vertices),
                index,
            };
            rest = later;
            if let [second, later @ ..] = later
                && let Some(pair) = FilterPair::new([(&first.0, first.1), (&second.0, second.1)])
            {
                pairs.push(pair);
                of_pairs.extend([exact(first), exact(second)]);
                rest = later;
                continue;
            }
            filters.push(first.0);
            single.push(exact(first));
        }
        of_pairs.append(&mut single);
        Self { pairs, filters, triangles: of_pairs, others }
    }

    /// True if all numbers of a loaded list can be used with so many primitives.
    pub(in crate::wide) fn is_whole(&self, count: usize) -> bool {
        let mut indices = self.triangles.iter().map(|it| it.index).chain(self.others.iter().map(|it| it.index));
        // A loaded list may be of any lengths, but none is near the end of `usize`.
        2 * self.pairs.len() + self.filters.len() == self.triangles.len()
            && self.triangles.len() <= MAX_TRIANGLES
            && indices.all(|index| (index as usize) < count)
    }

    /// Bytes on the heap.
    pub(in crate::wide) fn memory(&self) -> usize {
        self.pairs.capacity() * size_of::<FilterPair>()
            + self.filters.capacity() * size_of::<FilterTriangle>()
            + self.triangles.capacity() * size_of::<ListTriangle>()
            + self.others.capacity() * size_of::<ListOther>()
    }
}

#[cfg(test)]
mod tests {
    use rt_geometry::{MeshData, TriangleMesh};

    use super::*;

    fn list(triangles: &[[Vec3; 3]]) -> TriangleList {
        let filter = |vertices: &[Vec3; 3]| FilterTriangle::new(*vertices, DVec3::ZERO, 4.0);
        let all: Option<Vec<_>> =
            (0..).zip(triangles).map(|(index, it)| filter(it).map(|filter| (filter, *it, index))).collect();
        TriangleList::of_triangles(&all.expect("triangles that the filter applies to"), Vec::new())
    }

    #[test]
    fn halves_of_a_quadrilateral_are_a_pair() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let above = Vec3::Z;
        // Any corner may come first, and other triangles before and after.
        let list = list(&[[a, b, above], [a, b, c], [d, a, c], [b, c, above]]);
        assert_eq!((list.pairs.len(), list.filters.len()), (1, 2));
        let order: Vec<_> = list.triangles.iter().map(|triangle| triangle.index).collect();
        assert_eq!(order, [1, 2, 0, 3]);
        assert!(list.is_whole(4));
    }

    #[test]
    fn triangles_that_overlap_or_meet_at_an_angle_are_no_pairs() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let raised = d + 0.25 * Vec3::Z;
        for second in [[a, b, c], [a, b, d], [a, c, raised], [c, a, d]] {
            assert_eq!(list(&[[a, b, c], second]).pairs.len(), 0, "{second:?}");
        }
    }

    #[test]
    fn equal_triangles_are_listed_once() {
        let quad = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let positions = quad.iter().chain(&quad).chain(&[Vec3::Z]).copied().collect();
        let triangles = vec![[0, 1, 8], [0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let data = MeshData { positions, triangles, ..MeshData::default() };
        let (mesh, _) = TriangleMesh::build(data).expect("a mesh");
        let list = TriangleList::of(&mesh, LeafKind::Watertight, DVec3::splat(0.5), 1.0).expect("a list");
        let order: Vec<_> = list.triangles.iter().map(|triangle| triangle.index).collect();
        assert_eq!(order, [1, 2, 0]);
    }
}
