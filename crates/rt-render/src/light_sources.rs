//! Lights that light tracing starts from, and the specular objects that it aims at.

use rt_geometry::Shape;
use rt_shading::{Appearance, Ball, LightSources, Targets, emitter::EmitterSet};

use crate::{
    camera_medium::reach_of_transparent_bodies,
    instance::{BottomLevel, Instance, InstanceGeometry, uses_material},
    world::World,
};

/// The lights of the world as beginnings of paths; `None` if none of them can shine on a sharp mirror or glass.
pub(crate) fn light_sources(appearance: &Appearance, emitters: &EmitterSet, world: &World) -> Option<LightSources> {
    let may_be_delta = |material: u32| {
        appearance.materials.get(material as usize).is_some_and(|material| material.model.may_be_delta())
    };
    let targets = match world {
        World::Spheres(world, _) => {
            let sharp = world.spheres.as_slice().iter().zip(&world.materials);
            let sharp = sharp.filter(|(_, material)| may_be_delta(**material));
            let ball =
                |(sphere, _): (&rt_geometry::Sphere, _)| Ball { centre: sphere.centre(), radius: sphere.radius() };
            Targets::new(sharp.map(ball).collect())
        }
        World::Instances(top, levels) => targets(&top.instances, levels, &may_be_delta),
    };
    let bodies = reach_of_transparent_bodies(&appearance.materials, world);
    let sources = LightSources::new(&appearance.lights, emitters, targets, world.bounds(), bodies);
    (!sources.is_empty()).then_some(sources)
}

fn targets(instances: &[Instance], levels: &BottomLevel, may_be_delta: &impl Fn(u32) -> bool) -> Targets {
    let ball = |instance: &Instance| match &instance.geometry {
        InstanceGeometry::Shape(Shape::Sphere(sphere)) => {
            Some(Ball { centre: sphere.centre(), radius: sphere.radius() })
        }
        _ => instance.bounds.map(|bounds| Ball { centre: bounds.centre(), radius: 0.5 * bounds.extent().length() }),
    };
    let sharp = instances.iter().filter(|instance| uses_material(instance, levels, may_be_delta));
    sharp.map(ball).collect::<Option<Vec<_>>>().map_or(Targets::EVERYWHERE, Targets::new)
}
