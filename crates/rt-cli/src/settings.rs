//! Settings of a render: the scene file with the command-line options applied.

use rt_camera::{CameraSettings, Projection};
use rt_check::short_number;
use rt_image::{Development, Dither};
use rt_math::{DVec3, Transform};
use rt_render::{PlanOptions, Quality};
use rt_scene_io::{Accel, AdaptiveSampling, Background, Integrator, LoadErrorKind, Scene};

use crate::args::{AdaptiveChoice, BackgroundChoice, DevelopmentArgs, ImageArgs, ViewArgs};
use crate::error::{CliError, usage};

/// Applies options to a scene. `environment` is the image of `--env`, and `memory` the limit in bytes.
pub(crate) fn resolve(
    mut scene: Scene,
    args: &ImageArgs,
    development: Option<&DevelopmentArgs>,
    environment: Option<&Background>,
    memory: Option<u64>,
) -> Result<(Scene, PlanOptions), CliError> {
    let film = &mut scene.film;
    [film.width, film.height] = args.size.unwrap_or([film.width, film.height]);
    let settings = &mut scene.settings;
    replace(&mut settings.spp, args.spp);
    settings.passes = args.passes.or(settings.passes);
    settings.adaptive = adaptive(args, settings.adaptive)?;
    if let Some(min_spp) = args.min_spp.filter(|min_spp| *min_spp > settings.spp) {
        let spp = settings.spp;
        return usage(format!("--min-spp {min_spp} exceeds the {spp} samples per pixel; lower it, or raise --spp"));
    }
    replace(&mut settings.depth, args.max_depth);
    replace(&mut settings.seed, args.seed);
    settings.clamp = args.clamp.or(settings.clamp);
    replace(&mut settings.integrator, args.integrator);
    replace(&mut settings.pattern, args.sampler);
    replace(&mut settings.accel, args.accel);
    replace(&mut settings.light_sampling, args.light_sampling);
    if args.integrator.is_some_and(|integrator| !integrator.follows_light()) {
        // Exposure and tone curve of the scene suit its light, which debug views do not show.
        let Development { encoding, .. } = film.development;
        film.development = Development { encoding, ..Development::default() };
    }
    if let Some(development) = development {
        apply_development(development, &mut film.development);
    }
    if let (Some(dither), Some(crop)) = (&mut film.development.dither, args.crop) {
        dither.origin = [crop.x, crop.y];
    }
    let color = match args.background {
        Some(BackgroundChoice::Color(color)) => Some(color),
        _ => None,
    };
    if let Some(environment) = environment {
        scene.appearance.background = environment.clone();
        if args.integrator.is_none() && scene.settings.integrator == Integrator::Whitted {
            scene.settings.integrator = Integrator::Path;
        }
    } else if let Some(color) = color {
        scene.appearance.background = Background::Constant(color);
    }
    if args.integrator.is_some() {
        let note = simplification(&scene);
        scene.notes.extend(note);
    }
    let notes = unused_options(args, &scene);
    scene.notes.extend(notes);
    correct_notes(&args.view, &mut scene);
    let camera = find_camera(args.view.camera.as_deref(), &scene)?;
    if let Some(camera) = scene.cameras.get_mut(camera) {
        move_camera(&args.view, &mut camera.settings)?;
    }
    let options = PlanOptions {
        camera,
        crop: args.crop,
        transparent: args.background == Some(BackgroundChoice::Transparent),
        backdrop: color.filter(|_| environment.is_some()),
        full: args.full_plan,
        simd: args.simd,
        precision: args.precision,
        quality: args.build_quality,
        memory,
        progressive: false,
        maps: false,
    };
    Ok((scene, options))
}

/// Notes about options that do not apply to the scene with its settings.
fn unused_options(args: &ImageArgs, scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    let (accel, materials) = (scene.settings.accel, &scene.appearance.materials);
    if args.build_quality != Quality::default() && !matches!(accel, Accel::Auto | Accel::Wide) {
        notes.push(format!("--build-quality has no effect on {}: only {} has it.", accel.name(), Accel::Wide.name()));
    }
    let has_environment = matches!(scene.appearance.background, Background::Environment(_));
    if args.light_sampling.is_some() && !has_environment && materials.iter().all(|material| material.emission.is_zero())
    {
        notes.push("--light-sampling has no effect: the scene has no area light and no environment image.".to_owned());
    }
    notes
}

/// Note about features of physically based materials that the integrator ignores.
fn simplification(scene: &Scene) -> Option<String> {
    let left_out = match scene.settings.integrator {
        Integrator::Whitted => {
            "shows physically based materials as Phong surfaces: highlights for rough reflections, no clearcoat, sheen or rough \
             glass, and the mean of roughness and metalness textures"
        }
        Integrator::Distributed => {
            "follows the reflections and refractions of physically based materials, and no light from one diffuse surface to \
             another"
        }
        Integrator::Direct => {
            "shows physically based materials in direct light only: no reflections of other surfaces, and nothing through glass"
        }
        _ => return None,
    };
    let is_physical = |material: &rt_scene_io::Material| material.is_physically_based();
    let integrator = scene.settings.integrator.name();
    let is_simplified = scene.appearance.materials.iter().any(is_physical);
    is_simplified.then(|| format!("`{integrator}` {left_out}; `path` shows them in full."))
}

