//! What a model file brings: pieces of a scene, numbered among themselves.

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;

use rt_geometry::TriangleMesh;
use rt_shading::{Light, Material, Texture, TextureId};

use crate::error::ErrorAt;
use crate::{LoadError, LoadErrorKind, LoadOptions, MaterialId, MeshId, NamedCamera, NamedMesh, Node, Warning, format};

/// The content of a file that another program wrote.
///
/// Ids are local: [`MaterialId`](crate::MaterialId) counts in `materials`, [`MeshId`](crate::MeshId) in `meshes`,
/// [`TextureId`](rt_shading::TextureId) in `textures`. Nodes hold meshes, shapes or nothing, never instances of groups.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Meshes that nodes refer to.
    pub meshes: Vec<NamedMesh>,
    /// Materials that nodes refer to: at least one if any node holds a mesh or shape. Names need not be unique.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Lights in the model's world space.
    pub lights: Vec<Light>,
    /// Whether their intensities are in candela and lux, without an exposure: a bare model is exposed to suit them.
    pub is_photometric: bool,
    /// What rays see that hit nothing, if the file says.
    pub background: Option<format::Background>,
    /// Width and height of the image in pixels, if the file says.
    pub image_size: Option<[u32; 2]>,
    /// Cameras in the model's world space; names are unique.
    pub cameras: Vec<NamedCamera>,
    /// The tree.
    pub nodes: Vec<Node>,
    /// What was mended or left out.
    pub warnings: Vec<Warning>,
    /// What was chosen because the file leaves it open. One sentence each.
    pub notes: Vec<String>,
}

impl Model {
    /// Adds a texture.
    #[cfg(any(feature = "gltf", feature = "obj"))]
    pub(crate) fn add_texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    /// Adds a material.
    pub(crate) fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Adds a mesh.
    pub(crate) fn add_mesh(&mut self, name: String, mesh: TriangleMesh) -> MeshId {
        self.meshes.push(NamedMesh { name, mesh: Arc::new(mesh) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Adds a warning about a line, an object or a path in the document.
    pub(crate) fn warn(&mut self, place: impl Display, message: impl Into<String>) {
        self.warnings.push(Warning { place: place.to_string(), message: message.into() });
    }

    /// Adds a grey mesh with the name of its file.
    #[cfg(any(feature = "ply", feature = "stl"))]
    pub(crate) fn set_mesh(&mut self, data: rt_geometry::MeshData, path: &Path) -> Result<(), LoadError> {
        let place = path.display().to_string();
        let mesh = crate::build_mesh::build_mesh(data, &place, &mut self.warnings);
        let Some(mesh) = mesh.at(path, "")? else {
            let message = "no triangle is left: the file has no usable faces";
            return Err(LoadErrorKind::Syntax(message.to_owned()).at(path, ""));
        };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let material = self.add_material(Material::new("default".to_owned(), rt_shading::Phong::default()));
        let content = crate::Content::Mesh(self.add_mesh(name.clone(), mesh));
        self.nodes.push(Node { name, ..Node::new(content, material) });
        Ok(())
    }
}

/// The endings of the names of models that can be read, for messages.
pub(crate) const KNOWN_EXTENSIONS: &str = ".obj, .gltf, .glb, .nff, .pbrt, .ply, .stl";

/// Loads a model by the ending of its name.
///
/// `options.root` bounds what the model may refer to.
///
/// # Errors
/// If the file cannot be read, is no valid model, or needs a feature that is not supported or not built in.
#[cfg_attr(
    not(any(feature = "obj", feature = "gltf", feature = "nff", feature = "pbrt", feature = "ply", feature = "stl")),
    expect(unused_variables, reason = "without a loader there are no references to follow")
)]
pub fn load_model(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let options = options.rooted_at(path);
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        #[cfg(feature = "obj")]
        "obj" => crate::obj::load(path, &options),
        #[cfg(feature = "gltf")]
        "gltf" | "glb" => crate::gltf::load(path, &options),
        #[cfg(feature = "nff")]
        "nff" => crate::nff::load(path, &options),
        #[cfg(feature = "pbrt")]
        "pbrt" => crate::pbrt::load(path, &options),
        #[cfg(feature = "ply")]
        "ply" => crate::ply::load(path, &options),
        #[cfg(feature = "stl")]
        "stl" => crate::stl::load(path, &options),
        _ => Err(LoadErrorKind::UnknownFormat { known: KNOWN_EXTENSIONS }.at(path, "")),
    }
}
