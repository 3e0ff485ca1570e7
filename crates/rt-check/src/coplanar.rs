//! Overlap test of two triangles or convex polygons in one plane.

use rt_math::DVec3;

/// True if the triangles lie in one plane and overlap in more than an edge or corner. `tolerance` is the allowed rounding
/// error of distances.
pub(crate) fn overlap_in_plane(a: [DVec3; 3], b: [DVec3; 3], tolerance: f64) -> bool {
    let Some(axis) = common_plane(a, b, tolerance) else { return false };
    let (a, b) = (a.map(|p| flattened(p, axis)), b.map(|p| flattened(p, axis)));
    !is_separated_by_an_edge(&a, &b, tolerance) && !is_separated_by_an_edge(&b, &a, tolerance)
}

/// Axis that is steepest to the plane of two triangles; `None` if they lie in different planes.
pub(crate) fn common_plane(a: [DVec3; 3], b: [DVec3; 3], tolerance: f64) -> Option<usize> {
    let (normal_a, normal_b) = (area_vector(a), area_vector(b));
    // The plane of the larger triangle is more precise.
    let (base, normal, other) =
        if normal_a.length_squared() >= normal_b.length_squared() { (a, normal_a, b) } else { (b, normal_b, a) };
    let normal = normal.normalize_or_zero();
    if normal == DVec3::ZERO || other.iter().any(|p| (*p - base[0]).dot(normal).abs() > tolerance) {
        return None;
    }
    Some(if normal.x.abs() >= normal.y.abs().max(normal.z.abs()) {
        0
    } else if normal.y.abs() >= normal.z.abs() {
        1
    } else {
        2
    })
}

/// Coordinates of a point without that of one axis.
pub(crate) fn flattened(p: DVec3, axis: usize) -> [f64; 2] {
    [p[(axis + 1) % 3], p[(axis + 2) % 3]]
}

/// Normal whose length is twice the area.
pub(crate) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// True if all of `other` is on the outer side of an edge of a convex polygon (the separating axis theorem).
pub(crate) fn is_separated_by_an_edge(polygon: &[[f64; 2]], other: &[[f64; 2]], tolerance: f64) -> bool {
    let side = double_area(polygon).signum();
    (0..polygon.len()).any(|i| {
        let (from, to) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let length = ((to[0] - from[0]) * (to[0] - from[0]) + (to[1] - from[1]) * (to[1] - from[1])).sqrt();
        let depth = other.iter().map(|p| side * cross(from, to, *p)).fold(f64::NEG_INFINITY, f64::max);
        depth <= tolerance * length
    })
}

/// Twice the area of a polygon, positive if its corners run counter-clockwise.
fn double_area(polygon: &[[f64; 2]]) -> f64 {
    polygon.windows(2).map(|pair| cross(polygon[0], pair[0], pair[1])).sum()
}

/// (b − a) × (p − a).
pub(crate) fn cross(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    rt_math::float::difference_of_products(b[0] - a[0], p[1] - a[1], b[1] - a[1], p[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn moved(by: DVec3) -> [DVec3; 3] {
        CORNER.map(|p| p + by)
    }

    #[test]
    fn only_shared_area_counts() {
        let overlap = |other| overlap_in_plane(CORNER, other, 0.0);
        assert!(overlap(CORNER));
        assert!(overlap([DVec3::ZERO, DVec3::Y, DVec3::X]), "back to back");
        assert!(overlap(moved(DVec3::X * 0.5)));
        assert!(overlap(CORNER.map(|p| p * 1e-3 + DVec3::splat(0.1) * DVec3::new(1.0, 1.0, 0.0))), "within");
        assert!(!overlap(moved(DVec3::X)), "a corner");
        assert!(!overlap([DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y]), "an edge");
        assert!(!overlap(moved(DVec3::Z * 1e-12)), "another plane");
        assert!(!overlap([DVec3::ZERO, DVec3::X, DVec3::Z]), "across");
        assert!(!overlap(moved(DVec3::new(3.0, 3.0, 0.0))));
    }

    #[test]
    fn rounding_is_allowed_for() {
        let tolerance = 1e-9;
        assert!(overlap_in_plane(CORNER, moved(DVec3::Z * 1e-10), tolerance));
        assert!(!overlap_in_plane(CORNER, moved(DVec3::Z * 1e-8), tolerance));
        let neighbour = [DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y].map(|p| p - DVec3::X * 1e-10);
        assert!(!overlap_in_plane(CORNER, neighbour, tolerance), "neighbours that overlap by rounding");
    }
}
