//! The list, and its construction.

use glam::Vec3;
use rt_geometry::{PrimitiveGeometry, Primitives, padded_bounds};
use rt_math::DVec3;

use super::entry::{ExactPlane, FilterTriangle, ListOther, ListTriangle, corners};
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
    pub(in crate::wide) filters: Vec<FilterTriangle>,
    /// Exact data, one for each filter.
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
        let mut list =
            Self { filters: Vec::with_capacity(count), triangles: Vec::with_capacity(count), others: vec![] };
        for index in 0..count as u32 {
            if let PrimitiveGeometry::ExactTriangle(vertices) = primitives.geometry(index)
                && let Some(filter) = FilterTriangle::new(vertices, centre, size)
            {
                list.push(filter, vertices, index);
                continue;
            }
            list.others.push(ListOther {
                bounds: padded_bounds(primitives, index)?,
                index,
                casts_shadow: primitives.blocks(index),
            });
        }
        (list.others.len() <= MAX_OTHERS).then_some(list)
    }

    fn push(&mut self, filter: FilterTriangle, vertices: [Vec3; 3], index: u32) {
        self.filters.push(filter);
        self.triangles.push(ListTriangle { corners: corners(vertices), plane: ExactPlane::new(vertices), index });
    }

    /// True if all numbers of a loaded list can be used with so many primitives.
    pub(in crate::wide) fn is_whole(&self, count: usize) -> bool {
        let mut indices = self.triangles.iter().map(|it| it.index).chain(self.others.iter().map(|it| it.index));
        self.filters.len() == self.triangles.len()
            && self.triangles.len() <= MAX_TRIANGLES
            && indices.all(|index| (index as usize) < count)
    }

    /// Bytes on the heap.
    pub(in crate::wide) fn memory(&self) -> usize {
        self.filters.capacity() * size_of::<FilterTriangle>()
            + self.triangles.capacity() * size_of::<ListTriangle>()
            + self.others.capacity() * size_of::<ListOther>()
    }
}
