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
    let hides_lights = top.instances.iter().any(|instance| match instance.geometry.group() {
        None => may_hide_lights(instance, None, n_sampled),
        Some(group) => {
            let mut inner = levels.groups[group as usize].instances.iter();
            inner.any(|inner| may_hide_lights(inner, Some(instance), n_sampled))
        }
    });
    if hides_lights { lights.seen_through_objects() } else { lights }
}

/// True if an object, perhaps within the instance of a group, casts no shadow and may lie before a sampled light other than itself.
fn may_hide_lights(object: &Instance, group: Option<&Instance>, n_sampled: usize) -> bool {
    let casts_shadow = object.casts_shadow && group.is_none_or(|group| group.casts_shadow);
    // Objects of a group that is not sampled keep the indices of their lights.
    let is_sampled = object.light.is_some() && group.is_none_or(|group| group.light.is_some());
    !casts_shadow && n_sampled > usize::from(is_sampled)
}

/// Half of the diagonal around the bounded part of the world; 1 without one.
fn radius(top: &Aggregate) -> f64 {
    let bounds = top.instances.iter().filter_map(|instance| instance.bounds).fold(Aabb::EMPTY, Aabb::union);
    if bounds.is_empty() { 1.0 } else { 0.5 * bounds.extent().length() }
}
