//! Layout of leaves of spheres: centres, then radii.
//!
//! Other primitives have spheres around their padded bounds, with negative radii.

use glam::DVec3;
use rt_geometry::{PrimitiveGeometry, Primitives, padded_bounds};

use super::block::LeafMut;
use crate::wide::ray::round_up;

/// Maximum coordinate of all spheres.
pub(in crate::wide) const SPHERE_HEADER: usize = 1;

/// Centre and radius.
pub(in crate::wide) const SPHERE_NUMBERS: usize = 4;

pub(super) fn fill<P: Primitives>(block: &mut LeafMut<'_>, primitives: &P, indices: &[u32], centre: DVec3) {
    let mut max_coordinate = 0.0f64;
    for (lane, &index) in indices.iter().enumerate() {
        let (position, radius) = match primitives.geometry(index) {
            PrimitiveGeometry::Sphere(position, radius) => (position - centre, radius),
            PrimitiveGeometry::ExactSphere(sphere) => (sphere.centre - centre, sphere.radius),
            _ => bounding_sphere(primitives, index, centre),
        };
        max_coordinate = max_coordinate.max(position.abs().max_element() + radius.abs());
        for axis in 0..3 {
            block.set(axis, lane, position[axis] as f32);
        }
        block.set(3, lane, radius as f32);
    }
    block.set_header(0, round_up(max_coordinate));
}

/// Centre and negated radius of a sphere around the padded bounds of another primitive.
fn bounding_sphere<P: Primitives>(primitives: &P, index: u32, centre: DVec3) -> (DVec3, f64) {
    padded_bounds(primitives, index)
        .map_or((DVec3::NAN, f64::NAN), |own| (own.centre() - centre, -0.5 * own.extent().length()))
}
