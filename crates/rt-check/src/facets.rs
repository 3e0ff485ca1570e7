//! Flat faces of a scene in world space: triangles, polygons, disks, and caps of cylinders, cones and frusta.

use std::f64::consts::{PI, TAU};

use rt_geometry::{InsideRule, Polygon, Shape};
use rt_math::float::UNIT_ROUNDOFF;
use rt_math::transcendental::{cos, sincos};
use rt_math::{Aabb, DVec3};

use crate::flat_region::Outline;
use crate::objects::{Geometry, Objects};
use crate::welded::corners;

/// Largest number of faces to compare.
pub(crate) const MAX_FACETS: usize = 1 << 21;

/// Corners of the polygon that stands for a circle; its area is 0.2 % smaller.
const CIRCLE_CORNERS: usize = 64;

/// Faces of a box as pairs of triangles, counter-clockwise from outside. Corner `i` of a box is at its maximum in x for
/// odd `i`, in y for bit 2, in z for bit 4.
const BOX_TRIANGLES: [[usize; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

/// A flat face of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub(crate) object: usize,
    /// Number among the facets of the object.
    pub(crate) number: usize,
    /// World space, counter-clockwise seen from the front: the corners of a triangle, or three corners of another outline.
    pub(crate) corners: [DVec3; 3],
}

/// An object with facets.
#[derive(Clone, Copy, Debug)]
struct Faceted {
    object: usize,
    /// Number of its first facet among those of the scene.
    first: usize,
    /// Three corners of a polygon in local space, counter-clockwise seen from the front.
    span: Option<[DVec3; 3]>,
}

/// Bytes per object with facets.
pub(crate) const FACETED_BYTES: usize = size_of::<Faceted>();

/// All facets of a scene, numbered consecutively and computed on demand.
#[derive(Debug)]
pub(crate) struct Facets<'o> {
    objects: &'o Objects<'o>,
    list: Vec<Faceted>,
    pub(crate) count: usize,
    /// True if there are more than [`MAX_FACETS`].
    pub(crate) truncated: bool,
    /// Corners of a circle of radius 1 around the y axis, counter-clockwise seen from above.
    circle: Vec<DVec3>,
}

impl<'o> Facets<'o> {
    pub(crate) fn of(objects: &'o Objects<'o>) -> Self {
        let corner = |index| {
            let (x, z) = sincos(TAU * index as f64 / CIRCLE_CORNERS as f64);
            DVec3::new(x, 0.0, z)
        };
        let circle = (0..CIRCLE_CORNERS).map(corner).collect();
        let mut facets = Self { objects, list: Vec::new(), count: 0, truncated: false, circle };
        for (index, object) in objects.list.iter().enumerate() {
            let count = facet_count(&object.geometry);
            if facets.count + count > MAX_FACETS {
                facets.truncated = true;
            } else if count > 0 {
                let span = match object.geometry {
                    Geometry::Shape(Shape::Polygon(polygon)) => Some(span(polygon)),
                    _ => None,
                };
                facets.list.push(Faceted { object: index, first: facets.count, span });
                facets.count += count;
            }
        }
        facets
    }

    /// Computes facet number `index` of `0..count`.
    pub(crate) fn at(&self, index: usize) -> Facet {
        let faceted = &self.list[self.list.partition_point(|faceted| faceted.first <= index) - 1];
        self.facet(faceted, index - faceted.first)
    }

    /// Corners of all facets of an object in world space.
    pub(crate) fn corners_of(&self, object: usize) -> Vec<DVec3> {
        let Ok(rank) = self.list.binary_search_by_key(&object, |faceted| faceted.object) else { return Vec::new() };
        let facets = (0..facet_count(&self.objects.list[object].geometry)).map(|n| self.facet(&self.list[rank], n));
        facets.flat_map(|facet| self.outline(&facet).rings).flatten().collect()
    }

    fn facet(&self, faceted: &Faceted, number: usize) -> Facet {
        let placed = &self.objects.list[faceted.object];
        let [a, b, c] = self.local_corners(faceted, number).map(|corner| placed.world_from_local.point(corner));
        let turned = placed.world_from_local.flips_handedness();
        Facet { object: faceted.object, number, corners: if turned { [a, c, b] } else { [a, b, c] } }
    }

    /// True if the corners of a facet are all of its outline.
    pub(crate) fn is_triangle(&self, facet: &Facet) -> bool {
        use Shape::{Cuboid, Rectangle, Triangle};
        match self.objects.list[facet.object].geometry {
            Geometry::Mesh(..) => true,
            Geometry::Shape(shape) => matches!(shape, Cuboid(_) | Rectangle(_) | Triangle(_)),
        }
    }

