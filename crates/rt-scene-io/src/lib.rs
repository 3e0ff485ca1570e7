//! # rt-scene-io: files to resolved scenes

#![forbid(unsafe_code)]

mod scene;

pub use scene::{
    Accel, Content, Group, GroupId, Integrator, Material, MaterialId, MeshId, NamedCamera, NamedMesh, Node, Scene,
    Settings, Warning,
};
