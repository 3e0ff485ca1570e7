//! Interlocked rings.

use std::f64::consts::TAU;

use rt_math::{DVec3, transcendental::sincos};

use super::nff::{Fill, Nff, NffView};

/// From the middle of a ring to a corner, and the radius of its tube.
const RING: f64 = 0.930995;
const RADIUS_OF_CYLINDERS: f64 = 0.07412;
/// The colours of the rings of a set.
const COLOURS: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]];

/// Sets of six pentagonal rings before a wall, in `size` layers of 1, 4, 9, ... sets. The rings of a set share a
/// centre, one for each axis of an icosahedron. A ring is made of five cylinders and five spheres.
///
/// The view, the lights and the wall are those of size 2, and grow with the size.
pub(super) fn rings(size: u32) -> Nff {
    let grown = f64::from(size) / 2.0;
    let layer = layer_distance();
    let place = |x: f64, z: f64| DVec3::new(x * grown, -layer, z * grown);
    let middle = place(-1.0, 0.5);
    let view = NffView { from: middle, at: middle + DVec3::Y, up: DVec3::Z };
    let mut file =
        Nff::new(&format!("rings, size {size}"), &view, &[place(3.0, 3.0), place(-4.0, 1.0), place(2.0, -4.0)]);
    file.fill(&Fill::matte([1.0; 3], 1.0));
    let half = 4.37286 * grown;
    let corner = |x: f64, z: f64| DVec3::new(middle.x + x * half, f64::from(size + 1) * layer, middle.z + z * half);
    file.polygon(&[corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]);
    for number in 1..=size {
        let spread = f64::from(number) - 1.0;
        for (z, x) in (0..number).flat_map(|z| (0..number).map(move |x| (z, x))) {
            let [x, z] = [x, z].map(|i| 2.0 * f64::from(i) - spread);
            set(&mut file, DVec3::new(x, layer * f64::from(number), z));
        }
    }
    file
}

/// From one layer to the next: twice the outer radius of a regular octagon of edge 1.
fn layer_distance() -> f64 {
    1.0 / sincos(TAU / 16.0).0
}

fn set(file: &mut Nff, middle: DVec3) {
    for (axis, colour) in COLOURS.into_iter().enumerate() {
        file.fill(&Fill { specular: 0.2, shine: 3.0827, ..Fill::matte(colour, 0.5) });
        let [right, up] = plane(axis);
        let corner = |i: u32| {
            let (sin, cos) = sincos(f64::from(i) / 5.0 * TAU);
            middle + (right * cos + up * sin) * RING
        };
        for i in 0..5 {
            file.cone((corner(i), RADIUS_OF_CYLINDERS), (corner((i + 4) % 5), RADIUS_OF_CYLINDERS));
            file.sphere(corner(i), RADIUS_OF_CYLINDERS);
        }
    }
}

/// Two directions of the plane of a ring: the first axis is +z, the other five lie around it, at an angle of tangent 2.
fn plane(axis: usize) -> [DVec3; 2] {
    if axis == 0 {
        return [DVec3::X, DVec3::Y];
    }
    let (sin, cos) = sincos((-0.15 + 0.2 * (axis as f64 - 1.0)) * TAU);
    let normal = DVec3::new(2.0 * cos, 2.0 * sin, 1.0) / 5f64.sqrt();
    let right = DVec3::new(-sin, cos, 0.0);
    [right, normal.cross(right)]
}
