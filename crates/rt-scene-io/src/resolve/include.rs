//! Model files within a scene.

use std::ffi::OsStr;

use super::node::Objects;
use crate::load_model::KNOWN_EXTENSIONS;
use crate::memory::tree_bytes;
use crate::{Content, Diagnostic, LoadErrorKind, MaterialId, MeshId, Model, SceneNode, load_model, resolve_path};

impl Objects<'_> {
    /// The tree of a model file, with the materials of the model or all in the one that is given.
    pub(super) fn include(&mut self, path: &str, reference: &str, own: Option<MaterialId>) -> Option<Vec<SceneNode>> {
        if !self.models.trees.contains_key(reference) {
            let model = match self.models.at_hand.remove(reference) {
                Some(model) => Some(model),
                None => self.load(path, reference),
            };
            let tree = model.map(|model| self.merge(reference, model));
            self.models.trees.insert(reference.to_owned(), tree);
        }
        let tree = self.models.trees.get(reference)?.as_ref()?;
        let memory = self.options.memory.keep(format_args!("{reference} in all its instances"), tree_bytes(tree));
        self.report.check(format_args!("{path}.model"), memory)?;
        let mut nodes = tree.clone();
        if let Some(material) = own {
            for_each_node(&mut nodes, &mut |node| node.material = material);
        }
        Some(nodes)
    }

    fn load(&mut self, path: &str, reference: &str) -> Option<Model> {
        let file = resolve_path(reference, self.source, self.options);
        let file = self.report.check(format_args!("{path}.model"), file)?;
        let is_scene = |extension: &OsStr| ["ron", "json"].iter().any(|known| extension.eq_ignore_ascii_case(known));
        if file.extension().is_some_and(is_scene) {
            let rule = format!(
                "is a scene file, and `model` takes {KNOWN_EXTENSIONS}; copy its nodes and materials into this scene"
            );
            return self.report.check(format_args!("{path}.model"), Err(LoadErrorKind::bad_reference(reference, rule)));
        }
        match load_model(&file, &self.shutter.for_models(self.options)) {
            Ok(model) => Some(model),
            Err(error) => {
                // An error of the reference, not of the content of a file.
                let reason = match error.diagnostics() {
                    _ if file.is_dir() => &LoadErrorKind::Directory,
                    [Diagnostic { kind: kind @ LoadErrorKind::UnknownFormat { .. }, .. }] => kind,
                    _ => {
                        self.report.add(error.into_diagnostics());
                        return None;
                    }
                };
                self.report.check(format_args!("{path}.model"), Err(LoadErrorKind::bad_reference(reference, reason)))
            }
        }
    }

    /// Adds the parts of a model to the scene and returns its tree, with ids of the scene.
    fn merge(&mut self, reference: &str, model: Model) -> Vec<SceneNode> {
        let first_mesh = self.meshes.len() as u32;
        let first_texture = self.textures.list.len() as u32;
        self.meshes.extend(model.meshes);
        self.textures.list.extend(model.textures);
        let mut ids = Vec::with_capacity(model.materials.len());
        for mut material in model.materials {
            material.offset_textures(first_texture);
            ids.push(self.materials.add_of_model(material, &mut self.textures, &mut self.report));
        }
        let mut nodes = model.nodes;
        for_each_node(&mut nodes, &mut |node| {
            node.material = ids.get(node.material.0 as usize).copied().unwrap_or(MaterialId(0));
            if let Some(Content::Mesh(MeshId(id))) = &mut node.content {
                *id += first_mesh;
            }
        });
        self.report.warnings.extend(model.warnings);
        let unused = [
            (model.lights.len(), "lights", self.file.lights.is_some()),
            (model.cameras.len(), "cameras", self.file.camera.is_some() || !self.file.cameras.is_empty()),
        ];
        for (count, what, given) in unused {
            if count > 0 && !given {
                self.notes.push(format!("{reference} brings {count} {what}, which scenes that include it do not use."));
            }
        }
        nodes
    }
}

/// Applies `change` to all nodes of a tree. Loaders bound the depth.
fn for_each_node(nodes: &mut [SceneNode], change: &mut impl FnMut(&mut SceneNode)) {
    for node in nodes {
        change(node);
        for_each_node(&mut node.children, change);
    }
}
