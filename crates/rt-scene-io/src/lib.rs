//! # rt-scene-io: files to resolved scenes

#![forbid(unsafe_code)]

#[cfg(feature = "format")]
mod bare;
mod bounds;
#[cfg(feature = "format")]
mod error;
#[cfg(feature = "format")]
mod files;
#[cfg(any(feature = "obj", feature = "gltf"))]
mod mesh_build;
#[cfg(feature = "format")]
pub mod format;
#[cfg(feature = "format")]
mod load;
#[cfg(feature = "format")]
mod model;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "format")]
mod options;
#[cfg(feature = "format")]
mod resolve;
mod scene;
#[cfg(feature = "format")]
mod texture;

#[cfg(feature = "format")]
pub use error::{LoadError, Place, Problem, Reason};
#[cfg(feature = "format")]
pub use files::{read_file, read_text, read_texture, resolve_path};
#[cfg(feature = "format")]
pub use load::load;
#[cfg(feature = "format")]
pub use model::{Model, load_model};
#[cfg(feature = "format")]
pub use options::LoadOptions;
#[cfg(feature = "format")]
pub use resolve::resolve;
pub use scene::{
    Accel, Content, Group, GroupId, Integrator, Material, MaterialId, MeshId, NamedCamera, NamedMesh, Node, Scene,
    Settings, Truth, Warning,
};
#[cfg(feature = "format")]
pub use texture::{TextureError, decode_texture};
