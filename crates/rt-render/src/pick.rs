//! Picking: object, material and point at a pixel.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{Hit, InteractionFlags};
use rt_math::{DVec2, DVec3, Interval, Ray};

use crate::{
    RenderPlan, flatten,
    instance::Instances,
    work_probe::WorkProbe,
    world::{ShadedPrimitives, World},
};

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
        match &self.scene.world {
            World::Spheres(world, structure) => {
                let name = |hit: &Hit| {
                    let mut names = flatten::names_of_shapes(self.scene.source);
                    names.nth(hit.primitive as usize).map(|name| vec![name.to_owned()])
                };
                self.pick_in(world, structure, &ray, name)
            }
            World::Instances(top, levels) => {
                let world = top.set(levels);
                self.pick_in(&world, &top.structure, &ray, |hit| world.names_at(hit))
            }
        }
    }

    /// Names of all objects, in the order of their numbers in [`FirstHitLayer::ObjectId`](crate::FirstHitLayer::ObjectId), which
    /// begin at 1. The name of a number without an object is empty.
    pub fn object_names(&self) -> Vec<String> {
        let (top, levels) = match &self.scene.world {
            World::Spheres(..) => {
                return flatten::names_of_shapes(self.scene.source).map(str::to_owned).collect();
            }
            World::Instances(top, levels) => (top, levels),
        };
        let mut names = Vec::new();
        let all = core::iter::once(top).chain(&levels.groups).flat_map(|aggregate| &aggregate.instances);
        for instance in all.filter(|instance| instance.geometry.group().is_none()) {
            let id = instance.object_id as usize;
            if names.len() <= id {
                names.resize(id + 1, String::new());
            }
            names[id] = instance.name.to_string();
        }
        names
    }

    fn pick_in<W: ShadedPrimitives>(
        &self,
        world: &W,
        structure: &AnyAccelerator,
        ray: &Ray,
        names: impl Fn(&Hit) -> Option<Vec<String>>,
    ) -> Option<PickResult> {
        let hit = structure.closest(world, ray, Interval::new(0.0, f64::INFINITY), &mut WorkProbe::default())?;
        let surface = world.surface_at(ray, &hit, InteractionFlags::ALL)?;
        let material = self.scene.source.appearance.materials.get(surface.material as usize);
        Some(PickResult {
            object: names(&hit)?,
            material: material.map_or_else(String::new, |material| material.name.clone()),
            t: surface.t,
            distance: surface.t * ray.direction.length(),
            point: surface.interaction.point + self.scene.space.origin(),
            normal: surface.interaction.shading_normal,
        })
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
