//! What a model file brings: pieces of a scene, numbered among themselves.

use std::path::Path;

use rt_shading::{Light, Material, Texture};

use crate::{LoadError, LoadOptions, NamedCamera, NamedMesh, Node, Reason, Warning, format};

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

#[cfg(any(feature = "ply", feature = "stl"))]
impl Model {
    /// Adds a mesh in plain grey, named like the file that it makes up.
    pub(crate) fn set_mesh(&mut self, data: rt_geometry::MeshData, path: &Path) -> Result<(), LoadError> {
        let place = path.display().to_string();
        let mesh = crate::mesh_build::build_mesh(data, &place, &mut self.warnings);
        let Some(mesh) = mesh.map_err(|error| Reason::from(error).at(path, ""))? else {
            return Err(Reason::Syntax("no triangle is left: the file has no usable faces".to_owned()).at(path, ""));
        };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let material = crate::MaterialId(self.materials.len() as u32);
        self.materials.push(Material::new("default".to_owned(), rt_shading::Phong::default()));
        let content = crate::Content::Mesh(crate::MeshId(self.meshes.len() as u32));
        self.nodes.push(Node { name: name.clone(), ..Node::new(content, material) });
        self.meshes.push(NamedMesh { name, mesh: std::sync::Arc::new(mesh) });
        Ok(())
    }
}

/// The endings of the names of models that can be read, for messages.
pub(crate) const KNOWN_ENDINGS: &str = ".obj, .gltf, .glb, .nff, .pbrt, .ply, .stl";

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
        _ => Err(Reason::UnknownFormat { known: KNOWN_ENDINGS }.at(path, "")),
    }
}
