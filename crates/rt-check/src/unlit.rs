//! Scenes without light.

use rt_render::has_light;
use rt_scene_io::MaterialId;
use rt_shading::ShadingFeatures;

use crate::finding::{Finding, Findings, Kind};
use crate::objects::Objects;

/// Reports a scene whose image is black. `render` warns of the same scenes.
pub(crate) fn check(objects: &Objects<'_>, findings: &mut Findings) {
    let scene = objects.scene;
    if objects.truncated || objects.list.is_empty() || !scene.settings.integrator.follows_light() {
        return;
    }
    let appearance = &scene.appearance;
    let mut used = vec![false; appearance.materials.len()];
    let media = scene.cameras.iter().filter_map(|camera| camera.medium).map(|MaterialId(index)| index as usize);
    for material in objects.list.iter().map(|object| object.material).chain(media) {
        if let Some(used) = used.get_mut(material) {
            *used = true;
        }
    }
    let features = ShadingFeatures::of(appearance, |material| used[material]);
    if !has_light(scene, &features) {
        let message = "has no light, no emissive object, and a black background: the image will be black";
        findings.add(Finding::new(Kind::Unlit, &scene.name, &[], message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_math::{DVec3, Rgb};
    use rt_scene_io::Integrator;
    use rt_shading::{Background, ColorTexture};

    #[test]
    fn a_scene_without_light_is_found() {
        let mut scene = scene_with(vec![sphere(DVec3::ZERO, 1.0)]);
        assert_eq!(of_kind(&scene, Kind::Unlit), [], "`whitted` adds ambient light");
        scene.settings.integrator = Integrator::Path;
        let finding = only(&scene, Kind::Unlit);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Warning, "test"));

        let mut lit = scene.clone();
        lit.appearance.lights = vec![point_light(DVec3::X * 3.0, 0.0)];
        assert_eq!(of_kind(&lit, Kind::Unlit), []);
        let mut emissive = scene.clone();
        emissive.appearance.materials[1].emission = ColorTexture::Constant(Rgb::WHITE);
        assert_eq!(of_kind(&emissive, Kind::Unlit).len(), 1, "no object has this material");
        emissive.appearance.materials[0].emission = ColorTexture::Constant(Rgb::WHITE);
        assert_eq!(of_kind(&emissive, Kind::Unlit), []);
        let mut outdoors = scene.clone();
        outdoors.appearance.background = Background::Constant(Rgb::WHITE);
        assert_eq!(of_kind(&outdoors, Kind::Unlit), []);
        scene.settings.integrator = Integrator::Cost;
        assert_eq!(of_kind(&scene, Kind::Unlit), [], "a view of the geometry");
    }
}
