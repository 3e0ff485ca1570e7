//! Flat faces of a scene in world space, as triangles.

use rt_geometry::Shape;
use rt_math::float::UNIT_ROUNDOFF;
use rt_math::{Aabb, DVec3};

use crate::objects::{Geometry, Object, Objects};
use crate::welded::corners;

/// Largest number of faces to compare.
const MAX_FACETS: usize = 1 << 21;

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

/// A flat triangle of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub(crate) object: usize,
    /// World space, counter-clockwise seen from the front.
    pub(crate) corners: [DVec3; 3],
}

/// All facets of a scene, numbered consecutively and computed on demand.
#[derive(Debug)]
pub(crate) struct Facets<'o> {
    objects: &'o Objects<'o>,
    /// Objects with facets, with the number of their first one.
    starts: Vec<(usize, usize)>,
    pub(crate) count: usize,
    /// True if there are more than [`MAX_FACETS`].
    pub(crate) truncated: bool,
}

impl<'o> Facets<'o> {
    pub(crate) fn of(objects: &'o Objects<'o>) -> Self {
        let mut facets = Self { objects, starts: Vec::new(), count: 0, truncated: false };
        for (index, object) in objects.list.iter().enumerate() {
            let count = facet_count(object);
            if facets.count + count > MAX_FACETS {
                facets.truncated = true;
            } else if count > 0 {
                facets.starts.push((index, facets.count));
                facets.count += count;
            }
        }
        facets
    }

    /// Computes facet number `index` of `0..count`.
    pub(crate) fn at(&self, index: usize) -> Facet {
        let (object, first) = self.starts[self.starts.partition_point(|(_, first)| *first <= index) - 1];
        let number = index - first;
        let placed = &self.objects.list[object];
        let [a, b, c] = local_corners(placed, number).map(|corner| placed.world_from_local.point(corner));
        let turned = placed.world_from_local.flips_handedness();
        Facet { object, corners: if turned { [a, c, b] } else { [a, b, c] } }
    }

    /// Boxes around all facets, padded by the rounding error of their positions.
    pub(crate) fn boxes(&self) -> Vec<Aabb> {
        let mut boxes = Vec::with_capacity(self.count);
        for &(object, _) in &self.starts {
            let object = &self.objects.list[object];
            let error = object.placement_error();
            boxes.extend((0..facet_count(object)).map(|number| {
                let corners = local_corners(object, number).map(|corner| object.world_from_local.point(corner));
                widened(Aabb::from_points(corners), error)
            }));
        }
        boxes
    }
}

/// A box padded by the allowance of [`tolerance`].
pub(crate) fn widened(bounds: Aabb, placement_error: f64) -> Aabb {
    let margin = DVec3::splat(4.0 * placement_error + 8.0 * UNIT_ROUNDOFF * bounds.max_abs());
    Aabb::new(bounds.min - margin, bounds.max + margin)
}

/// Maximum computed distance of coincident surfaces: the errors of both transforms, and a few roundings of the
/// largest coordinate.
pub(crate) fn tolerance(placement_errors: f64, max_abs: f64) -> f64 {
    4.0 * placement_errors + 8.0 * UNIT_ROUNDOFF * max_abs
}

fn facet_count(object: &Object<'_>) -> usize {
    match object.geometry {
        Geometry::Mesh(_, mesh) => mesh.data().triangles.len(),
        Geometry::Shape(Shape::Cuboid(_)) => BOX_TRIANGLES.len(),
        Geometry::Shape(Shape::Triangle(_)) => 1,
        Geometry::Shape(Shape::Rectangle(_)) => 2,
        Geometry::Shape(_) => 0,
    }
}

fn local_corners(object: &Object<'_>, number: usize) -> [DVec3; 3] {
    match object.geometry {
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
        Geometry::Shape(_) => [DVec3::NAN; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_geometry::Cuboid;
    use rt_math::Transform;
    use rt_scene_io::{Content, SceneNode};

    #[test]
    fn faces_of_boxes_look_outwards_even_if_mirrored() {
        let mut scene = empty();
        let solid = Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).unwrap();
        let mut node = SceneNode::new(Content::Shape(Shape::Cuboid(solid)), GREY);
        node.parent_from_local = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).unwrap();
        scene.nodes = vec![SceneNode { parent_from_local: Transform::IDENTITY, ..node.clone() }, node];
        let objects = Objects::of(&scene);
        let facets = Facets::of(&objects);
        assert_eq!(facets.count, 24);
        let mut area = [0.0; 2];
        for index in 0..facets.count {
            let Facet { object, corners: [a, b, c] } = facets.at(index);
            let normal = (b - a).cross(c - a);
            let centre = objects.list[object].bounds.unwrap().centre();
            assert!(normal.dot(a - centre) > 0.0, "facet {index}");
            area[object] += normal.length() / 2.0;
        }
        assert_eq!(area, [22.0; 2]);
    }
}
