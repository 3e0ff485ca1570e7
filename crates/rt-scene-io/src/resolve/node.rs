//! The tree of objects.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use rt_math::Transform;

use super::animation::node_places;
use super::group::order;
use super::material::{Assigned, Materials};
use super::models::Models;
use super::shape::{ResolvedShape, resolve_shape};
use super::shutter::ShutterInterval;
use super::texture::Textures;
use super::tree_size;
use crate::diagnostics::Diagnostics;
use crate::format::{self, SceneFile};
use crate::{
    Content, Group, GroupId, LoadErrorKind, LoadOptions, MaterialId, MeshId, NamedMesh, SceneNode, Warning, limits,
};

/// Resolved objects of a scene so far, and their materials, meshes and groups.
pub(super) struct Objects<'a> {
    pub(super) file: &'a SceneFile,
    pub(super) report: Diagnostics,
    pub(super) materials: Materials<'a>,
    pub(super) textures: Textures<'a>,
    pub(super) meshes: Vec<NamedMesh>,
    pub(super) models: Models,
    pub(super) notes: Vec<String>,
    pub(super) source: &'a Path,
    pub(super) options: &'a LoadOptions,
    pub(super) shutter: ShutterInterval,
    group_ids: HashMap<&'a str, GroupId>,
    pub(super) groups: Vec<Group>,
    pub(super) nodes: Vec<SceneNode>,
    /// Medium of each camera.
    pub(super) media: Vec<Option<MaterialId>>,
}

impl<'a> Objects<'a> {
    /// Resolves all nodes. Errors are collected in the report.
    pub(super) fn resolve(
        file: &'a SceneFile,
        cameras: &[(String, format::Camera)],
        source: &'a Path,
        options: &'a LoadOptions,
        models: Models,
    ) -> Self {
        let mut objects = Self {
            file,
            report: Diagnostics::new(source),
            materials: Materials::new(&file.materials),
            textures: Textures::new(source, options),
            meshes: Vec::new(),
            models,
            notes: Vec::new(),
            source,
            options,
            shutter: ShutterInterval::new(file, cameras, options),
            group_ids: HashMap::new(),
            groups: Vec::new(),
            nodes: Vec::new(),
            media: Vec::new(),
        };
        let order = objects.report.check("groups", order(&file.groups)).unwrap_or_default();
        for index in order {
            let Some((name, nodes)) = file.groups.get_index(index) else { continue };
            let path = format!("groups[\"{name}\"]");
            let nodes = objects.tree(&path, nodes, None, 1);
            objects.group_ids.insert(name, GroupId(objects.groups.len() as u32));
            objects.groups.push(Group { name: name.clone(), nodes });
        }
        objects.nodes = objects.tree("nodes", &file.nodes, None, 1);
        objects.report.check("nodes", tree_size::check(&objects.nodes, &objects.groups));
        objects.media = cameras.iter().map(|(path, camera)| objects.medium(path, camera)).collect();
        objects.materials.check_unused(Textures::new(source, options), &mut objects.report);
        objects
    }

    fn tree(
        &mut self,
        path: &str,
        nodes: &'a [format::Node],
        inherited: Option<&Assigned<'a>>,
        depth: u64,
    ) -> Vec<SceneNode> {
        let checked = LoadErrorKind::check_limit("the depth of the tree", depth, limits::NODE_DEPTH);
        if self.report.check(path, checked).is_none() {
            return Vec::new();
        }
        nodes
            .iter()
            .enumerate()
            .filter_map(|(i, node)| self.node(&format!("{path}[{i}]"), node, inherited, depth))
            .collect()
    }

    fn node(
        &mut self,
        path: &str,
        node: &'a format::Node,
        inherited: Option<&Assigned<'a>>,
        depth: u64,
    ) -> Option<SceneNode> {
        let places = node_places(&mut self.report, path, node, &self.shutter);
        let (parent_from_local, moves_to) = places.unwrap_or((Transform::IDENTITY, None));
        let own = node.material.as_ref().map(|material| Assigned { path: format!("{path}.material"), material });
        let material = own.as_ref().or(inherited);
        let mut placed = SceneNode {
            moves_to,
            casts_shadow: node.casts_shadow,
            ..SceneNode::empty(node.name.clone(), parent_from_local)
        };
        match (&node.shape, &node.model, &node.instance) {
            (None, None, None) => self.check_material(path, own.as_ref()),
            (Some(shape), None, None) => {
                placed.material = self.material(path, material)?;
                placed.content = self.shape(path, &node.name, shape);
            }
            (None, Some(model), None) => {
                let own = match own.as_ref() {
                    Some(own) => Some(self.material(path, Some(own))?),
                    None => None,
                };
                placed.children = self.include(path, model, own)?;
            }
            (None, None, Some(group)) => placed.content = Some(Content::Instance(self.instance(path, group, node)?)),
            _ => {
                let rule = "are given at one node: move all but one to its `children`";
                self.report.refuse::<()>(path, "two of `shape`, `model` and `instance`", rule);
            }
        }
        if own.is_some() && node.shape.is_none() && node.model.is_none() {
            self.warn_of_unreached(path, node);
        }
        placed.children.extend(self.tree(&format!("{path}.children"), &node.children, material, depth + 1));
        Some(placed)
    }

