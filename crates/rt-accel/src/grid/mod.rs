//! Uniform grid.

mod dda;
mod grid_axis;
mod resolution;

use core::ops::{ControlFlow, RangeInclusive};

use rt_geometry::{Primitives, Probe, padded_bounds};
use rt_math::{Aabb, Interval, SlabRay};

use crate::prim_bounds::{PrimBounds, validate_lists};
use crate::{Accelerator, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError, ray_query::is_finite};
use dda::Dda;
use grid_axis::GridAxis;
use resolution::{MAX_CELLS, cubical, suitable_cells};

/// Maximum number of references to primitives: 4 GiB.
const MAX_REFERENCES: u64 = 1 << 30;

/// Box of equal cells with a list of primitives each. The fastest accelerator to build, and a good one for evenly
/// distributed primitives of similar size.
///
/// Rays traverse the grid cell by cell (Amanatides and Woo 1987), and test a primitive in each of its cells. A few
/// small primitives in a large scene share one cell ("teapot in a stadium"): prefer [`Bvh`](crate::Bvh) there.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct UniformGrid {
    bounds: Aabb,
    axes: [GridAxis; 3],
    /// Start of the list of each cell in `indices`, and the end of the last one.
    starts: Vec<u32>,
    /// Primitives cell by cell, by rising index.
    indices: Vec<u32>,
    unbounded: Vec<u32>,
    primitives: u32,
}

impl UniformGrid {
    /// Builds a grid with about six nearly cubical cells per primitive, fewer where large primitives would fill too
    /// many.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let count = boxes.bounded.len();
        let mut cells = suitable_cells(count);
        loop {
            let bounds = boxes.finite_union();
            let axes = divide(&bounds, cubical(bounds.extent(), cells));
            if cells == 1 || n_references(&boxes, &axes) <= 16 * count as u64 + 4096 {
                return Self::fill(boxes, axes);
            }
            cells /= 4;
        }
    }

    /// Builds a grid with this number of cells along x, y and z. Zeros count as one, and cells that `f64` coordinates
    /// cannot distinguish are merged: see [`resolution`](Self::resolution).
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build), and [`BuildError::TooMany`] for more than 2²⁶ cells or 2³⁰ references.
    pub fn with_resolution<P: Primitives>(primitives: &P, resolution: [u32; 3]) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let axes = divide(&boxes.finite_union(), resolution);
        Self::fill(boxes, axes)
    }

    /// Counting sort of references by cell.
    fn fill(boxes: PrimBounds, axes: [GridAxis; 3]) -> Result<Self, BuildError> {
        let cells = axes.iter().fold(1u64, |product, axis| product.saturating_mul(u64::from(axis.cells)));
        for (count, limit) in [(cells, MAX_CELLS), (n_references(&boxes, &axes), MAX_REFERENCES)] {
            if count > limit {
                return Err(BuildError::TooMany { count, limit });
            }
        }
        let mut starts = vec![0u32; cells as usize + 1];
        for (_, own) in &boxes.bounded {
            for_each_cell(&axes, own, |cell| starts[cell] += 1);
        }
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        // Fill each list from its end, so that its end becomes its start.
        let mut indices = vec![0; total as usize];
        for (index, own) in boxes.bounded.iter().rev() {
            for_each_cell(&axes, own, |cell| {
                starts[cell] -= 1;
                indices[starts[cell] as usize] = *index;
            });
        }
        let primitives = (boxes.bounded.len() + boxes.unbounded.len()) as u32;
        Ok(Self { bounds: boxes.finite_union(), axes, starts, indices, unbounded: boxes.unbounded, primitives })
    }

    /// Number of cells along x, y and z.
    pub fn resolution(&self) -> [u32; 3] {
        self.axes.map(|axis| axis.cells)
    }

    /// Checks all invariants that do not depend on the primitives.
    #[cfg(feature = "serde")]
    fn check_shape(&self) -> Result<(), ValidationError> {
        let cells = self.axes.iter().try_fold(1u64, |product, axis| product.checked_mul(u64::from(axis.cells)));
        let is_divided = self.axes.iter().all(GridAxis::is_valid);
        let ends = [self.starts.first(), self.starts.last()].map(|end| end.map(|&end| end as usize));
        let n_starts = cells.filter(|&cells| cells > 0).and_then(|cells| cells.checked_add(1));
        let is_listed = n_starts == Some(self.starts.len() as u64)
            && self.starts.is_sorted()
            && ends == [Some(0), Some(self.indices.len())];
        if !(is_divided && is_listed) {
            return Err(ValidationError::Count { built: self.primitives, given: self.indices.len() });
        }
        match self.indices.iter().chain(&self.unbounded).find(|&&index| index >= self.primitives) {
            Some(&primitive) => Err(ValidationError::Misplaced { primitive }),
            None => Ok(()),
        }
    }

    /// Primitives of a cell.
    #[inline(always)]
    fn list(&self, cell: usize) -> &[u32] {
        let [start, end] = [self.starts[cell], self.starts[cell + 1]];
        &self.indices[start as usize..end as usize]
    }

    /// Intersects a ray with the bounds of the grid.
    #[inline(always)]
    fn grid_entry(&self, ray: &SlabRay, span: Interval) -> GridEntry {
        let resolves = |axis: usize| self.axes[axis].resolves(ray.ray.origin[axis], ray.ray.direction[axis]);
        if !(is_finite(&ray.ray) && resolves(0) && resolves(1) && resolves(2)) {
            return GridEntry::Unresolved;
        }
        match self.bounds.clip(ray, span) {
            None => GridEntry::Missed,
            Some(inside) if inside.min.is_finite() && inside.max.is_finite() => GridEntry::Inside(inside),
            Some(_) => GridEntry::Unresolved,
        }
    }
}

