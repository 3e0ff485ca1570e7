//! Flattening of the node tree to instances: transforms are concatenated, groups with a single use are dissolved.

use std::collections::HashMap;
use std::sync::Arc;

use rt_accel::BuildError;
use rt_geometry::{Primitives, Shape, TransformedShape};
use rt_math::{Aabb, AnimatedTransformChain, Transform};
use rt_scene_io::{Content, Group, GroupId, Integrator, MeshId, NamedMesh, Scene, SceneNode};
use rt_shading::{Alpha, Material, StreamPrimitive, StreamShape, Texture};

use crate::{
    RenderError,
    accel_choice::{self, AccelOptions},
    alpha_mesh::{AlphaTest, AlphaTestedMesh},
    inlined_triangle::InlinedTriangle,
    instance::{Aggregate, Animated, BottomLevel, Instance, InstanceGeometry, Instances},
    mesh_blas::MeshBlas,
};

/// Deepest accepted nesting of nodes and groups together.
const MAX_DEPTH: usize = 1024;

/// Maximum number of triangles of an inlined mesh. The triangles of an untransformed small mesh join the level above.
pub(crate) const MAX_INLINED_TRIANGLES: usize = 64;

/// Flattens a scene and builds all acceleration structures, in the target space of `plan_from_world`.
///
/// `may_be_flat` allows accelerators to intersect primitives from their own copies if all instances are single primitives.
/// With a `static_time`, all objects rest at their positions at that time.
pub(crate) fn flatten(
    scene: &Scene,
    accel_options: AccelOptions,
    plan_from_world: Transform,
    may_be_flat: bool,
    static_time: Option<f64>,
) -> Result<(Aggregate, BottomLevel), RenderError> {
    let mut flattener = Flattener {
        scene,
        accel_options,
        may_be_flat,
        static_time,
        mesh_levels: HashMap::new(),
        group_levels: vec![None; scene.groups.len()],
        group_uses: count_group_uses(scene)?,
        levels: BottomLevel { textures: textures(scene), ..BottomLevel::default() },
        next_object: 0,
    };
    let level = Level { aggregate_from_parent: AnimatedTransformChain::constant(plan_from_world), ..Level::TOP };
    let top = flattener.aggregate(&scene.nodes, level)?;
    Ok((top, flattener.levels))
}

/// Textures, if an alpha test or a normal map uses them.
fn textures(scene: &Scene) -> Vec<Texture> {
    let mut materials = scene.appearance.materials.iter();
    let uses_textures = materials.any(|material| material.normal_map.is_some() || material.alpha != Alpha::OPAQUE);
    if uses_textures { scene.appearance.textures.clone() } else { Vec::new() }
}

/// Number of uses of each group, through nested groups.
pub(crate) fn count_group_uses(scene: &Scene) -> Result<Vec<u64>, RenderError> {
    let mut uses = vec![0u64; scene.groups.len()];
    let mut open = vec![(scene.nodes.as_slice(), 0usize)];
    while let Some((nodes, depth)) = open.pop() {
        for node in nodes {
            if depth >= MAX_DEPTH {
                return Err(RenderError::Nesting(node.name.clone()));
            }
            open.push((&node.children, depth + 1));
            if let Some(Content::Instance(id)) = node.content {
                let group = group_of(scene, node, id)?;
                let count = &mut uses[id.0 as usize];
                *count += 1;
                // Count nested groups on the first use only: further uses share the level of this group.
                if *count == 1 {
                    open.push((&group.nodes, depth + 1));
                }
            }
        }
    }
    Ok(uses)
}

pub(crate) fn group_of<'s>(scene: &'s Scene, node: &SceneNode, id: GroupId) -> Result<&'s Group, RenderError> {
    scene.groups.get(id.0 as usize).ok_or_else(|| RenderError::Dangling {
        object: node.name.clone(),
        what: "group",
        index: id.0,
        count: scene.groups.len(),
    })
}

/// Position of the traversal.
#[derive(Clone, Debug)]
struct Level {
    aggregate_from_parent: AnimatedTransformChain,
    casts_shadow: bool,
    depth: usize,
    /// True inside a group with its own level: nested groups are dissolved into it.
    within_group: bool,
}

impl Level {
    const TOP: Self = Self {
        aggregate_from_parent: AnimatedTransformChain::IDENTITY,
        casts_shadow: true,
        depth: 0,
        within_group: false,
    };