    fn material(&mut self, path: &str, assigned: Option<&Assigned<'a>>) -> Option<MaterialId> {
        let id = self.materials.of(assigned, &mut self.textures, &mut self.report);
        self.report.check(format_args!("{path}.material"), id)
    }

    /// Checks a material that only children may use.
    fn check_material(&mut self, path: &str, assigned: Option<&Assigned<'a>>) {
        let is_sound = |assigned: &&Assigned<'_>| match assigned.material {
            format::NodeMaterial::Name(name) => self.file.materials.contains_key(name),
            format::NodeMaterial::Inline(_) => false,
        };
        if let Some(assigned) = assigned.filter(|assigned| !is_sound(assigned)) {
            self.material(path, Some(assigned));
        }
    }

    /// Warns of a material that only instances and models would inherit.
    fn warn_of_unreached(&mut self, path: &str, node: &format::Node) {
        let mut cut_off = None;
        let mut open: Vec<&format::Node> = node.children.iter().rev().collect();
        while let Some(below) = open.pop() {
            match (&below.shape, &below.model, &below.instance) {
                // The others take their own material further down.
                _ if below.material.is_some() => continue,
                (Some(_), ..) => return,
                (_, Some(model), _) => cut_off = cut_off.or(Some(("model", model))),
                (.., Some(group)) => cut_off = cut_off.or(Some(("instance", group))),
                _ => {}
            }
            open.extend(below.children.iter().rev());
        }
        if let Some((kind, name)) = cut_off {
            let place = if kind == "model" { "node of the model" } else { "nodes of the group" };
            let message =
                format!("has no effect: the {kind} \"{name}\" below does not inherit it; write it at the {place}");
            self.report.warnings.push(Warning { place: format!("{path}.material"), message });
        }
    }

    /// The material that a camera names as its medium.
    fn medium(&mut self, path: &str, camera: &format::Camera) -> Option<MaterialId> {
        let name = camera.medium.as_deref()?;
        let id = self.materials.id(name, &mut self.textures, &mut self.report).and_then(|id| {
            if self.materials.list[id.0 as usize].interior.is_some() {
                return Ok(id);
            }
            let rule = "is not transparent: name a material with `transmission`, or glass";
            Err(LoadErrorKind::invalid(format_args!("the material \"{name}\""), rule))
        });
        self.report.check(format_args!("{path}.medium"), id)
    }

    fn shape(&mut self, path: &str, name: &str, shape: &format::Shape) -> Option<Content> {
        let place = format!("{path}.shape");
        let resolve_shape = resolve_shape(shape, &place, &mut self.report.warnings);
        match self.report.check(place, resolve_shape)? {
            ResolvedShape::Shape(shape) => Some(Content::Shape(shape)),
            ResolvedShape::Mesh(mesh) => {
                let mesh = Arc::new(mesh?);
                let name = if name.is_empty() { path } else { name };
                let id = MeshId(self.meshes.len() as u32);
                self.meshes.push(NamedMesh { name: name.to_owned(), mesh });
                Some(Content::Mesh(id))
            }
        }
    }

    fn instance(&mut self, path: &str, group: &str, node: &format::Node) -> Option<GroupId> {
        if node.material.is_some() {
            let rule = "has no effect on an `instance`: set it on the nodes of the group";
            self.report.refuse::<()>(format_args!("{path}.material"), "the material", rule);
        }
        // Of groups that contain each other, none is resolved, and all are named in an error.
        if self.file.groups.contains_key(group) && !self.group_ids.contains_key(group) {
            return None;
        }
        let known = || self.report.names(self.file.groups.keys());
        let id = self.group_ids.get(group).copied().ok_or_else(|| LoadErrorKind::unknown("group", group, known()));
        self.report.check(format_args!("{path}.instance"), id)
    }
}