/// Intersection of a ray with the bounds of the grid.
enum GridEntry {
    /// The ray hits no bounded primitive.
    Missed,
    /// All hits are in the cells along this part of the ray.
    Inside(Interval),
    /// Rounding hides the cells on the path: every primitive has to be tested.
    Unresolved,
}

fn divide(bounds: &Aabb, resolution: [u32; 3]) -> [GridAxis; 3] {
    core::array::from_fn(|axis| GridAxis::new(bounds.min[axis], bounds.max[axis], resolution[axis]))
}

fn n_references(boxes: &PrimBounds, axes: &[GridAxis; 3]) -> u64 {
    let n_cells = |own: &Aabb| {
        (0..3)
            .map(|axis| axes[axis].insertion_range(own.min[axis], own.max[axis]))
            .fold(1u64, |product, range| product.saturating_mul(u64::from(range.end() - range.start()) + 1))
    };
    boxes.bounded.iter().fold(0, |sum, (_, own)| sum.saturating_add(n_cells(own)))
}

fn for_each_cell(axes: &[GridAxis; 3], own: &Aabb, mut visit: impl FnMut(usize)) {
    let ranges = core::array::from_fn(|axis| axes[axis].insertion_range(own.min[axis], own.max[axis]));
    for_each_in(axes, ranges, |_, cell| visit(cell));
}

/// Visits cells with their indices along x, y and z, and in the list of all.
fn for_each_in(axes: &[GridAxis; 3], ranges: [RangeInclusive<u32>; 3], mut visit: impl FnMut([u32; 3], usize)) {
    let [x, y, z] = ranges;
    for k in z {
        for j in y.clone() {
            let row = (k as usize * axes[1].cells as usize + j as usize) * axes[0].cells as usize;
            for i in x.clone() {
                visit([i, j, k], row + i as usize);
            }
        }
    }
}

