//! Binned SAH: finds a split by the surface area heuristic (MacDonald and Booth 1990) over bins of centroids, on all
//! three axes at once. See Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.

use glam::{BVec3A, Vec3A};

use super::prim_ref::PrimRef;
use crate::bvh::Aabb32;

const MAX_BINS: usize = 32;

/// Addition of this constant rounds a small number to an integer in the low bits of the sum.
const ROUNDING: f32 = 1.5 * (1u32 << 23) as f32;

/// Half surface area in units of the scene, so that no scale over- or underflows.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalizedArea(f32);

impl NormalizedArea {
    pub(super) fn new(scene: &Aabb32) -> Self {
        Self((1.0 / (scene.max - scene.min).max_element()).clamp(f32::MIN_POSITIVE, 1e37))
    }

    /// Infinite or NaN for an empty box.
    #[inline(always)]
    pub(super) fn area(self, bounds: &Aabb32) -> f32 {
        let edges = (bounds.max - bounds.min) * self.0;
        edges.dot(glam::Vec3Swizzles::yzx(edges))
    }
}

/// Mapping from centroids to bins.
#[derive(Clone, Copy)]
pub(super) struct BinMapping {
    min: Vec3A,
    scale: Vec3A,
    /// Number of bins in use.
    len: usize,
    axes: Axes,
}

/// Axes on which splits are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    All,
    /// The axis with the largest extent of centroids.
    Widest,
}

/// A plane between two bins.
#[derive(Clone, Copy)]
pub(super) struct BinSplit {
    axis: usize,
    min: f32,
    scale: f32,
    /// First bin on the right.
    first_right: u32,
}

impl BinMapping {
    /// Mapping for `count` references with centroids in this box.
    pub(super) fn new(centroids: &Aabb32, count: usize, axes: Axes) -> Self {
        let len = (4 + count / 8).min(MAX_BINS);
        let scale = Vec3A::splat(len as f32 * 0.99999) / (centroids.max - centroids.min);
        Self { min: centroids.min, scale: scale.min(Vec3A::splat(f32::MAX)), len, axes }
    }

    /// Bin on each axis; 0 on an axis without a finite extent.
    #[inline(always)]
    fn bins(&self, reference: &PrimRef) -> [u32; 3] {
        let position = (reference.centroid() - self.min) * self.scale;
        let rounded = (position - 0.5) + ROUNDING;
        rounded.to_array().map(bin_at)
    }

    fn cut(&self, axis: usize, first_right: u32) -> BinSplit {
        BinSplit { axis, min: self.min[axis], scale: self.scale[axis], first_right }
    }
}

impl BinSplit {
    #[inline(always)]
    fn bin(&self, reference: &PrimRef) -> u32 {
        let position = (reference.centroid_on(self.axis) - self.min) * self.scale;
        bin_at((position - 0.5) + ROUNDING)
    }

    /// Side of a reference: 0 or 1.
    #[inline(always)]
    pub(super) fn side(&self, reference: &PrimRef) -> usize {
        usize::from(self.bin(reference) >= self.first_right)
    }
}

#[inline(always)]
fn bin_at(rounded: f32) -> u32 {
    rounded.to_bits() % MAX_BINS as u32
}

/// Visits references alternately from both halves: neighbours often share a bin, which serialises their updates.
#[inline(always)]
fn in_two_streams(references: &[PrimRef], mut visit: impl FnMut(&PrimRef)) {
    let (front, back) = references.split_at(references.len() / 2);
    let (last, back) = back.split_at(back.len() - front.len());
    for (a, b) in front.iter().zip(back) {
        visit(a);
        visit(b);
    }
    last.iter().for_each(visit);
}

/// Bounds and counts of the bins on all three axes.
pub(super) struct Bins {
    binning: BinMapping,
    boxes: [[Aabb32; 3]; MAX_BINS],
    counts: [[u32; 4]; MAX_BINS],
}

/// The split of minimum cost, and the bounds of both sides.
pub(super) struct BestSplit {
    pub(super) cut: BinSplit,
    /// Number of references on the left.
    pub(super) middle: usize,
    pub(super) bounds: [Aabb32; 2],
}

