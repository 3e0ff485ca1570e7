//! Picking: object, material and point at a pixel.

use rt_accel::Accelerator;
use rt_geometry::{Hit, InteractionFlags};
use rt_math::{DVec2, DVec3, Interval};

use crate::{RenderPlan, instance::Instances, work_probe::WorkProbe, world::World};

/// Closest hit of the ray through the middle of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PickResult {
    /// Name of the node that was hit, preceded by that of the instance of its group, if the group is placed more than
    /// once. Names are those of the scene, and may be empty.
    pub object: Vec<String>,
    /// Name of the material.
    pub material: String,
    /// Ray parameter of the point; for camera rays, its depth along the view axis.
    pub t: f64,
    /// Distance of the point from the ray origin: the pinhole, the centre of the lens, or the camera plane of parallel
    /// rays; in world units.
    pub distance: f64,
    /// Hit point in world space.
    pub point: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
}

impl RenderPlan<'_> {
    /// Object at the middle of pixel (`x`, `y`), counted from the upper left corner of the whole image, in the middle of the
    /// shutter interval. `None` for the background. Pixels outside of the image are valid.
    pub fn pick(&self, x: u32, y: u32) -> Option<PickResult> {
        let raster = DVec2::new(f64::from(x), f64::from(y)) + self.frame.sample_offset;
        let time = if self.frame.has_motion { self.frame.camera.shutter_time(0.5) } else { 0.0 };
        let ray = self.frame.camera.ray(raster, time);
        let (world, accelerator) = (self.scene.world.instances(), &self.scene.world.top.accelerator);
        let hit = accelerator.closest(&world, &ray, Interval::new(0.0, f64::INFINITY), &mut WorkProbe::default())?;
        let surface = world.surface(&ray, &hit, InteractionFlags::ALL)?;
        let material = self.scene.source.appearance.materials.get(surface.material as usize);
        Some(PickResult {
            object: world.names_at(&hit)?,
            material: material.map_or_else(String::new, |material| material.name.clone()),
            t: surface.t,
            distance: surface.t * ray.direction.length(),
            point: surface.interaction.point + self.scene.space.origin(),
            normal: surface.interaction.shading_normal,
        })
    }

    /// Names of all objects, in the order of their numbers in [`FirstHitLayer::ObjectId`](crate::FirstHitLayer::ObjectId), which
    /// begin at 1. The name of a number without an object is empty.
    pub fn object_names(&self) -> Vec<String> {
        let World { top, levels } = &self.scene.world;
        let mut names = Vec::new();
        for instance in top.all_instances(levels).filter(|instance| instance.geometry.group().is_none()) {
            let id = instance.object_id as usize;
            if names.len() <= id {
                names.resize(id + 1, String::new());
            }
            names[id] = instance.name.to_string();
        }
        names
    }
}

impl Instances<'_> {
    /// Names of the hit object; that of an instance comes first.
    fn names_at(&self, hit: &Hit) -> Option<Vec<String>> {
        let instance = self.instances.get(self.instance_index(hit) as usize)?;
        let inner = instance.geometry.group().and_then(|level| {
            let inner = &self.levels.groups.get(level as usize)?.instances;
            inner.get(inner.partition_point(|instance| instance.first_primitive <= hit.primitive).checked_sub(1)?)
        });
        Some([Some(instance), inner].into_iter().flatten().map(|instance| instance.name.to_string()).collect())
    }
}
