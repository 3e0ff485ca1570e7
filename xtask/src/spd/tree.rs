//! A tree that forks.

use std::f64::consts::TAU;

use rt_math::{DVec3, Frame, transcendental::sincos};

use super::nff::{Fill, Nff, NffView};

/// Between a branch and those that grow from it.
const FORK_DEGREES: [f64; 2] = [22.0, 34.0];
/// Length and thickness of a branch relative to its parent.
const LENGTHS: [f64; 2] = [0.85, 0.72];
const THICKNESS: f64 = 0.72;
/// Around its branch, the plane of a fork is turned so far from that before it: the golden angle.
const TURN: f64 = 0.381_966;

/// A tree after Aono and Kunii, "Botanical Tree Image Generation", IEEE CG&A 4(5), 1984. Every branch is a cone that
/// ends in a sphere and forks in two, `size` times. With the square below: 2^(size + 1) − 1 cones, as many spheres, and
/// a polygon.
///
/// The paper gives the numbers of objects; angles and lengths are ours.
pub(super) fn tree(size: u32) -> Nff {
    let view = NffView { from: DVec3::new(4.5, 0.4, 2.0), at: DVec3::new(0.0, 0.0, 1.5), up: DVec3::Z };
    let lights = [
        (30.0, 30.0, 40.0),
        (30.0, -30.0, 40.0),
        (-30.0, 30.0, 40.0),
        (-30.0, -30.0, 40.0),
        (0.0, 0.0, 50.0),
        (40.0, 0.0, 20.0),
        (0.0, 40.0, 30.0),
    ]
    .map(DVec3::from);
    let mut file = Nff::new(&format!("tree, size {size}"), &view, &lights);
    file.fill(&Fill::matte([0.5, 0.45, 0.35], 1.0));
    let corner = |x: f64, y: f64| DVec3::new(50.0 * x, 50.0 * y, 0.0);
    file.polygon(&[corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]);
    file.fill(&Fill::matte([0.55, 0.4, 0.2], 1.0));
    branch(&mut file, size, DVec3::ZERO, DVec3::Z, DVec3::X, 0.8, 0.1);
    file
}

/// A branch from `foot` along the unit vector `along`, and all that grows on it; `side` is at right angles to it.
fn branch(file: &mut Nff, forks: u32, foot: DVec3, along: DVec3, side: DVec3, length: f64, radius: f64) {
    let end = foot + along * length;
    let thinner = radius * THICKNESS;
    file.cone((foot, radius), (end, thinner));
    file.sphere(end, thinner);
    if forks == 0 {
        return;
    }
    let (sin, cos) = sincos(TURN * TAU);
    let side = side * cos + along.cross(side) * sin;
    for (twig, (degrees, part)) in FORK_DEGREES.into_iter().zip(LENGTHS).enumerate() {
        let (sin, cos) = sincos(degrees.to_radians() * if twig == 0 { 1.0 } else { -1.0 });
        let direction = (along * cos + side * sin).normalize();
        branch(file, forks - 1, end, direction, Frame::from_z(direction).x, length * part, thinner);
    }
}