impl Bins {
    pub(super) fn new() -> Self {
        let binning = BinMapping::new(&Aabb32::EMPTY, 0, Axes::All);
        Self { binning, boxes: [[Aabb32::EMPTY; 3]; MAX_BINS], counts: [[0; 4]; MAX_BINS] }
    }

    /// Clears the bins in use.
    pub(super) fn reset(&mut self, binning: BinMapping) {
        self.binning = binning;
        self.boxes[..binning.len].fill([Aabb32::EMPTY; 3]);
        self.counts[..binning.len].fill([0; 4]);
    }

    pub(super) fn add(&mut self, references: &[PrimRef]) {
        match self.binning.axes {
            Axes::All => in_two_streams(references, |reference| {
                let bounds = reference.bounds();
                for (axis, bin) in self.binning.bins(reference).into_iter().enumerate() {
                    let bin = bin as usize;
                    self.boxes[bin][axis] = self.boxes[bin][axis].union(bounds);
                    self.counts[bin][axis] += 1;
                }
            }),
            Axes::Widest => {
                let (axis, cut) =
                    (self.binning.scale.min_position(), self.binning.cut(self.binning.scale.min_position(), 0));
                in_two_streams(references, |reference| {
                    let bin = cut.bin(reference) as usize;
                    self.boxes[bin][axis] = self.boxes[bin][axis].union(reference.bounds());
                    self.counts[bin][axis] += 1;
                });
            }
        }
    }

    /// Adds bins of the same mapping.
    #[cfg(feature = "parallel")]
    pub(super) fn merge(&mut self, other: &Self) {
        for bin in 0..self.binning.len {
            for axis in 0..3 {
                self.boxes[bin][axis] = self.boxes[bin][axis].union(other.boxes[bin][axis]);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
    }

    /// Number of references on the left of a cut.
    pub(super) fn left_of(&self, cut: &BinSplit) -> usize {
        self.counts[..cut.first_right as usize].iter().map(|counts| counts[cut.axis] as usize).sum()
    }

    /// Split of minimum cost with references on both sides; the first in order of axes and bins among equals.
    pub(super) fn best_split(&self, unit: NormalizedArea) -> Option<BestSplit> {
        let len = self.binning.len;
        let areas = |boxes: &[Aabb32; 3]| Vec3A::from_array(core::array::from_fn(|axis| unit.area(&boxes[axis])));
        let count = |counts: &[u32; 4]| Vec3A::from_array(core::array::from_fn(|axis| counts[axis] as i32 as f32));

        let mut right_costs = [Vec3A::ZERO; MAX_BINS];
        let (mut boxes, mut counts) = ([Aabb32::EMPTY; 3], Vec3A::ZERO);
        for bin in (1..len).rev() {
            boxes = core::array::from_fn(|axis| boxes[axis].union(self.boxes[bin][axis]));
            counts += count(&self.counts[bin]);
            right_costs[bin] = areas(&boxes) * counts;
        }
        let (mut boxes, mut counts) = ([Aabb32::EMPTY; 3], Vec3A::ZERO);
        let (mut min_cost, mut place) = (Vec3A::INFINITY, Vec3A::ZERO);
        for (bin, right_cost) in right_costs.iter().enumerate().take(len).skip(1) {
            boxes = core::array::from_fn(|axis| boxes[axis].union(self.boxes[bin - 1][axis]));
            counts += count(&self.counts[bin - 1]);
            // NaN for an empty side: an infinite area times zero.
            let costs = areas(&boxes) * counts + *right_cost;
            let is_less: BVec3A = costs.cmplt(min_cost);
            min_cost = Vec3A::select(is_less, costs, min_cost);
            place = Vec3A::select(is_less, Vec3A::splat(bin as f32), place);
        }
        let axis = min_cost.min_position();
        (min_cost[axis] < f32::INFINITY).then(|| self.at(axis, place[axis] as usize))
    }

    fn at(&self, axis: usize, bin: usize) -> BestSplit {
        let union = |boxes: &[[Aabb32; 3]]| boxes.iter().fold(Aabb32::EMPTY, |all, bins| all.union(bins[axis]));
        let (left, right) = self.boxes[..self.binning.len].split_at(bin);
        let cut = self.binning.cut(axis, bin as u32);
        BestSplit { cut, middle: self.left_of(&cut), bounds: [union(left), union(right)] }
    }
}
