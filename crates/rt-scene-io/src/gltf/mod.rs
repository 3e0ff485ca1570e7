//! glTF 2.0 and GLB, through the `gltf` crate.
//!
//! ```text
//! bytes ── Container ──> JSON ── checks ──> Document ── pose ── tree ──> nodes, cameras, lights
//!              └──────> buffers ── accessors ── primitives ── morph, skin ──> meshes
//!                           └── images ──> textures, materials
//! ```
//!
//! The crate provides types and defaults; all content of the file is checked before use (see `document` and `accessor`). Meshes
//! are built for one time: morphed, and skinned meshes in world space, or next to it if they are far from its origin.

mod accessor;
mod animation;
mod attribute_rules;
mod attributes;
mod buffers;
mod container;
mod document;
mod draco;
mod instancing;
mod material_json;
mod materials;
mod meshopt;
mod node_pose;
mod node_tree;
mod primitive;
mod skin;
mod textures;
mod used_vertices;
mod variants;

use std::{
    collections::HashMap,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::Arc,
};

use self::{
    buffers::Buffers,
    container::Container,
    materials::MaterialReader,
    node_pose::{Affine, Pose, Poses},
    node_tree::MeshPart,
    primitive::{Deformation, PrimitiveContent},
};
use crate::error::ErrorAt;
use crate::{
    LoadError, LoadErrorKind, LoadOptions, Model, Warning,
    build_mesh::build_mesh,
    files::refuse_utf16,
    limits,
    memory::Reservation,
    memory::{FileSample, load_within_budget},
};

/// Bytes of memory that an object of the document takes: as it is written, as it is understood, and as a node.
const OBJECT_BYTES: u64 = 1800;

/// Bytes of memory that a corner of a triangle takes while its mesh is built.
const CORNER_BYTES: u64 = 8;

/// Bytes of memory per attribute of a vertex.
const ATTRIBUTE_BYTES: u64 = 16;

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| {
        refuse_utf16(&bytes).at(path, "")?;
        // Last resort: the `gltf` crate may panic on documents that pass the checks.
        catch_unwind(AssertUnwindSafe(|| load_bytes(&bytes, path, options))).unwrap_or_else(|_| {
            let message = "the document is inconsistent; check it with the glTF validator";
            Err(LoadErrorKind::Syntax(message.to_owned()).at(path, ""))
        })
    })
}

/// Bytes of memory that the document takes while it is read, without buffers and meshes, which are counted later.
fn peak_bytes(sample: &FileSample) -> u64 {
    let objects = |text: &[u8]| text.iter().filter(|&&byte| byte == b'{').count() as u64;
    let (json, objects) = match Container::json_bytes(sample.head()) {
        None => (sample.size, sample.over_lines(|line| [objects(line)])[0]),
        Some(json) => {
            let (json, seen) = (json.min(sample.size), sample.head().len().max(1) as u64);
            (json, objects(sample.head()).saturating_mul((json / seen).max(1)))
        }
    };
    sample.size + 3 * json + OBJECT_BYTES * objects
}

fn load_bytes(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let mut model = Model::default();
    let container = Container::split(bytes).map_err(|message| LoadErrorKind::Syntax(message).at(path, ""))?;
    let parsed = document::parse(container.json, path, &mut model.warnings)?;
    let document = &parsed.document;
    let variant = options.variant.as_deref().map(|name| variants::find(name, document, path)).transpose()?;
    let buffers = Buffers::load(document, container.blob, path, options)?;
    let (pose, later) = animation::poses(document, &parsed.animations, &buffers, options, &mut model)?;
    let worlds = |pose: &Pose| if document.skins().len() > 0 { pose.worlds(document) } else { Vec::new() };
    let mut meshes = Meshes {
        buffers: &buffers,
        appearance: MaterialReader::new(document, &buffers, options),
        variant,
        pose: &pose,
        worlds: worlds(&pose),
        later: later.as_ref().map(|later| (later, worlds(later))),
        held: 0,
        skins: HashMap::new(),
        known: HashMap::new(),
        bytes: 0,
        reservations: Vec::new(),
        options,
    };
    let poses = Poses { opens: &pose, closes: later.as_ref() };
    let held_lights =
        node_tree::walk(&buffers, &poses, &mut model, |node, mesh, model| meshes.parts(node, mesh, model))?;
    if meshes.held > 0 {
        let held = meshes.held;
        let message = format!(
            "meshes with skins or morph targets have no motion blur: {held}; their pose at the start of the shutter is used"
        );
        model.warn("animations", message);
    }
    if held_lights > 0 {
        let message =
            format!("lights have no motion blur: {held_lights}; their place at the start of the shutter is used");
        model.warn("animations", message);
    }
    if model.meshes.is_empty() {
        let message = "there are no triangles in the scene".to_owned();
        model.warn("scene", message);
    }
    for warning in &mut model.warnings {
        warning.place = format!("{}: {}", path.display(), warning.place);
    }
    Ok(model)
}

/// The meshes of a document, made when first used.
struct Meshes<'a> {
    buffers: &'a Buffers<'a>,
    appearance: MaterialReader<'a>,
    /// The variant of the materials that is shown.
    variant: Option<usize>,
    pose: &'a Pose,
    /// From nodes to the world; empty if no mesh follows bones.
    worlds: Vec<Option<Affine>>,
    /// The pose when the shutter closes, if it is another, with its maps to the world.
    later: Option<(&'a Pose, Vec<Option<Affine>>)>,
    /// Meshes that would change while the shutter is open.
    held: u32,
    /// The joints of skins, by their index.
    skins: HashMap<usize, Arc<[Affine]>>,
    /// The primitives, each with its material, by the index of the mesh and that of the node, if it poses the mesh.
    known: HashMap<(usize, Option<usize>), Vec<MeshPart>>,
    bytes: u64,
    /// The memory of the meshes so far.
    reservations: Vec<Reservation>,
    options: &'a LoadOptions,
}

