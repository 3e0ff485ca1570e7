//! From the types of the file to the scene: names become ids, degrees radians, references files, and all values are
//! checked.

mod animation;
mod area_light;
mod camera;
mod camera_pose;
mod defaults;
mod film;
mod group;
mod include;
mod lens;
mod light;
mod material;
mod material_model;
mod models;
mod node;
mod settings;
mod shape;
mod shutter;
mod texture;
mod transform;
mod tree_size;
mod value;

use std::path::Path;

use rt_math::Aabb;
use rt_shading::{Appearance, Texture};

use crate::bounds::tree_bounds;
use crate::format::SceneFile;
use crate::scene::{is_emissive, used_materials};
use crate::{Integrator, KnownMean, LoadError, LoadOptions, Material, Model, Scene, StudioLights, format};
use defaults::SceneLighting;
pub(crate) use defaults::{EffectiveFields, rounded};
pub(crate) use material_model::{written_material, written_phong};
use models::Models;
use node::Objects;
use shutter::{is_animated, key_times};

/// Resolves a scene that was read from `source`. References to files are relative to it.
///
/// # Errors
/// All errors of the scene and of the files that it refers to, each with its path in the document.
pub fn resolve(file: &SceneFile, source: &Path, options: &LoadOptions) -> Result<Scene, LoadError> {
    resolve_with(file, source, options, None).map(|(scene, _)| scene)
}

/// Version of [`resolve`] with a model that is loaded already, under its reference. Also returns the fields of the file as they
/// were used.
pub(crate) fn resolve_with(
    file: &SceneFile,
    source: &Path,
    options: &LoadOptions,
    model: Option<(String, Model)>,
) -> Result<(Scene, EffectiveFields), LoadError> {
    let options = options.rooted_at(source);
    let mut fields = EffectiveFields::new(file, &options);
    let models = Models::at_hand(model);
    let Objects {
        mut report, mut materials, mut textures, meshes, groups, mut nodes, media, mut notes, shutter, ..
    } = Objects::resolve(file, &fields.cameras, source, &options, models);
    nodes.extend(area_light::nodes(&mut report, fields.lights.as_deref().unwrap_or_default(), &mut materials));
    let bounds = match options.at_time {
        Some(_) if fields.needs_bounds() => bounds_at_rest(file, &fields.cameras, source, &options),
        _ => tree_bounds(&nodes, &groups, &meshes),
    };
    let used = used_materials(groups.iter().map(|group| &*group.nodes).chain([&*nodes]));
    let used: Vec<&Material> = used.iter().filter_map(|id| materials.list.get(*id as usize)).collect();
    let has_emissive = used.iter().any(|material| is_emissive(material, &textures.list));
    let has_layers = used.iter().any(|material| material.model.has_layers());
    let default_integrator = default_integrator(file, (&used, &textures.list), &options);
    let set = file.settings.integrator.unwrap_or(default_integrator);
    let integrator = match options.integrator {
        Some(integrator) => integrator,
        None if options.has_environment && set == Integrator::Whitted => Integrator::Path,
        None => set,
    };
    notes.extend(fields.fill(&mut report, &bounds, SceneLighting { integrator, has_emissive, has_layers }, &options));
    key_times(file).for_each(|time| options.animation_end.extend(time));
    if options.at_time.is_none() && is_animated(file) {
        notes.push("The scene is animated: it is shown at 0 s.".to_owned());
    }

    let (lights, ambient) = light::lights(&mut report, fields.lights.as_deref().unwrap_or_default());
    let background = light::background(&mut report, fields.background.as_ref(), &mut textures);
    let film = film::film(&mut report, &fields.film);
    let cameras = camera::cameras(&mut report, &fields.cameras, &film, &media, &shutter);
    let settings = settings::settings(&mut report, &file.settings, default_integrator, &options);
    let is_chosen = options.integrator.is_none() && file.settings.integrator.is_none();
    if is_chosen && settings.integrator != Integrator::Whitted {
        notes.push(format!(
            "The integrator is `{}`, because the scene has an area light, an emissive object, an environment image, or a material \
             other than `phong`.",
            settings.integrator.name()
        ));
    }
    let truth = file.truth.as_ref().and_then(|truth| {
        let mean = report.check("truth.mean", value::colour(&truth.mean))?;
        Some(KnownMean { mean, note: truth.note.clone(), size: file.film.size.into() })
    });
    let stem = || source.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let name = file.name.clone().unwrap_or_else(stem);
    let mut warnings = file.warnings.clone();
    warnings.extend(report.finish()?);
    let appearance = Appearance { materials: materials.list, textures: textures.list, lights, ambient, background };
    let shutter_interval = shutter.part();
    let camera_fields = fields.cameras.iter().map(|(_, camera)| camera.clone()).collect();
    let scene = Scene {
        name,
        cameras,
        camera_fields,
        film,
        settings,
        appearance,
        meshes,
        groups,
        nodes,
        truth,
        shutter_interval,
        warnings,
        notes,
    };
    Ok((scene, fields))
}

/// Bounds of a scene over all times. So the default camera, which shows the whole scene, does not shake from one frame
/// of an animation to the next.
fn bounds_at_rest(
    file: &SceneFile,
    cameras: &[(String, format::Camera)],
    source: &Path,
    options: &LoadOptions,
) -> Aabb {
    let options = LoadOptions { at_time: None, ..options.clone() };
    let Objects { nodes, groups, meshes, .. } = Objects::resolve(file, cameras, source, &options, Models::default());
    tree_bounds(&nodes, &groups, &meshes)
}

/// Path tracing for light that `whitted` lacks: area lights, environment images, physically based materials. Without
/// `lights` in the scene, physically based materials of models and emissive objects count too. `used` are the materials of all
/// objects.
fn default_integrator(
    file: &SceneFile,
    (used, textures): (&[&Material], &[Texture]),
    options: &LoadOptions,
) -> Integrator {
    let has_studio = options.studio_lights == StudioLights::Studio;
    let needs_path =
        |material: &&Material| material.is_physically_based() || (is_emissive(material, textures) && !has_studio);
    let is_unspecified = file.lights.is_none() && used.iter().any(needs_path);
    let lights = file.lights.as_deref().unwrap_or_default();
    let is_physical = lights.iter().any(area_light::is_area_light)
        || matches!(file.background, Some(format::Background::Image { .. }))
        || file.materials().any(|material| !matches!(material, format::Material::Phong { .. }))
        || is_unspecified;
    if is_physical { Integrator::Path } else { Integrator::Whitted }
}
