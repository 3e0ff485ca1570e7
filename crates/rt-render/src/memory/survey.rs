//! Counts of the objects that flattening will make of the node tree.

use std::collections::HashSet;

use rt_geometry::Shape;
use rt_math::Transform;
use rt_scene_io::{Content, GroupId, MeshId, Node, Scene};

use crate::{
    RenderError,
    accel_choice::{AccelOptions, MAX_LINEAR, choose},
    flatten::{MAX_INLINED_TRIANGLES, count_group_uses, group_of},
    instance::{Animated, Instance},
};

/// Overhead of an allocation and of shared counts.
const HEADER: u64 = 32;

/// Bytes per triangle of an emissive mesh: its share of the light sampler.
const EMITTER_BYTES: u64 = 64;

/// Largest consumer of memory.
#[derive(Debug, Default)]
pub(crate) struct Most {
    pub(crate) bytes: u64,
    pub(crate) what: String,
}

impl Most {
    pub(crate) fn offer(&mut self, bytes: u64, what: impl FnOnce() -> String) {
        if bytes > self.bytes {
            *self = Self { bytes, what: what() };
        }
    }
}

/// Bytes of a structure over so many primitives: what it keeps, and what it takes besides while it is built. Measured on meshes
/// of half a million triangles, and rounded up.
fn accel_bytes(accel_options: AccelOptions, primitives: u64) -> [u64; 2] {
    use rt_accel::AcceleratorKind as Kind;
    let [kept, besides] = match choose(accel_options.accel, primitives <= MAX_LINEAR as u64) {
        Kind::Linear => [16, 0],
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
    [primitives.saturating_mul(kept), primitives.saturating_mul(besides)]
}

/// Bytes of the objects of a scene.
#[derive(Debug, Default)]
pub(crate) struct Survey {
    pub(crate) geometry: u64,
    pub(crate) structures: u64,
    /// Temporary bytes of the largest accelerator.
    pub(crate) building: u64,
}

/// Instances that a list of nodes becomes.
#[derive(Clone, Copy, Debug, Default)]
struct Holding {
    parts: u64,
    bytes: u64,
}

impl Holding {
    const fn add(&mut self, parts: u64, each: u64) {
        self.parts = self.parts.saturating_add(parts);
        self.bytes = self.bytes.saturating_add(parts.saturating_mul(each));
    }
}

struct Surveyor<'s, 'm> {
    scene: &'s Scene,
    accel_options: AccelOptions,
    survey: Survey,
    most: &'m mut Most,
    group_uses: Vec<u64>,
    /// Flags of groups whose own aggregate is counted.
    levels: Vec<bool>,
    /// Instances of each group with all nested groups dissolved, if known.
    dissolved: Vec<Option<Holding>>,
    /// Meshes that have a level of their own that is counted, with the material that cuts holes into them.
    meshes: HashSet<(u32, Option<u32>)>,
}

impl Survey {
    /// Counts what flattening will find. With `culls`, there may be a second structure half as large as the first.
    pub(crate) fn of(
        scene: &Scene,
        accel_options: AccelOptions,
        culls: bool,
        most: &mut Most,
    ) -> Result<Self, RenderError> {
        let count = scene.groups.len();
        let mut surveyor = Surveyor {
            scene,
            accel_options,
            survey: Self::default(),
            most,
            group_uses: count_group_uses(scene)?,
            levels: vec![false; count],
            dissolved: vec![None; count],
            meshes: HashSet::new(),
        };
        surveyor.scene_itself();
        let top = surveyor.holding(&scene.nodes, false)?;
        surveyor.aggregate(top, "the scene");
        if culls {
            let [kept, _] = accel_bytes(accel_options, top.parts / 2);
            surveyor.survey.structures = surveyor.survey.structures.saturating_add(kept);
        }
        Ok(surveyor.survey)
    }
}

impl<'s> Surveyor<'s, '_> {
    /// The nodes as they are loaded, and all meshes.
    fn scene_itself(&mut self) {
        let mut open: Vec<&[Node]> = self.scene.groups.iter().map(|group| group.nodes.as_slice()).collect();
        open.push(&self.scene.nodes);
        let mut nodes = 0u64;
        while let Some(list) = open.pop() {
            nodes += list.len() as u64;
            open.extend(list.iter().map(|node| node.children.as_slice()));
        }
        let bytes = nodes.saturating_mul(size_of::<Node>() as u64 + HEADER);
        self.most.offer(bytes, || format!("{nodes} nodes"));
        self.survey.geometry = bytes;
        for named in &self.scene.meshes {
            let (bytes, triangles) = (named.mesh.memory() as u64, named.mesh.data().triangles.len());
            self.most.offer(bytes, || format!("the mesh `{}` of {triangles} triangles", named.name));
            self.survey.geometry = self.survey.geometry.saturating_add(bytes);
        }
    }

    /// Adds an assembly of such parts, and the structure over them.
    fn aggregate(&mut self, holding: Holding, name: &str) {
        let Holding { parts, bytes } = holding;
        self.most.offer(bytes, || format!("{parts} objects of {name}"));
        self.survey.geometry = self.survey.geometry.saturating_add(bytes);
        self.add_accel(parts, || format!("the structure over {parts} objects of {name}"));
    }

    fn add_accel(&mut self, primitives: u64, what: impl FnOnce() -> String) {
        let [kept, besides] = accel_bytes(self.accel_options, primitives);
        self.most.offer(kept.saturating_add(besides), what);
        self.survey.structures = self.survey.structures.saturating_add(kept);
        self.survey.building = self.survey.building.max(besides);
    }

    /// Instances of nodes and their descendants. Trees may be deep, so the traversal keeps its own stack.
    fn holding(&mut self, nodes: &'s [Node], within_group: bool) -> Result<Holding, RenderError> {
        let mut sum = Holding::default();
        // With each list, whether everything above it stands where it is.
        let mut open = vec![(nodes, true)];
        while let Some((nodes, unmoved)) = open.pop() {
            for node in nodes {
                let unmoved = unmoved && node.moves_to.is_none() && node.parent_from_local.is_identity();
                open.push((&node.children, unmoved));
                let part = part_bytes(node, unmoved);
                match &node.content {
                    None => {}
                    Some(Content::Shape(shape)) => sum.add(1, part + shape_bytes(shape)),
                    Some(Content::Mesh(id)) => sum.add(self.mesh(node, *id, unmoved), part),
                    Some(Content::Instance(id)) => match (within_group, self.group_uses[id.0 as usize]) {
                        (false, 1) => open.push((&group_of(self.scene, node, *id)?.nodes, unmoved)),
                        (false, _) => {
                            self.level(*id)?;
                            sum.add(1, part);
                        }
                        (true, _) => {
                            let Holding { parts, bytes } = self.dissolved(*id)?;
                            sum.parts = sum.parts.saturating_add(parts);
                            sum.bytes = sum.bytes.saturating_add(bytes);
                        }
                    },
                }
            }
        }
        Ok(sum)
    }

    /// The number of parts that a mesh becomes; its level is counted when it is met first.
    fn mesh(&mut self, node: &Node, id: MeshId, unmoved: bool) -> u64 {
        let Some(named) = self.scene.meshes.get(id.0 as usize) else { return 0 };
        let triangles = named.mesh.data().triangles.len();
        let material = self.scene.appearance.materials.get(node.material.0 as usize);
        let is_plain = material.is_none_or(|m| m.normal_map.is_none() && m.alpha == rt_shading::Alpha::OPAQUE);
        if triangles <= MAX_INLINED_TRIANGLES && unmoved && is_plain {
            return triangles as u64;
        }
        let alpha_test = material.filter(|m| m.alpha != rt_shading::Alpha::OPAQUE).map(|_| node.material.0);
        if self.meshes.insert((id.0, alpha_test)) {
            self.add_accel(triangles as u64, || {
                let name =
                    if named.name.is_empty() { "without a name".to_owned() } else { format!("`{}`", named.name) };
                format!("the structure over the {triangles} triangles of the mesh {name}")
            });
            if material.is_some_and(|material| !material.emission.is_zero()) {
                self.survey.geometry = self.survey.geometry.saturating_add(EMITTER_BYTES * triangles as u64);
            }
        }
        1
    }

    /// A group that is placed more than once has a level of its own, once.
    fn level(&mut self, id: GroupId) -> Result<(), RenderError> {
        let index = id.0 as usize;
        if std::mem::replace(&mut self.levels[index], true) {
            return Ok(());
        }
        let group = &self.scene.groups[index];
        let holding = self.holding(&group.nodes, true)?;
        self.aggregate(holding, &format!("the group `{}`", group.name));
        Ok(())
    }

    /// Instances of a nested group. One that contains itself ends here; flattening refuses it.
    fn dissolved(&mut self, id: GroupId) -> Result<Holding, RenderError> {
        let index = id.0 as usize;
        if let Some(known) = self.dissolved[index] {
            return Ok(known);
        }
        self.dissolved[index] = Some(Holding::default());
        let holding = self.holding(&self.scene.groups[index].nodes, true)?;
        self.dissolved[index] = Some(holding);
        Ok(holding)
    }
}

/// Bytes of a part, with the name and the transform that it has on the heap.
fn part_bytes(node: &Node, unmoved: bool) -> u64 {
    let transform = if unmoved { 0 } else { size_of::<Transform>() as u64 + HEADER };
    let moving = if node.moves_to.is_some() { size_of::<Animated>() as u64 + HEADER } else { 0 };
    size_of::<Instance>() as u64 + node.name.len() as u64 + HEADER + transform + moving
}

/// Bytes that a shape has on the heap.
fn shape_bytes(shape: &Shape) -> u64 {
    if let Shape::Polygon(polygon) = shape { polygon.memory() as u64 } else { 0 }
}