impl Meshes<'_> {
    fn parts(
        &mut self,
        node: &gltf::Node<'_>,
        mesh: &gltf::Mesh<'_>,
        model: &mut Model,
    ) -> Result<Vec<MeshPart>, LoadError> {
        let weights = self.pose.weights(node, mesh);
        let key = (mesh.index(), (node.skin().is_some() || weights.is_some()).then_some(node.index()));
        if let Some(parts) = self.known.get(&key) {
            return Ok(parts.clone());
        }
        let deformation = Deformation {
            weights: weights.or(mesh.weights()).unwrap_or_default(),
            joints: node.skin().map(|skin| self.joints(&skin)).transpose()?,
            mirrored: self.worlds.get(node.index()).copied().flatten().is_some_and(|w| w.linear.determinant() < 0.0),
        };
        let mut parts = Vec::new();
        for primitive in mesh.primitives() {
            let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            parts.extend(self.part(mesh, &primitive, &deformation, &place, model)?);
        }
        self.held += u32::from(self.changes(node, mesh, &parts));
        self.known.insert(key, parts.clone());
        Ok(parts)
    }

    /// True if bones or morph targets move a mesh while the shutter is open.
    fn changes(&self, node: &gltf::Node<'_>, mesh: &gltf::Mesh<'_>, parts: &[MeshPart]) -> bool {
        let Some((later, worlds)) = &self.later else { return false };
        let moved = |joint: gltf::Node<'_>| worlds.get(joint.index()) != self.worlds.get(joint.index());
        let is_skinned = parts.iter().any(|part| part.skinned_at.is_some());
        later.weights(node, mesh) != self.pose.weights(node, mesh)
            || node.skin().is_some_and(|skin| is_skinned && skin.joints().any(moved))
    }

    fn joints(&mut self, skin: &gltf::Skin<'_>) -> Result<Arc<[Affine]>, LoadError> {
        if let Some(known) = self.skins.get(&skin.index()) {
            return Ok(Arc::clone(known));
        }
        let joints: Arc<[Affine]> = skin::joints(skin, &self.worlds, self.buffers)?.into();
        self.skins.insert(skin.index(), Arc::clone(&joints));
        Ok(joints)
    }

    /// Reserves memory for reading a primitive: its accessors, twice, as arrays and as a mesh.
    fn reserve(
        &self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        place: &str,
    ) -> Result<Reservation, LoadError> {
        // Counts beyond the number of bytes are refused when they are read.
        let max_elements = self.buffers.bytes().max(limits::GLTF_ZEROS as u64);
        let vertices =
            primitive.get(&gltf::Semantic::Positions).map_or(0, |accessor| max_elements.min(accessor.count() as u64));
        // The crate's iterator panics at names that the specification lacks.
        let json = &self.buffers.document().as_json().meshes[mesh.index()].primitives[primitive.index()];
        let attributes = json.attributes.len() as u64;
        let corners = primitive.indices().map_or(vertices, |accessor| max_elements.min(accessor.count() as u64));
        let bytes =
            CORNER_BYTES.saturating_mul(corners).saturating_add(vertices.saturating_mul(ATTRIBUTE_BYTES * attributes));
        let what = format_args!("{place} of {}", self.buffers.path().display());
        self.options.memory.reserve(what, bytes).at(self.buffers.path(), place)
    }

    fn part(
        &mut self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        deformation: &Deformation<'_>,
        place: &str,
        model: &mut Model,
    ) -> Result<Option<MeshPart>, LoadError> {
        let path = self.buffers.path();
        let warning = |message: String| Warning { place: place.to_owned(), message };
        let material = variants::material(primitive, self.variant, self.buffers.document(), path, place)?;
        let has_colors = primitive.get(&gltf::Semantic::Colors(0)).is_some();
        let material = self.appearance.material(&material, has_colors, model)?;
        let reservation = self.reserve(mesh, primitive, place)?;
        let read = primitive::read(primitive, &material.required_attributes, deformation, self.buffers, place)?;
        let Some(PrimitiveContent { data, skinned_at, notes }) = read else {
            model.warnings.push(warning("points and lines are not supported; they are left out".to_owned()));
            return Ok(None);
        };
        model.warnings.extend(notes.into_iter().map(warning));
        let Some(built) = build_mesh(data, place, &mut model.warnings).at(path, place)? else { return Ok(None) };
        drop(reservation);
        let what = format!("{place} of {}", path.display());
        let reservation = self.options.memory.reserve(what, built.memory() as u64);
        self.reservations.push(reservation.at(path, place)?);
        self.bytes += built.memory() as u64;
        let (what, limit) = ("the memory of all meshes in bytes", limits::GLTF_MESH_BYTES);
        LoadErrorKind::check_limit(what, self.bytes, limit).at(path, place)?;
        let id = model.add_mesh(mesh.name().unwrap_or_default().to_owned(), built);
        Ok(Some(MeshPart { mesh: id, material: material.id, skinned_at }))
    }
}

#[cfg(test)]
mod tests;
