//! Predicted numbers and bytes of the instances that flattening creates from the node tree.

use std::collections::HashSet;

use rt_geometry::Shape;
use rt_math::Transform;
use rt_scene_io::{Content, GroupId, MeshId, Scene, SceneNode};

use crate::{
    RenderError,
    accel_choice::{AccelOptions, MAX_LINEAR, choose},
    flatten::{MAX_INLINED_TRIANGLES, count_group_uses, group_of},
    inlined_triangle::InlinedTriangle,
    instance::{Animated, Instance},
};

/// Overhead of an allocation and of shared counts.
const HEADER: u64 = 32;

/// Bytes per triangle of an emissive mesh: its share of the light sampler.
const EMITTER_BYTES: u64 = 64;

/// Largest single item of the memory prediction.
#[derive(Debug, Default)]
pub(crate) struct LargestItem {
    pub(crate) bytes: u64,
    pub(crate) what: String,
    /// Upper bound on the number of instances of an aggregate.
    pub(crate) instances: u64,
}

impl LargestItem {
    pub(crate) fn update(&mut self, bytes: u64, what: impl FnOnce() -> String) {
        if bytes > self.bytes {
            (self.bytes, self.what) = (bytes, what());
        }
    }
}

/// Bytes of an accelerator: the finished one, and temporary memory of its construction. Measured on meshes of half a million
/// triangles, rounded up.
fn accel_bytes(accel_options: AccelOptions, primitives: u64) -> [u64; 2] {
    use rt_accel::{AcceleratorKind as Kind, WideBvh};
    let [finished, temporary] = match choose(accel_options.accel, primitives <= MAX_LINEAR as u64) {
        Kind::Linear => [16, 0],
        Kind::Wide if primitives <= WideBvh::LIST_CAPACITY as u64 => [246, 100],
        Kind::Wide => [46, 100],
        Kind::Bvh => [40, 140],
        Kind::Grid => [44, 56],
        Kind::Spheres => [48, 72],
        Kind::Cylinders => [72, 90],
        Kind::Kd => [110, 260],
        Kind::Bsp => [220, 360],
        Kind::Bih => [20, 56],
        Kind::BihLazy => [60, 26],
    };
    [primitives.saturating_mul(finished), primitives.saturating_mul(temporary)]
}

/// Bytes of the objects of a scene.
#[derive(Debug, Default)]
pub(crate) struct Survey {
    pub(crate) geometry: u64,
    pub(crate) accelerators: u64,
    /// Temporary bytes of the largest accelerator.
    pub(crate) building: u64,
}

/// Number and bytes of the instances of a list of nodes.
#[derive(Clone, Copy, Debug, Default)]
struct InstanceTotals {
    count: u64,
    bytes: u64,
    /// Upper bound on the number: each small mesh counts as inlined.
    most: u64,
}

impl InstanceTotals {
    fn add(&mut self, count: u64, each: u64) {
        self.add_all(Self { count, bytes: count.saturating_mul(each), most: count });
    }

    fn add_all(&mut self, other: Self) {
        self.count = self.count.saturating_add(other.count);
        self.bytes = self.bytes.saturating_add(other.bytes);
        self.most = self.most.saturating_add(other.most);
    }
}

struct Surveyor<'s, 'm> {
    scene: &'s Scene,
    accel_options: AccelOptions,
    survey: Survey,
    largest: &'m mut LargestItem,
    group_uses: Vec<u64>,
    /// Flags of groups whose own aggregate is counted.
    levels: Vec<bool>,
    /// Instances of each group with all nested groups dissolved, if known.
    dissolved: Vec<Option<InstanceTotals>>,
    /// Meshes whose level is counted, with their material if it has an alpha test.
    meshes: HashSet<(u32, Option<u32>)>,
}

