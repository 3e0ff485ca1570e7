//! Builder of scenes.

use glam::DVec3;
use rt_math::{Aabb, Transform};

use super::error::SceneError;
use super::geometry::{Blas, Geometry};
use super::instances::{Instance, Instances};
use super::ray_queries::Scene;
use crate::WideBvh;
use crate::wide::BuildParams;

/// Number of a geometry within its [`SceneBuilder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GeometryId(u32);

/// Collects geometries and their instances.
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
    geometries: Vec<Blas<'a>>,
    instances: Vec<Instance>,
}

impl<'a> SceneBuilder<'a> {
    /// An empty scene, all of whose trees are built with these parameters.
    pub const fn new(params: BuildParams) -> Self {
        Self { params, geometries: Vec::new(), instances: Vec::new() }
    }

    /// Adds a geometry and builds its tree. It is in the scene once it is placed.
    ///
    /// # Errors
    ///
    /// [`SceneError::Geometry`] if no tree can be built.
    pub fn add(&mut self, geometry: impl Into<Geometry<'a>>) -> Result<GeometryId, SceneError> {
        let id = self.geometries.len() as u32;
        let built = Blas::build(geometry.into(), &self.params);
        self.geometries.push(built.map_err(|source| SceneError::Geometry { geometry: id, source })?);
        Ok(GeometryId(id))
    }

    /// Places a geometry as it is. Returns the number of the instance, as in [`Hit::instance`](crate::Hit::instance).
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`] for a geometry of another builder.
    pub fn place(&mut self, geometry: GeometryId) -> Result<u32, SceneError> {
        self.place_with(geometry, None)
    }

    /// Places a geometry by a transform from its space to world space. Returns the number of the instance.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownGeometry`] for a geometry of another builder, and [`SceneError::NotUniform`] for spheres that
    /// would become ellipsoids.
    pub fn place_at(&mut self, geometry: GeometryId, world_from_local: &Transform) -> Result<u32, SceneError> {
        self.place_with(geometry, (!world_from_local.is_identity()).then_some(world_from_local))
    }

    fn place_with(
        &mut self,
        GeometryId(geometry): GeometryId,
        world_from_local: Option<&Transform>,
    ) -> Result<u32, SceneError> {
        let Some(placed) = self.geometries.get(geometry as usize) else {
            return Err(SceneError::UnknownGeometry { geometry });
        };
        let stays_round = world_from_local.is_none_or(|transform| transform.uniform_scale().is_some());
        if matches!(placed.geometry, Geometry::Spheres(_)) && !stays_round {
            return Err(SceneError::NotUniform { geometry });
        }
        let local_bounds = if placed.bounds.is_empty() { Aabb::from_points([DVec3::ZERO]) } else { placed.bounds };
        let bounds = world_from_local.map_or(local_bounds, |transform| transform.aabb(&local_bounds));
        let instance = Instance { geometry, world_from_local: world_from_local.copied().map(Box::new), bounds };
        self.instances.push(instance);
        Ok((self.instances.len() - 1) as u32)
    }

    /// The scene of all placed geometries.
    ///
    /// # Errors
    ///
    /// [`SceneError::Instances`] if no tree can be built over the instances, as when a transform moves one beyond the
    /// range of numbers.
    pub fn build(self) -> Result<Scene<'a>, SceneError> {
        let Self { params, geometries, instances } = self;
        let set = Instances { instances: &instances, geometries: &geometries };
        let tree = WideBvh::build_with(&set, &params).map_err(SceneError::Instances)?;
        Ok(Scene { geometries, instances, tree })
    }
}

impl<'a> Scene<'a> {
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
