//! The command line has the last word: options laid over what the scene says.

use std::sync::Arc;

use rt_camera::{CameraSettings, Projection};
use rt_image::Development;
use rt_math::{DVec3, Rgb, Transform};
use rt_render::PlanOptions;
use rt_scene_io::{
    Adaptive, Background, InMemoryFile, Integrator, LoadErrorKind, LoadOptions, Scene, read_environment,
};

use crate::args::{AdaptiveChoice, BackgroundChoice, DevelopmentArgs, PictureArgs, ViewArgs};
use crate::error::Failure;
use crate::stdin::{self, is_dash};

/// Applies the options to the scene, which was loaded with others; those that are no part of a scene are returned.
pub(crate) fn apply(args: &PictureArgs, loaded: &LoadOptions, scene: &mut Scene) -> Result<PlanOptions, Failure> {
    let film = &mut scene.film;
    [film.width, film.height] = args.size.unwrap_or([film.width, film.height]);
    let settings = &mut scene.settings;
    replace(&mut settings.spp, args.spp);
    settings.passes = args.passes.or(settings.passes);
    settings.adaptive = adaptive(args, settings.adaptive)?;
    replace(&mut settings.depth, args.depth);
    replace(&mut settings.seed, args.seed);
    settings.clamp = args.clamp.or(settings.clamp);
    replace(&mut settings.integrator, args.integrator);
    replace(&mut settings.pattern, args.sampler);
    replace(&mut settings.accel, args.accel);
    replace(&mut settings.light_sampling, args.light_sampling);
    if args.integrator.is_some_and(|integrator| !integrator.follows_light()) {
        // The scene's exposure and tone curve suit its light, which such a view does not show.
        let Development { encoding, .. } = film.development;
        film.development = Development { encoding, ..Development::default() };
    }
    let colour = match args.background {
        Some(BackgroundChoice::Colour(colour)) => Some(colour),
        _ => None,
    };
    if let (Some(colour), None) = (colour, &args.env) {
        scene.appearance.background = Background::Constant(colour);
    }
    if let Some(file) = &args.env {
        if is_dash(file) && loaded.in_memory.is_some() {
            return Err(Failure::Usage(
                "standard input is one file: the scene and --env cannot both come from it".to_owned(),
            ));
        }
        let piped = if is_dash(file) { Some(stdin::content(loaded.max_file_bytes)?) } else { None };
        let in_memory = piped.map(|bytes| InMemoryFile { path: file.clone(), bytes });
        let light = read_environment(file, Rgb::WHITE, 0.0, &LoadOptions { in_memory, ..loaded.clone() });
        let light = light.map_err(|reason| Failure::from(reason.at(file, "")))?;
        scene.appearance.background = Background::Environment(Arc::new(light));
        if args.integrator.is_none() && scene.settings.integrator == Integrator::Whitted {
            scene.settings.integrator = Integrator::Path;
        }
    }
    if args.integrator.is_some() {
        let simplification = simplification(scene);
        scene.notes.extend(simplification);
    }
    let camera = find_camera(args.view.camera.as_deref(), scene)?;
    if let Some(camera) = scene.cameras.get_mut(camera) {
        move_camera(&args.view, &mut camera.settings)?;
    }
    Ok(PlanOptions {
        camera,
        crop: args.crop,
        transparent: args.background == Some(BackgroundChoice::Transparent),
        backdrop: colour.filter(|_| args.env.is_some()),
        full: args.full_plan,
        simd: args.simd,
        quality: args.quality.unwrap_or_default(),
        memory: loaded.memory.limit(),
        progressive: false,
    })
}

/// What the integrator leaves out of physically based materials, as a note.
fn simplification(scene: &Scene) -> Option<String> {
    let left_out = match scene.settings.integrator {
        Integrator::Whitted => {
            "shows physically based materials as Phong surfaces: highlights for rough reflections, no coat, sheen or rough \
             glass, and the mean of roughness and metalness textures"
        }
        Integrator::Distributed => {
            "follows the reflections and refractions of physically based materials, and no light from one diffuse surface to \
             another"
        }
        Integrator::Direct => {
            "shows physically based materials in the light of lamps and the background alone: no surface is seen in \
             another, and nothing through glass"
        }
        _ => return None,
    };
    let is_physical = |material: &rt_scene_io::Material| material.has_physical_surface();
    let integrator = scene.settings.integrator.name();
    let is_simplified = scene.appearance.materials.iter().any(is_physical);
    is_simplified.then(|| format!("`{integrator}` {left_out}; `path` shows them in full."))
}

/// What the options make of the scene's adaptive sampling.
fn adaptive(args: &PictureArgs, of_scene: Option<Adaptive>) -> Result<Option<Adaptive>, Failure> {
    let adaptive = match args.adaptive {
        None => of_scene,
        Some(AdaptiveChoice::Off) => None,
        Some(AdaptiveChoice::ObjectSpace) => of_scene.or(Some(Adaptive::ObjectSpace { least: None })),
    };
    match (adaptive, args.least) {
        (adaptive, None) => Ok(adaptive),
        (Some(Adaptive::ObjectSpace { .. }), least) => Ok(Some(Adaptive::ObjectSpace { least })),
        (None, Some(_)) => {
            Err(Failure::Usage("--least is for --adaptive object-space, which is not asked for".to_owned()))
        }
    }
}

/// Applies the options to how the film is developed.
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

/// The index of the camera of this name; the first by default.
fn find_camera(name: Option<&str>, scene: &Scene) -> Result<usize, Failure> {
    let Some(name) = name else { return Ok(0) };
    scene.cameras.iter().position(|camera| camera.name == name).ok_or_else(|| {
        let known = scene.cameras.iter().map(|camera| camera.name.clone()).collect();
        Failure::Usage(LoadErrorKind::UnknownWord { kind: "camera", found: name.to_owned(), known }.to_string())
    })
}

fn move_camera(args: &ViewArgs, camera: &mut CameraSettings) -> Result<(), Failure> {
    if let Some(degrees) = args.fov {
        match &mut camera.projection {
            Projection::Perspective { fov, .. } => *fov = degrees.to_radians(),
            Projection::Orthographic { .. } => {
                let message = "--fov does not fit this camera: it is orthographic; leave --fov out, or choose another";
                return Err(Failure::Usage(message.to_owned()));
            }
        }
    }
    if args.look_from.is_some() || args.look_at.is_some() || args.up.is_some() {
        camera.world_from_camera = placed(args, &camera.world_from_camera)?;
        // The way that it would take starts elsewhere.
        camera.moves_to = None;
    }
    Ok(())
}

/// What the options leave open, the camera keeps: its place, and the direction that it looks in.
fn placed(args: &ViewArgs, world_from_camera: &Transform) -> Result<Transform, Failure> {
    let eye = args.look_from.unwrap_or_else(|| world_from_camera.translation());
    let target = args.look_at.unwrap_or_else(|| eye + world_from_camera.vector(DVec3::NEG_Z));
    let up = args.up.unwrap_or(DVec3::Y);
    Transform::look_at(eye, target, up).map_err(|error| {
        Failure::Usage(format!(
            "the camera cannot look from {eye} at {target} with {up} up: {error}; change --look-from, --look-at or --up"
        ))
    })
}
