//! # rt-check: scene lints
//!
//! ```text
//!   Scene ──┬─ measures: size, smallest detail, distance from the origin, precision of each camera
//!           └─ findings: error (cannot be rendered) · warning (looks wrong) · note,
//!              each with the object's name, the measured numbers, and advice
//! ```
//!
//! **Owns** the lints: [`Kind`] lists them all, with the severity and advice of each.
//! **Does not own** loading (rt-scene-io), tracing (rt-render), or the text and JSON of the command line (rt-cli).
//! It changes no image.
//!
//! Limits bound the running time; a check that reaches one reports it ([`Kind::LimitReached`]).
//!
//! | group | examples |
//! |---|---|
//! | triangles | degenerate, duplicate, very thin; disagreeing orientation and normals |
//! | topology | open glass, glass that touches something, coincident and coplanar surfaces |
//! | transforms | condition numbers, mirrored or flattened objects |
//! | cameras | precision of hit points in parts of a pixel, cameras inside objects |
//! | lights | no light at all, lights and emissive objects inside opaque solids |
//!
//! ```
//! use rt_check::{Severity, check};
//! use rt_scene_io::Scene;
//!
//! let report = check(&Scene::empty("nothing"));
//! assert_eq!(report.count(Severity::Error), 0);
//! assert!(report.to_string().ends_with("0 errors, 0 warnings, 0 notes\n"));
//! ```

#![forbid(unsafe_code)]

mod camera;
mod coincident;
mod coplanar;
mod emitters;
mod enclosed;
mod facets;
mod finding;
#[cfg(test)]
mod fixture;
mod flat_region;
mod materials;
mod measures;
mod memory;
mod normals;
mod number;
mod objects;
mod polygons;
mod report;
mod round_side;
mod singular_values;
mod solids;
mod tolerance;
mod topology;
mod transforms;
mod triangles;
mod unlit;
mod welded;

use rt_camera::CameraSettings;
use rt_render::{RenderSpace, SceneGeometry};
use rt_scene_io::Scene;
use rt_shading::{Material, Texture, TextureId};

use crate::{
    finding::Findings,
    objects::{Geometry, Objects},
    solids::Solids,
    topology::Topology,
    welded::Welded,
};

pub use camera::CameraMeasures;
pub use finding::{Finding, Kind, Measurement, Severity};
pub use measures::Measures;
pub use memory::CheckMemory;
pub use number::short_number;
pub use report::{More, Report};

/// Checks a scene. Never fails: a reason not to render it is a finding.
pub fn check(scene: &Scene) -> Report {
    let mut findings = Findings::default();
    for warning in &scene.warnings {
        findings.add(Finding::new(Kind::LoadWarning, &warning.place, &[], &warning.message));
    }
    let camera = scene.cameras.first().map(|camera| &camera.settings);
    let space = camera.map_or(RenderSpace::WORLD, |camera: &CameraSettings| RenderSpace::of(scene, camera));
    let geometry = SceneGeometry::build(scene, space)
        .map_err(|error| findings.add(Finding::new(Kind::CannotRender, &scene.name, &[], error.to_string())))
        .ok();
    let objects = Objects::of(scene);
    if objects.truncated {
        let n = objects.list.len();
        let message = format!("has too many nodes: only the first {n} objects were checked");
        findings.add(
            Finding::new(Kind::LimitReached, &scene.name, &[("objects", n as f64)], message)
                .with_advice("check groups with many instances on their own"),
        );
    }
    let mut measures = Measures::of(&objects);
    measures::check(&objects, &measures, &mut findings);
    transforms::check(&objects, &mut findings);
    polygons::check(&objects, &mut findings);
    let topologies = meshes(&objects, &mut findings);
    let solids = Solids::of(&objects, &topologies);
    solids::check(&objects, &solids, &topologies, &mut findings);
    coincident::check(&objects, &solids, &mut findings);
    measures.cameras = camera::check(&objects, space, geometry.as_ref(), &mut findings);
    enclosed::check(&objects, &solids, &mut findings);
    emitters::check(&objects, &solids, &mut findings);
    unlit::check(&objects, &mut findings);
    materials::check(&objects, &mut findings);
    Report::new(measures, findings)
}

/// Checks each mesh once, however many instances it has, and returns the topology of each.
fn meshes(objects: &Objects<'_>, findings: &mut Findings) -> Vec<Topology> {
    let scene = objects.scene;
    let (mut glass, mut textured) = (vec![false; scene.meshes.len()], vec![false; scene.meshes.len()]);
    for object in &objects.list {
        if let Geometry::Mesh(index, _) = object.geometry {
            glass[index] |= objects.is_glass(object);
            textured[index] |= objects.material(object).is_some_and(|material| uses_uv(scene, material));
        }
    }
    let mut topologies = Vec::with_capacity(scene.meshes.len());
    for (index, named) in objects.meshes().enumerate() {
        let welded = Welded::new(named.mesh.data());
        let topology = Topology::of(&named.mesh, &welded);
        triangles::check(&named, &welded, findings);
        topology::check(&named, &topology, glass[index], findings);
        normals::check(&named, textured[index], findings);
        topologies.push(topology);
    }
    topologies
}

/// True if a texture of the material is looked up by texture coordinates. Vertex colours are not.
fn uses_uv(scene: &Scene, material: &Material) -> bool {
    let is_uv_texture = |TextureId(id): TextureId| {
        !matches!(scene.appearance.textures.get(id as usize), Some(Texture::VertexColor(None)))
    };
    material.textures().into_iter().any(is_uv_texture)
}

#[cfg(test)]
mod tests;
