//! Validation of polygons.

use crate::{Plane, ShapeError, area::area_vector, error::check_coordinates};
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3};

/// Maximum distance of a corner from the plane, relative to the diameter.
const FLATNESS: f64 = 1e-6;

/// Error of [`Polygon::new`](super::Polygon::new), with the invalid value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PolygonError {
    /// The outline or a hole with fewer than three corners.
    #[error("the {} has {count} {}; it needs at least 3", ring_name(*ring), if *count == 1 { "corner" } else { "corners" })]
    TooFewVertices {
        /// 0 for the outline, then the holes.
        ring: usize,
        /// Number of corners.
        count: usize,
    },
    /// A coordinate that no shape can have.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// An outline without area: collinear, or with loops that cancel. It has no plane.
    #[error("the outline of the polygon has no area: its corners lie on a line, or its loops cancel; move its corners")]
    NoArea,
    /// A corner off the plane of the outline.
    #[error(
        "the polygon is not flat: {vertex} lies {distance:e} off its plane, \
         more than a millionth of its diameter {diameter}: cut it into flat parts"
    )]
    NotFlat {
        /// Index of the farthest corner.
        vertex: DVec3,
        /// Its distance from the plane.
        distance: f64,
        /// Diagonal of the box of all corners.
        diameter: f64,
    },
    /// A concave or self-crossing outline under [`InsideRule::Convex`](crate::InsideRule::Convex).
    #[error("the polygon is not convex at corner {vertex}, counted from 0: choose another `rule`")]
    NotConvex {
        /// The first corner where the outline turns the wrong way, or more than once around.
        vertex: usize,
    },
    /// Holes under [`InsideRule::Convex`](crate::InsideRule::Convex).
    #[error("a convex polygon has {0} holes: remove them, or choose another `rule`")]
    ConvexWithHoles(usize),
}

/// `outline`, or `hole N` counted from 0.
fn ring_name(ring: usize) -> String {
    ring.checked_sub(1)
        .map_or_else(|| "outline of the polygon".to_owned(), |hole| format!("hole {hole} of the polygon"))
}

/// Checks the number of corners of each ring, and all coordinates.
pub(super) fn check_rings(outline: &[DVec3], holes: &[Vec<DVec3>]) -> Result<(), PolygonError> {
    let rings = || std::iter::once(outline).chain(holes.iter().map(Vec::as_slice));
    if let Some((ring, short)) = rings().enumerate().find(|(_, ring)| ring.len() < 3) {
        return Err(PolygonError::TooFewVertices { ring, count: short.len() });
    }
    Ok(check_coordinates(rings().flatten().copied())?)
}

/// Checks that the outline turns to the left at each corner or goes straight on, and runs once around.
///
/// The axis of the normal's greatest component is dropped, which rounds nothing, and the signs of the turns are exact.
pub(super) fn check_convex(outline: &[DVec3], holes: &[Vec<DVec3>], normal: DVec3) -> Result<(), PolygonError> {
    if !holes.is_empty() {
        return Err(PolygonError::ConvexWithHoles(holes.len()));
    }
    let size = normal.abs();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let n = outline.len();
    for i in 0..n {
        let corner = [outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n]];
        if area_vector(corner)[axis] * normal[axis] < 0.0 {
            return Err(PolygonError::NotConvex { vertex: i });
        }
    }
    // A convex outline goes one way along any axis and then back; one that winds around twice goes back and forth.
    let place = |i: usize| [outline[i % n][(axis + 1) % 3], outline[i % n][(axis + 2) % 3]];
    let mut turns = 0;
    let mut last = (0..n).rev().map(|i| place(i + 1).partial_cmp(&place(i))).find(|way| !is_standing(*way)).flatten();
    for i in 0..n {
        let way = place(i + 1).partial_cmp(&place(i));
        if !is_standing(way) && way != last {
            turns += 1;
            last = way;
        }
        if turns > 2 {
            return Err(PolygonError::NotConvex { vertex: i });
        }
    }
    Ok(())
}

/// True if an edge joins a corner to itself.
fn is_standing(way: Option<std::cmp::Ordering>) -> bool {
    way == Some(std::cmp::Ordering::Equal)
}

/// Flatness of the corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flatness {
    /// Flat but for rounding.
    Flat,
    /// Within the tolerance.
    Bent,
}

/// Measures how far the corners lie off the plane.
pub(super) fn flatness(vertices: &[DVec3], plane: &Plane) -> Result<Flatness, PolygonError> {
    let normal = plane.normal();
    let off = |v: DVec3| normal.dot(v - plane.point()).abs();
    let farthest = vertices.iter().fold(plane.point(), |far, &v| if off(v) > off(far) { v } else { far });
    let distance = off(farthest);
    let bounds = Aabb::from_points(vertices.iter().copied());
    let diameter = bounds.extent().length();
    if distance > FLATNESS * diameter {
        return Err(PolygonError::NotFlat { vertex: farthest, distance, diameter });
    }
    Ok(if distance > gamma(8) * bounds.max_abs() { Flatness::Bent } else { Flatness::Flat })
}
