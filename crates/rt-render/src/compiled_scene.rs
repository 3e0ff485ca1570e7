//! Camera-independent part of a plan: world, materials and lights.

use std::borrow::Cow;

use rt_scene_io::{Integrator, MaterialId, Scene};
use rt_shading::{Appearance, BsdfCache, LightSources, Lighting, Material, ShadingFeatures, light::LightSet};

use crate::{
    RenderError, RenderSpace,
    accel_choice::AccelOptions,
    area_lights::has_unsampled_emitters,
    flatten::flatten,
    instance::{Aggregate, BottomLevel, InstanceGeometry},
    light_set::light_set,
    light_sources::light_sources,
    plan_options::PlanOptions,
    world::World,
};

/// Scene with acceleration structures, trimmed to the parts that its image depends on.
#[derive(Debug)]
pub(crate) struct CompiledScene<'s> {
    pub(crate) source: &'s Scene,
    pub(crate) space: RenderSpace,
    /// Time of the only position of all objects, if the shutter opens for a single time.
    pub(crate) static_time: Option<f64>,
    pub(crate) accel: AccelOptions,
    pub(crate) world: World,
    /// Materials, textures and delta lights, in render space. `whitted` takes its lights from here.
    pub(crate) appearance: Cow<'s, Appearance>,
    /// All lights, if the integrator samples area lights.
    pub(crate) lights: LightSet,
    /// BSDFs of uniform materials, if the integrator evaluates BSDFs; empty in an untrimmed plan.
    pub(crate) bsdfs: BsdfCache,
    /// Lights that light tracing starts from, if the integrator traces light.
    pub(crate) light_sources: Option<LightSources>,
    pub(crate) features: ShadingFeatures,
    /// Features of the materials in use, also in an untrimmed plan.
    pub(crate) used_features: ShadingFeatures,
}

impl<'s> CompiledScene<'s> {
    /// Flattens a scene and builds its acceleration structures. `medium` surrounds the camera.
    pub(crate) fn build(
        source: &'s Scene,
        options: &PlanOptions,
        space: RenderSpace,
        static_time: Option<f64>,
        medium: Option<MaterialId>,
    ) -> Result<Self, RenderError> {
        let integrator = source.settings.integrator;
        let accel = AccelOptions::new(source, options);
        let (mut top, mut levels) = flatten(source, accel, space.render_from_world(), !options.full, static_time)?;
        let appearance = space.appearance(&source.appearance);
        let lights = if integrator.samples_area_lights() {
            light_set(source, &appearance, &mut top, &mut levels)
        } else {
            LightSet::default()
        };
        if !options.full && integrator != Integrator::Uv {
            mark_textured(source, &mut top, &mut levels);
        }
        let used = used_materials(source, &top, &levels, medium);
        let used_features = features(source, &top, &levels, &used);
        let world = World { top, levels };
        // The reference leaves out no feature of shading, so that a comparison with `path` tests what `path` leaves out.
        let trims_shading = !options.full && integrator != Integrator::PathReference;
        let bsdfs = if integrator.samples_area_lights() && trims_shading {
            BsdfCache::new(&appearance, |material| used[material])
        } else {
            BsdfCache::default()
        };
        let light_sources = match integrator {
            Integrator::Caustics => light_sources(&appearance, &lights, &world),
            _ => None,
        };
        Ok(Self {
            source,
            space,
            static_time,
            accel,
            world,
            appearance,
            lights,
            bsdfs,
            light_sources,
            features: if trims_shading { used_features } else { ShadingFeatures::ALL },
            used_features,
        })
    }

    /// True if the world has an emitter that is not sampled.
    pub(crate) fn has_unsampled_emitters(&self) -> bool {
        has_unsampled_emitters(self.source, &self.world.top, &self.world.levels)
    }

    /// Materials and lights for integrators that sample lights.
    pub(crate) fn lighting(&self) -> Lighting<'_> {
        Lighting { appearance: &self.appearance, lights: &self.lights, bsdfs: &self.bsdfs }
    }
}

/// False if a scene has no light: no delta light and no emissive surface, and the integrator gathers no light from the background.
/// `used` are the features of the materials of its objects.
pub fn has_light(scene: &Scene, used: &ShadingFeatures) -> bool {
    let Appearance { lights, ambient, background, .. } = &scene.appearance;
    let integrator = scene.settings.integrator;
    let gathers = integrator != Integrator::Whitted || used.reflection || used.refraction;
    let has_ambient = !ambient.is_black() && !integrator.gathers_background();
    !lights.is_empty() || has_ambient || (gathers && !background.is_black()) || used.emission
}

/// Marks the instances whose texture coordinates are used: those with a textured material.
fn mark_textured(scene: &Scene, top: &mut Aggregate, levels: &mut BottomLevel) {
    for instance in top.instances.iter_mut().chain(levels.groups.iter_mut().flat_map(|group| &mut group.instances)) {
        let material = scene.appearance.materials.get(instance.material as usize);
        instance.textured = instance.geometry.group().is_some() || material.is_none_or(Material::is_textured);
    }
}

/// For each material a flag: an object in the world has it, or it fills the space around the camera.
fn used_materials(scene: &Scene, top: &Aggregate, levels: &BottomLevel, medium: Option<MaterialId>) -> Vec<bool> {
    let mut used = vec![false; scene.appearance.materials.len()];
    if let Some(MaterialId(material)) = medium {
        used[material as usize] = true;
    }
    for instance in top.all_instances(levels) {
        if !matches!(instance.geometry.static_geometry(), InstanceGeometry::Group(..)) {
            used[instance.material as usize] = true;
        }
    }
    used
}

/// Features of shading that objects in the world use.
fn features(scene: &Scene, top: &Aggregate, levels: &BottomLevel, used: &[bool]) -> ShadingFeatures {
    let mut casts_shadow = false;
    let mut shading_normals = false;
    for instance in top.all_instances(levels) {
        casts_shadow |= instance.casts_shadow;
        let mesh = match instance.geometry.static_geometry() {
            InstanceGeometry::Mesh(level, _) => &levels.meshes[*level as usize].mesh,
            InstanceGeometry::Triangle(triangle) => &triangle.mesh,
            _ => continue,
        };
        shading_normals |= !mesh.data().normals.is_empty();
    }
    let features = ShadingFeatures::of(&scene.appearance, |material| used[material]);
    // Media dim shadow rays, too.
    casts_shadow |= scene.appearance.has_shadow_media(&features);
    ShadingFeatures { shadows: features.shadows && casts_shadow, shading_normals, ..features }
}
