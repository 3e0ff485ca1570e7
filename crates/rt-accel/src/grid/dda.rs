//! Traversal of a ray from cell to cell (3D-DDA).

use rt_math::{Interval, SlabRay};

use super::grid_axis::GridAxis;

/// Traversal state (Amanatides and Woo 1987), with one change: intersections with planes are computed from the indices
/// of the planes, never accumulated.
pub(super) struct Dda<'a> {
    axes: &'a [GridAxis; 3],
    origin: [f64; 3],
    inverse: [f64; 3],
    /// Index of the next plane to cross.
    plane: [u32; 3],
    /// Index of the outer plane of the last cell, which is not crossed.
    last: [u32; 3],
    /// Parameter of the next plane; ∞ without one.
    next_t: [f64; 3],
    /// Increment of the cell index at a plane, modulo 2⁶⁴.
    stride: [usize; 3],
    cell: usize,
    /// Parameter at which the ray leaves the bounds of the grid.
    exit: f64,
}

impl<'a> Dda<'a> {
    /// Starts in the cell at the beginning of `inside`, the part of the ray within the bounds of the grid.
    #[inline]
    pub(super) fn new(axes: &'a [GridAxis; 3], ray: &SlabRay, inside: Interval) -> Self {
        let (origin, direction) = (ray.ray.origin.to_array(), ray.ray.direction.to_array());
        let strides = [1, axes[0].cells as usize, axes[0].cells as usize * axes[1].cells as usize];
        let mut walk = Self {
            axes,
            origin,
            inverse: ray.inverse.to_array(),
            plane: [0; 3],
            last: [0; 3],
            next_t: [f64::INFINITY; 3],
            stride: [0; 3],
            cell: 0,
            exit: inside.max,
        };
        for axis in 0..3 {
            // A direction whose inverse is infinite counts as zero, as in the slab test.
            let is_parallel = walk.inverse[axis].is_infinite();
            let start = if is_parallel { origin[axis] } else { origin[axis] + inside.min * direction[axis] };
            let index = axes[axis].index(start);
            walk.cell += index as usize * strides[axis];
            if is_parallel {
                continue;
            }
            if walk.inverse[axis].is_sign_negative() {
                walk.plane[axis] = index;
                walk.stride[axis] = strides[axis].wrapping_neg();
            } else {
                walk.plane[axis] = index + 1;
                walk.last[axis] = axes[axis].cells;
                walk.stride[axis] = strides[axis];
            }
            walk.next_t[axis] = walk.crossing(axis);
        }
        walk
    }

    /// Index of the current cell.
    #[inline(always)]
    pub(super) fn cell(&self) -> usize {
        self.cell
    }

    /// Moves to the next cell. False if the ray enters it strictly after `limit`, or has left the grid.
    #[inline(always)]
    pub(super) fn advance(&mut self, limit: f64) -> bool {
        let [x, y, z] = self.next_t;
        let axis = if x < y {
            if x < z { 0 } else { 2 }
        } else if y < z {
            1
        } else {
            2
        };
        let t = self.next_t[axis];
        if t > limit || t > self.exit || t == f64::INFINITY {
            return false;
        }
        self.cell = self.cell.wrapping_add(self.stride[axis]);
        if self.inverse[axis].is_sign_negative() {
            self.plane[axis] -= 1;
        } else {
            self.plane[axis] += 1;
        }
        self.next_t[axis] = self.crossing(axis);
        true
    }

    #[inline(always)]
    fn crossing(&self, axis: usize) -> f64 {
        if self.plane[axis] == self.last[axis] {
            return f64::INFINITY;
        }
        (self.axes[axis].plane(self.plane[axis]) - self.origin[axis]) * self.inverse[axis]
    }
}
