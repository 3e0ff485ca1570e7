//! Builder of scenes, which also changes them.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec3;
use rt_math::{Aabb, Transform};

use super::error::SceneError;
use super::geometry::{Blas, Geometry};
use super::instances::{Instance, Instances};
use super::ray_queries::Scene;
use super::refit_tree::RefitTree;
use super::triangle_mesh::Vertices;
use crate::wide::BuildParams;

/// Index of a geometry within its [`SceneBuilder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GeometryId(u32);

/// Collects geometries and their instances, or changes those of a scene.
///
/// ```
/// use rt_accel::{BuildParams, DVec3, Interval, Ray, SceneBuilder, Transform, TriangleMesh};
///
/// let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let leaf = TriangleMesh::new(&vertices, &[[0, 1, 2]])?;
/// let mut builder = SceneBuilder::new(BuildParams::HIGH);
/// let leaf = builder.add(leaf)?;
/// for z in 0..10 {
///     builder.place_at(leaf, &Transform::translate(DVec3::new(0.0, 0.0, f64::from(z))))?;
/// }
/// let scene = builder.build()?;
/// let hit = scene.closest(&Ray::new(DVec3::new(0.2, 0.2, 20.0), DVec3::NEG_Z), Interval::FORWARD);
/// assert_eq!(hit.map(|hit| (hit.instance, hit.primitive)), Some((9, 0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneBuilder<'a> {
    params: BuildParams,
    /// By index; `None` for removed ones.
    geometries: Vec<Option<Arc<Blas<'a>>>>,
    /// Indices of these, which are reused.
    free_geometries: BTreeSet<u32>,
    /// By number; `None` for free numbers.
    instances: Vec<Option<Instance>>,
    /// Indices of these.
    free: BTreeSet<u32>,
    /// Meshes whose vertices have changed, so that the bounds of their instances are outdated.
    moved: BTreeSet<u32>,
    /// Tree of a scene with the same instances at other places.
    former_tree: Option<RefitTree>,
}

impl<'a> SceneBuilder<'a> {
    /// An empty scene, all of whose trees are built with these parameters.
    pub const fn new(params: BuildParams) -> Self {
        Self {
            params,
            geometries: Vec::new(),
            free_geometries: BTreeSet::new(),
            instances: Vec::new(),
            free: BTreeSet::new(),
            moved: BTreeSet::new(),
            former_tree: None,
        }
    }

    /// Adds a geometry and builds its tree. It is in the scene once it is placed. Its index is the lowest that is free.
    ///
    /// # Errors
    ///
    /// [`SceneError::Geometry`] if no tree can be built.
    pub fn add(&mut self, geometry: impl Into<Geometry<'a>>) -> Result<GeometryId, SceneError> {
        let id = self.free_geometries.first().copied().unwrap_or(self.geometries.len() as u32);
        let built = Blas::build(geometry.into(), &self.params);
        let built = Some(Arc::new(built.map_err(|source| SceneError::Geometry { geometry: id, source })?));
        if self.free_geometries.remove(&id) {
            self.geometries[id as usize] = built;
        } else {
            self.geometries.push(built);
        }
        Ok(GeometryId(id))
    }

    /// Adds an instance of a geometry, without a transform. Returns the index of the instance, as in
    /// [`Hit::instance`](crate::Hit::instance): the lowest that is free.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`] for a geometry that this builder does not have. It does not notice an index of another
    /// builder.
    pub fn place(&mut self, geometry: GeometryId) -> Result<u32, SceneError> {
        self.place_with(geometry, None)
    }

    /// Adds an instance of a geometry, with a transform from its space to world space. Returns the index of the
    /// instance.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`] as [`place`](Self::place), [`SceneError::Transform`] for a transform that is not
    /// finite, and [`SceneError::NotUniform`] for spheres that would become ellipsoids.
    pub fn place_at(&mut self, geometry: GeometryId, world_from_local: &Transform) -> Result<u32, SceneError> {
        self.place_with(geometry, (!world_from_local.is_identity()).then_some(world_from_local))
    }

    fn place_with(
        &mut self,
        GeometryId(geometry): GeometryId,
        world_from_local: Option<&Transform>,
    ) -> Result<u32, SceneError> {
        let number = self.free.first().copied().unwrap_or(self.instances.len() as u32);
        let instance = self.instance(number, geometry, world_from_local)?;
        if self.free.remove(&number) {
            self.instances[number as usize] = Some(instance);
        } else {
            self.instances.push(Some(instance));
        }
        self.former_tree = None;
        Ok(number)
    }

