//! Non-planar polygons, and polygons with crossing edges.

use rt_geometry::{Polygon, Shape};
use rt_math::float::{UNIT_ROUNDOFF, difference_of_products};
use rt_math::{Aabb, DVec3};

use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Geometry, Objects};

/// Maximum deviation of a polygon from a plane, as a fraction of its diameter.
const FLAT: f64 = 1e-9;

/// Largest number of pairs of edges to compare in a scene.
const MAX_EDGE_PAIRS: usize = 1 << 25;

type Edge = [[f64; 2]; 2];

pub(crate) fn check(objects: &Objects<'_>, findings: &mut Findings) {
    let (mut left, mut passed_over) = (MAX_EDGE_PAIRS, 0u64);
    for object in &objects.list {
        let Geometry::Shape(Shape::Polygon(polygon)) = object.geometry else { continue };
        findings.extend(bent(objects.name(object), polygon));
        let corners: usize = polygon.rings().map(<[DVec3]>::len).sum();
        match left.checked_sub(corners.saturating_mul(corners) / 2) {
            Some(rest) => {
                left = rest;
                findings.extend(crossed(objects.name(object), polygon));
            }
            None => passed_over += 1,
        }
    }
    if passed_over > 0 {
        findings.add(Finding::new(
            Kind::LimitReached,
            &objects.scene.name,
            &[("polygons", passed_over as f64)],
            format!("{passed_over} polygons have too many corners to test for crossing edges"),
        ));
    }
}

fn bent(object: String, polygon: &Polygon) -> Option<Finding> {
    let first = *polygon.rings().next()?.first()?;
    let (mut min, mut max) = (0.0f64, 0.0f64);
    for corner in polygon.rings().flatten() {
        let height = (*corner - first).dot(polygon.normal());
        (min, max) = (min.min(height), max.max(height));
    }
    let deviation = (max - min) / 2.0;
    let diameter = Aabb::from_points(polygon.rings().flatten().copied()).extent().length();
    (deviation > FLAT * diameter).then(|| {
        Finding::new(
            Kind::NonPlanarPolygon,
            object,
            &[("deviation", deviation), ("deviation_over_diameter", deviation / diameter)],
            format!("corners lie up to {deviation:.3e} off a plane ({:.3e} of its diameter)", deviation / diameter),
        )
    })
}

fn crossed(object: String, polygon: &Polygon) -> Option<Finding> {
    let count = crossings(polygon);
    (count > 0).then(|| {
        Finding::new(
            Kind::SelfIntersectingPolygon,
            object,
            &[("crossings", count as f64)],
            format!("edges cross {count} times; the inside depends on the `rule` of the polygon"),
        )
    })
}

/// Number of pairs of edges that certainly cross in a point inside of both.
fn crossings(polygon: &Polygon) -> usize {
    let normal = polygon.normal().abs();
    let axis = if normal.x >= normal.y.max(normal.z) { 0 } else { 1 + usize::from(normal.z > normal.y) };
    let flat = |p: DVec3| [p[(axis + 1) % 3], p[(axis + 2) % 3]];
    let edges: Vec<Edge> = polygon
        .rings()
        .flat_map(|ring| (0..ring.len()).map(move |i| [flat(ring[i]), flat(ring[(i + 1) % ring.len()])]))
        .collect();
    let crossing = |(i, a): (usize, &Edge)| edges[i + 1..].iter().filter(|b| cross(a, b)).count();
    edges.iter().enumerate().map(crossing).sum()
}

fn cross(a: &Edge, b: &Edge) -> bool {
    let apart = |k: usize| a[0][k].max(a[1][k]) < b[0][k].min(b[1][k]) || b[0][k].max(b[1][k]) < a[0][k].min(a[1][k]);
    !apart(0) && !apart(1) && side(a, b[0]) * side(a, b[1]) < 0 && side(b, a[0]) * side(b, a[1]) < 0
}

/// Side of an edge on which a point lies: 1 or −1, and 0 if uncertain by rounding. The products have exact signs; the
/// differences before them have a relative error of u each.
fn side(edge: &Edge, p: [f64; 2]) -> i32 {
    let [a, b] = edge;
    let (e, f) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let determinant = difference_of_products(e[0], f[1], e[1], f[0]);
    let doubt = 4.0 * UNIT_ROUNDOFF * ((e[0] * f[1]).abs() + (e[1] * f[0]).abs());
    if determinant.abs() > doubt { if determinant > 0.0 { 1 } else { -1 } } else { 0 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fixture::*;
    use rt_geometry::InsideRule;
    use rt_scene_io::{Content, Scene, SceneNode};

    fn scene_of(outline: Vec<DVec3>, holes: Vec<Vec<DVec3>>) -> Scene {
        let polygon = Polygon::new(outline, holes, InsideRule::EvenOdd).unwrap();
        Scene { nodes: vec![SceneNode::new(Content::Shape(Shape::Polygon(Arc::new(polygon))), GREY)], ..empty() }
    }

    fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|[x, y]| DVec3::new(*x, *y, 1.0)).collect()
    }

    #[test]
    fn a_pentagram_crosses_itself_five_times() {
        let star = [[0.0, 3.0], [2.0, -3.0], [-3.0, 1.0], [3.0, 1.0], [-2.0, -3.0]];
        let finding = only(&scene_of(flat(&star), vec![]), Kind::SelfIntersectingPolygon);
        assert_eq!(finding.values, [value("crossings", 5.0)]);
    }

    #[test]
    fn concave_outlines_and_holes_do_not_cross() {
        let concave = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let hole = [[1.0, 0.25], [3.0, 0.25], [2.0, 0.75]];
        assert_eq!(of_kind(&scene_of(flat(&concave), vec![flat(&hole)]), Kind::SelfIntersectingPolygon), []);
        let outside = [[1.0, 0.25], [3.0, 0.25], [2.0, -1.0]];
        let finding = only(&scene_of(flat(&concave), vec![flat(&outside)]), Kind::SelfIntersectingPolygon);
        assert_eq!(finding.values, [value("crossings", 2.0)]);
        assert_eq!(of_kind(&scene_of(flat(&concave), vec![]), Kind::NonPlanarPolygon), []);
    }

    #[test]
    fn a_bent_polygon_is_measured() {
        let mut square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        square[2].z += 1e-7;
        let finding = only(&scene_of(square, vec![]), Kind::NonPlanarPolygon);
        assert!((2e-8..6e-8).contains(&finding.values[0].value), "{finding:?}");
    }
}
