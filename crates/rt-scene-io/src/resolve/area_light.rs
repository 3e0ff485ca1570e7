//! Area lights: emissive shapes, added to the objects.

use std::sync::Arc;

use rt_geometry::{CappedQuadric, Disk, InsideRule, Polygon, Shape, Sphere};
use rt_math::{DMat3, DVec3, Frame, Rgb, Transform};
use rt_shading::light::EmissionSides;
use rt_shading::{ColorTexture, MaterialModel};

use super::material::Materials;
use super::value::{colour, direction, positive, vector};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{Content, LoadErrorKind, Material, SceneNode};

/// Nodes of all area lights; each has a material of its own.
pub(super) fn nodes(
    report: &mut Diagnostics,
    lights: &[format::Light],
    materials: &mut Materials<'_>,
) -> Vec<SceneNode> {
    let mut nodes = Vec::new();
    for (i, light) in lights.iter().enumerate() {
        let path = format!("lights[{i}]");
        let Some((name, radiance, sides)) = surface(light) else { continue };
        let radiance = report.check(format_args!("{path}.radiance"), colour(radiance));
        let (Some(radiance), Some((shape, place))) = (radiance, placed(report, &path, light)) else { continue };
        let name = if name.is_empty() { format!("light {i}") } else { name.to_owned() };
        let node = SceneNode::new(Content::Shape(shape), materials.add(light_material(&name, radiance, sides)));
        nodes.push(SceneNode { name, parent_from_local: place, ..node });
    }
    nodes
}

/// True for an area light.
pub(super) fn is_area_light(light: &format::Light) -> bool {
    surface(light).is_some()
}

/// Name, radiance and emission sides of an area light; `None` for other lights.
fn surface(light: &format::Light) -> Option<(&str, &format::Color, EmissionSides)> {
    match light {
        format::Light::Quad { name, radiance, emission_sides, .. }
        | format::Light::Disk { name, radiance, emission_sides, .. } => {
            Some((name, radiance, (*emission_sides).into()))
        }
        format::Light::Sphere { name, radiance, .. } | format::Light::Cylinder { name, radiance, .. } => {
            Some((name, radiance, EmissionSides::Front))
        }
        _ => None,
    }
}

fn light_material(name: &str, radiance: Rgb, emission_sides: EmissionSides) -> Material {
    let emission = ColorTexture::Constant(radiance);
    Material { emission, emission_sides, ..Material::new(name.to_owned(), MaterialModel::Black) }
}

/// Shape and transform of a light. Errors are reported.
fn placed(report: &mut Diagnostics, path: &str, light: &format::Light) -> Option<(Shape, Transform)> {
    match light {
        format::Light::Quad { corner, edges, .. } => {
            let corner = report.check(format_args!("{path}.corner"), vector(*corner));
            let along = report.check(format_args!("{path}.edges"), vector(edges.0));
            let across = report.check(format_args!("{path}.edges"), vector(edges.1));
            let (corner, along, across) = (corner?, along?, across?);
            let outline = vec![corner, corner + along, corner + along + across, corner + across];
            let polygon = report.check(path, Polygon::new(outline, Vec::new(), InsideRule::Convex))?;
            Some((Shape::Polygon(Arc::new(polygon)), Transform::IDENTITY))
        }
        format::Light::Disk { center, normal, radius, .. } => {
            let normal = report.check(format_args!("{path}.normal"), direction(*normal));
            let center = report.check(format_args!("{path}.center"), vector(*center));
            let disk = positive(*radius).and_then(|radius| Ok(Disk::new(radius, 0.0)?));
            let disk = report.check(format_args!("{path}.radius"), disk)?;
            Some((Shape::Disk(disk), upright(report, path, center?, normal?)?))
        }
        format::Light::Sphere { center, radius, .. } => {
            let center = report.check(format_args!("{path}.center"), vector(*center))?;
            let sphere = positive(*radius).and_then(|radius| Ok(Sphere::new(center, radius)?));
            let sphere = report.check(format_args!("{path}.radius"), sphere)?;
            Some((Shape::Sphere(sphere), Transform::IDENTITY))
        }
        format::Light::Cylinder { base, top, radius, caps, .. } => {
            let base = report.check(format_args!("{path}.base"), vector(*base));
            let top = report.check(format_args!("{path}.top"), vector(*top));
            let (base, top) = (base?, top?);
            let axis = direction((top - base).to_array());
            let [x, y, z] = top.to_array();
            let same = || LoadErrorKind::invalid(format_args!("({x}, {y}, {z})"), "is base and top: move one of them");
            let axis = axis.map_err(|error| if base == top { same() } else { error });
            let axis = report.check(format_args!("{path}.top"), axis)?;
            let cylinder = positive(*radius)
                .and_then(|radius| Ok(CappedQuadric::cylinder(radius, 0.0, (top - base).length(), *caps)?));
            let cylinder = report.check(format_args!("{path}.radius"), cylinder)?;
            Some((Shape::Cylinder(cylinder), upright(report, path, base, axis)?))
        }
        _ => None,
    }
}

/// Takes +y to a unit vector, and the origin to a point.
fn upright(report: &mut Diagnostics, path: &str, origin: DVec3, up: DVec3) -> Option<Transform> {
    let frame = Frame::from_z(up);
    let turn = DMat3::from_cols(frame.y, frame.z, frame.x);
    report.check(path, Transform::from_linear(turn, origin))
}
