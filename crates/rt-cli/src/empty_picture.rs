//! Pictures that show nothing, and why.

use rt_image::Image;
use rt_render::RenderPlan;
use rt_scene_io::{Integrator, Scene};

/// Says of a scene without any light that its picture will be black, before it is rendered.
pub(crate) fn unlit(scene: &Scene, plan: &RenderPlan<'_>) -> Option<String> {
    let is_unlit = scene.settings.integrator.follows_light() && !plan.has_light();
    is_unlit.then(|| {
        "nothing in the scene gives light, and the picture will be black: there is no light, no material that emits, and a black \
         background; add a light to the scene, or light it by an image with --env"
            .to_owned()
    })
}

/// Says of a whole picture that it shows nothing, with the likely cause; `None` if it shows something. Of its camera samples,
/// `hits` have met a surface; `is_developed` tells that it is stored as bytes for display.
pub(crate) fn empty(
    scene: &Scene,
    plan: &RenderPlan<'_>,
    film: &Image,
    hits: u64,
    is_developed: bool,
) -> Option<String> {
    let integrator = scene.settings.integrator;
    if hits == 0 && integrator != Integrator::Cost {
        return Some(unseen(scene));
    }
    if !integrator.follows_light() || !plan.has_light() {
        // Such a scene was warned of before.
        return None;
    }
    let brightest = film.pixels().as_flattened().iter().copied().fold(0.0, f32::max);
    let development = &scene.film.development;
    if brightest == 0.0 {
        return Some(
            "the picture is black: no light reaches what the camera sees; look for objects that enclose the lights or the camera, \
             for lights that point away, and at --depth"
                .to_owned(),
        );
    }
    (is_developed && development.byte(brightest) == 0).then(|| {
        let exposure = development.exposure;
        format!(
            "the picture is black: its brightest light is {brightest:e}, and the exposure {exposure}; raise --exposure"
        )
    })
}

fn unseen(scene: &Scene) -> String {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return "no camera ray meets an object: the scene has none, and the picture shows the background alone"
            .to_owned();
    }
    let middle = bounds.centre();
    let target = if middle.is_finite() {
        format!("--look-at {:.4},{:.4},{:.4}, the middle of the scene", middle.x, middle.y, middle.z)
    } else {
        "--look-from and --look-at".to_owned()
    };
    format!(
        "no camera ray meets an object, and the picture shows the background alone: the camera probably looks away from the scene; \
         try {target}"
    )
}
