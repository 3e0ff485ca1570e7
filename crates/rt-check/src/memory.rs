//! Prediction of the memory of a check from counts, before any of it is allocated.

use rt_geometry::Shape;
use rt_math::Aabb;
use rt_scene_io::{Content, Scene, SceneNode};

use crate::facets::{FACETED_BYTES, MAX_FACETS, facet_count};
use crate::objects::{Geometry, MAX_DEPTH, MAX_NODES, NODE_BYTES, Object};
use crate::topology::EDGE_BYTES;

/// Bytes of a [`Bvh`](rt_accel::Bvh) over boxes while it is built, per box. Measured on models of a million triangles, rounded
/// up.
const BVH_BYTES: u64 = 290;

/// Bytes that [`check`](crate::check) holds in addition to the scene and its accelerators. The prediction of both is
/// [`MemoryPrediction::of_scene`](rt_render::MemoryPrediction::of_scene).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CheckMemory {
    /// List of all objects, held throughout.
    pub objects: u64,
    /// Temporary lists of the edges and vertices of the largest mesh.
    pub meshes: u64,
    /// Temporary boxes of all faces and curved shapes, with a tree over them.
    pub faces: u64,
}

impl CheckMemory {
    /// Prediction for a scene. Visits all nodes, those of a group once per instance.
    pub fn of(scene: &Scene) -> Self {
        let mut counts = Counts::default();
        counts.add(scene);
        let of_mesh = |triangles: usize, vertices: usize| {
            // The vertices are sorted before the edges are listed.
            let sorted_vertices = vertices * (size_of::<[u32; 4]>() + size_of::<u32>());
            let edges = triangles * (size_of::<[u32; 4]>() + 3 * EDGE_BYTES);
            (triangles * size_of::<[u32; 3]>() + sorted_vertices.max(edges)) as u64
        };
        let meshes = scene.meshes.iter().map(|named| named.mesh.data());
        let per_box = size_of::<Aabb>() as u64 + BVH_BYTES;
        let facets = counts.facets.min(MAX_FACETS as u64) * per_box;
        let curved = counts.curved * (per_box + size_of::<usize>() as u64);
        Self {
            objects: counts.nodes * NODE_BYTES as u64 + counts.objects * size_of::<Object<'_>>() as u64,
            meshes: meshes.map(|data| of_mesh(data.triangles.len(), data.positions.len())).max().unwrap_or(0),
            faces: counts.objects * FACETED_BYTES as u64 + facets.max(curved),
        }
    }

    /// Largest amount held at any time.
    pub const fn peak(&self) -> u64 {
        self.objects + if self.meshes > self.faces { self.meshes } else { self.faces }
    }
}

/// Numbers of the parts of a scene that a check lists.
#[derive(Debug, Default)]
struct Counts {
    nodes: u64,
    objects: u64,
    facets: u64,
    curved: u64,
}

impl Counts {
    /// Visits the nodes as [`Objects::of`](crate::objects::Objects::of) does.
    fn add(&mut self, scene: &Scene) {
        let mut open: Vec<std::slice::Iter<'_, SceneNode>> = vec![scene.nodes.iter()];
        while let Some(siblings) = open.last_mut() {
            let Some(node) = siblings.next() else {
                open.pop();
                continue;
            };
            if self.nodes >= MAX_NODES as u64 || open.len() >= MAX_DEPTH {
                return;
            }
            self.nodes += 1;
            open.push(node.children.iter());
            match &node.content {
                Some(Content::Shape(shape)) => self.add_object(&Geometry::Shape(shape)),
                Some(Content::Mesh(id)) => {
                    if let Some(named) = scene.meshes.get(id.0 as usize) {
                        self.add_object(&Geometry::Mesh(id.0 as usize, &named.mesh));
                    }
                }
                Some(Content::Instance(id)) => {
                    open.extend(scene.groups.get(id.0 as usize).map(|group| group.nodes.iter()));
                }
                None => {}
            }
        }
    }

    fn add_object(&mut self, geometry: &Geometry<'_>) {
        use Shape::{Cuboid, Disk, Plane, Polygon, Rectangle, Triangle};
        let is_flat = matches!(
            geometry,
            Geometry::Mesh(..)
                | Geometry::Shape(Cuboid(_) | Disk(_) | Plane(_) | Polygon(_) | Rectangle(_) | Triangle(_))
        );
        self.objects += 1;
        self.facets += facet_count(geometry) as u64;
        self.curved += u64::from(!is_flat);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::Facets;
    use crate::fixture::*;
    use crate::objects::Objects;
    use rt_geometry::MeshData;
    use rt_math::{DVec3, Vec3};
    use rt_scene_io::{Group, GroupId, MaterialId};

    /// A grid of 2 · `side` · `side` triangles.
    fn sheet(side: u32) -> Scene {
        let point = |i: u32| Vec3::new((i % (side + 1)) as f32, 0.0, (i / (side + 1)) as f32);
        let cell = |i: u32| {
            let a = i / side * (side + 1) + i % side;
            [[a, a + side + 1, a + 1], [a + 1, a + side + 1, a + side + 2]]
        };
        let positions = (0..(side + 1) * (side + 1)).map(point).collect();
        let triangles = (0..side * side).flat_map(cell).collect();
        scene_of_mesh(MeshData { positions, triangles, ..MeshData::default() })
    }

    /// The prediction for a check was that for a render.
    #[test]
    fn the_memory_of_a_check_grows_with_the_faces() {
        let [small, large] = [32, 64].map(|side| CheckMemory::of(&sheet(side)));
        let ratio = large.peak() as f64 / small.peak() as f64;
        assert!((3.9..4.1).contains(&ratio), "{ratio}");
        let per_facet = (large.faces - small.faces) as f64 / f64::from(2 * (64 * 64 - 32 * 32));
        assert!((330.0..345.0).contains(&per_facet), "{per_facet}");
        let per_triangle = (large.meshes - small.meshes) as f64 / f64::from(2 * (64 * 64 - 32 * 32));
        assert!((60.0..70.0).contains(&per_triangle), "{per_triangle}");
        assert_eq!(CheckMemory::of(&empty()), CheckMemory::default());
    }

    #[test]
    fn objects_count_once_per_instance() {
        let mut scene = sheet(4);
        let cube = add_mesh(&mut scene, cube_data());
        scene.groups = vec![Group { name: "pair".into(), nodes: vec![cube, sphere(DVec3::ZERO, 1.0)] }];
        let instance = SceneNode::new(Content::Instance(GroupId(0)), MaterialId(0));
        scene.nodes.extend([instance.clone(), instance]);
        let mut counts = Counts::default();
        counts.add(&scene);
        assert_eq!((counts.nodes, counts.objects, counts.curved), (7, 5, 2));
        let objects = Objects::of(&scene);
        assert_eq!((objects.list.len() as u64, Facets::of(&objects).count as u64), (counts.objects, counts.facets));
        assert_eq!(counts.facets, 32 + 2 * 12);
    }
}
