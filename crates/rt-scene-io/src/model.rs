//! Content of a model file.

use rt_shading::{DeltaLight, Material, Texture};

use crate::{NamedCamera, NamedMesh, SceneNode, Warning, format};

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
    pub nodes: Vec<SceneNode>,
    /// Repairs and omissions.
    pub warnings: Vec<Warning>,
    /// Choices that the file leaves open. One sentence each.
    pub notes: Vec<String>,
}