    /// Geometry and bounds at this position, given the untransformed bounds.
    fn place(
        &self,
        bounds: Option<Aabb>,
        geometry: impl FnOnce(Option<Box<Transform>>) -> InstanceGeometry,
    ) -> (InstanceGeometry, Option<Aabb>) {
        match self.aggregate_from_parent.as_constant() {
            Some(transform) if transform.is_identity() => (geometry(None), bounds),
            Some(transform) => (geometry(Some(Box::new(*transform))), bounds.map(|bounds| transform.aabb(&bounds))),
            None => {
                let aggregate_from_local = self.aggregate_from_parent.clone();
                let swept = bounds.map(|bounds| aggregate_from_local.aabb(&bounds));
                (
                    InstanceGeometry::Animated(Box::new(Animated { aggregate_from_local, geometry: geometry(None) })),
                    swept,
                )
            }
        }
    }
}

struct Flattener<'s> {
    scene: &'s Scene,
    accel_options: AccelOptions,
    /// Identifies hits by primitive index only, if all instances are single primitives.
    may_be_flat: bool,
    /// Time of the only position of all objects, if there is one.
    static_time: Option<f64>,
    /// Level by mesh, and by material if that has an alpha test.
    mesh_levels: HashMap<(u32, Option<u32>), u32>,
    group_levels: Vec<Option<u32>>,
    group_uses: Vec<u64>,
    levels: BottomLevel,
    /// Number of the next shape or mesh.
    next_object: u32,
}

impl<'s> Flattener<'s> {
    fn aggregate(&mut self, nodes: &'s [SceneNode], level: Level) -> Result<Aggregate, RenderError> {
        let within_group = level.within_group;
        let mut instances = Vec::new();
        self.collect(nodes, level, &mut instances)?;
        if within_group {
            self.number(&mut instances)?;
        }
        let is_flat =
            self.may_be_flat && !within_group && !instances.iter().any(|instance| instance.geometry.is_accelerator());
        let mut set = Instances { instances: &instances, levels: &self.levels, is_flat, has_only_primitives: false };
        let is_textured =
            |material: u32| self.scene.appearance.materials.get(material as usize).is_none_or(Material::is_textured);
        // Streams have no texture coordinates of spheres and polygons.
        let has_only_primitives = set.stream_primitives().all(|primitive| {
            primitive.is_some_and(|StreamPrimitive { shape, material, .. }| {
                !(matches!(shape, StreamShape::Sphere(_) | StreamShape::Polygon(_)) && is_textured(material))
            })
        });
        set.has_only_primitives = has_only_primitives;
        let accelerator = accel_choice::build(self.accel_options, &set).map_err(|source| {
            let object = match source {
                BuildError::BadBounds { index, .. } => instances[index as usize].name.to_string(),
                _ => self.scene.name.clone(),
            };
            RenderError::Build { object, source }
        })?;
        Ok(Aggregate { instances, accelerator, is_flat, has_only_primitives })
    }

    /// Assigns consecutive indices to the primitives of all instances of a group: one index of a hit identifies both.
    fn number(&self, instances: &mut [Instance]) -> Result<(), RenderError> {
        let mut next = 0u32;
        for instance in instances {
            instance.first_primitive = next;
            let count = match instance.geometry.static_geometry() {
                InstanceGeometry::Mesh(level, _) => self.levels.meshes[*level as usize].mesh.data().triangles.len(),
                _ => 1,
            };
            next = u32::try_from(count)
                .ok()
                .and_then(|count| next.checked_add(count))
                .ok_or(RenderError::TooManyObjects)?;
        }
        Ok(())
    }

