//! Overlapping surfaces in one plane, which are seldom intended.
//!
//! At bit-identical distances the first object is visible. Hits on faces that are rotated in their plane differ by rounding:
//! either face can be visible.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rt_accel::{Accelerator, Boxes, Bvh};
use rt_geometry::{Shape, Sphere, TransformedShape};
use rt_math::{Aabb, DVec3};

use crate::coplanar::{area_vector, common_plane, flattened, overlap_in_plane};
use crate::facets::{Facet, Facets, widened};
use crate::finding::{Finding, Findings, Kind};
use crate::flat_region::{Outline, overlap};
use crate::objects::{Geometry, Object, Objects};
use crate::round_side::RoundSide;
use crate::solids::Solids;
use crate::tolerance::tolerance;

/// Largest number of overlapping boxes to compare.
const MAX_PAIRS: u64 = 1 << 24;

/// Largest number of planes to compare with all faces.
const MAX_PLANES: usize = 64;

/// Largest number of pairs of edges to compare, of faces that are no triangles.
const MAX_EDGE_PAIRS: usize = 1 << 28;

/// Overlap of two objects, or of parts of one.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    /// Pairs of faces.
    faces: u64,
    /// Pairs with a camera on their front side.
    visible: u64,
}

/// Finds contacts between objects.
struct Search<'o> {
    objects: &'o Objects<'o>,
    solids: &'o Solids,
    eyes: Vec<DVec3>,
    errors: Vec<f64>,
    /// Pairs of edges that may still be compared.
    edge_pairs_left: usize,
    /// Overlaps by pair of objects. At equal distances the first object is visible.
    contacts: BTreeMap<(usize, usize), Contact>,
}

pub(crate) fn check(objects: &Objects<'_>, solids: &Solids, findings: &mut Findings) {
    let cameras = &objects.scene.cameras;
    let mut search = Search {
        objects,
        solids,
        eyes: cameras.iter().map(|camera| camera.settings.world_from_camera.translation()).collect(),
        errors: objects.list.iter().map(Object::placement_error).collect(),
        edge_pairs_left: MAX_EDGE_PAIRS,
        contacts: BTreeMap::new(),
    };
    let facets = Facets::of(objects);
    let complete = [search.faces(&facets), search.planes(&facets), search.round_shapes(), !facets.truncated];
    for (&(first, second), contact) in &search.contacts {
        findings.extend(search.finding(first, second, contact));
    }
    if complete.contains(&false) {
        let message = "has too many faces, or too many close ones, to compare all of them";
        findings.add(Finding::new(Kind::LimitReached, &objects.scene.name, &[("pairs", MAX_PAIRS as f64)], message));
    }
}

