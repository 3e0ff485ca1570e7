//! Where to cut a set of references in two: the surface area heuristic (MacDonald and Booth 1990) over bins of centroids
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), on all three axes at once.

use glam::{BVec3A, Vec3A};

use super::reference::Reference;
use crate::bvh::NodeBox;

const MOST_BINS: usize = 32;

/// Adding it rounds a small number to an integer, which then is the low bits of the sum.
const ROUNDING: f32 = 1.5 * (1u32 << 23) as f32;

/// Half of the surface area in units of the scene, so that it neither overflows nor vanishes, whatever the scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaUnit(f32);

impl AreaUnit {
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
pub(super) struct Binning {
    least: Vec3A,
    scale: Vec3A,
    /// Number of bins in use.
    len: usize,
}

/// A cut between two bins.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    binning: Binning,
    axis: usize,
    /// First bin on the right.
    bin: u32,
}

impl Binning {
    /// For `count` references whose centroids lie in this box.
    pub(super) fn new(centroids: &NodeBox, count: usize) -> Self {
        let len = (4 + count / 16).min(MOST_BINS);
        let scale = Vec3A::splat(len as f32 * 0.99999) / (centroids.max - centroids.min);
        Self { least: centroids.min, scale: scale.min(Vec3A::splat(f32::MAX)), len }
    }

    /// The bin on each axis. All centroids are in bin 0 of an axis on which they coincide, or have no finite extent.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [u32; 3] {
        let position = (reference.centroid() - self.least) * self.scale;
        let rounded = (position - 0.5) + ROUNDING;
        rounded.to_array().map(|x| x.to_bits() % MOST_BINS as u32)
    }
}

impl Cut {
    /// The side of a reference: 0 or 1.
    #[inline(always)]
    pub(super) fn side(&self, reference: &Reference) -> usize {
        usize::from(self.binning.bins(reference)[self.axis] >= self.bin)
    }
}

/// What the bins of all three axes hold.
pub(super) struct Bins {
    binning: Binning,
    boxes: [[NodeBox; 3]; MOST_BINS],
    counts: [[u32; 4]; MOST_BINS],
}

/// The cheapest cut, what it leaves on both sides.
pub(super) struct Best {
    pub(super) cut: Cut,
    /// Number of references on the left.
    pub(super) middle: usize,
    pub(super) bounds: [NodeBox; 2],
}

impl Bins {
    pub(super) fn new(binning: Binning) -> Self {
        Self { binning, boxes: [[NodeBox::EMPTY; 3]; MOST_BINS], counts: [[0; 4]; MOST_BINS] }
    }

    #[inline]
    pub(super) fn add(&mut self, references: &[Reference]) {
        for reference in references {
            let bins = self.binning.bins(reference);
            let bounds = reference.bounds();
            for (axis, bin) in bins.into_iter().enumerate() {
                let bin = bin as usize;
                self.boxes[bin][axis] = self.boxes[bin][axis].union(bounds);
                self.counts[bin][axis] += 1;
            }
        }
    }

    /// The cheapest cut with references on both sides; the first one in order of axes and bins where several are.
    pub(super) fn best_cut(&self, unit: AreaUnit) -> Option<Best> {
        let len = self.binning.len;
        let areas = |boxes: &[NodeBox; 3]| Vec3A::from_array(core::array::from_fn(|axis| unit.area(&boxes[axis])));
        let count = |counts: &[u32; 4]| Vec3A::from_array(core::array::from_fn(|axis| counts[axis] as i32 as f32));

        let mut right_costs = [Vec3A::ZERO; MOST_BINS];
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

    fn at(&self, axis: usize, bin: usize) -> Best {
        let union = |boxes: &[[NodeBox; 3]]| boxes.iter().fold(NodeBox::EMPTY, |all, bins| all.union(bins[axis]));
        let (left, right) = self.boxes[..self.binning.len].split_at(bin);
        Best {
            cut: Cut { binning: self.binning, axis, bin: bin as u32 },
            middle: self.counts[..bin].iter().map(|counts| counts[axis] as usize).sum(),
            bounds: [union(left), union(right)],
        }
    }
}