impl Survey {
    /// Surveys a scene. With `culls`, a second accelerator of half the size is added.
    pub(crate) fn of(
        scene: &Scene,
        accel_options: AccelOptions,
        culls: bool,
        largest: &mut LargestItem,
    ) -> Result<Self, RenderError> {
        let count = scene.groups.len();
        let mut surveyor = Surveyor {
            scene,
            accel_options,
            survey: Self::default(),
            largest,
            group_uses: count_group_uses(scene)?,
            levels: vec![false; count],
            dissolved: vec![None; count],
            meshes: HashSet::new(),
        };
        surveyor.add_scene();
        let top = surveyor.instance_totals(&scene.nodes, false)?;
        surveyor.aggregate(top, "the scene");
        if culls {
            let [finished, _] = accel_bytes(accel_options, top.count / 2);
            surveyor.survey.accelerators = surveyor.survey.accelerators.saturating_add(finished);
        }
        Ok(surveyor.survey)
    }
}

impl<'s> Surveyor<'s, '_> {
    /// Adds the loaded nodes and all meshes.
    fn add_scene(&mut self) {
        let mut open: Vec<&[SceneNode]> = self.scene.groups.iter().map(|group| group.nodes.as_slice()).collect();
        open.push(&self.scene.nodes);
        let mut nodes = 0u64;
        while let Some(list) = open.pop() {
            nodes += list.len() as u64;
            open.extend(list.iter().map(|node| node.children.as_slice()));
        }
        let bytes = nodes.saturating_mul(size_of::<SceneNode>() as u64 + HEADER);
        self.largest.update(bytes, || format!("{nodes} nodes"));
        self.survey.geometry = bytes;
        for named in &self.scene.meshes {
            let (bytes, triangles) = (named.mesh.memory() as u64, named.mesh.data().triangles.len());
            self.largest.update(bytes, || format!("the mesh `{}` of {triangles} triangles", named.name));
            self.survey.geometry = self.survey.geometry.saturating_add(bytes);
        }
    }

    /// Adds an aggregate of instances with its accelerator.
    fn aggregate(&mut self, totals: InstanceTotals, name: &str) {
        let InstanceTotals { count, bytes, most } = totals;
        self.largest.instances = self.largest.instances.max(most);
        self.largest.update(bytes, || format!("{count} objects of {name}"));
        self.survey.geometry = self.survey.geometry.saturating_add(bytes);
        self.add_accel(count, || format!("the accelerator over {count} objects of {name}"));
    }

    fn add_accel(&mut self, primitives: u64, what: impl FnOnce() -> String) {
        let [finished, temporary] = accel_bytes(self.accel_options, primitives);
        self.largest.update(finished.saturating_add(temporary), what);
        self.survey.accelerators = self.survey.accelerators.saturating_add(finished);
        self.survey.building = self.survey.building.max(temporary);
    }

    /// Instances of nodes and their descendants. Trees may be deep, so the traversal keeps its own stack.
    fn instance_totals(&mut self, nodes: &'s [SceneNode], within_group: bool) -> Result<InstanceTotals, RenderError> {
        let mut sum = InstanceTotals::default();
        // The flag of a list: no ancestor has a transform.
        let mut open = vec![(nodes, true)];
        while let Some((nodes, is_untransformed)) = open.pop() {
            for node in nodes {
                let is_untransformed =
                    is_untransformed && node.moves_to.is_none() && node.parent_from_local.is_identity();
                open.push((&node.children, is_untransformed));
                let each = instance_bytes(node, is_untransformed);
                match &node.content {
                    None => {}
                    Some(Content::Shape(shape)) => sum.add(1, each + shape_bytes(shape)),
                    Some(Content::Mesh(id)) => match self.inlined_triangles(node, *id, is_untransformed) {
                        Some(triangles) => sum.add(triangles, each + size_of::<InlinedTriangle>() as u64 + HEADER),
                        None => {
                            let count = self.mesh(node, *id);
                            let most = self.small_mesh_triangles(*id).unwrap_or(count);
                            sum.add_all(InstanceTotals { count, bytes: count.saturating_mul(each), most });
                        }
                    },
                    Some(Content::Instance(id)) => match (within_group, self.group_uses[id.0 as usize]) {
                        (false, 1) => open.push((&group_of(self.scene, node, *id)?.nodes, is_untransformed)),
                        (false, _) => {
                            self.level(*id)?;
                            sum.add(1, each);
                        }
                        (true, _) => sum.add_all(self.dissolved(*id)?),
                    },
                }
            }
        }
        Ok(sum)
    }

    /// Number of triangles of a mesh that are instances of their own; `None` for a mesh with its own level.
    fn inlined_triangles(&self, node: &SceneNode, id: MeshId, is_untransformed: bool) -> Option<u64> {
        let material = self.scene.appearance.materials.get(node.material.0 as usize);
        let is_plain = material.is_none_or(|m| m.normal_map.is_none() && m.alpha == rt_shading::Alpha::OPAQUE);
        self.small_mesh_triangles(id).filter(|_| is_untransformed && is_plain)
    }

    /// Number of triangles of a mesh that may be inlined.
    fn small_mesh_triangles(&self, id: MeshId) -> Option<u64> {
        let triangles = self.scene.meshes.get(id.0 as usize)?.mesh.data().triangles.len();
        (triangles <= MAX_INLINED_TRIANGLES).then_some(triangles as u64)
    }

    /// Number of instances of a mesh. Its level is added on the first use.
    fn mesh(&mut self, node: &SceneNode, id: MeshId) -> u64 {
        let Some(named) = self.scene.meshes.get(id.0 as usize) else { return 0 };
        let triangles = named.mesh.data().triangles.len();
        let material = self.scene.appearance.materials.get(node.material.0 as usize);
        let alpha_test = material.filter(|m| m.alpha != rt_shading::Alpha::OPAQUE).map(|_| node.material.0);
        if self.meshes.insert((id.0, alpha_test)) {
            self.add_accel(triangles as u64, || {
                let name =
                    if named.name.is_empty() { "without a name".to_owned() } else { format!("`{}`", named.name) };
                format!("the accelerator over the {triangles} triangles of the mesh {name}")
            });
            if material.is_some_and(|material| !material.emission.is_zero()) {
                self.survey.geometry = self.survey.geometry.saturating_add(EMITTER_BYTES * triangles as u64);
            }
        }
        1
    }

    /// Adds the level of a group with several uses, on the first use.
    fn level(&mut self, id: GroupId) -> Result<(), RenderError> {
        let index = id.0 as usize;
        if std::mem::replace(&mut self.levels[index], true) {
            return Ok(());
        }
        let group = &self.scene.groups[index];
        let totals = self.instance_totals(&group.nodes, true)?;
        self.aggregate(totals, &format!("the group `{}`", group.name));
        Ok(())
    }

    /// Instances of a nested group. A group that contains itself counts as empty; flattening rejects it.
    fn dissolved(&mut self, id: GroupId) -> Result<InstanceTotals, RenderError> {
        let index = id.0 as usize;
        if let Some(known) = self.dissolved[index] {
            return Ok(known);
        }
        self.dissolved[index] = Some(InstanceTotals::default());
        let totals = self.instance_totals(&self.scene.groups[index].nodes, true)?;
        self.dissolved[index] = Some(totals);
        Ok(totals)
    }
}

/// Bytes of an instance, with its name and transform on the heap.
fn instance_bytes(node: &SceneNode, is_untransformed: bool) -> u64 {
    let transform = if is_untransformed { 0 } else { size_of::<Transform>() as u64 + HEADER };
    let moving = if node.moves_to.is_some() { size_of::<Animated>() as u64 + HEADER } else { 0 };
    size_of::<Instance>() as u64 + node.name.len() as u64 + HEADER + transform + moving
}

/// Bytes of a shape on the heap.
fn shape_bytes(shape: &Shape) -> u64 {
    if let Shape::Polygon(polygon) = shape { polygon.memory() as u64 } else { 0 }
}
