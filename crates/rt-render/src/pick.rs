//! What a pixel shows: the object, its material, and the point.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{Hit, InteractionFlags, NoProbe};
use rt_math::{DVec2, DVec3, Interval, Ray};

use crate::{RenderPlan, flatten, plan::World, trace::Surfaces, world::Parts};

/// What the ray through the middle of a pixel meets first.
#[derive(Clone, Debug, PartialEq)]
pub struct PickResult {
    /// Names of the node that was met, and before it of the instance whose group it belongs to, if that is placed more than
    /// once. Names are those of the scene, and may be empty.
    pub object: Vec<String>,
    /// Name of the material.
    pub material: String,
    /// Ray parameter of the point; for camera rays, its depth along the view axis.
    pub t: f64,
    /// Distance of the point from where the ray starts: the pinhole, the centre of the lens, or the camera plane of parallel
    /// rays; in world units.
    pub distance: f64,
    /// The point in world space.
    pub point: DVec3,
    /// The shading normal there, of unit length.
    pub normal: DVec3,
}

impl RenderPlan<'_> {
    /// What pixel (`x`, `y`), counted from the upper left corner of the whole image, shows in its middle, in the middle of the
    /// shutter's time. `None` where that is the background. Pixels outside of the image are fine.
    pub fn pick(&self, x: u32, y: u32) -> Option<PickResult> {
        let raster = DVec2::new(f64::from(x), f64::from(y)) + self.sample_offset;
        let time = if self.moves { self.camera.moment(0.5) } else { 0.0 };
        let ray = self.camera.ray(raster, time);
        match &self.world {
            World::Spheres(world, structure) => {
                let name =
                    |hit: &Hit| flatten::name_of_shape(self.scene, hit.primitive).map(|name| vec![name.to_owned()]);
                self.pick_in(world, structure, &ray, name)
            }
            World::Parts(top, levels) => {
                let world = top.set(levels);
                self.pick_in(&world, &top.structure, &ray, |hit| world.names_at(hit))
            }
        }
    }

    fn pick_in<W: Surfaces>(
        &self,
        world: &W,
        structure: &AnyAccelerator,
        ray: &Ray,
        names: impl Fn(&Hit) -> Option<Vec<String>>,
    ) -> Option<PickResult> {
        let hit = structure.closest(world, ray, Interval::new(0.0, f64::INFINITY), &mut NoProbe)?;
        let surface = world.surface_at(ray, &hit, InteractionFlags::ALL)?;
        let material = self.scene.appearance.materials.get(surface.material as usize);
        Some(PickResult {
            object: names(&hit)?,
            material: material.map_or_else(String::new, |material| material.name.clone()),
            t: surface.t,
            distance: surface.t * ray.direction.length(),
            point: surface.interaction.point + self.origin,
            normal: surface.interaction.shading_normal,
        })
    }
}

impl Parts<'_> {
    /// The names of the part that a hit is on, that of an instance before that of what it places.
    fn names_at(&self, hit: &Hit) -> Option<Vec<String>> {
        let part = self.parts.get(self.place(hit) as usize)?;
        let inner = part.geometry.group().and_then(|level| {
            let inner = &self.levels.groups.get(level as usize)?.parts;
            inner.get(inner.partition_point(|part| part.first_primitive <= hit.primitive).checked_sub(1)?)
        });
        Some([Some(part), inner].into_iter().flatten().map(|part| part.name.to_string()).collect())
    }
}
