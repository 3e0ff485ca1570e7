//! Overlap test of two flat regions in one plane, with straight edges.

use rt_geometry::InsideRule;
use rt_math::DVec3;
use rt_math::transcendental::hypot;

use crate::coplanar::{cross, is_separated_by_an_edge};

/// Distance of a probe from the middle of an edge, as a fraction of the length of the edge.
const PROBE: f64 = 1e-3;

/// Rings of corners in a plane, with the rule for their inside.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    /// World space.
    pub(crate) rings: Vec<Vec<DVec3>>,
    pub(crate) rule: InsideRule,
}

impl Outline {
    pub(crate) fn corner_count(&self) -> usize {
        self.rings.iter().map(Vec::len).sum()
    }

    /// Region in the plane of two coordinates.
    pub(crate) fn flattened(&self, flatten: impl Fn(DVec3) -> [f64; 2]) -> FlatRegion {
        let rings = self.rings.iter().map(|ring| ring.iter().map(|corner| flatten(*corner)).collect()).collect();
        FlatRegion { rings, rule: self.rule }
    }
}

/// Region of the plane.
#[derive(Clone, Debug)]
pub(crate) struct FlatRegion {
    rings: Vec<Vec<[f64; 2]>>,
    rule: InsideRule,
}

type EdgeInPlane = [[f64; 2]; 2];

/// True if two regions overlap in more than an edge or corner. `tolerance` is the allowed rounding error of distances.
///
/// Two convex regions are compared by the separating axis theorem. Others overlap if their edges cross, or if both contain a
/// point next to the middle of an edge.
pub(crate) fn overlap(a: &FlatRegion, b: &FlatRegion, tolerance: f64) -> bool {
    if let (Some(a), Some(b)) = (a.convex_ring(), b.convex_ring()) {
        return !is_separated_by_an_edge(a, b, tolerance) && !is_separated_by_an_edge(b, a, tolerance);
    }
    let has_probe_inside = |a: &FlatRegion, b: &FlatRegion| {
        a.edges().flat_map(|edge| probes(edge, tolerance)).any(|p| a.contains(p) && b.contains(p))
    };
    has_probe_inside(a, b)
        || has_probe_inside(b, a)
        || a.edges().any(|edge| b.edges().any(|other| do_cross(edge, other, tolerance)))
}

impl FlatRegion {
    fn convex_ring(&self) -> Option<&[[f64; 2]]> {
        self.rings.first().filter(|_| self.rule == InsideRule::Convex).map(Vec::as_slice)
    }

    fn edges(&self) -> impl Iterator<Item = EdgeInPlane> {
        self.rings.iter().flat_map(|ring| (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]))
    }

    fn contains(&self, p: [f64; 2]) -> bool {
        let (mut winding, mut crossings) = (0, 0);
        for [a, b] in self.edges() {
            if (a[1] <= p[1]) != (b[1] <= p[1]) {
                let is_left = cross(a, b, p) > 0.0;
                let is_upward = a[1] <= p[1];
                if is_left == is_upward {
                    crossings += 1;
                    winding += if is_upward { 1 } else { -1 };
                }
            }
        }
        if self.rule == InsideRule::EvenOdd { crossings % 2 == 1 } else { winding != 0 }
    }
}

/// Points on both sides of the middle of an edge.
fn probes([a, b]: EdgeInPlane, tolerance: f64) -> [[f64; 2]; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = hypot(along[0], along[1]);
    let step = PROBE.max(4.0 * tolerance / length);
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    [step, -step].map(|step| [middle[0] - step * along[1], middle[1] + step * along[0]])
}

/// True if the ends of each edge lie on different sides of the other one, by more than the tolerance.
fn do_cross(e: EdgeInPlane, f: EdgeInPlane, tolerance: f64) -> bool {
    let divides = |[a, b]: EdgeInPlane, [c, d]: EdgeInPlane| {
        let limit = tolerance * hypot(b[0] - a[0], b[1] - a[1]);
        let [c, d] = [cross(a, b, c), cross(a, b, d)];
        c.min(d) < -limit && c.max(d) > limit
    };
    divides(e, f) && divides(f, e)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(rings: &[&[[f64; 2]]], rule: InsideRule) -> FlatRegion {
        FlatRegion { rings: rings.iter().map(|ring| ring.to_vec()).collect(), rule }
    }

    fn square(min: f64, max: f64) -> [[f64; 2]; 4] {
        [[min, min], [max, min], [max, max], [min, max]]
    }

    #[test]
    fn holes_and_notches_are_outside() {
        let frame = region(&[&square(0.0, 4.0), &square(1.0, 3.0)], InsideRule::EvenOdd);
        let convex = |min, max| region(&[&square(min, max)], InsideRule::Convex);
        assert!(!overlap(&frame, &convex(1.0, 3.0), 1e-12), "fills the hole");
        assert!(!overlap(&frame, &convex(1.5, 2.5), 1e-12), "within the hole");
        assert!(overlap(&frame, &convex(0.25, 0.75), 1e-12), "within the frame");
        assert!(overlap(&frame, &convex(0.0, 4.0), 1e-12), "with the same border");
        assert!(overlap(&frame, &convex(-1.0, 9.0), 1e-12), "around the frame");
        assert!(overlap(&frame, &convex(2.0, 3.5), 1e-12), "across the inner border");
        assert!(!overlap(&frame, &convex(4.0, 5.0), 1e-12), "at a corner");
        assert!(overlap(&frame, &frame, 1e-12), "the same");

        let notched = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        for rule in [InsideRule::EvenOdd, InsideRule::Winding] {
            let notched = region(&[&notched], rule);
            let above = region(&[&[[1.5, 3.0], [2.5, 3.0], [2.0, 3.5]]], InsideRule::Convex);
            assert!(!overlap(&notched, &above, 1e-12), "in the notch");
            assert!(overlap(&notched, &convex(0.1, 0.2), 1e-12));
        }
    }
}
