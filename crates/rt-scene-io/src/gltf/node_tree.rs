//! The tree of nodes, with cameras and lights in world space.

use std::{collections::HashSet, path::Path};

use gltf::{
    Document, Node as Source,
    json::{camera::Type as CameraType, extensions::scene::khr_lights_punctual as lights, validation::Checked},
};
use rt_camera::{CameraSettings, FovAxis, Projection};
use rt_math::{AnimatedTransform, DVec3, Rgb, Transform, TransformError, transcendental::cos};
use rt_shading::{DeltaLight, DeltaLightKind, Falloff, LightUnits};

use super::{
    buffers::Buffers,
    instancing,
    node_pose::{Poses, transform},
};
use crate::error::ErrorAt;
use crate::{Content, LoadError, LoadErrorKind, MaterialId, MeshId, Model, NamedCamera, SceneNode, limits};

/// Mesh of a primitive, with its material.
#[derive(Clone, Copy)]
pub(super) struct MeshPart {
    pub(super) mesh: MeshId,
    pub(super) material: MaterialId,
    /// Origin of a mesh with joints, in world space; `None` for a mesh in the space of its node.
    pub(super) skinned_at: Option<DVec3>,
}

/// Walks the tree of the scene to be shown. `parts_of` gives the meshes of a node. Returns the number of lights that would move
/// while the shutter is open.
pub(super) fn walk(
    buffers: &Buffers<'_>,
    poses: &Poses<'_>,
    model: &mut Model,
    mut parts_of: impl FnMut(&Source<'_>, &gltf::Mesh<'_>, &mut Model) -> Result<Vec<MeshPart>, LoadError>,
) -> Result<u32, LoadError> {
    let (document, path) = (buffers.document(), buffers.path());
    let nodes: Vec<Source<'_>> = document.nodes().collect();
    let (mut instances, mut held_lights) = (0, 0);
    for root in roots(document, path)? {
        let mut stack: Vec<OpenNode> = Vec::new();
        stack.extend(open(&nodes[root], poses, &WorldTransforms::IDENTITY, model));
        while let Some(mut frame) = stack.pop() {
            if let Some(child) = frame.children.pop() {
                let world = frame.world;
                stack.push(frame);
                stack.extend(open(&nodes[child], poses, &world, model));
                continue;
            }
            let source = &nodes[frame.index];
            if let Some(mesh) = source.mesh() {
                let parts = parts_of(source, &mesh, model)?;
                let (bound, parts) = parts.into_iter().partition(|part| part.skinned_at.is_some());
                place_skinned(source, bound, model);
                if let Some(reason) = &frame.unusable {
                    let is_all = source.children().len() == 0 && source.camera().is_none() && source.light().is_none();
                    if !(is_all && parts.is_empty()) {
                        warn(source, &format!("{reason}; all but its skinned meshes is left out"), model);
                    }
                    continue;
                }
                place(source, &mut frame.node, &parts, buffers, &mut instances, model)?;
            }
            place_camera(source, document, &frame.world, model);
            held_lights += u32::from(place_light(source, document, &frame.world, model));
            match stack.last_mut() {
                Some(parent) => parent.node.children.push(frame.node),
                None => model.nodes.push(frame.node),
            }
        }
    }
    Ok(held_lights)
}

/// A node whose children are being visited.
struct OpenNode {
    index: usize,
    node: SceneNode,
    world: WorldTransforms,
    /// Reason why the transform of a node with a skin is unusable: only its skinned meshes, which ignore the transform, are kept.
    unusable: Option<String>,
    /// Still to be visited, last first.
    children: Vec<usize>,
}

/// Takes the space of a node to the world, when the shutter opens and when it closes.
#[derive(Clone, Copy)]
struct WorldTransforms {
    opens: Transform,
    closes: Transform,
}

impl WorldTransforms {
    const IDENTITY: Self = Self { opens: Transform::IDENTITY, closes: Transform::IDENTITY };

    fn compose(&self, node: &SceneNode) -> Self {
        Self {
            opens: self.opens.compose(&node.parent_from_local),
            closes: self.closes.compose(&node.moves_to.unwrap_or(node.parent_from_local)),
        }
    }
}

/// Starts a node, unless its transform is unusable. One with a skin is started without its children then.
fn open(source: &Source<'_>, poses: &Poses<'_>, parent: &WorldTransforms, model: &mut Model) -> Option<OpenNode> {
    let parent_from_local = match transform(poses.opens.matrix(source.index())?) {
        Ok(transform) => transform,
        Err(error) => {
            let reason = match error {
                TransformError::DegenerateDirection => {
                    "its rotation has no direction, because the quaternion is zero".to_owned()
                }
                other => other.to_string(),
            };
            if source.skin().is_some() && source.mesh().is_some() {
                let node = empty(source);
                let unusable = Some(reason);
                return Some(OpenNode { index: source.index(), node, world: *parent, unusable, children: Vec::new() });
            }
            warn(source, &format!("{reason}; it and its children are left out"), model);
            return None;
        }
    };
    let mut children: Vec<usize> = source.children().map(|child| child.index()).collect();
    children.reverse();
    let moves_to = moves_to(source, poses, &parent_from_local, model);
    let node = SceneNode { parent_from_local, moves_to, ..empty(source) };
    Some(OpenNode { index: source.index(), world: parent.compose(&node), node, unusable: None, children })
}

