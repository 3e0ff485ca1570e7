//! What a model file brings: pieces of a scene, numbered among themselves.

use std::path::Path;

use rt_shading::{Light, Material, Texture};

use crate::{LoadError, LoadOptions, NamedCamera, NamedMesh, Node, Reason, Warning};

/// The content of an OBJ or glTF file.
///
/// Ids are local: [`MaterialId`](crate::MaterialId) counts in `materials`, [`MeshId`](crate::MeshId) in `meshes`,
/// [`TextureId`](rt_shading::TextureId) in `textures`. Nodes hold meshes or nothing, never instances of groups.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Meshes that nodes refer to.
    pub meshes: Vec<NamedMesh>,
    /// Materials that nodes refer to: at least one if any node holds a mesh. Names need not be unique.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Lights in the model's world space. They are photometric (candela, lux), as in glTF.
    pub lights: Vec<Light>,
    /// Cameras in the model's world space; names are unique.
    pub cameras: Vec<NamedCamera>,
    /// The tree.
    pub nodes: Vec<Node>,
    /// What was mended or left out.
    pub warnings: Vec<Warning>,
}

/// Loads a model by the ending of its name.
///
/// `options.root` bounds what the model may refer to.
///
/// # Errors
/// If the file cannot be read, is no valid model, or needs a feature that is not supported or not built in.
#[cfg_attr(
    not(any(feature = "obj", feature = "gltf")),
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
        _ => Err(Reason::UnknownFormat { known: ".obj, .gltf, .glb" }.at(path, "")),
    }
}
