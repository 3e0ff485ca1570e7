//! Tree of planes of any direction.

mod candidates;
mod plane;
mod split;

use rt_geometry::Primitives;

use crate::BuildError;
use crate::space_partition::{BspPartition, accelerator_by_partition};
use plane::Plane;
pub(crate) use split::SampledPlanes;

/// Binary partition of space by planes of the geometry (Fuchs, Kedem and Naylor, "On visible surface generation by a
/// priori tree structures", 1980). Candidates are planes of triangles, planes through the centre of a sphere and
/// tangent planes that face another primitive, and faces of padded bounds.
///
/// Candidates of some primitives are compared by the surface area heuristic, with a sample of the others. See Ize, Wald
/// and Parker, "Ray Tracing with the BSP Tree", 2008. Primitives are never split: they are listed on both sides of a
/// plane that their padded bounds touch within rounding. Recommended for long walls at odd angles with small objects
/// between them; otherwise a [`KdTree`](crate::KdTree) builds faster and costs less per node.
///
/// No leaf is deeper than 60, and planes and references together are at most 16 per primitive and 4096 more. Primitives
/// that no plane can separate share a leaf. The tree is a pure function of the primitives, with or without the feature
/// `parallel`. With the feature `serde`, use a format that keeps every bit of an `f64`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BspTree(pub(crate) BspPartition<Plane>);

impl BspTree {
    /// Builds the tree: O(n log n) time, 110 to 210 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or there are too many primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Ok(Self(BspPartition::build(primitives, &SampledPlanes { primitives })?))
    }
}

accelerator_by_partition!(BspTree);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space_partition::{SplitHeuristic, Task};
    use crate::{Accelerator, Boxes, Linear, SphereRegion};
    use core::ops::ControlFlow;
    use glam::DVec3;
    use rt_geometry::{Counters, Hit, NoProbe};
    use rt_math::random::{hash, unit};
    use rt_math::{Aabb, Interval, Ray};

    /// Splits through or next to some box, in any direction.
    struct Haphazard;

    impl SplitHeuristic<Plane> for Haphazard {
        fn find_split(&self, boxes: &[(u32, Aabb)], task: &Task<Plane>) -> Option<Plane> {
            let draw = |k: u64| unit(hash(&[task.path, k]));
            let normal = (DVec3::new(draw(0), draw(1), draw(2)) - 0.5).try_normalize()?;
            let own = boxes[*task.items.get((draw(3) * task.items.len() as f64) as usize)? as usize].1;
            let [under, over] = Plane::around(normal, &own);
            let through = Plane { normal, offset: normal.dot(own.min) };
            (task.items.len() > 2 && task.depth < 25).then_some([under, over, through][(draw(4) * 3.0) as usize])
        }
    }

    fn vector(i: u64, k: u64) -> DVec3 {
        DVec3::new(unit(hash(&[i, k])), unit(hash(&[i, k + 1])), unit(hash(&[i, k + 2]))) * 2.0 - 1.0
    }

    /// Checks the traversal with planes that no heuristic would select.
    #[test]
    fn trees_of_haphazard_planes_equal_brute_force() {
        for (scale, offset) in [(1.0, 0.0), (1e-4, 1e3), (1.0, 1e7), (1e30, 0.0)] {
            let place = |v: DVec3| v * scale + DVec3::new(offset, -0.7 * offset, 0.3 * offset);
            let aabb = |i| Aabb::from_points([place(vector(i, 0)), place(vector(i, 0) + 0.2 * vector(i, 3))]);
            let aabbs: Vec<Aabb> = (0..200).map(aabb).collect();
            let boxes = Boxes(&aabbs);
            let tree = BspTree(BspPartition::build(&boxes, &Haphazard).expect("boxes"));
            assert_eq!(tree.validate(&boxes), Ok(()));
            assert!(tree.build_stats().leaves > 100, "{:?}", tree.build_stats());
            let linear = Linear::build(&boxes).expect("boxes");
            let (mut counters, mut n_hits) = (Counters::default(), 0u64);
            for i in 0..5_000 {
                let bits = hash(&[i, 20]);
                let corner = |k: u64| aabbs[(k % 200) as usize].corners()[(k >> 20) as usize % 8];
                let origin = if bits & 1 == 0 { corner(bits >> 8) } else { place(2.0 * vector(i, 21)) };
                let mut direction = corner(hash(&[i, 22])) - origin;
                if bits & 6 == 0 {
                    direction[(bits >> 40) as usize % 3] = [0.0, -0.0, 5e-324, 1e-30][(bits >> 50) as usize % 4];
                }
                let ray = Ray::new(origin, direction);
                for span in [Interval::FORWARD, Interval::SEGMENT, Interval::new(-2.0, 2.0)] {
                    let expected = linear.closest(&boxes, &ray, span, &mut NoProbe);
                    let found = tree.closest(&boxes, &ray, span, &mut counters);
                    let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive));
                    assert_eq!(key(found), key(expected), "{ray:?} {span:?}");
                    n_hits += u64::from(expected.is_some());
                }
            }
            let tested = counters.total().tests as f64 / (3.0 * 5_000.0 * 200.0);
            assert!(n_hits > 5_000 && tested < 0.5, "{n_hits} hits, {tested} tested");
        }
    }

    #[test]
    fn searches_of_haphazard_planes_find_everything_once() {
        let aabb = |i| Aabb::from_points([vector(i, 0), vector(i, 0) + 0.3 * vector(i, 3)]);
        let aabbs: Vec<Aabb> = (0..300).map(aabb).collect();
        let boxes = Boxes(&aabbs);
        let tree = BspTree(BspPartition::build(&boxes, &Haphazard).expect("boxes"));
        let linear = Linear::build(&boxes).expect("boxes");
        fn found(accelerator: &impl Accelerator, boxes: &Boxes<'_>, sphere: &SphereRegion) -> Vec<u32> {
            let mut found = Vec::new();
            accelerator.visit_overlapping(boxes, sphere, |index| {
                found.push(index);
                ControlFlow::Continue(())
            });
            found.sort_unstable();
            found
        }
        for i in 0..2000 {
            let sphere = SphereRegion { centre: vector(i, 9), radius: 0.5 * unit(hash(&[i, 12])) };
            assert_eq!(found(&tree, &boxes, &sphere), found(&linear, &boxes, &sphere), "{sphere:?}");
        }
    }
}