/// Transform of a node when the shutter closes; `None` for a static node.
fn moves_to(source: &Source<'_>, poses: &Poses<'_>, start: &Transform, model: &mut Model) -> Option<Transform> {
    let end = transform(poses.closes?.matrix(source.index())?);
    if end.is_ok_and(|end| end == *start) {
        return None;
    }
    let end = end.ok().filter(|end| AnimatedTransform::new(start, end).is_ok());
    if end.is_none() {
        warn(source, "its transform at the end of the shutter is invalid; it does not move", model);
    }
    end
}

/// Root nodes: those of the chosen scene, or all without a parent. Each node must have at most one parent, and roots none, so
/// that the walk terminates.
fn roots(document: &Document, path: &Path) -> Result<Vec<usize>, LoadError> {
    let mut parents = vec![None; document.nodes().len()];
    for node in document.nodes() {
        for child in node.children() {
            if let Some(other) = parents[child.index()].replace(node.index()) {
                let message = format!("has two parents, {other} and {}; the nodes must form trees", node.index());
                return Err(LoadErrorKind::Syntax(message).at(path, format!("nodes[{}]", child.index())));
            }
        }
    }
    let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
        let free: Vec<usize> = (0..parents.len()).filter(|i| parents[*i].is_none()).collect();
        if free.is_empty() && !parents.is_empty() {
            return Err(
                LoadErrorKind::Syntax("every node has a parent: they form a cycle".to_owned()).at(path, "nodes")
            );
        }
        return Ok(free);
    };
    let mut seen = HashSet::new();
    let mut roots = Vec::new();
    for node in scene.nodes() {
        if let Some(parent) = parents[node.index()] {
            let message =
                format!("is a root of the scene, but also a child of the node {parent}; the nodes must form trees");
            return Err(LoadErrorKind::Syntax(message).at(path, format!("nodes[{}]", node.index())));
        }
        if seen.insert(node.index()) {
            roots.push(node.index());
        }
    }
    Ok(roots)
}

/// Puts meshes that follow bones into the world. The transform of their node does not apply to them (glTF 2.0, section 3.7.3).
fn place_skinned(source: &Source<'_>, parts: Vec<MeshPart>, model: &mut Model) {
    if !parts.is_empty() {
        let mut bound = empty(source);
        place_mesh(&mut bound, &parts);
        model.nodes.push(bound);
    }
}

/// Puts a mesh where its node is, or where the node's instances are.
fn place(
    source: &Source<'_>,
    node: &mut SceneNode,
    parts: &[MeshPart],
    buffers: &Buffers<'_>,
    instances: &mut u64,
    model: &mut Model,
) -> Result<(), LoadError> {
    if source.skin().is_some() && parts.is_empty() {
        return Ok(());
    }
    let Some((placements, unusable)) = instancing::placements(source, buffers)? else {
        place_mesh(node, parts);
        return Ok(());
    };
    *instances += placements.len() as u64;
    let checked = LoadErrorKind::check_limit("the number of instances", *instances, limits::GLTF_INSTANCES);
    checked.at(buffers.path(), format!("nodes[{}].extensions.{}", source.index(), instancing::NAME))?;
    if unusable > 0 {
        warn(source, &format!("{unusable} of its instances have an invalid transform; they are left out"), model);
    }
    for parent_from_local in placements {
        // Names of instances are dropped to save memory.
        let mut instance = SceneNode { name: String::new(), parent_from_local, ..empty(source) };
        place_mesh(&mut instance, parts);
        node.children.push(instance);
    }
    Ok(())
}

/// A node without content at its parent's place.
fn empty(source: &Source<'_>) -> SceneNode {
    SceneNode::empty(source.name().unwrap_or_default().to_owned(), Transform::IDENTITY)
}

/// One mesh becomes the content of the node, several become children of it.
fn place_mesh(node: &mut SceneNode, parts: &[MeshPart]) {
    if let [MeshPart { mesh, material, skinned_at }] = *parts {
        node.content = Some(Content::Mesh(mesh));
        node.material = material;
        if let Some(origin) = skinned_at {
            node.parent_from_local = Transform::translate(origin);
        }
        return;
    }
    node.children.extend(parts.iter().map(|part| SceneNode {
        name: node.name.clone(),
        parent_from_local: part.skinned_at.map_or(Transform::IDENTITY, Transform::translate),
        ..SceneNode::new(Content::Mesh(part.mesh), part.material)
    }));
}

