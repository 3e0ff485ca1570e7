//! Surfaces that lie in each other. Where both are met at the same distance to the last bit, the object that comes first
//! is seen. Faces that are turned against each other in their plane are met at distances that rounding makes differ, and
//! either may be seen. It is seldom what was meant.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rt_accel::{Accelerator, Boxes, Bvh};
use rt_geometry::{Shape, Sphere, TransformedShape};
use rt_math::{Aabb, DVec3};

use super::bodies::Bodies;
use super::coplanar::{area_vector, lie_in_each_other};
use super::facets::{Facet, Facets, tolerance, widened};
use super::objects::{Geometry, Object, Objects};
use super::report::{Finding, Findings, Kind, Severity, value};

/// Most pairs of overlapping boxes that are looked at.
const MAX_PAIRS: u64 = 1 << 24;

/// Most planes that are compared with all faces.
const MAX_PLANES: usize = 64;

/// Where two objects (or parts of one) lie in each other.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    /// Pairs of faces.
    faces: u64,
    /// Those in front of which a camera stands.
    visible: u64,
}

/// Finds contacts between objects.
struct Search<'o> {
    objects: &'o Objects<'o>,
    bodies: &'o Bodies,
    eyes: Vec<DVec3>,
    errors: Vec<f64>,
    /// By the two objects, the one that comes first and is seen ahead of the other.
    contacts: BTreeMap<(usize, usize), Contact>,
}

pub(super) fn check(objects: &Objects<'_>, bodies: &Bodies, findings: &mut Findings) {
    let cameras = &objects.scene.cameras;
    let mut search = Search {
        objects,
        bodies,
        eyes: cameras.iter().map(|camera| camera.settings.world_from_camera.translation()).collect(),
        errors: objects.list.iter().map(Object::placement_error).collect(),
        contacts: BTreeMap::new(),
    };
    let facets = Facets::of(objects);
    let complete = [search.faces(&facets), search.planes(&facets), search.round_shapes(), !facets.truncated];
    for (&(first, second), contact) in &search.contacts {
        findings.extend(search.finding(first, second, contact));
    }
    if complete.contains(&false) {
        findings.add(Finding {
            severity: Severity::Info,
            kind: Kind::LimitReached,
            object: objects.scene.name.clone(),
            values: vec![value("pairs", MAX_PAIRS as f64)],
            message: "has too many faces, or too many that are near each other, to compare all of them".into(),
            advice: "check its parts one by one to find all coincident surfaces",
        });
    }
}

