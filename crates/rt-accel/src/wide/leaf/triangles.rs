//! Layout of leaves of triangles: by vertex and axis, the coordinates of all triangles.
//!
//! Other primitives have NaN vertices.

use glam::{DVec3, Vec3};
use rt_geometry::{PrimitiveGeometry, Primitives};

use super::block::{Lane, LeafMut, LeafView};
use crate::wide::simd::Simd;

/// Maximum extent of a triangle along an axis, and maximum coordinate.
pub(in crate::wide) const TRIANGLE_HEADER: usize = 2;

/// Three coordinates of three vertices.
pub(in crate::wide) const TRIANGLE_NUMBERS: usize = 9;

/// Vertices of a primitive that is not a triangle.
const UNKNOWN: [Vec3; 3] = [Vec3::NAN; 3];

/// Fills a leaf with vertices relative to a centre, or with exact ones if there is none.
pub(super) fn fill<P: Primitives>(block: &mut LeafMut<'_>, primitives: &P, indices: &[u32], centre: Option<DVec3>) {
    let mut max_coordinate = Vec3::ZERO;
    let mut extent = Vec3::ZERO;
    for (lane, &index) in indices.iter().enumerate() {
        let vertices = match (primitives.geometry(index), centre) {
            (PrimitiveGeometry::ExactTriangle(vertices), None) => vertices,
            (PrimitiveGeometry::ExactTriangle(vertices), Some(centre)) => {
                vertices.map(|v| (v.as_dvec3() - centre).as_vec3())
            }
            (PrimitiveGeometry::Triangle(vertices), Some(centre)) => vertices.map(|v| (v - centre).as_vec3()),
            _ => UNKNOWN,
        };
        if !vertices[0].is_nan() {
            let [a, b, c] = vertices;
            max_coordinate =
                vertices.iter().fold(max_coordinate, |max_coordinate, vertex| max_coordinate.max(vertex.abs()));
            extent = extent.max(a.max(b).max(c) - a.min(b).min(c));
        }
        for (vertex, position) in vertices.iter().enumerate() {
            for axis in 0..3 {
                block.set(3 * vertex + axis, lane, position[axis]);
            }
        }
    }
    block.set_header(0, extent.max_element().next_up());
    block.set_header(1, max_coordinate.max_element());
}

/// One coordinate of the three vertices of a triangle.
///
/// # Safety
///
/// The leaf must be one of triangles, and the axis less than 3.
#[inline(always)]
pub(in crate::wide) unsafe fn coordinates(leaf: LeafView<'_>, lane: Lane, axis: usize) -> [f32; 3] {
    debug_assert!(axis < 3);
    let at = TRIANGLE_HEADER + axis * leaf.count + lane.index();
    // SAFETY: as the caller promises, these are numbers 0 to 8 of nine.
    unsafe { [leaf.number(at), leaf.number(at + 3 * leaf.count), leaf.number(at + 6 * leaf.count)] }
}

/// One vertex of a triangle, exact in leaves of [`LeafKind::Watertight`](super::kind::LeafKind).
///
/// # Safety
///
/// The leaf must be one of triangles, and the vertex less than 3.
#[inline(always)]
pub(in crate::wide) unsafe fn corner(leaf: LeafView<'_>, lane: Lane, vertex: usize) -> [f32; 3] {
    debug_assert!(vertex < 3);
    let at = TRIANGLE_HEADER + 3 * vertex * leaf.count + lane.index();
    // SAFETY: as the caller promises, these are numbers 0 to 8 of nine.
    unsafe { [leaf.number(at), leaf.number(at + leaf.count), leaf.number(at + 2 * leaf.count)] }
}

/// One coordinate of the three vertices of eight triangles.
///
/// # Safety
///
/// The leaf must be one of triangles, and the axis less than 3.
#[inline(always)]
pub(in crate::wide) unsafe fn load_coordinates<S: Simd>(simd: S, leaf: LeafView<'_>, axis: usize) -> [S::F32x8; 3] {
    debug_assert!(axis < 3);
    let first = TRIANGLE_HEADER + axis * leaf.count;
    // SAFETY: as the caller promises, these are numbers 0 to 8 of nine.
    unsafe {
        [leaf.lanes(simd, first), leaf.lanes(simd, first + 3 * leaf.count), leaf.lanes(simd, first + 6 * leaf.count)]
    }
}

/// Broadcasts one coordinate of the three vertices of one triangle.
///
/// # Safety
///
/// See [`coordinates`].
#[inline(always)]
pub(in crate::wide) unsafe fn splat_coordinates<S: Simd>(
    simd: S,
    leaf: LeafView<'_>,
    lane: Lane,
    axis: usize,
) -> [S::F32x8; 3] {
    // SAFETY: as the caller promises.
    let [a, b, c] = unsafe { coordinates(leaf, lane, axis) };
    [simd.splat(a), simd.splat(b), simd.splat(c)]
}