fn place_camera(source: &Source<'_>, document: &Document, world: &WorldTransforms, model: &mut Model) {
    let Some(json) = source.camera().and_then(|camera| document.as_json().cameras.get(camera.index())) else { return };
    let projection = match (json.type_, &json.perspective, &json.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(camera), _) => {
            let fov = f64::from(camera.yfov);
            let usable = fov > 0.0 && fov < std::f64::consts::PI;
            usable.then_some(Projection::Perspective { fov, axis: FovAxis::Vertical })
        }
        (Checked::Valid(CameraType::Orthographic), _, Some(camera)) => {
            let height = 2.0 * f64::from(camera.ymag.abs());
            (height > 0.0 && height.is_finite()).then_some(Projection::Orthographic { height })
        }
        _ => None,
    };
    // Cameras have a position and a direction, but no scale.
    let view = |world: &Transform| {
        let eye = world.point(DVec3::ZERO);
        Transform::look_at(eye, eye + world.vector(DVec3::NEG_Z).normalize_or_zero(), world.vector(DVec3::Y))
    };
    let views = view(&world.opens).and_then(|opens| Ok((opens, view(&world.closes)?)));
    let (Some(projection), Ok((world_from_camera, closes))) = (projection, views) else {
        warn(source, "the field of view or transform of its camera is invalid; the camera is left out", model);
        return;
    };
    let wanted = [json.name.as_deref(), source.name()].into_iter().flatten().find(|name| !name.is_empty());
    let wanted = wanted.unwrap_or("camera");
    let taken = |name: &str| model.cameras.iter().any(|camera| camera.name == name);
    let name = if taken(wanted) { format!("{wanted} (node {})", source.index()) } else { wanted.to_owned() };
    if taken(&name) {
        warn(source, "its camera has the name of another camera; it is left out", model);
        return;
    }
    let moves_to = (world.closes != world.opens).then_some(closes);
    let settings = CameraSettings { moves_to, ..CameraSettings::new(world_from_camera, projection) };
    model.cameras.push(NamedCamera { name, settings, medium: None });
}

/// Puts a light where its node is when the shutter opens; true if it would move until the shutter closes.
fn place_light(source: &Source<'_>, document: &Document, world: &WorldTransforms, model: &mut Model) -> bool {
    let all = document.as_json().extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let Some(json) = source.light().and_then(|light| all?.lights.get(light.index())) else { return false };
    let intensity = Rgb::from(json.color.map(f64::from)) * f64::from(json.intensity);
    let [position, position_at_end] = [world.opens, world.closes].map(|world| world.point(DVec3::ZERO));
    let [direction, direction_at_end] =
        [world.opens, world.closes].map(|world| world.vector(DVec3::NEG_Z).try_normalize());
    let falloff = Falloff::InverseSquare;
    let kind = match (json.type_, &json.spot, direction) {
        (Checked::Valid(lights::Type::Point), ..) => {
            Some(DeltaLightKind::Point { position, falloff, shadow_near: 0.0 })
        }
        (Checked::Valid(lights::Type::Directional), _, Some(direction)) => {
            Some(DeltaLightKind::Directional { direction })
        }
        (Checked::Valid(lights::Type::Spot), Some(spot), Some(direction)) => {
            let (cos_inner, cos_outer) = cone(spot.inner_cone_angle, spot.outer_cone_angle);
            Some(DeltaLightKind::Spot { position, direction, cos_inner, cos_outer, falloff })
        }
        _ => None,
    };
    let dark = [intensity.r, intensity.g, intensity.b].into_iter().any(|c| !(c.is_finite() && c >= 0.0));
    let Some(kind) = kind.filter(|_| position.is_finite() && !dark) else {
        warn(source, "the direction or intensity of its light is invalid; the light is left out", model);
        return false;
    };
    let moves = match kind {
        DeltaLightKind::Point { .. } => position != position_at_end,
        DeltaLightKind::Directional { .. } => direction != direction_at_end,
        DeltaLightKind::Spot { .. } => (position, direction) != (position_at_end, direction_at_end),
    };
    let name = json.name.as_deref().or(source.name()).unwrap_or("light").to_owned();
    model.lights.push(DeltaLight { name, kind, intensity, units: LightUnits::Physical, casts_shadows: true });
    model.is_photometric = true;
    moves
}

/// Cosines of the angles of a spot. Where both angles are the same the edge is as sharp as can be.
fn cone(inner: f32, outer: f32) -> (f64, f64) {
    let cosine = |angle: f32| cos(f64::from(angle).clamp(0.0, std::f64::consts::FRAC_PI_2));
    let outer = cosine(outer).min(1.0_f64.next_down());
    (cosine(inner).max(outer.next_up()), outer)
}

fn warn(source: &Source<'_>, message: &str, model: &mut Model) {
    let place = match source.name() {
        Some(name) => format!("node `{name}`"),
        None => format!("nodes[{}]", source.index()),
    };
    model.warn(place, message);
}
