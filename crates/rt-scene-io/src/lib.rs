//! # rt-scene-io: files to resolved scenes
//!
//! ```text
//!   .ron .json ── parse ──► SceneFile ──┐
//!                                       ├─ resolve ─► Scene    plain data: ids instead of names, radians instead of
//!   .obj .gltf .nff ── load ──► Model ──┘                      degrees, pixels instead of paths, nothing unchecked
//!   .ply .stl .pbrt
//! ```
//!
//! **Owns** [`Scene`] and its tree of nodes, its bounds ([`Scene::bounds`]), the scene format ([`mod@format`]) and its JSON Schema,
//! the model loaders, texture decoding, the rules for files that refer to files, and the guesses that are made where
//! a file leaves something open: camera, lights, exposure.
//! **Does not own** shapes, materials, lights or cameras themselves, and does not know how a scene is rendered.
//!
//! Everything has a default but the geometry. Every mistake in a file is reported at once, each with its place, the
//! value, the rule, and the nearest right name. References must stay below a root folder.
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
//! Without default features only [`Scene`] and its parts are left, for scenes that are built in code.

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
mod memory;
#[cfg(feature = "format")]
mod model;
#[cfg(feature = "nff")]
mod nff;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "format")]
mod options;
#[cfg(feature = "pbrt")]
mod pbrt;
#[cfg(feature = "format")]
mod phong_fallback;
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
pub use convert::{Converted, convert};
#[cfg(feature = "format")]
pub use environment::read_environment;
#[cfg(feature = "format")]
pub use error::{Diagnostic, LoadError, LoadErrorKind, Location};
#[cfg(feature = "format")]
pub use excerpt::Excerpt;
#[cfg(feature = "format")]
pub use files::{read_file, read_text, read_texture, resolve_path};
#[cfg(feature = "format")]
pub use load::load;
#[cfg(feature = "format")]
pub use memory::MemoryBudget;
pub use memory::MemoryError;
#[cfg(feature = "format")]
pub use model::{Model, load_model};
#[cfg(feature = "format")]
pub use options::{AnimationEnd, InMemoryFile, InputHashes, LoadOptions, ReferencedFiles, StudioLights};
#[cfg(feature = "format")]
pub use resolve::resolve;
pub use rt_shading::emitter::LightSampling;
pub use scene::{
    Accel, Adaptive, Background, Content, Group, GroupId, Integrator, Material, MaterialId, MeshId, NamedCamera,
    NamedMesh, Node, Scene, Settings, Truth, Warning,
};
#[cfg(feature = "format")]
pub use texture::{TextureError, decode_numbers, decode_texture};
