//! Where to cut a set of references in two: the surface area heuristic (MacDonald and Booth 1990) over bins of centroids
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), on all three axes at once.

use glam::{BVec3A, Vec3A};

use super::reference::PrimRef;
use crate::bvh::NodeBox;

const MAX_BINS: usize = 32;

/// Adding it rounds a small number to an integer, which then is the low bits of the sum.
const ROUNDING: f32 = 1.5 * (1u32 << 23) as f32;

/// Half of the surface area in units of the scene, so that it neither overflows nor vanishes, whatever the scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalizedArea(f32);

impl NormalizedArea {
    pub(super) fn new(scene: &NodeBox) -> Self {
        Self((1.0 / (scene.max - scene.min).max_element()).clamp(f32::MIN_POSITIVE, 1e37))
    }

    /// Infinite or NaN for an empty box.
    #[inline(always)]
    pub(super) fn area(self, bounds: &NodeBox) -> f32 {
        let edges = (bounds.max - bounds.min) * self.0;
        edges.dot(glam::Vec3Swizzles::yzx(edges))
    }
}

/// The map from centroids to bins.
#[derive(Clone, Copy)]
pub(super) struct BinMapping {
    least: Vec3A,
    scale: Vec3A,
    /// Number of bins in use.
    len: usize,
    axes: Axes,
}

/// The axes on which a cut is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    All,
    /// The one on which the centroids are farthest apart.
    Widest,
}

/// A cut between two bins.
#[derive(Clone, Copy)]
pub(super) struct SplitPlane {
    axis: usize,
    least: f32,
    scale: f32,
    /// First bin on the right.
    first_right: u32,
}

impl BinMapping {
    /// For `count` references whose centroids lie in this box.
    pub(super) fn new(centroids: &NodeBox, count: usize, axes: Axes) -> Self {
        let len = (4 + count / 8).min(MAX_BINS);
        let scale = Vec3A::splat(len as f32 * 0.99999) / (centroids.max - centroids.min);
        Self { least: centroids.min, scale: scale.min(Vec3A::splat(f32::MAX)), len, axes }
    }

    /// The bin on each axis. All centroids are in bin 0 of an axis on which they coincide, or have no finite extent.
    #[inline(always)]
    fn bins(&self, reference: &PrimRef) -> [u32; 3] {
        let position = (reference.centroid() - self.least) * self.scale;
        let rounded = (position - 0.5) + ROUNDING;
        rounded.to_array().map(bin_at)
    }

    fn cut(&self, axis: usize, first_right: u32) -> SplitPlane {
        SplitPlane { axis, least: self.least[axis], scale: self.scale[axis], first_right }
    }
}

impl SplitPlane {
    #[inline(always)]
    fn bin(&self, reference: &PrimRef) -> u32 {
        let position = (reference.centroid_on(self.axis) - self.least) * self.scale;
        bin_at((position - 0.5) + ROUNDING)
    }

    /// The side of a reference: 0 or 1.
    #[inline(always)]
    pub(super) fn side(&self, reference: &PrimRef) -> usize {
        usize::from(self.bin(reference) >= self.first_right)
    }
}

#[inline(always)]
fn bin_at(rounded: f32) -> u32 {
    rounded.to_bits() % MAX_BINS as u32
}

/// Visits all, by turns from both halves: neighbours often share bins, and would wait for each other.
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

/// What the bins of all three axes hold.
pub(super) struct Bins {
    binning: BinMapping,
    boxes: [[NodeBox; 3]; MAX_BINS],
    counts: [[u32; 4]; MAX_BINS],
}

/// The cheapest cut, what it leaves on both sides.
pub(super) struct BestSplit {
    pub(super) cut: SplitPlane,
    /// Number of references on the left.
    pub(super) middle: usize,
    pub(super) bounds: [NodeBox; 2],
}

impl Bins {
    pub(super) fn new() -> Self {
        let binning = BinMapping::new(&NodeBox::EMPTY, 0, Axes::All);
        Self { binning, boxes: [[NodeBox::EMPTY; 3]; MAX_BINS], counts: [[0; 4]; MAX_BINS] }
    }

    /// Empties the bins that are now in use.
    pub(super) fn reset(&mut self, binning: BinMapping) {
        self.binning = binning;
        self.boxes[..binning.len].fill([NodeBox::EMPTY; 3]);
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

    /// Adds what the bins of the same map hold.
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
    pub(super) fn left_of(&self, cut: &SplitPlane) -> usize {
        self.counts[..cut.first_right as usize].iter().map(|counts| counts[cut.axis] as usize).sum()
    }

    /// The cheapest cut with references on both sides; the first one in order of axes and bins where several are.
    pub(super) fn best_split(&self, unit: NormalizedArea) -> Option<BestSplit> {
        let len = self.binning.len;
        let areas = |boxes: &[NodeBox; 3]| Vec3A::from_array(core::array::from_fn(|axis| unit.area(&boxes[axis])));
        let count = |counts: &[u32; 4]| Vec3A::from_array(core::array::from_fn(|axis| counts[axis] as i32 as f32));

        let mut right_costs = [Vec3A::ZERO; MAX_BINS];
        let (mut boxes, mut counts) = ([NodeBox::EMPTY; 3], Vec3A::ZERO);
        for bin in (1..len).rev() {
            boxes = core::array::from_fn(|axis| boxes[axis].union(self.boxes[bin][axis]));
            counts += count(&self.counts[bin]);
            right_costs[bin] = areas(&boxes) * counts;
        }
        let (mut boxes, mut counts) = ([NodeBox::EMPTY; 3], Vec3A::ZERO);
        let (mut least, mut place) = (Vec3A::INFINITY, Vec3A::ZERO);
        for (bin, right_cost) in right_costs.iter().enumerate().take(len).skip(1) {
            boxes = core::array::from_fn(|axis| boxes[axis].union(self.boxes[bin - 1][axis]));
            counts += count(&self.counts[bin - 1]);
            // NaN where one side is empty: an infinite area times zero.
            let costs = areas(&boxes) * counts + *right_cost;
            let is_less: BVec3A = costs.cmplt(least);
            least = Vec3A::select(is_less, costs, least);
            place = Vec3A::select(is_less, Vec3A::splat(bin as f32), place);
        }
        let axis = least.min_position();
        (least[axis] < f32::INFINITY).then(|| self.at(axis, place[axis] as usize))
    }

    fn at(&self, axis: usize, bin: usize) -> BestSplit {
        let union = |boxes: &[[NodeBox; 3]]| boxes.iter().fold(NodeBox::EMPTY, |all, bins| all.union(bins[axis]));
        let (left, right) = self.boxes[..self.binning.len].split_at(bin);
        let cut = self.binning.cut(axis, bin as u32);
        BestSplit { cut, middle: self.left_of(&cut), bounds: [union(left), union(right)] }
    }
}