impl Search<'_> {
    /// Compares flat faces with each other. Returns true if all were compared.
    fn faces(&mut self, facets: &Facets<'_>) -> bool {
        let mut is_complete = true;
        let all_visited = visit_pairs(&facets.boxes(), |i, j| {
            is_complete &= self.pair(facets, facets.at(i), facets.at(j));
        });
        all_visited && is_complete
    }

    /// Compares two faces. Returns false if that would take too long.
    fn pair(&mut self, facets: &Facets<'_>, a: Facet, b: Facet) -> bool {
        let geometry = self.objects.list[a.object].geometry;
        if a.object == b.object && (!matches!(geometry, Geometry::Mesh(..)) || is_same_triangle(a.corners, b.corners)) {
            return true;
        }
        let reach = a.corners.iter().chain(&b.corners).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let allowed = tolerance(self.errors[a.object] + self.errors[b.object], reach);
        let do_overlap = if facets.is_triangle(&a) && facets.is_triangle(&b) {
            overlap_in_plane(a.corners, b.corners, allowed)
        } else if let Some(axis) = common_plane(a.corners, b.corners, allowed) {
            let [outline_a, outline_b] = [&a, &b].map(|facet| facets.outline(facet));
            let edge_pairs = outline_a.corner_count().saturating_mul(outline_b.corner_count());
            let Some(left) = self.edge_pairs_left.checked_sub(edge_pairs) else { return false };
            self.edge_pairs_left = left;
            let region = |outline: Outline| outline.flattened(|corner| flattened(corner, axis));
            overlap(&region(outline_a), &region(outline_b), allowed)
        } else {
            false
        };
        if do_overlap {
            self.add(a, b, area_vector(a.corners), area_vector(b.corners));
        }
        true
    }

    /// Compares planes with faces and each other. Returns true if all were compared.
    fn planes(&mut self, facets: &Facets<'_>) -> bool {
        let is_plane = |(_, object): &(usize, &Object<'_>)| matches!(object.geometry, Geometry::Shape(Shape::Plane(_)));
        let planes: Vec<(usize, &Object<'_>)> = self.objects.list.iter().enumerate().filter(is_plane).collect();
        let some = &planes[..planes.len().min(MAX_PLANES)];
        for (rank, &(index, object)) in some.iter().enumerate() {
            let Some((point, normal)) = plane_in_world(object) else { continue };
            let as_facet = |object, point| Facet { object, number: 0, corners: [point; 3] };
            for &(other_index, other) in &some[rank + 1..] {
                let Some((other_point, other_normal)) = plane_in_world(other) else { continue };
                let reach = point.abs().max_element().max(other_point.abs().max_element());
                let allowed = tolerance(self.errors[index] + self.errors[other_index], reach);
                let parallel = normal.cross(other_normal).length() <= tolerance(0.0, 1.0);
                if parallel && (other_point - point).dot(normal).abs() <= allowed {
                    self.add(as_facet(index, point), as_facet(other_index, other_point), normal, other_normal);
                }
            }
            for facet in (0..facets.count).map(|i| facets.at(i)) {
                let reach =
                    facet.corners.iter().map(|p| p.abs().max_element()).fold(point.abs().max_element(), f64::max);
                let allowed = tolerance(self.errors[facet.object] + self.errors[index], reach);
                if facet.corners.iter().all(|p| (*p - point).dot(normal).abs() <= allowed) {
                    self.add(as_facet(index, point), facet, normal, area_vector(facet.corners));
                }
            }
        }
        planes.len() <= MAX_PLANES
    }

    /// Finds curved surfaces at the same position. Returns true if all were compared.
    fn round_shapes(&mut self) -> bool {
        let is_round = |object: &Object<'_>| match object.geometry {
            Geometry::Shape(
                Shape::Cuboid(_)
                | Shape::Triangle(_)
                | Shape::Rectangle(_)
                | Shape::Plane(_)
                | Shape::Disk(_)
                | Shape::Polygon(_),
            )
            | Geometry::Mesh(..) => None,
            Geometry::Shape(_) => object.bounds,
        };
        let (indices, boxes): (Vec<usize>, Vec<_>) = (self.objects.list.iter().enumerate())
            .filter_map(|(index, object)| Some((index, widened(is_round(object)?, self.errors[index]))))
            .unzip();
        visit_pairs(&boxes, |i, j| {
            let (first, second) = (indices[i], indices[j]);
            let (a, b) = (&self.objects.list[first], &self.objects.list[second]);
            if is_same_surface(a, b, self.errors[first] + self.errors[second]) {
                let contact = self.contacts.entry((first, second)).or_default();
                contact.faces += 1;
                contact.visible += 1;
            }
        })
    }

    fn add(&mut self, a: Facet, b: Facet, normal_a: DVec3, normal_b: DVec3) {
        let contact = self.contacts.entry((a.object.min(b.object), a.object.max(b.object))).or_default();
        contact.faces += 1;
        // Faces of solids are visible from their front: only a surface that touches the front can cover it.
        let in_front = |facet: &Facet, normal: DVec3| {
            self.eyes.is_empty() || self.eyes.iter().any(|eye| (*eye - facet.corners[0]).dot(normal) > 0.0)
        };
        let visible = match (self.solids.is_closed(a.object), self.solids.is_closed(b.object)) {
            (false, false) => true,
            (true, false) => in_front(&a, normal_a),
            (false, true) => in_front(&b, normal_b),
            (true, true) => normal_a.dot(normal_b) > 0.0 && in_front(&a, normal_a),
        };
        contact.visible += u64::from(visible);
    }

    fn finding(&self, first: usize, second: usize, contact: &Contact) -> Option<Finding> {
        let objects = self.objects;
        let (a, b) = (&objects.list[first], &objects.list[second]);
        let (name, other) = (objects.name(a), objects.name(b));
        let Contact { faces, visible } = *contact;
        let values = [("faces", faces as f64), ("visible_faces", visible as f64)];
        let pairs = if faces == 1 { "pair" } else { "pairs" };
        if first == second {
            let message = format!("{faces} pairs of triangles overlap; the one of the lower index is visible");
            let finding = Finding::new(Kind::CoincidentSurfaces, name, &values, message);
            return Some(
                finding
                    .warn_if(objects.is_glass(a))
                    .with_advice("remove the overlap: rays enter the dielectric twice there"),
            );
        }
        if objects.is_glass(a) || objects.is_glass(b) {
            let message = format!(
                "touches {other} exactly ({faces} {pairs} of faces); rays hit the first of the two and miss the other"
            );
            // Rays through glass that is hit first continue behind the surface that it touches.
            let leaks = objects.is_glass(a) && !objects.is_glass(b);
            return Some(Finding::new(Kind::TouchingGlass, name, &values, message).warn_if(leaks));
        }
        (visible > 0).then(|| {
            let message = format!(
                "overlaps {other} ({faces} {pairs} of faces); the first of the two is visible, or either if one is rotated"
            );
            Finding::new(Kind::CoincidentSurfaces, name, &values, message).warn_if(a.material != b.material)
        })
    }
}

