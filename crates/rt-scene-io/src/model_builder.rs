//! Appending parts to a [`Model`].

use std::fmt::Display;
use std::sync::Arc;

use rt_geometry::TriangleMesh;
use rt_shading::Material;

use crate::{MaterialId, MeshId, Model, NamedMesh, Warning};

impl Model {
    #[cfg(any(feature = "gltf", feature = "obj"))]
    pub(crate) fn add_texture(&mut self, texture: rt_shading::Texture) -> rt_shading::TextureId {
        self.textures.push(texture);
        rt_shading::TextureId(self.textures.len() as u32 - 1)
    }

    pub(crate) fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    pub(crate) fn add_mesh(&mut self, name: String, mesh: TriangleMesh) -> MeshId {
        self.meshes.push(NamedMesh { name, mesh: Arc::new(mesh) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Adds a warning about a line, an object or a path in the document.
    pub(crate) fn warn(&mut self, place: impl Display, message: impl Into<String>) {
        self.warnings.push(Warning { place: place.to_string(), message: message.into() });
    }

    /// Error of a model without content. It includes the first warning, which may state the cause.
    #[cfg(any(feature = "obj", feature = "pbrt", feature = "ply", feature = "stl"))]
    pub(crate) fn empty(&self, message: &str, path: &std::path::Path) -> crate::LoadError {
        let cause = self.warnings.first().map_or_else(String::new, |warning| format!(" (warning: {warning})"));
        crate::LoadErrorKind::Syntax(format!("{message}{cause}")).at(path, "")
    }

    /// Adds a grey mesh with the name of its file.
    #[cfg(any(feature = "ply", feature = "stl"))]
    pub(crate) fn set_mesh(
        &mut self,
        data: rt_geometry::MeshData,
        path: &std::path::Path,
    ) -> Result<(), crate::LoadError> {
        use crate::error::ErrorAt;
        let place = path.display().to_string();
        let mesh = crate::build_mesh::build_mesh(data, &place, &mut self.warnings);
        let Some(mesh) = mesh.at(path, "")? else {
            // The last warning says the same.
            self.warnings.pop();
            return Err(self.empty("has no usable triangles", path));
        };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let material = self.add_material(Material::new("default".to_owned(), rt_shading::Phong::default()));
        let content = crate::Content::Mesh(self.add_mesh(name.clone(), mesh));
        self.nodes.push(crate::SceneNode { name, ..crate::SceneNode::new(content, material) });
        Ok(())
    }
}

/// Access for tests.
#[cfg(test)]
impl Model {
    pub(crate) fn mesh_data(&self, mesh: usize) -> &rt_geometry::MeshData {
        self.meshes[mesh].mesh.data()
    }

    /// Its warnings, without their places.
    pub(crate) fn messages(&self) -> Vec<&str> {
        self.warnings.iter().map(|warning| warning.message.as_str()).collect()
    }
}