impl Search<'_> {
    /// Flat faces against each other. Returns whether all were compared.
    fn faces(&mut self, facets: &Facets<'_>) -> bool {
        visit_pairs(&facets.boxes(), |i, j| self.pair(facets.at(i), facets.at(j)))
    }

    fn pair(&mut self, a: Facet, b: Facet) {
        let geometry = self.objects.list[a.object].geometry;
        if a.object == b.object && (!matches!(geometry, Geometry::Mesh(..)) || is_same_triangle(a.corners, b.corners)) {
            return;
        }
        let reach = a.corners.iter().chain(&b.corners).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        if lie_in_each_other(a.corners, b.corners, tolerance(self.errors[a.object] + self.errors[b.object], reach)) {
            self.add(a, b, area_vector(a.corners), area_vector(b.corners));
        }
    }

    /// Planes against faces and each other. Returns whether all were compared.
    fn planes(&mut self, facets: &Facets<'_>) -> bool {
        let is_plane = |(_, object): &(usize, &Object<'_>)| matches!(object.geometry, Geometry::Shape(Shape::Plane(_)));
        let planes: Vec<(usize, &Object<'_>)> = self.objects.list.iter().enumerate().filter(is_plane).collect();
        let some = &planes[..planes.len().min(MAX_PLANES)];
        for (rank, &(index, object)) in some.iter().enumerate() {
            let Some((point, normal)) = plane_in_world(object) else { continue };
            let as_facet = |object, point| Facet { object, corners: [point; 3] };
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

    /// Shapes without flat faces: the same one in the same place. Returns whether all were compared.
    fn round_shapes(&mut self) -> bool {
        let is_round = |object: &Object<'_>| match object.geometry {
            Geometry::Shape(Shape::Cuboid(_) | Shape::Triangle(_) | Shape::Rectangle(_) | Shape::Plane(_))
            | Geometry::Mesh(..) => None,
            Geometry::Shape(_) => object.bounds,
        };
        let (indices, boxes): (Vec<usize>, Vec<_>) = (self.objects.list.iter().enumerate())
            .filter_map(|(index, object)| Some((index, widened(is_round(object)?, self.errors[index]))))
            .unzip();
        visit_pairs(&boxes, |i, j| {
            let (first, second) = (indices[i], indices[j]);
            let (a, b) = (&self.objects.list[first], &self.objects.list[second]);
            if is_same_shape(a, b, self.errors[first] + self.errors[second]) {
                let contact = self.contacts.entry((first, second)).or_default();
                contact.faces += 1;
                contact.visible += 1;
            }
        })
    }

    fn add(&mut self, a: Facet, b: Facet, normal_a: DVec3, normal_b: DVec3) {
        let contact = self.contacts.entry((a.object.min(b.object), a.object.max(b.object))).or_default();
        contact.faces += 1;
        // Faces of bodies are seen from their front; what touches that front may cover it, but not what is behind.
        let in_front = |facet: &Facet, normal: DVec3| {
            self.eyes.is_empty() || self.eyes.iter().any(|eye| (*eye - facet.corners[0]).dot(normal) > 0.0)
        };
        let visible = match (self.bodies.is_closed(a.object), self.bodies.is_closed(b.object)) {
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
        let values = vec![value("faces", contact.faces as f64), value("visible_faces", contact.visible as f64)];
        let faces = contact.faces;
        if first == second {
            return Some(Finding {
                severity: if objects.is_glass(a) { Severity::Warning } else { Severity::Info },
                kind: Kind::CoincidentSurfaces,
                object: name,
                values,
                message: format!("{faces} pairs of triangles lie in each other; the one of the lower number is seen"),
                advice: "cut away what overlaps: glass is entered twice there",
            });
        }
        if objects.is_glass(a) || objects.is_glass(b) {
            // Glass that is seen first sends its rays on behind the surface that it touches.
            let leaks = objects.is_glass(a) && !objects.is_glass(b);
            return Some(Finding {
                severity: if leaks { Severity::Warning } else { Severity::Info },
                kind: Kind::TouchingGlass,
                object: name,
                values,
                message: format!(
                    "touches {other} exactly ({faces} pairs of faces); the first of the two is met, the other missed"
                ),
                advice: "let the two overlap a little, or leave a gap: light passes each surface then",
            });
        }
        (contact.visible > 0).then(|| Finding {
            severity: if a.material == b.material { Severity::Info } else { Severity::Warning },
            kind: Kind::CoincidentSurfaces,
            object: name,
            values,
            message: format!(
                "lies in {other} ({faces} pairs of faces); the first of the two is seen, either if one is turned"
            ),
            advice: "move one of them, or order them so that the one to be seen comes first",
        })
    }
}

/// Visits pairs of overlapping boxes, once each with the lower index first. Returns whether there were few enough to
/// visit all of them.
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

/// Whether the corners are the same in any order; such triangles of a mesh are counted elsewhere.
fn is_same_triangle(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    a.iter().all(|corner| b.contains(corner))
}

/// A point and the unit normal of a plane in world space.
fn plane_in_world(object: &Object<'_>) -> Option<(DVec3, DVec3)> {
    let Geometry::Shape(Shape::Plane(plane)) = object.geometry else { return None };
    let map = &object.world_from_local;
    Some((map.point(plane.point()), map.normal(plane.normal()).try_normalize()?))
}

fn is_same_shape(a: &Object<'_>, b: &Object<'_>, placement_errors: f64) -> bool {
    let (Geometry::Shape(shape_a), Geometry::Shape(shape_b)) = (a.geometry, b.geometry) else { return false };
    match (sphere_in_world(shape_a, a), sphere_in_world(shape_b, b)) {
        (Some(a), Some(b)) => {
            let allowed = tolerance(placement_errors, a.centre().abs().max_element() + a.radius());
            (a.centre() - b.centre()).length() <= allowed && (a.radius() - b.radius()).abs() <= allowed
        }
        _ => shape_a == shape_b && a.world_from_local == b.world_from_local,
    }
}

/// The sphere that a sphere is after a transform that keeps it round.
fn sphere_in_world(shape: &Shape, object: &Object<'_>) -> Option<Sphere> {
    match TransformedShape::new(shape.clone(), object.world_from_local).bake_transform_ignoring_uv() {
        Some(Shape::Sphere(sphere)) => Some(sphere),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
