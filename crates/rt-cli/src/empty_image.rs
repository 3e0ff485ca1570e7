//! Warnings about images that are black or show no object.

use rt_camera::Camera;
use rt_check::short_number;
use rt_math::{Aabb, DVec2, DVec3};
use rt_render::{RenderPlan, Rendering, Statistics};
use rt_scene_io::{Integrator, Scene};

/// Warning about a scene without light, before it is rendered.
pub(crate) fn unlit(scene: &Scene, plan: &RenderPlan<'_>) -> Option<String> {
    let is_unlit = scene.settings.integrator.follows_light() && !plan.has_light();
    is_unlit.then(|| {
        "the scene has no light, no emissive material, and a black background: the image will be black; add a light, or an environment \
         image with --env"
            .to_owned()
    })
}

/// Warning about an image that is black or shows no object, with the likely cause. `is_developed` is true for an image
/// of display bytes.
pub(crate) fn empty(scene: &Scene, plan: &RenderPlan<'_>, rendering: &Rendering, is_developed: bool) -> Option<String> {
    let integrator = scene.settings.integrator;
    let Rendering { film, statistics: Statistics { camera_hits, bad_samples, .. }, .. } = rendering;
    if *camera_hits == 0 && integrator != Integrator::Cost {
        return Some(unseen(scene, plan));
    }
    if !integrator.follows_light() || !plan.has_light() {
        // `unlit` has warned already.
        return None;
    }
    let brightest = film.pixels().as_flattened().iter().copied().fold(0.0, f32::max);
    let development = &scene.film.development;
    let has_area_lights_only =
        integrator == Integrator::Whitted && scene.appearance.lights.is_empty() && plan.has_emission();
    if brightest == 0.0 && *bad_samples > 0 {
        // Bad samples count as black, and have a warning of their own.
        return None;
    }
    if brightest == 0.0 && has_area_lights_only {
        return Some("the image is black: `whitted` samples no area lights; use `distributed` or `path`".to_owned());
    }
    if brightest == 0.0 {
        return Some(
            "the image is black: no light reaches the visible surfaces; check for objects around the lights or the camera, for lights that \
             point away, and --max-depth"
                .to_owned(),
        );
    }
    (is_developed && development.byte(brightest) == 0).then(|| {
        let exposure = development.exposure;
        format!("the image is black: its maximum radiance is {brightest:e} at exposure {exposure}; raise --exposure")
    })
}

fn unseen(scene: &Scene, plan: &RenderPlan<'_>) -> String {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return "the scene has no objects: the image shows the background only".to_owned();
    }
    if is_in_view(scene, plan, bounds.centre()) {
        return "no camera ray hits an object, and the image shows the background only, although the centre of the scene is in view: backs of \
                single-sided materials and an alpha of 0 let rays through, and objects may be smaller than a pixel"
            .to_owned();
    }
    let target = if bounds.centre().is_finite() {
        format!("--look-at {} (the centre of the scene)", centre_text(&bounds))
    } else {
        "--look-from and --look-at".to_owned()
    };
    format!(
        "no camera ray hits an object, and the image shows the background only: the camera probably looks away from the scene; try \
         {target}"
    )
}

/// True if the image shows this point when the shutter opens.
fn is_in_view(scene: &Scene, plan: &RenderPlan<'_>, point: DVec3) -> bool {
    let (width, height) = (scene.film.width, scene.film.height);
    let settings = scene.cameras.iter().find(|camera| camera.name == plan.camera_name()).map(|camera| &camera.settings);
    let camera = settings.and_then(|settings| Camera::new(settings, width, height).ok());
    let size = DVec2::new(f64::from(width), f64::from(height));
    let raster = camera.and_then(|camera| camera.project(point));
    raster.is_some_and(|raster| raster.cmpge(DVec2::ZERO).all() && raster.cmple(size).all())
}

/// `X,Y,Z` of the centre, with as many digits as resolve a thousandth of the size.
fn centre_text(bounds: &Aabb) -> String {
    const MAX_DIGITS: i32 = 17;
    let size = bounds.extent().length();
    let shown = |value: f64| {
        if value.abs() < size * 1e-4 {
            return "0".to_owned();
        }
        let (mut digits, mut reach) = (4, size);
        while reach < value.abs() && digits < MAX_DIGITS {
            reach *= 10.0;
            digits += 1;
        }
        short_number(value, digits)
    };
    bounds.centre().to_array().map(shown).join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_have_as_many_digits_as_the_size_needs() {
        let text = |centre: [f64; 3], side: f64| {
            let [centre, half] = [DVec3::from_array(centre), DVec3::splat(side / 2.0)];
            centre_text(&Aabb::new(centre - half, centre + half))
        };
        assert_eq!(text([0.0, -0.0, 1e-9], 1.0), "0,0,0");
        assert_eq!(text([3e-7, 2.5e-6, 0.0], 1e-6), "3.000e-7,2.5000e-6,0");
        assert_eq!(text([123_456.789, 0.0, -2.0], 0.1), "123456.789,0,-2");
        assert_eq!(text([0.5, 0.25, 1.0 / 3.0], 1.0), "0.5,0.25,0.3333");
    }
}
