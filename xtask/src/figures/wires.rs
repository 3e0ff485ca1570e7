//! Lines around boxes, spheres and cylinders.

use rt_math::{Aabb, DVec3};

/// A line with the depth of what it belongs to.
#[derive(Debug)]
pub(super) enum Wire {
    /// Straight, along an axis, between two points.
    Edge { ends: Aabb, depth: u32 },
    /// A circle across an axis.
    Circle { axis: usize, centre: DVec3, radius: f64, depth: u32 },
}

/// All lines of a figure.
pub(super) type Wires = Vec<Wire>;

/// The twelve edges of a box.
pub(super) fn around_box(aabb: &Aabb, depth: u32, wires: &mut Wires) {
    for axis in 0..3 {
        for side in 0..4 {
            let (mut min, mut max) = (aabb.min, aabb.max);
            for (bit, across) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
                let place = if side >> bit & 1 == 0 { aabb.min[across] } else { aabb.max[across] };
                (min[across], max[across]) = (place, place);
            }
            wires.push(Wire::Edge { ends: Aabb::new(min, max), depth });
        }
    }
}

/// Three great circles.
pub(super) fn around_sphere(centre: DVec3, radius: f64, depth: u32, wires: &mut Wires) {
    wires.extend((0..3).map(|axis| Wire::Circle { axis, centre, radius, depth }));
}

/// Both rims, and four lines between them.
pub(super) fn around_cylinder(axis: usize, centre: DVec3, radius: f64, caps: [f64; 2], depth: u32, wires: &mut Wires) {
    let rims = caps.map(|cap| {
        let mut rim = centre;
        rim[axis] = cap;
        rim
    });
    wires.extend(rims.map(|centre| Wire::Circle { axis, centre, radius, depth }));
    for across in [(axis + 1) % 3, (axis + 2) % 3] {
        for side in [-radius, radius] {
            let mut offset = DVec3::ZERO;
            offset[across] = side;
            wires.push(Wire::Edge { ends: Aabb::new(rims[0] + offset, rims[1] + offset), depth });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_box_has_twelve_different_edges_between_its_corners() {
        let aabb = Aabb::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let mut wires = Wires::new();
        around_box(&aabb, 0, &mut wires);
        let edges: Vec<&Aabb> = wires
            .iter()
            .map(|wire| match wire {
                Wire::Edge { ends, .. } => ends,
                Wire::Circle { .. } => panic!("boxes have no circles"),
            })
            .collect();
        let bits = |ends: &Aabb| [ends.min, ends.max].map(|end| end.to_array().map(f64::to_bits));
        assert_eq!(edges.iter().map(|ends| bits(ends)).collect::<BTreeSet<_>>().len(), 12);
        let length: f64 = edges.iter().map(|ends| ends.extent().element_sum()).sum();
        assert_eq!(length, 4.0 * (1.0 + 2.0 + 3.0));
    }

    #[test]
    fn lines_of_a_cylinder_touch_both_rims() {
        let mut wires = Wires::new();
        around_cylinder(1, DVec3::new(1.0, 2.0, 3.0), 0.5, [0.0, 4.0], 0, &mut wires);
        assert_eq!(wires.len(), 6);
        for wire in &wires[2..] {
            let Wire::Edge { ends, .. } = wire else { panic!("a circle") };
            assert_eq!((ends.min.y, ends.max.y), (0.0, 4.0));
            let axis = DVec3::new(1.0, ends.min.y, 3.0);
            assert_eq!(ends.min.distance(axis), 0.5);
        }
    }
}
