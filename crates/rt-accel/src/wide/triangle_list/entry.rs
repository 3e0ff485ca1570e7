//! Copies of one primitive in a list.

use glam::Vec3;
use rt_math::float::{UNIT_ROUNDOFF, cross, two_product, two_sum};
use rt_math::{Aabb, DVec3};

/// Error of weights per rounding of coordinates; see [`list_filter`](crate::wide::list_filter).
const EDGE_MARGIN: f64 = 96.0 / (1 << 24) as f64;

/// Maximum length of the gradients of barycentric coordinates, in reciprocal sizes of the tree. No height of a triangle is
/// thus less than 2⁻¹² of the size.
const MAX_GRADIENT: f64 = (1 << 12) as f64;

/// Maximum ratio of the length of an edge to the height above it.
const MAX_ASPECT: f64 = (1 << 10) as f64;

/// Plane and barycentric coordinates of a triangle, for the filter. Positions are relative to the centre of the tree.
///
/// Baldwin and Weber, "Fast Ray-Triangle Intersections by Coordinate Transformation", JCGT 5(3), 2016.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct FilterTriangle {
    /// Unit normal, and its product with a point of the plane.
    pub(in crate::wide) plane: [f32; 4],
    /// Gradient of the weight of the second vertex, and the weight at the centre.
    pub(in crate::wide) second: [f32; 4],
    /// The same of the third vertex.
    pub(in crate::wide) third: [f32; 4],
    /// Error of a weight per error of a coordinate.
    pub(in crate::wide) margin: f32,
}

/// Two triangles of one plane, for the filter. They share an edge and lie on opposite sides of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct FilterPair {
    /// See [`FilterTriangle::plane`].
    pub(in crate::wide) plane: [f32; 4],
    /// [`second`](FilterTriangle::second) and [`third`](FilterTriangle::third) of each triangle.
    pub(in crate::wide) weights: [[[f32; 4]; 2]; 2],
    /// The greater of both margins.
    pub(in crate::wide) margin: f32,
}

/// Plane of a triangle in world space, for rays that start next to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct ExactPlane {
    /// Normal, twice as long as the area, to [`NORMAL_ERROR`].
    pub(in crate::wide) normal: [f64; 3],
    /// First vertex.
    pub(in crate::wide) vertex: [f64; 3],
    /// Minimum product with the normal at which the signs of `t` and of the determinant are certain, for a direction of
    /// maximum component 1. One part is that of the triangle itself, the other is per distance of the first vertex.
    pub(in crate::wide) min_slope: [f64; 2],
}

/// Relative error bound of each coordinate of the normal: a difference of two products with their errors, and the sum of the
/// differences.
pub(in crate::wide) const NORMAL_ERROR: f64 = 2.5 * UNIT_ROUNDOFF;

/// Coordinates x, y, z, x, y and z of each vertex. Any three in a row are those that
/// [`WatertightRay`](rt_geometry::WatertightRay) uses for one of the axes.
pub(in crate::wide) type Corners = [f32; 18];

/// Copies of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct ListTriangle {
    pub(in crate::wide) corners: Corners,
    pub(in crate::wide) plane: ExactPlane,
    pub(in crate::wide) index: u32,
}

/// A primitive that only its own test intersects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct ListOther {
    /// Padded bounds.
    pub(in crate::wide) bounds: Aabb,
    pub(in crate::wide) index: u32,
    pub(in crate::wide) casts_shadow: bool,
}

/// `b − a`; `None` if a coordinate is rounded or has more than 50 bits.
fn exact_difference(a: DVec3, b: DVec3) -> Option<DVec3> {
    let difference = b - a;
    let is_exact = |axis: usize| two_sum(b[axis], -a[axis]).1 == 0.0 && difference[axis].to_bits() & 7 == 0;
    (0..3).all(is_exact).then_some(difference)
}