/// Visits pairs of overlapping boxes, once each with the lower index first. Returns true if their number allowed to visit
/// all of them.
fn visit_pairs(boxes: &[Aabb], mut visit: impl FnMut(usize, usize)) -> bool {
    let boxes = Boxes(boxes);
    let Ok(bvh) = Bvh::build(&boxes) else { return false };
    let mut left = MAX_PAIRS;
    bvh.visit_overlapping_pairs(&boxes, |i, j| {
        if left == 0 {
            return ControlFlow::Break(());
        }
        left -= 1;
        visit(i as usize, j as usize);
        ControlFlow::Continue(())
    });
    left > 0
}

/// True if the corners are the same in any order; another lint reports such triangles of a mesh.
fn is_same_triangle(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    a.iter().all(|corner| b.contains(corner))
}

/// A point and the unit normal of a plane in world space.
fn plane_in_world(object: &Object<'_>) -> Option<(DVec3, DVec3)> {
    let Geometry::Shape(Shape::Plane(plane)) = object.geometry else { return None };
    let map = &object.world_from_local;
    Some((map.point(plane.point()), map.normal(plane.normal()).try_normalize()?))
}

/// True if two curved surfaces are the same, or coincide in a part of the sides of cylinders, cones or frusta.
fn is_same_surface(a: &Object<'_>, b: &Object<'_>, placement_errors: f64) -> bool {
    if let (Some(a), Some(b)) = (RoundSide::of(a), RoundSide::of(b)) {
        return a.coincides(&b, placement_errors);
    }
    let (Geometry::Shape(shape_a), Geometry::Shape(shape_b)) = (a.geometry, b.geometry) else { return false };
    match (sphere_in_world(shape_a, a), sphere_in_world(shape_b, b)) {
        (Some(a), Some(b)) => {
            let allowed = tolerance(placement_errors, a.centre().abs().max_element() + a.radius());
            (a.centre() - b.centre()).length() <= allowed && (a.radius() - b.radius()).abs() <= allowed
        }
        _ => shape_a == shape_b && a.world_from_local == b.world_from_local,
    }
}

/// Image of a sphere under a similarity transform.
fn sphere_in_world(shape: &Shape, object: &Object<'_>) -> Option<Sphere> {
    match TransformedShape::new(shape.clone(), object.world_from_local).bake_transform_ignoring_uv() {
        Some(Shape::Sphere(sphere)) => Some(sphere),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