impl Accelerator for UniformGrid {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.test_leaf(primitives, &self.unbounded, probe)?;
        match self.grid_entry(query.ray(), query.span()) {
            GridEntry::Missed => {}
            GridEntry::Inside(inside) => {
                let ray = *query.ray();
                let mut walk = Dda::new(&self.axes, &ray, inside);
                loop {
                    probe.node();
                    query.test_leaf(primitives, self.list(walk.cell()), probe)?;
                    if !walk.advance(query.span().max) {
                        break;
                    }
                }
            }
            GridEntry::Unresolved => {
                for index in 0..self.primitives {
                    query.test_primitive(primitives, index, probe)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits cells in shells around that of the query point.
    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.test_leaf(&self.unbounded)?;
        let focus = query.query_point();
        let start = core::array::from_fn(|axis| self.axes[axis].index(focus[axis]));
        for distance in 0.. {
            let bounds = query.bounds();
            if !bounds.overlaps(&self.bounds) {
                break;
            }
            let ranges = core::array::from_fn(|axis| {
                self.axes[axis].index(bounds.min[axis])..=self.axes[axis].index(bounds.max[axis])
            });
            if !self.search_shell(&CellShell { start, distance }, &ranges, query)? {
                break;
            }
        }
        ControlFlow::Continue(())
    }

    fn memory(&self) -> usize {
        let numbers = self.starts.capacity() + self.indices.capacity() + self.unbounded.capacity();
        size_of::<Self>() + numbers * size_of::<u32>()
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded.len(),
            nodes: self.starts.len() - 1,
            leaves: self.starts.windows(2).filter(|ends| ends[0] < ends[1]).count(),
            max_depth: 1,
            references: self.indices.len(),
            sah_cost: None,
        }
    }

    /// Checks that each bounded primitive lies within the grid and is listed in every cell that its padded bounds
    /// touch.
    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        validate_lists(primitives, self.primitives, &self.unbounded)?;
        for primitive in 0..self.primitives {
            let Some(own) = padded_bounds(primitives, primitive) else { continue };
            if !self.bounds.encloses(&own) {
                return Err(ValidationError::Outside { primitive });
            }
            let [x, y, z] = core::array::from_fn(|axis| self.axes[axis].touched_range(own.min[axis], own.max[axis]));
            let mut is_listed = true;
            for_each_in(&self.axes, [x, y, z], |_, cell| {
                is_listed &= self.list(cell).binary_search(&primitive).is_ok()
            });
            if !is_listed {
                return Err(ValidationError::Misplaced { primitive });
            }
        }
        Ok(())
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        visit(self.bounds, 0);
        let [x, y, z] = self.resolution();
        for_each_in(&self.axes, [0..=x - 1, 0..=y - 1, 0..=z - 1], |place, cell| {
            if !self.list(cell).is_empty() {
                let corner = |side: u32| {
                    glam::DVec3::from_array(core::array::from_fn(|axis| self.axes[axis].plane(place[axis] + side)))
                };
                visit(Aabb::new(corner(0), corner(1)), 1);
            }
        });
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(UniformGrid, UniformGrid::check_shape);

/// Cells whose indices differ from those of a starting cell by `distance` on one axis, and by no more on others.
struct CellShell {
    start: [u32; 3],
    distance: u32,
}

impl CellShell {
    /// Part of an index range that is no farther away than the shell.
    fn clamped_range(&self, axis: usize, range: &RangeInclusive<u32>) -> RangeInclusive<u32> {
        let (start, distance) = (self.start[axis], self.distance);
        start.saturating_sub(distance).max(*range.start())..=start.saturating_add(distance).min(*range.end())
    }

    fn is_on(&self, axis: usize, number: u32) -> bool {
        self.start[axis].abs_diff(number) == self.distance
    }

    /// True if cells in the ranges are as far away as the shell, or farther.
    fn is_needed(&self, ranges: &[RangeInclusive<u32>; 3]) -> bool {
        (0..3).any(|axis| {
            let farthest = |number: u32| self.start[axis].abs_diff(number);
            farthest(*ranges[axis].start()).max(farthest(*ranges[axis].end())) >= self.distance
        })
    }
}

impl UniformGrid {
    /// Tests the primitives in the cells of a shell within the ranges. False if all further shells are out of range.
    fn search_shell<Q: RegionQuery>(
        &self,
        shell: &CellShell,
        ranges: &[RangeInclusive<u32>; 3],
        query: &mut Q,
    ) -> ControlFlow<(), bool> {
        if !shell.is_needed(ranges) {
            return ControlFlow::Continue(false);
        }
        let x_range = shell.clamped_range(0, &ranges[0]);
        for z in shell.clamped_range(2, &ranges[2]) {
            for y in shell.clamped_range(1, &ranges[1]) {
                let is_side = shell.is_on(2, z) || shell.is_on(1, y);
                let row = (z as usize * self.axes[1].cells as usize + y as usize) * self.axes[0].cells as usize;
                let mut visit = |x: u32| self.search_cell(row + x as usize, [x, y, z], query);
                if is_side {
                    x_range.clone().try_for_each(visit)?;
                    continue;
                }
                // Between the sides of the shell, only the two ends of a row belong to it.
                let ends = [shell.start[0].checked_sub(shell.distance), shell.start[0].checked_add(shell.distance)];
                ends.into_iter().flatten().filter(|x| x_range.contains(x)).try_for_each(&mut visit)?;
            }
        }
        ControlFlow::Continue(true)
    }

    fn search_cell<Q: RegionQuery>(&self, cell: usize, place: [u32; 3], query: &mut Q) -> ControlFlow<()> {
        for &index in self.list(cell) {
            query
                .test_primitive(index, |point| (0..3).all(|axis| self.axes[axis].index(point[axis]) == place[axis]))?;
        }
        ControlFlow::Continue(())
    }
}