    /// Adds the instances of nodes and their descendants. The traversal has an explicit stack, as trees can be deep.
    fn collect(
        &mut self,
        nodes: &'s [SceneNode],
        level: Level,
        instances: &mut Vec<Instance>,
    ) -> Result<(), RenderError> {
        let mut open = vec![(nodes.iter(), level)];
        while let Some((nodes, level)) = open.last_mut() {
            let Some(node) = nodes.next() else {
                open.pop();
                continue;
            };
            if level.depth >= MAX_DEPTH {
                return Err(RenderError::Nesting(node.name.clone()));
            }
            let here = Level {
                aggregate_from_parent: self.place_below(&level.aggregate_from_parent, node)?,
                casts_shadow: level.casts_shadow && node.casts_shadow,
                depth: level.depth + 1,
                within_group: level.within_group,
            };
            check_transform(node, &here.aggregate_from_parent)?;
            open.push((node.children.iter(), here.clone()));
            let object = instances.len() as u32;
            let instance_id = instances.last().map_or(0, |last| last.instance_id + 1);
            match node.content {
                Some(Content::Shape(ref shape)) => {
                    let object_id = self.number_object();
                    let instance = self.shape_instance(node, shape, &here)?;
                    instances.push(Instance { object, object_id, instance_id, ..instance });
                }
                Some(Content::Mesh(id)) => {
                    let object_id = self.number_object();
                    let triangles = self.mesh_instances(node, id, &here)?.into_iter();
                    instances.extend(triangles.map(|triangle| Instance { object, object_id, instance_id, ..triangle }));
                }
                Some(Content::Instance(id)) => {
                    let group = group_of(self.scene, node, id)?;
                    // An animated group stays one instance with an animated transform.
                    let is_static = here.aggregate_from_parent.as_constant().is_some();
                    if here.within_group || (is_static && self.group_uses[id.0 as usize] == 1) {
                        open.push((group.nodes.iter(), here));
                    } else {
                        let instance = self.group_instance(node, id, group, &here)?;
                        instances.extend(instance.map(|instance| Instance { object, instance_id, ..instance }));
                    }
                }
                None => {}
            }
        }
        Ok(())
    }

    /// Number of the next shape or mesh.
    const fn number_object(&mut self) -> u32 {
        self.next_object += 1;
        self.next_object - 1
    }

    /// Transform from the space of the node to that of the aggregate.
    fn place_below(
        &self,
        outer: &AnimatedTransformChain,
        node: &SceneNode,
    ) -> Result<AnimatedTransformChain, RenderError> {
        let chain = match self.static_time {
            None => node.place_below(outer),
            Some(static_time) => node.motion().map(|motion| {
                let place = motion.map_or(node.parent_from_local, |motion| motion.at(static_time));
                outer.clone().compose(&place)
            }),
        };
        chain.map_err(|source| RenderError::AnimatedTransform { object: node.name.clone(), source })
    }

    fn shape_instance(&self, node: &SceneNode, shape: &Shape, here: &Level) -> Result<Instance, RenderError> {
        let transformed = here.aggregate_from_parent.as_constant().filter(|transform| !transform.is_identity());
        let (geometry, bounds) = if let Some(transform) = transformed {
            let placed = TransformedShape::new(shape.clone(), *transform);
            let baked = if self.shows_uv(node) { placed.bake_transform() } else { placed.bake_transform_ignoring_uv() };
            match baked {
                Some(shape) => {
                    let bounds = shape.bounds();
                    (InstanceGeometry::Shape(shape), bounds)
                }
                None => {
                    let bounds = placed.bounds();
                    (InstanceGeometry::TransformedShape(Box::new(placed)), bounds)
                }
            }
        } else {
            here.place(shape.bounds(), |_| InstanceGeometry::Shape(shape.clone()))
        };
        self.instance(node, here, geometry, bounds)
    }

    /// True if the material or the environment of the node uses texture coordinates.
    fn shows_uv(&self, node: &SceneNode) -> bool {
        let material = self.scene.appearance.materials.get(node.material.0 as usize);
        self.scene.settings.integrator == Integrator::Uv || material.is_some_and(|m| m.is_textured())
    }

    /// Instances of a mesh: one, or one per triangle if the mesh is small and untransformed. A mesh without triangles has none.
    fn mesh_instances(&mut self, node: &SceneNode, id: MeshId, here: &Level) -> Result<Vec<Instance>, RenderError> {
        let named = self.scene.meshes.get(id.0 as usize).ok_or_else(|| RenderError::Dangling {
            object: node.name.clone(),
            what: "mesh",
            index: id.0,
            count: self.scene.meshes.len(),
        })?;
        let count = named.mesh.data().triangles.len();
        let material = self.scene.appearance.materials.get(node.material.0 as usize);
        let alpha_test = material.and_then(|material| AlphaTest::of(material, &named.mesh, [id.0, node.material.0]));
        let has_normal_map = material.is_some_and(|material| material.normal_map.is_some());
        if count <= MAX_INLINED_TRIANGLES
            && alpha_test.is_none()
            && !has_normal_map
            && here.aggregate_from_parent.as_constant().is_some_and(Transform::is_identity)
        {
            let triangle = |index| {
                let bounds = Primitives::bounds(&*named.mesh, index);
                let triangle = Box::new(InlinedTriangle::new(&named.mesh, index)?);
                Some(self.instance(node, here, InstanceGeometry::Triangle(triangle), bounds))
            };
            return (0..count as u32).filter_map(triangle).collect();
        }
        let key = (id.0, alpha_test.as_ref().map(|_| node.material.0));
        let level = match self.mesh_levels.get(&key) {
            Some(level) => *level,
            None => {
                let level = self.levels.meshes.len() as u32;
                let mesh = self.mesh_level(named, alpha_test)?;
                self.levels.meshes.push(mesh);
                self.mesh_levels.insert(key, level);
                level
            }
        };
        let (geometry, bounds) =
            here.place(Some(named.mesh.bounds()), |transform| InstanceGeometry::Mesh(level, transform));
        Ok(vec![self.instance(node, here, geometry, bounds)?])
    }