    fn instance(&self, id: u32, geometry: u32, world_from_local: Option<&Transform>) -> Result<Instance, SceneError> {
        let placed = self.geometry(GeometryId(geometry))?;
        if world_from_local.is_some_and(|at| !(at.linear().is_finite() && at.translation().is_finite())) {
            return Err(SceneError::Transform { instance: id });
        }
        let stays_round = world_from_local.is_none_or(|transform| transform.uniform_scale().is_some());
        if matches!(placed.geometry, Geometry::Spheres(_)) && !stays_round {
            return Err(SceneError::NotUniform { geometry });
        }
        let bounds = bounds(placed, world_from_local);
        Ok(Instance { id, geometry, world_from_local: world_from_local.copied().map(Box::new), bounds })
    }

    fn geometry(&self, GeometryId(geometry): GeometryId) -> Result<&Blas<'a>, SceneError> {
        let found = self.geometries.get(geometry as usize).and_then(Option::as_deref);
        found.ok_or(SceneError::UnknownGeometry { geometry })
    }

    fn placed(&self, instance: u32) -> Result<&Instance, SceneError> {
        let found = self.instances.get(instance as usize).and_then(Option::as_ref);
        found.ok_or(SceneError::UnknownInstance { instance })
    }

    /// Moves an instance: its former transform is replaced by one from the space of its geometry to world space.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownInstance`], [`SceneError::Transform`] and [`SceneError::NotUniform`]. The instance is unchanged
    /// then.
    pub fn set_transform(&mut self, instance: u32, world_from_local: &Transform) -> Result<(), SceneError> {
        let geometry = self.placed(instance)?.geometry;
        let world_from_local = (!world_from_local.is_identity()).then_some(world_from_local);
        self.instances[instance as usize] = Some(self.instance(instance, geometry, world_from_local)?);
        Ok(())
    }

    /// Removes an instance. The indices of the others stay; its own is reused. Its geometry can have new instances.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownInstance`].
    pub fn remove(&mut self, instance: u32) -> Result<(), SceneError> {
        self.placed(instance)?;
        self.instances[instance as usize] = None;
        self.free.insert(instance);
        self.former_tree = None;
        Ok(())
    }

    /// Removes a geometry without instances, and frees its memory unless a scene still uses it. The indices of the
    /// others stay; its own is reused, and [`GeometryId`]s of the removed geometry may then name another one.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`] and [`SceneError::InUse`].
    pub fn remove_geometry(&mut self, geometry: GeometryId) -> Result<(), SceneError> {
        self.geometry(geometry)?;
        if let Some(instance) = self.instances.iter().flatten().find(|instance| instance.geometry == geometry.0) {
            return Err(SceneError::InUse { geometry: geometry.0, instance: instance.id });
        }
        self.geometries[geometry.0 as usize] = None;
        self.free_geometries.insert(geometry.0);
        Ok(())
    }

    /// Moves the vertices of a mesh, whose triangles stay. All of its instances change.
    ///
    /// The tree of the mesh is refitted, which takes a fraction of the time of building it. It is built anew if
    /// refitting raises its cost by the surface area heuristic to more than 1.5 times that of when it was built.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`], [`SceneError::NotAMesh`], [`SceneError::Vertices`] for arrays that are no mesh, and
    /// [`SceneError::Geometry`] if no tree can be built. The mesh is unchanged then.
    pub fn set_vertices(&mut self, geometry: GeometryId, vertices: impl Into<Vertices<'a>>) -> Result<(), SceneError> {
        let id = geometry.0;
        let Geometry::Mesh(mesh) = &self.geometry(geometry)?.geometry else {
            return Err(SceneError::NotAMesh { geometry: id });
        };
        let mesh = mesh.with_vertices(vertices).map_err(|source| SceneError::Vertices { geometry: id, source })?;
        let refitted = self.geometry(geometry)?.refitted(mesh.into(), &self.params);
        let refitted = refitted.map_err(|source| SceneError::Geometry { geometry: id, source })?;
        self.geometries[id as usize] = Some(Arc::new(refitted));
        self.moved.insert(id);
        Ok(())
    }

    /// The scene of all placed geometries. Builds the tree over the instances, or refits it if a scene had the same ones at
    /// other places; the trees of geometries exist already.
    ///
    /// # Errors
    ///
    /// [`SceneError::Instances`] if no tree can be built over the instances, as when a transform moves one beyond the
    /// range of numbers.
    pub fn build(self) -> Result<Scene<'a>, SceneError> {
        let Self { params, geometries, instances, moved, former_tree, .. } = self;
        let mut instances: Vec<Instance> = instances.into_iter().flatten().collect();
        for instance in instances.iter_mut().filter(|instance| moved.contains(&instance.geometry)) {
            if let Some(Some(geometry)) = geometries.get(instance.geometry as usize) {
                instance.bounds = bounds(geometry, instance.world_from_local.as_deref());
            }
        }
        let set = Instances { instances: &instances, geometries: &geometries };
        let tree = match former_tree {
            Some(tree) => tree.refitted(&set, &params),
            None => RefitTree::build(&set, &params),
        };
        let tree = tree.map_err(SceneError::Instances)?;
        Ok(Scene { params, geometries, instances, tree })
    }
}