/// `a × b` to [`NORMAL_ERROR`], for vectors from [`exact_difference`]: the errors of two products of almost equal size have a
/// sum of less than 50 bits.
fn accurate_cross(a: DVec3, b: DVec3) -> DVec3 {
    let difference = |i: usize, j: usize| {
        let ((ab, ab_error), (cd, cd_error)) = (two_product(a[i], b[j]), two_product(a[j], b[i]));
        (ab - cd) + (ab_error - cd_error)
    };
    DVec3::new(difference(1, 2), difference(2, 0), difference(0, 1))
}

impl FilterTriangle {
    /// `None` for triangles that the proof of the filter excludes.
    pub(in crate::wide) fn new(vertices: [Vec3; 3], centre: DVec3, size: f64) -> Option<Self> {
        let [a, b, c] = vertices.map(|vertex| vertex.as_dvec3() - centre);
        let (to_b, to_c) = (b - a, c - a);
        let normal = cross(to_b, to_c);
        let longest = to_b.length_squared().max(to_c.length_squared()).max((c - b).length_squared());
        let area_squared = normal.length_squared();
        // False for NaN.
        if !(area_squared * MAX_ASPECT * MAX_ASPECT >= longest * longest && longest > 0.0) {
            return None;
        }
        let unit = normal / area_squared.sqrt();
        let (second, third) = (cross(to_c, normal) / area_squared, cross(normal, to_b) / area_squared);
        let sum = |gradient: DVec3| gradient.abs().element_sum();
        let gradients = sum(second) + sum(third);
        if !(gradients * size <= MAX_GRADIENT) {
            return None;
        }
        let row = |v: DVec3, offset: f64| [v.x as f32, v.y as f32, v.z as f32, offset as f32];
        Some(Self {
            plane: row(unit, unit.dot(a)),
            second: row(second, -second.dot(a)),
            third: row(third, -third.dot(a)),
            margin: (gradients * EDGE_MARGIN) as f32,
        })
    }
}

impl FilterPair {
    /// Pair of two triangles with these vertices; `None` if their planes are not equal as stored. So it is, too, unless they run
    /// along a common edge in opposite directions: a ray could hit both.
    pub(in crate::wide) fn new([first, second]: [(&FilterTriangle, [Vec3; 3]); 2]) -> Option<Self> {
        let edges = |[a, b, c]: [Vec3; 3]| [(a, b), (b, c), (c, a)];
        let shares_edge = edges(first.1).iter().any(|&(from, to)| edges(second.1).contains(&(to, from)));
        let (first, second) = (first.0, second.0);
        (shares_edge && first.plane == second.plane).then(|| Self {
            plane: first.plane,
            weights: [[first.second, first.third], [second.second, second.third]],
            margin: first.margin.max(second.margin),
        })
    }
}

impl ExactPlane {
    /// Plane of a triangle that has a [`FilterTriangle`].
    pub(in crate::wide) fn new(vertices: [Vec3; 3]) -> Self {
        let [a, b, c] = vertices.map(|vertex| vertex.as_dvec3());
        // Never certain where differences of vertices are rounded.
        let Some((to_b, to_c)) = exact_difference(a, b).zip(exact_difference(a, c)) else {
            return Self { normal: [0.0; 3], vertex: a.into(), min_slope: [f64::MAX; 2] };
        };
        let normal = accurate_cross(to_b, to_c);
        let longest = to_b.length().max(to_c.length()).max((c - b).length());
        let twice_area = normal.length();
        // The area over the least height is half of the longest edge.
        let per_distance = longest * SLOPE_PER_DISTANCE;
        Self {
            normal: normal.into(),
            vertex: a.into(),
            min_slope: [twice_area * MIN_COSINE + longest * per_distance, per_distance],
        }
    }
}

/// Cosine of the angle between ray and normal up to which a triangle counts as seen edge-on.
const MIN_COSINE: f64 = 1.0 / (1 << 10) as f64;

/// 2⁻²⁹
const SLOPE_PER_DISTANCE: f64 = 1.0 / (1 << 29) as f64;

/// Numbers of three vertices.
pub(in crate::wide) fn corners(vertices: [Vec3; 3]) -> Corners {
    let mut corners = [0.0; 18];
    for (at, number) in corners.iter_mut().enumerate() {
        *number = vertices[at / 6][at % 3];
    }
    corners
}