fn adaptive(args: &ImageArgs, of_scene: Option<AdaptiveSampling>) -> Result<Option<AdaptiveSampling>, CliError> {
    let adaptive = match args.adaptive {
        None => of_scene,
        Some(AdaptiveChoice::Off) => None,
        Some(AdaptiveChoice::ObjectSpace) => of_scene.or(Some(AdaptiveSampling::ObjectSpace { min_spp: None })),
    };
    match (adaptive, args.min_spp) {
        (adaptive, None) => Ok(adaptive),
        (Some(AdaptiveSampling::ObjectSpace { .. }), min_spp) => Ok(Some(AdaptiveSampling::ObjectSpace { min_spp })),
        (None, Some(_)) => usage("--min-spp requires --adaptive object-space"),
    }
}

/// Tone mapping of an image without a scene.
pub(crate) fn development(args: &DevelopmentArgs) -> Development {
    let mut development = Development { dither: Some(Dither::default()), ..Development::default() };
    apply_development(args, &mut development);
    development
}

pub(crate) fn apply_development(args: &DevelopmentArgs, development: &mut Development) {
    replace(&mut development.exposure, args.exposure);
    replace(&mut development.tone, args.tone);
    if let Some(dithers) = args.dither {
        development.dither = dithers.then(|| development.dither.unwrap_or_default());
    }
}

fn replace<T>(value: &mut T, other: Option<T>) {
    if let Some(other) = other {
        *value = other;
    }
}

/// Index of the named camera; 0 by default.
fn find_camera(name: Option<&str>, scene: &Scene) -> Result<usize, CliError> {
    let Some(name) = name else { return Ok(0) };
    scene.cameras.iter().position(|camera| camera.name == name).ok_or_else(|| {
        let known = scene.cameras.iter().map(|camera| camera.name.clone()).collect();
        let unknown = LoadErrorKind::UnknownWord { kind: "camera", found: name.to_owned(), known };
        CliError::Usage(format!("--camera: {unknown}"))
    })
}

/// Removes from the notes on automatic placement of cameras what options of the camera make untrue.
fn correct_notes(args: &ViewArgs, scene: &mut Scene) {
    const PLACED: &str = "The camera has no position: ";
    const FRAMED: &str = ", and shows the whole scene.";
    let is_moved = args.look_from.is_some() || args.look_at.is_some();
    if is_moved && scene.cameras.len() == 1 {
        scene.notes.retain(|note| !note.starts_with(PLACED));
    }
    if is_moved || args.up.is_some() || args.fov.is_some() {
        for note in scene.notes.iter_mut().filter(|note| note.starts_with(PLACED)) {
            if let Some(kept) = note.strip_suffix(FRAMED) {
                *note = format!("{kept}.");
            }
        }
    }
}

fn move_camera(args: &ViewArgs, camera: &mut CameraSettings) -> Result<(), CliError> {
    if let Some(degrees) = args.fov {
        match &mut camera.projection {
            Projection::Perspective { fov, .. } => *fov = degrees.to_radians(),
            Projection::Orthographic { .. } => {
                return usage("--fov does not apply to an orthographic camera; remove it, or choose another --camera");
            }
        }
    }
    if args.look_from.is_some() || args.look_at.is_some() || args.up.is_some() {
        camera.world_from_camera = placed(args, &camera.world_from_camera)?;
        // Camera motion would start at the old position.
        camera.moves_to = None;
    }
    Ok(())
}

/// Camera pose; position and direction are kept unless given.
fn placed(args: &ViewArgs, world_from_camera: &Transform) -> Result<Transform, CliError> {
    let eye = args.look_from.unwrap_or_else(|| world_from_camera.translation());
    let target = args.look_at.unwrap_or_else(|| eye + world_from_camera.vector(DVec3::NEG_Z));
    let up = args.up.unwrap_or(DVec3::Y);
    Transform::look_at(eye, target, up).map_err(|error| {
        let [eye, target, up] = [eye, target, up].map(four_digits);
        CliError::Usage(format!(
            "the camera cannot look from {eye} at {target} with {up} up: {error}; change --look-from, --look-at or --up"
        ))
    })
}

/// Vector with four significant digits per component.
fn four_digits(vector: DVec3) -> String {
    format!("({})", vector.to_array().map(|value| short_number(value, 4)).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_have_four_digits() {
        let text = four_digits(DVec3::new(2.163_012_345, -0.001_234_56, 1e-320));
        assert_eq!(text, "(2.163, -0.001235, 1.000e-320)");
        assert_eq!(four_digits(DVec3::new(0.0, 100.0, 123_456.7)), "(0, 100, 123457)");
    }
}
