//! The numerical health of a scene: what may lose digits, and what is probably not meant.
//!
//! ```text
//!   Scene ──┬─ measures: how large, how fine, how far away, how sharply seen
//!           └─ findings: error (cannot be rendered) · warning (looks wrong) · info, each with
//!              the object's name, the measured value, and what to do
//! ```
//!
//! Nothing here decides what a picture looks like. Limits keep the time bounded; where one is reached, the report says
//! so ([`Kind::LimitReached`]).

mod bodies;
mod camera;
mod coincident;
mod coplanar;
mod enclosed;
mod facets;
#[cfg(test)]
mod fixture;
mod materials;
mod measures;
mod normals;
mod objects;
mod polygons;
mod report;
mod topology;
mod transforms;
mod triangles;
mod welded;

use rt_math::DVec3;
use rt_scene_io::Scene;
use rt_shading::{Material, Texture, TextureId};

use crate::{flatten::flatten, rebase, structure::Wanted};
use bodies::Bodies;
pub use camera::CameraMeasures;
pub use measures::Measures;
use objects::{Geometry, Objects};
use report::Findings;
pub use report::{Finding, Kind, Measurement, More, Report, Severity};
use topology::Topology;
use welded::Welded;

/// Checks a scene. Never fails: what prevents rendering is a finding.
///
/// ```
/// use rt_render::check::{Severity, check};
/// use rt_scene_io::Scene;
///
/// let report = check(&Scene::empty("nothing"));
/// assert_eq!(report.count(Severity::Error), 0);
/// assert!(report.to_string().ends_with("0 errors, 0 warnings, 0 notes\n"));
/// ```
pub fn check(scene: &Scene) -> Report {
    let mut findings = Findings::default();
    for warning in &scene.warnings {
        findings.add(mended(warning));
    }
    let origin = scene.cameras.first().map_or(DVec3::ZERO, |camera| rebase::origin(scene, &camera.settings));
    let world = flatten(scene, Wanted::default(), rebase::plan_from_world(origin), true, Some(0.0))
        .map_err(|error| findings.add(refused(scene, &error.to_string())))
        .ok();
    let objects = Objects::of(scene);
    if objects.truncated {
        findings.add(truncated(&objects));
    }
    let mut measures = Measures::of(&objects);
    measures::check(&objects, &measures, &mut findings);
    transforms::check(&objects, &mut findings);
    polygons::check(&objects, &mut findings);
    let topologies = meshes(&objects, &mut findings);
    let bodies = Bodies::of(&objects, &topologies);
    bodies::check(&objects, &bodies, &topologies, &mut findings);
    coincident::check(&objects, &bodies, &mut findings);
    measures.cameras = camera::check(&objects, world.as_ref(), origin, &mut findings);
    enclosed::check(&objects, &bodies, &mut findings);
    materials::check(&objects, &mut findings);
    findings.report(measures)
}

/// Checks each mesh once, however often it is placed; returns how the triangles of each hang together.
fn meshes(objects: &Objects<'_>, findings: &mut Findings) -> Vec<Topology> {
    let scene = objects.scene;
    let (mut glass, mut textured) = (vec![false; scene.meshes.len()], vec![false; scene.meshes.len()]);
    for object in &objects.list {
        if let Geometry::Mesh(index, _) = object.geometry {
            glass[index] |= objects.is_glass(object);
            textured[index] |= objects.material(object).is_some_and(|material| looks_at_uv(scene, material));
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

/// True if a texture of the material is laid along texture coordinates; colours of vertices are not.
fn looks_at_uv(scene: &Scene, material: &Material) -> bool {
    let is_laid = |TextureId(id): TextureId| {
        !matches!(scene.appearance.textures.get(id as usize), Some(Texture::VertexColor(None)))
    };
    material.textures().into_iter().any(is_laid)
}

fn mended(warning: &rt_scene_io::Warning) -> Finding {
    Finding {
        severity: Severity::Warning,
        kind: Kind::Mended,
        object: warning.place.clone(),
        values: vec![],
        message: warning.message.clone(),
        advice: "mend the file if the picture should show it",
    }
}

fn refused(scene: &Scene, message: &str) -> Finding {
    Finding {
        severity: Severity::Error,
        kind: Kind::CannotRender,
        object: scene.name.clone(),
        values: vec![],
        message: message.to_owned(),
        advice: "mend what is named; rendering refuses the scene for the same reason",
    }
}

fn truncated(objects: &Objects<'_>) -> Finding {
    Finding {
        severity: Severity::Info,
        kind: Kind::LimitReached,
        object: objects.scene.name.clone(),
        values: vec![report::value("objects", objects.list.len() as f64)],
        message: format!("has too many nodes: {} objects were looked at, the rest was not", objects.list.len()),
        advice: "check groups that are placed many times on their own",
    }
}

#[cfg(test)]
mod tests;