    /// Outline of a facet in world space.
    pub(crate) fn outline(&self, facet: &Facet) -> Outline {
        if self.is_triangle(facet) {
            return Outline { rings: vec![facet.corners.to_vec()], rule: InsideRule::Convex };
        }
        let object = &self.objects.list[facet.object];
        let mut outline = match object.geometry {
            Geometry::Shape(Shape::Polygon(polygon)) => polygon_outline(polygon),
            Geometry::Shape(Shape::Disk(disk)) => {
                // The polygon of the hole is around its circle, so that a disk that fills the hole is outside.
                let inner = disk.inner_radius() / cos(PI / CIRCLE_CORNERS as f64);
                let radii = [disk.radius(), inner].into_iter().filter(|radius| *radius > 0.0);
                Outline {
                    rings: radii.map(|radius| self.circle.iter().map(|p| *p * radius).collect()).collect(),
                    rule: if inner > 0.0 { InsideRule::EvenOdd } else { InsideRule::Convex },
                }
            }
            _ => {
                let (radius, height) = self.cap(facet.object, facet.number);
                let ring = self.circle.iter().map(|p| *p * radius + DVec3::Y * height).collect();
                Outline { rings: vec![ring], rule: InsideRule::Convex }
            }
        };
        for corner in outline.rings.iter_mut().flatten() {
            *corner = object.world_from_local.point(*corner);
        }
        outline
    }

    /// Boxes around all facets, padded by the rounding error of their positions.
    pub(crate) fn boxes(&self) -> Vec<Aabb> {
        let mut boxes = Vec::with_capacity(self.count);
        for faceted in &self.list {
            let object = &self.objects.list[faceted.object];
            let error = object.placement_error();
            boxes.extend((0..facet_count(&object.geometry)).map(|number| {
                let facet = self.facet(faceted, number);
                let bounds = if self.is_triangle(&facet) {
                    Aabb::from_points(facet.corners)
                } else {
                    Aabb::from_points(self.outline(&facet).rings.into_iter().flatten())
                };
                widened(bounds, error)
            }));
        }
        boxes
    }

    fn local_corners(&self, faceted: &Faceted, number: usize) -> [DVec3; 3] {
        let third = CIRCLE_CORNERS / 3;
        let [a, b, c] = [self.circle[0], self.circle[third], self.circle[2 * third]];
        match self.objects.list[faceted.object].geometry {
            Geometry::Mesh(_, mesh) => corners(mesh, mesh.data().triangles[number]),
            Geometry::Shape(Shape::Cuboid(axis_box)) => {
                let corners = axis_box.bounds().corners();
                BOX_TRIANGLES[number].map(|corner| corners[corner])
            }
            Geometry::Shape(Shape::Triangle(triangle)) => triangle.vertices(),
            Geometry::Shape(Shape::Rectangle(rectangle)) => {
                let (x, z) = (DVec3::X * (rectangle.width() / 2.0), DVec3::Z * (rectangle.depth() / 2.0));
                if number == 0 { [-x - z, z - x, x + z] } else { [-x - z, x + z, x - z] }
            }
            Geometry::Shape(Shape::Disk(disk)) => [a, b, c].map(|p| p * disk.radius()),
            Geometry::Shape(Shape::Polygon(_)) => faceted.span.unwrap_or([DVec3::NAN; 3]),
            Geometry::Shape(_) => {
                let (radius, height) = self.cap(faceted.object, number);
                let corners = if number == BOTTOM { [a, c, b] } else { [a, b, c] };
                corners.map(|p| p * radius + DVec3::Y * height)
            }
        }
    }

    /// Radius and height of a cap of a cylinder, cone or frustum; NaN for other shapes.
    fn cap(&self, object: usize, number: usize) -> (f64, f64) {
        match self.objects.list[object].geometry {
            Geometry::Shape(Shape::Cylinder(quadric) | Shape::Cone(quadric) | Shape::Frustum(quadric)) => {
                (quadric.radii()[number], quadric.heights()[number])
            }
            _ => (f64::NAN, f64::NAN),
        }
    }
}

/// A box padded by the allowance of [`tolerance`].
pub(crate) fn widened(bounds: Aabb, placement_error: f64) -> Aabb {
    let margin = DVec3::splat(4.0 * placement_error + 8.0 * UNIT_ROUNDOFF * bounds.max_abs());
    Aabb::new(bounds.min - margin, bounds.max + margin)
}

