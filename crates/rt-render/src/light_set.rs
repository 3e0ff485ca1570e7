//! Lights of a plan.

use rt_math::Aabb;
use rt_scene_io::Scene;
use rt_shading::{
    Appearance, Background,
    light::{Light, LightSet},
};

use crate::{
    area_lights::area_lights,
    instance::{Aggregate, BottomLevel, Instance},
};

/// Area lights, the environment and the delta lights of a scene. `appearance` is in render space.
pub(crate) fn light_set(
    scene: &Scene,
    appearance: &Appearance,
    top: &mut Aggregate,
    levels: &mut BottomLevel,
) -> LightSet {
    let mut lights = area_lights(scene, top, levels);
    if let Background::Environment(light) = &appearance.background {
        lights.push(Light::Environment(light.as_ref().clone()));
    }
    lights.extend(appearance.lights.iter().cloned().map(Light::Delta));
    let n_sampled = lights.iter().filter(|light| !light.is_delta()).count();
    let lights = LightSet::new(lights, scene.settings.light_sampling, radius(top));
    // A light that casts no shadow hides others only.
    let hides_lights =
        |instance: &Instance| !instance.casts_shadow && n_sampled > usize::from(instance.light.is_some());
    if top.all_instances(levels).any(hides_lights) { lights.seen_through_objects() } else { lights }
}

/// Half of the diagonal around the bounded part of the world; 1 without one.
fn radius(top: &Aggregate) -> f64 {
    let bounds = top.instances.iter().filter_map(|instance| instance.bounds).fold(Aabb::EMPTY, Aabb::union);
    if bounds.is_empty() { 1.0 } else { 0.5 * bounds.extent().length() }
}