    fn mesh_level(&self, named: &NamedMesh, alpha_test: Option<AlphaTest>) -> Result<MeshBlas, RenderError> {
        let mesh = Arc::clone(&named.mesh);
        let accelerator = match &alpha_test {
            None => accel_choice::build(self.accel_options, &*mesh),
            Some(alpha_test) => accel_choice::build(
                self.accel_options,
                &AlphaTestedMesh { mesh: &mesh, alpha_test, textures: &self.levels.textures },
            ),
        };
        let accelerator = accelerator.map_err(|source| RenderError::Build { object: named.name.clone(), source })?;
        Ok(MeshBlas { mesh, alpha_test, accelerator })
    }

    /// Instance of a group; `None` if the group is empty.
    fn group_instance(
        &mut self,
        node: &SceneNode,
        id: GroupId,
        group: &'s Group,
        here: &Level,
    ) -> Result<Option<Instance>, RenderError> {
        let level = match self.group_levels[id.0 as usize] {
            Some(level) => level,
            None => {
                let inside = Level { within_group: true, depth: here.depth, ..Level::TOP };
                let aggregate = self.aggregate(&group.nodes, inside)?;
                let level = self.levels.groups.len() as u32;
                self.levels.groups.push(aggregate);
                self.group_levels[id.0 as usize] = Some(level);
                level
            }
        };
        let group = &self.levels.groups[level as usize];
        if group.instances.is_empty() {
            return Ok(None);
        }
        let bounds = group.instances.iter().try_fold(Aabb::EMPTY, |sum, instance| Some(sum.union(instance.bounds?)));
        let (geometry, bounds) = here.place(bounds, |transform| InstanceGeometry::Group(level, transform));
        self.instance(node, here, geometry, bounds).map(Some)
    }

    fn instance(
        &self,
        node: &SceneNode,
        here: &Level,
        geometry: InstanceGeometry,
        bounds: Option<Aabb>,
    ) -> Result<Instance, RenderError> {
        let count = self.scene.appearance.materials.len();
        let is_group = matches!(geometry.static_geometry(), InstanceGeometry::Group(..));
        if node.material.0 as usize >= count && !is_group {
            let (object, index) = (node.name.clone(), node.material.0);
            return Err(RenderError::Dangling { object, what: "material", index, count });
        }
        // Shadow rays ignore media. A solid of air must not cast a shadow in air; as a bubble in glass, the surface of the
        // glass blocks the ray.
        let material = (!is_group).then(|| &self.scene.appearance.materials[node.material.0 as usize]);
        let passes_shadow_rays = material.is_some_and(Material::passes_shadow_rays);
        let normal_map = material.and_then(|material| material.normal_map);
        Ok(Instance {
            geometry,
            normal_map,
            textured: true,
            material: node.material.0,
            casts_shadow: here.casts_shadow && !passes_shadow_rays,
            bounds,
            object: 0,
            object_id: 0,
            instance_id: 0,
            first_primitive: 0,
            light: None,
            name: Arc::from(node.name.as_str()),
        })
    }
}

/// Checks a product of transforms: it can be singular though each factor is invertible.
fn check_transform(node: &SceneNode, place: &AnimatedTransformChain) -> Result<(), RenderError> {
    for static_time in [0.0, 1.0] {
        let transform = place.at(static_time);
        Transform::from_linear(transform.linear(), transform.translation())
            .map_err(|source| RenderError::Transform { object: node.name.clone(), source })?;
    }
    Ok(())
}
