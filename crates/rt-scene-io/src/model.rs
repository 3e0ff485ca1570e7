//! Content of a model file.

use std::path::Path;

use rt_shading::{DeltaLight, Material, Texture};

use crate::{LoadError, LoadErrorKind, LoadOptions, NamedCamera, NamedMesh, Node, Warning, format};

/// Content of a file that another program wrote.
///
/// Ids are local: [`MaterialId`](crate::MaterialId) indexes `materials`, [`MeshId`](crate::MeshId) `meshes`,
/// [`TextureId`](rt_shading::TextureId) `textures`. Nodes hold meshes or shapes, never instances of groups.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Meshes that nodes refer to.
    pub meshes: Vec<NamedMesh>,
    /// Materials that nodes refer to: at least one if any node holds a mesh or shape. Names need not be unique.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Lights in the model's world space.
    pub lights: Vec<DeltaLight>,
    /// True if intensities are in candela and lux, without an exposure. A bare model is exposed to suit them.
    pub is_photometric: bool,
    /// Radiance of rays that leave the scene, if specified.
    pub background: Option<format::Background>,
    /// Width and height of the image in pixels, if specified.
    pub image_size: Option<[u32; 2]>,
    /// Cameras in the model's world space; names are unique.
    pub cameras: Vec<NamedCamera>,
    /// The tree.
    pub nodes: Vec<Node>,
    /// Repairs and omissions.
    pub warnings: Vec<Warning>,
    /// Choices that the file leaves open. One sentence each.
    pub notes: Vec<String>,
}

/// Extensions of supported models, for messages.
pub(crate) const KNOWN_EXTENSIONS: &str = ".obj, .gltf, .glb, .nff, .pbrt, .ply, .stl";

/// Loads a model by its file extension.
///
/// `options.root` bounds the files that the model may refer to.
///
/// # Errors
/// An unreadable file, an invalid model, or a feature that is unsupported or not compiled in.
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