/// Indices of the items that are `None`.
fn free_places<T>(items: &[Option<T>]) -> BTreeSet<u32> {
    (0..).zip(items).filter_map(|(index, item)| item.is_none().then_some(index)).collect()
}

/// World bounds of a placed geometry; a point without primitives.
fn bounds(geometry: &Blas<'_>, world_from_local: Option<&Transform>) -> Aabb {
    let local = if geometry.bounds.is_empty() { Aabb::from_points([DVec3::ZERO]) } else { geometry.bounds };
    world_from_local.map_or(local, |transform| transform.aabb(&local))
}

impl<'a> Scene<'a> {
    /// A builder that holds this scene, to change it: instances and geometries keep their numbers, and share their trees
    /// with this scene. Only the tree over the instances changes: it is refitted if instances have moved, and built again
    /// if some were added or removed. Queries of this scene are not affected.
    ///
    /// ```
    /// use rt_accel::{BuildParams, DVec3, Interval, Ray, SceneBuilder, Transform, TriangleMesh};
    ///
    /// let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mut builder = SceneBuilder::new(BuildParams::default());
    /// let leaf = builder.add(TriangleMesh::new(&vertices, &[[0, 1, 2]])?)?;
    /// let (low, high) = (builder.place(leaf)?, builder.place_at(leaf, &Transform::translate(DVec3::Z))?);
    /// let before = builder.build()?;
    ///
    /// let mut builder = before.to_builder();
    /// builder.remove(high)?;
    /// builder.set_transform(low, &Transform::translate(DVec3::new(0.0, 0.0, -1.0)))?;
    /// let after = builder.build()?;
    /// let ray = Ray::new(DVec3::new(0.2, 0.2, 4.0), DVec3::NEG_Z);
    /// let t = [before, after].map(|scene| scene.closest(&ray, Interval::FORWARD).map(|hit| hit.t));
    /// assert_eq!(t, [Some(3.0), Some(5.0)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_builder(&self) -> SceneBuilder<'a> {
        let mut instances = Vec::with_capacity(self.instances.len());
        for instance in &self.instances {
            instances.resize(instance.id as usize, None);
            instances.push(Some(instance.clone()));
        }
        SceneBuilder {
            params: self.params,
            geometries: self.geometries.clone(),
            free_geometries: free_places(&self.geometries),
            free: free_places(&instances),
            instances,
            moved: BTreeSet::new(),
            former_tree: Some(self.tree.clone()),
        }
    }

    /// A scene of a single geometry, with default parameters.
    ///
    /// # Errors
    ///
    /// [`SceneError::Geometry`] if no tree can be built.
    pub fn new(geometry: impl Into<Geometry<'a>>) -> Result<Self, SceneError> {
        let mut builder = SceneBuilder::new(BuildParams::default());
        let geometry = builder.add(geometry)?;
        builder.place(geometry)?;
        builder.build()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleMesh;

    #[test]
    fn geometries_that_come_and_go_take_no_room() {
        let mesh = || TriangleMesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        let mut scene = Scene::new(mesh().expect("a mesh")).expect("a scene");
        let mut ids = Vec::new();
        for _ in 0..10 {
            let mut builder = scene.to_builder();
            let id = builder.add(mesh().expect("a mesh")).expect("a geometry");
            let instance = builder.place(id).expect("an instance");
            let mut builder = builder.build().expect("a scene").to_builder();
            builder.remove(instance).expect("an instance");
            builder.remove_geometry(id).expect("a geometry");
            scene = builder.build().expect("a scene");
            ids.push(id);
        }
        assert!(ids.iter().all(|id| *id == GeometryId(1)) && scene.geometries.len() == 2, "{ids:?}");
    }
}
