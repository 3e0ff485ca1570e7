//! # rt-scene-io: files to resolved scenes
//!
//! ```text
//!   .ron .json ── parse ──► SceneFile ──┐
//!                                       ├─ resolve ─► Scene    plain data: ids instead of names, radians instead of
//!   .obj .gltf .nff ── load ──► Model ──┘                      degrees, pixels instead of paths, all of it checked
//!   .ply .stl .pbrt
//! ```
//!
//! **Owns** [`Scene`] with its node tree and bounds ([`Scene::bounds`]), the scene format ([`mod@format`]) and its JSON Schema,
//! model loaders and texture decoding. Also owns the rules for references between files, and the defaults for camera, lights
//! and exposure.
//! **Does not own** shapes, materials, lights, cameras or rendering.
//!
//! Every field has a default but the geometry. All errors of a file are reported at once, each with its location, the value,
//! the rule, and the nearest valid name. References must stay below a root folder.
//!
//! ```
//! use rt_scene_io::{LoadOptions, format::parse_ron, resolve};
//! use std::path::Path;
//!
//! let text = r##"(
//!     camera: (look_from: (0, 1, 5), look_at: (0, 0.5, 0), fov: 40),
//!     lights: [point(position: (-3, 5, 4), intensity: 0.9), ambient(1)],
//!     materials: {
//!         "floor": phong(color: checker(even: 1, odd: "#c03020")),
//!         "steel": phong(diffuse: 0.2, specular: 0.5, exponent: 80, mirror: 0.6),
//!     },
//!     nodes: [
//!         (shape: plane(), material: "floor"),
//!         (shape: sphere(radius: 0.5), transform: [translate(0, 0.5, 0)], material: "steel"),
//!     ],
//! )"##;
//! let path = Path::new("scenes/steel.ron");
//! let file = parse_ron(text, path)?;
//! let scene = resolve(&file, path, &LoadOptions::default())?;
//! assert!(scene.bounds().encloses(&rt_math::Aabb::new([-0.5, 0.0, -0.5].into(), [0.5, 1.0, 0.5].into())));
//!
//! let error = parse_ron("(nodes: [(shape: sphere(raduis: 1))])", path).unwrap_err();
//! assert!(error.to_string().starts_with("scenes/steel.ron:1:25: unknown field `raduis` in sphere; did you mean `radius`?"));
//! # Ok::<(), rt_scene_io::LoadError>(())
//! ```
//!
//! Without default features, only [`Scene`] and its parts remain, for scenes built in code.

#![forbid(unsafe_code)]

mod bounds;
#[cfg(feature = "format")]
mod build_mesh;
#[cfg(feature = "format")]
mod convert;
#[cfg(feature = "format")]
mod default_scene;
#[cfg(feature = "format")]
mod diagnostics;
#[cfg(feature = "format")]
mod environment;
#[cfg(feature = "format")]
mod error;
#[cfg(feature = "format")]
mod excerpt;
#[cfg(feature = "format")]
mod files;
#[cfg(feature = "format")]
pub mod format;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "format")]
pub mod limits;
#[cfg(feature = "format")]
mod load;
#[cfg(feature = "format")]
mod load_model;
mod memory;
#[cfg(feature = "format")]
mod model;
#[cfg(any(feature = "gltf", feature = "nff", feature = "obj", feature = "pbrt", feature = "ply", feature = "stl"))]
mod model_builder;
#[cfg(feature = "nff")]
mod nff;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "format")]
mod options;
#[cfg(any(feature = "gltf", feature = "ply"))]
mod parser_message;
#[cfg(feature = "pbrt")]
mod pbrt;
#[cfg(feature = "ply")]
mod ply;
#[cfg(feature = "format")]
mod resolve;
mod sanitize;
mod scene;
#[cfg(feature = "stl")]
mod stl;
#[cfg(any(feature = "gltf", feature = "obj", feature = "pbrt"))]
mod tangents;
#[cfg(any(feature = "nff", feature = "obj", feature = "pbrt"))]
mod text;
#[cfg(feature = "format")]
mod texture;
#[cfg(feature = "format")]
mod texture_error;
#[cfg(feature = "ply")]
mod unshare;

#[cfg(feature = "format")]
pub use convert::{Converted, convert};
#[cfg(feature = "format")]
pub use environment::read_environment;
#[cfg(feature = "format")]
pub use error::{Diagnostic, LoadError, LoadErrorKind, Location, unreadable};
#[cfg(feature = "format")]
pub use excerpt::Excerpt;
#[cfg(feature = "format")]
pub use files::{read_file, read_text, read_texture, resolve_path};
#[cfg(feature = "format")]
pub use load::load;
#[cfg(feature = "format")]
pub use load_model::load_model;
#[cfg(feature = "format")]
pub use memory::MemoryBudget;
pub use memory::MemoryError;
#[cfg(feature = "format")]
pub use model::Model;
#[cfg(feature = "format")]
pub use options::{AnimationEnd, Hasher, InMemoryFile, InputHashes, LoadOptions, ReferencedFiles, StudioLights};
#[cfg(feature = "format")]
pub use resolve::resolve;
pub use rt_shading::light::LightSampling;
pub use scene::{
    Accel, AdaptiveSampling, Background, Content, Group, GroupId, Integrator, KnownMean, Material, MaterialId, MeshId,
    NamedCamera, NamedMesh, RenderSettings, Scene, SceneNode, Warning,
};
#[cfg(feature = "format")]
pub use texture::{decode_numbers, decode_texture};
#[cfg(feature = "format")]
pub use texture_error::TextureError;
