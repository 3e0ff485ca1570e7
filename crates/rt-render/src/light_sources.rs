//! Lights that light tracing starts from, and the specular objects that it aims at.

use rt_geometry::Shape;
use rt_shading::{Appearance, LightSources, ProjectionMap, TargetSphere, light::LightSet};

use crate::{
    camera_medium::bounds_of_dielectrics,
    instance::{BottomLevel, Instance, InstanceGeometry, uses_material},
    world::World,
};

/// Lights of the world as origins of light paths; `None` if none of them can reach a specular surface.
pub(crate) fn light_sources(appearance: &Appearance, lights: &LightSet, world: &World) -> Option<LightSources> {
    let may_be_delta = |material: u32| {
        appearance.materials.get(material as usize).is_some_and(|material| material.model.may_be_delta())
    };
    let targets = targets(&world.top.instances, &world.levels, &may_be_delta);
    let dielectric_bounds = bounds_of_dielectrics(&appearance.materials, world);
    let sources = LightSources::new(lights, targets, world.bounds(), dielectric_bounds);
    (!sources.is_empty()).then_some(sources)
}

fn targets(instances: &[Instance], levels: &BottomLevel, may_be_delta: &impl Fn(u32) -> bool) -> ProjectionMap {
    let sphere = |instance: &Instance| match &instance.geometry {
        InstanceGeometry::Shape(Shape::Sphere(sphere)) => {
            Some(TargetSphere { centre: sphere.centre(), radius: sphere.radius() })
        }
        _ => instance
            .bounds
            .map(|bounds| TargetSphere { centre: bounds.centre(), radius: 0.5 * bounds.extent().length() }),
    };
    let sharp = instances.iter().filter(|instance| uses_material(instance, levels, may_be_delta));
    sharp.map(sphere).collect::<Option<Vec<_>>>().map_or(ProjectionMap::EVERYWHERE, ProjectionMap::new)
}
