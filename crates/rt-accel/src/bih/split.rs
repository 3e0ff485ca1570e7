//! Selection of splits: the global heuristic of Wächter and Keller.

use rt_math::Aabb;

use super::planes::Planes;
use crate::axis::Axis;
use crate::binned_sah::{bounds_of, centroid_bounds, median_split, partition};
use crate::prim_bounds::Item;
use crate::top_down::SliceSplit;
use crate::traversal::depth_allows_median_split;

/// Maximum number of primitives in a leaf.
pub(super) const MAX_LEAF: usize = 4;

/// Maximum number of halvings of a cell that separate no primitives.
const MOST_EMPTY_HALVES: u32 = 256;

/// Reorders `items` and splits them, or returns `None` for a leaf. A pure function.
///
/// Halves the cell of a node across its longest side, and items go to the side of their centre. An empty half is
/// dropped and the other one halved again, so that planes lie on a regular grid over the whole scene. Where all centres
/// coincide, and where the remaining depth is needed for it, the set is split at the median instead.
pub(super) fn split(items: &mut [Item], cell: &Aabb, depth: u32) -> Option<SliceSplit<Planes, Aabb>> {
    if items.len() <= MAX_LEAF {
        return None;
    }
    let centres = centroid_bounds(items);
    let halves = if depth_allows_median_split(items.len(), depth) { halve_cell(*cell, &centres) } else { None };
    let (axis, middle, states) = match halves {
        Some(Halves { axis, plane, cells }) => {
            (axis, partition(items, |(_, own)| own.centre()[axis as usize] < plane), cells)
        }
        None => {
            let axis = Axis::ALL[centres.extent().max_position()];
            (axis, median_split(items, &centres), [*cell; 2])
        }
    };
    let [left, right] = [&items[..middle], &items[middle..]].map(bounds_of);
    Some(SliceSplit { middle, payload: Planes::around(axis, &left, &right), states })
}

/// Halves of a cell, neither of them empty.
struct Halves {
    axis: Axis,
    plane: f64,
    cells: [Aabb; 2],
}

fn halve_cell(mut cell: Aabb, centres: &Aabb) -> Option<Halves> {
    if centres.min == centres.max {
        return None;
    }
    for _ in 0..MOST_EMPTY_HALVES {
        // Half the extent, which does not overflow.
        let axis = (cell.max * 0.5 - cell.min * 0.5).max_position();
        let plane = cell.centre()[axis];
        let (mut lower, mut upper) = (cell, cell);
        (lower.max[axis], upper.min[axis]) = (plane, plane);
        if centres.max[axis] < plane {
            cell = lower;
        } else if plane <= centres.min[axis] {
            cell = upper;
        } else {
            return Some(Halves { axis: Axis::ALL[axis], plane, cells: [lower, upper] });
        }
    }
    None
}