/// Number of facets of an object.
pub(crate) fn facet_count(geometry: &Geometry<'_>) -> usize {
    match geometry {
        Geometry::Mesh(_, mesh) => mesh.data().triangles.len(),
        Geometry::Shape(Shape::Cuboid(_)) => BOX_TRIANGLES.len(),
        Geometry::Shape(Shape::Triangle(_) | Shape::Disk(_) | Shape::Polygon(_)) => 1,
        Geometry::Shape(Shape::Rectangle(_)) => 2,
        Geometry::Shape(Shape::Cylinder(quadric) | Shape::Frustum(quadric)) if quadric.has_caps() => 2,
        Geometry::Shape(Shape::Cone(quadric)) if quadric.has_caps() => 1,
        Geometry::Shape(_) => 0,
    }
}

/// Number of the facet at the bottom of a cylinder, cone or frustum.
const BOTTOM: usize = 0;

fn polygon_outline(polygon: &Polygon) -> Outline {
    let rings: Vec<Vec<DVec3>> = polygon.rings().map(<[DVec3]>::to_vec).collect();
    let is_convex = polygon.rule() == InsideRule::Convex
        || rings.len() == 1 && Polygon::new(rings[0].clone(), Vec::new(), InsideRule::Convex).is_ok();
    Outline { rings, rule: if is_convex { InsideRule::Convex } else { polygon.rule() } }
}

/// Three corners of a polygon that are far apart, counter-clockwise seen from the front.
fn span(polygon: &Polygon) -> [DVec3; 3] {
    let corners = || polygon.rings().flatten().copied();
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        corners().max_by(|a, b| measure(*a).total_cmp(&measure(*b))).unwrap_or(DVec3::NAN)
    };
    let a = corners().next().unwrap_or(DVec3::NAN);
    let b = farthest(&|p| (p - a).length_squared());
    let c = farthest(&|p| (b - a).cross(p - a).length_squared());
    if (b - a).cross(c - a).dot(polygon.normal()) < 0.0 { [a, c, b] } else { [a, b, c] }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::coplanar::area_vector;
    use crate::fixture::*;
    use rt_geometry::{CappedQuadric, Cuboid, Disk};
    use rt_math::Transform;
    use rt_scene_io::{Content, SceneNode};

    #[test]
    fn faces_of_boxes_look_outwards_even_if_mirrored() {
        let solid = Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).unwrap();
        let mut node = SceneNode::new(Content::Shape(Shape::Cuboid(solid)), GREY);
        node.parent_from_local = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).unwrap();
        let scene = scene_with(vec![SceneNode { parent_from_local: Transform::IDENTITY, ..node.clone() }, node]);
        let objects = Objects::of(&scene);
        let facets = Facets::of(&objects);
        assert_eq!(facets.count, 24);
        let mut area = [0.0; 2];
        for index in 0..facets.count {
            let Facet { object, corners: [a, b, c], .. } = facets.at(index);
            let normal = (b - a).cross(c - a);
            let centre = objects.list[object].bounds.unwrap().centre();
            assert!(normal.dot(a - centre) > 0.0, "facet {index}");
            area[object] += normal.length() / 2.0;
        }
        assert_eq!(area, [22.0; 2]);
    }

    #[test]
    fn caps_disks_and_polygons_look_to_their_front() {
        let corners = [[0.0, 0.0], [1.0, 1.0], [0.0, 3.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, -2.0));
        let polygon = Polygon::new(corners.to_vec(), Vec::new(), InsideRule::EvenOdd).unwrap();
        let shapes = [
            Shape::Cylinder(CappedQuadric::cylinder(0.5, -1.0, 1.0, true).unwrap()),
            Shape::Frustum(CappedQuadric::frustum(0.5, 2.0, 1.0, true).unwrap()),
            Shape::Cone(CappedQuadric::cone(0.5, 1.0, true).unwrap()),
            Shape::Disk(Disk::new(2.0, 1.0).unwrap()),
            Shape::Polygon(Arc::new(polygon)),
        ];
        let scene = scene_with(shapes.map(|shape| SceneNode::new(Content::Shape(shape), GREY)).to_vec());
        let objects = Objects::of(&scene);
        let facets = Facets::of(&objects);
        let fronts: Vec<DVec3> =
            (0..facets.count).map(|i| area_vector(facets.at(i).corners).normalize().round()).collect();
        let [down, up] = [DVec3::NEG_Y, DVec3::Y];
        assert_eq!(fronts, [down, up, down, up, down, up, DVec3::Z]);
        for (index, bounds) in facets.boxes().into_iter().enumerate() {
            let facet = facets.at(index);
            assert!(!facets.is_triangle(&facet) && facet.corners.iter().all(|corner| bounds.contains(*corner)));
            let inside = objects.list[facet.object].bounds.unwrap();
            assert!(inside.overlaps(&bounds) && (bounds.extent().max_element() > 0.99), "{bounds:?}");
        }
    }
}
