//! Media around the origins of camera rays.

use rt_camera::{Camera, Projection};
use rt_geometry::RayStream;
use rt_math::{Aabb, DVec2, DVec3, Ray};
use rt_scene_io::{NamedCamera, Scene};
use rt_shading::{InteriorList, Material, SceneQueries};

use crate::{
    frustum_cull::PrimaryTarget, instance::uses_material, tracer::SceneTracer, work_probe::WorkProbe, world::World,
};

/// Direction of the ray that finds the media around the pinhole. It points upwards to leave a half-space of water. It is
/// oblique to all axes and diagonals, so that it hits few edges.
const PROBE_DIRECTION: DVec3 = DVec3::new(0.36, 0.80, 0.48);

/// Dielectrics around the origins of camera rays.
#[derive(Debug)]
pub(crate) enum CameraMedium {
    /// One medium for all rays.
    Constant(InteriorList),
    /// Found for each ray that starts in this box: ray origins differ with a lens or a parallel projection, and media can
    /// move.
    PerRay(Aabb),
}

impl CameraMedium {
    /// Medium outside of all dielectrics.
    pub(crate) fn air() -> Self {
        Self::Constant(InteriorList::default())
    }

    /// Medium named by the camera, or else found in the world around it.
    pub(crate) fn of(named: &NamedCamera, camera: &Camera, moves: bool, scene: &Scene, world: &World) -> Self {
        if let Some(medium) = named.medium {
            return Self::Constant(InteriorList::filled_with(medium.0));
        }
        let bounds = bounds_of_dielectrics(&scene.appearance.materials, world);
        let start_apart = matches!(named.settings.projection, Projection::Orthographic { .. }) || camera.has_lens();
        if (start_apart || camera.moves()) && !bounds.is_empty() {
            return Self::PerRay(bounds);
        }
        let pinhole = camera.ray(DVec2::ZERO, 0.0).origin;
        if !bounds.contains(pinhole) {
            return Self::air();
        }
        if moves {
            return Self::PerRay(bounds);
        }
        Self::Constant(find_enclosing(scene, world, &Ray::new(pinhole, PROBE_DIRECTION)))
    }

    /// Version of [`find`](Self::find) for a stream: one list for all rays, or one for each, which are written to `lists`.
    pub(crate) fn find_all<'a>(
        &'a self,
        world: &mut dyn SceneQueries,
        materials: &[Material],
        rays: &RayStream,
        lists: &'a mut Vec<InteriorList>,
    ) -> &'a [InteriorList] {
        if let Self::Constant(all) = self {
            return core::slice::from_ref(all);
        }
        lists.resize_with(rays.len(), InteriorList::default);
        for (at, interior) in lists.iter_mut().enumerate() {
            self.find(world, materials, &rays.get(at).0, interior);
        }
        lists
    }

    /// Sets `interior` to the dielectrics around the origin of a camera ray.
    pub(crate) fn find(
        &self,
        world: &mut dyn SceneQueries,
        materials: &[Material],
        ray: &Ray,
        interior: &mut InteriorList,
    ) {
        match self {
            Self::Constant(all) => interior.clone_from(all),
            Self::PerRay(bounds) => interior.find_enclosing_media_within(*bounds, world, materials, ray),
        }
    }
}

fn find_enclosing(scene: &Scene, world: &World, ray: &Ray) -> InteriorList {
    let materials = &scene.appearance.materials;
    let mut interior = InteriorList::default();
    let (world, accelerator) = (world.instances(), &world.top.accelerator);
    let mut tracer = SceneTracer::new(&world, accelerator, PrimaryTarget::All(accelerator), WorkProbe::default());
    interior.find_enclosing_media(&mut tracer, materials, ray);
    interior
}

/// Bounds of all dielectrics; all of space if one of them is unbounded.
pub(crate) fn bounds_of_dielectrics(materials: &[Material], world: &World) -> Aabb {
    let is_transparent = |material: u32| materials.get(material as usize).is_some_and(|m| m.interior.is_some());
    let everywhere = Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY);
    let World { top, levels } = world;
    let transparent = top.instances.iter().filter(|instance| uses_material(instance, levels, &is_transparent));
    transparent.fold(Aabb::EMPTY, |sum, instance| sum.union(instance.bounds.unwrap_or(everywhere)))
}
