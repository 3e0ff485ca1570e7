//! glTF 2.0 and GLB, through the `gltf` crate.
//!
//! ```text
//! bytes ── Container ──> JSON ── checks ──> Document ── pose ── tree ──> nodes, cameras, lights
//!              └──────> buffers ── accessors ── primitives ── morph, skin ──> meshes
//!                           └── images ──> textures, materials
//! ```
//!
//! The crate gives types and defaults; whatever comes from the file is checked before it is used (see `document` and
//! `accessor`). Meshes are made as they are at one moment: morphed, and in the world if they follow bones.

mod accessor;
mod animation;
mod appearance;
mod attribute_rules;
mod attributes;
mod buffers;
mod container;
mod description;
mod document;
mod draco;
mod instancing;
mod material;
mod meshopt;
mod pose;
mod primitive;
mod skin;
mod tangents;
mod textures;
mod tree;
mod variants;

use std::{
    collections::HashMap,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::Arc,
};

use self::{
    appearance::Appearance,
    buffers::Buffers,
    container::Container,
    pose::{Affine, Pose},
    primitive::{Content, Deformation},
};
use crate::{
    LoadError, LoadOptions, MaterialId, MeshId, Model, NamedMesh, Reason, Warning, files::read_file,
    mesh_build::build_mesh,
};

/// Most memory that all meshes of a model may take.
const MAX_MESH_BYTES: u64 = 1 << 32;

/// A mesh of one material.
type Part = (MeshId, MaterialId);

/// Loads the model at `path`.
pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let bytes = read_file(path).map_err(|reason| reason.at(path, ""))?;
    // The last net, below the checks: the `gltf` crate may panic on documents that nobody thought of.
    catch_unwind(AssertUnwindSafe(|| load_bytes(&bytes, path, options))).unwrap_or_else(|_| {
        Err(Reason::Syntax("the document contradicts itself in a way that is not understood".to_owned()).at(path, ""))
    })
}

fn load_bytes(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let mut model = Model::default();
    let container = Container::split(bytes).map_err(|message| Reason::Syntax(message).at(path, ""))?;
    let parsed = document::parse(container.json, path, &mut model.warnings)?;
    let document = &parsed.document;
    let variant = options.variant.as_deref().map(|name| variants::find(name, document, path)).transpose()?;
    let buffers = Buffers::load(document, container.blob, path, options)?;
    let mut pose = Pose::rest(document);
    animation::animate(&mut pose, &parsed.animations, &buffers, options, &mut model.warnings)?;
    let mut meshes = Meshes {
        buffers: &buffers,
        appearance: Appearance::new(document, &buffers, options),
        variant,
        pose: &pose,
        worlds: if document.skins().len() > 0 { pose.worlds(document) } else { Vec::new() },
        skins: HashMap::new(),
        known: HashMap::new(),
        bytes: 0,
    };
    tree::walk(&buffers, &pose, &mut model, |node, mesh, model| meshes.parts(node, mesh, model))?;
    if model.meshes.is_empty() {
        let message = "there are no triangles in the scene".to_owned();
        model.warnings.push(Warning { place: "scene".to_owned(), message });
    }
    for warning in &mut model.warnings {
        warning.place = format!("{}: {}", path.display(), warning.place);
    }
    Ok(model)
}

/// The meshes of a document, made when first used.
struct Meshes<'a> {
    buffers: &'a Buffers<'a>,
    appearance: Appearance<'a>,
    /// The variant of the materials that is shown.
    variant: Option<usize>,
    pose: &'a Pose,
    /// From nodes to the world; empty if no mesh follows bones.
    worlds: Vec<Option<Affine>>,
    /// The joints of skins, by their index.
    skins: HashMap<usize, Arc<[Affine]>>,
    /// The primitives, each with its material, by the index of the mesh and that of the node, if it poses the mesh.
    known: HashMap<(usize, Option<usize>), Vec<Part>>,
    bytes: u64,
}

impl Meshes<'_> {
    fn parts(
        &mut self,
        node: &gltf::Node<'_>,
        mesh: &gltf::Mesh<'_>,
        model: &mut Model,
    ) -> Result<Vec<Part>, LoadError> {
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
        self.known.insert(key, parts.clone());
        Ok(parts)
    }

    fn joints(&mut self, skin: &gltf::Skin<'_>) -> Result<Arc<[Affine]>, LoadError> {
        if let Some(known) = self.skins.get(&skin.index()) {
            return Ok(Arc::clone(known));
        }
        let joints: Arc<[Affine]> = skin::joints(skin, &self.worlds, self.buffers)?.into();
        self.skins.insert(skin.index(), Arc::clone(&joints));
        Ok(joints)
    }

    fn part(
        &mut self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        deformation: &Deformation<'_>,
        place: &str,
        model: &mut Model,
    ) -> Result<Option<Part>, LoadError> {
        let path = self.buffers.path();
        let warning = |message: String| Warning { place: place.to_owned(), message };
        let material = variants::material(primitive, self.variant, self.buffers.document(), path, place)?;
        let has_colors = primitive.get(&gltf::Semantic::Colors(0)).is_some();
        let along = uv_set_of_normals(&material);
        let material = self.appearance.material(&material, has_colors, model)?;
        let along = material.wants.uv_sets.iter().position(|set| *set == along && set.is_some()).unwrap_or(0);
        let data = match primitive::read(primitive, &material.wants, along, deformation, self.buffers, place)? {
            Content::Triangles(data, notes) => {
                model.warnings.extend(notes.into_iter().map(warning));
                data
            }
            Content::NoSurface => {
                model.warnings.push(warning("points and lines have no surface; they are left out".to_owned()));
                return Ok(None);
            }
        };
        let built = build_mesh(data, place, &mut model.warnings).map_err(|e| Reason::from(e).at(path, place))?;
        let Some(built) = built else { return Ok(None) };
        self.bytes += built.memory() as u64;
        if self.bytes > MAX_MESH_BYTES {
            let (value, limit) = (self.bytes, MAX_MESH_BYTES);
            return Err(Reason::TooLarge { what: "the memory of all meshes in bytes", value, limit }.at(path, place));
        }
        let id = MeshId(model.meshes.len() as u32);
        model.meshes.push(NamedMesh { name: mesh.name().unwrap_or_default().to_owned(), mesh: Arc::new(built) });
        Ok(Some((id, material.id)))
    }
}

/// The texture coordinates that a normal map is laid along.
fn uv_set_of_normals(material: &gltf::Material<'_>) -> Option<u32> {
    let texture = material.normal_texture()?;
    let moved = texture.extension_value("KHR_texture_transform").and_then(|object| object.get("texCoord")?.as_u64());
    Some(moved.and_then(|set| u32::try_from(set).ok()).unwrap_or_else(|| texture.tex_coord()))
}

#[cfg(test)]
mod tests;
