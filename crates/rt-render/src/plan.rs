//! The plan: a scene compiled once to what rendering needs, and no more.

use std::{borrow::Cow, time::Instant};

use rt_accel::AnyAccelerator;
use rt_accel::wide::{Quality, SimdLevel};
use rt_camera::{Camera, Filter, SamplerKind, ViewVolume};
use rt_geometry::{Shape, Spheres};
use rt_math::{DVec2, DVec3, Rgb};
use rt_scene_io::{Integrator, MaterialId, NamedCamera, Scene, Settings};
use rt_shading::{
    AmbientOcclusion, AovIntegrator, Appearance, BsdfCache, Clamp, Follows, LightSources, Material, Needs,
    PathSettings, emitter::EmitterSet,
};
use serde::{Deserialize, Serialize};

use crate::{
    RenderError, Rendering, Statistics,
    emitters::{emitters, moving_lamp},
    flatten::flatten,
    light_pass::light_sources,
    memory::{MemoryPrediction, PerPixel},
    outlook::{Outlook, Shot, Stage},
    rebase,
    structure::Wanted,
    surroundings::CameraMedium,
    trace::SphereWorld,
    visible::Visible,
    world::{Assembly, InstanceGeometry, Levels, Part},
};

/// A part of the image, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crop {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, at least 1.
    pub width: u32,
    /// Height, at least 1.
    pub height: u32,
}

/// Choices that a plan takes beside the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanOptions {
    /// Which camera of the scene to use.
    pub camera: usize,
    /// Render this part of the image only; its pixels are those of the whole image.
    pub crop: Option<Crop>,
    /// Leave the background out and record coverage in an alpha channel.
    pub transparent: bool,
    /// Radiance shown to camera rays that leave the scene, in place of its background, which goes on lighting the scene.
    /// Views of geometry or cost do without.
    pub backdrop: Option<Rgb>,
    /// Leave nothing out. The picture is the same to the bit; this is how tests prove it.
    pub full: bool,
    /// The instructions that structures use; `None` for the best that the processor has. What it does not have is
    /// replaced by what every processor has. The picture is the same to the bit.
    pub simd: Option<SimdLevel>,
    /// How much time the wide tree may take to be built. The picture is the same to the bit.
    pub quality: Quality,
    /// Most bytes of memory that the render may take. What is predicted to take more is refused before it is built; `None`
    /// for no limit.
    pub memory: Option<u64>,
    /// Whether the render will go on until something ends it, or keep maps of error and samples: more is then kept of each
    /// pixel. It matters for the prediction of memory alone.
    pub progressive: bool,
}

/// Effect of a bound on contributions of indirect light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamping {
    /// The bound, in units of radiance.
    pub bound: f64,
    /// Contributions that were scaled down to it.
    pub contributions: u64,
    /// Share of the light of the image that they lost; by this much, the picture is too dark on average.
    pub lost_share: f64,
}

/// What camera rays are asked for.
#[derive(Debug)]
pub(crate) enum View {
    Light,
    Paths(PathSettings),
    AmbientOcclusion(AmbientOcclusion),
    FirstHit(AovIntegrator),
    Cost,
}

impl View {
    /// True if it draws random numbers for more than the place in the pixel.
    pub(crate) const fn draws(&self) -> bool {
        matches!(self, Self::Paths(_) | Self::AmbientOcclusion(_))
    }

    /// How paths are followed; not at all, for views that follow none.
    pub(crate) const fn path_settings(&self) -> PathSettings {
        match self {
            Self::Paths(settings) => *settings,
            _ => PathSettings { max_depth: 0, roulette_from: 0, follows: Follows::Everything, clamp: Clamp::NONE },
        }
    }
}

/// The world on one of two forms.
#[derive(Debug)]
pub(crate) enum World {
    Spheres(SphereWorld, AnyAccelerator),
    Parts(Assembly, Levels),
}

/// A scene compiled for rendering: the camera and sampler prepared, the tree flattened to two levels, structures
/// built, and everything left out that the picture does not depend on.
#[derive(Debug)]
pub struct RenderPlan<'s> {
    pub(crate) scene: &'s Scene,
    pub(crate) options: PlanOptions,
    pub(crate) camera_name: &'s str,
    pub(crate) camera: Camera,
    pub(crate) pattern: SamplerKind,
    pub(crate) seed: u64,
    pub(crate) filter: Filter,
    pub(crate) sample_offset: DVec2,
    /// Width and height of the whole image.
    pub(crate) size: [u32; 2],
    pub(crate) crop: Crop,
    pub(crate) transparent: bool,
    /// Shown to camera rays in place of the background.
    pub(crate) backdrop: Option<Rgb>,
    /// Independent passes of a render of a fixed number of samples.
    pub(crate) passes: u32,
    /// Samples per pixel of each of them.
    pub(crate) pass_spp: u32,
    /// The same of pixels that show no edge, where pixels are told apart in object space.
    pub(crate) simple_pass_spp: Option<u32>,
    pub(crate) integrator: Integrator,
    pub(crate) view: View,
    pub(crate) depth: u32,
    pub(crate) min_contribution: f64,
    pub(crate) needs: Needs,
    pub(crate) appearance: Cow<'s, Appearance>,
    /// Lights with extent, if the integrator draws from them.
    pub(crate) emitters: EmitterSet,
    /// BSDFs that are the same everywhere, if the integrator asks for BSDFs; none in a full plan.
    pub(crate) bsdfs: BsdfCache,
    /// Lights that paths begin at, if the integrator follows any.
    pub(crate) light_sources: Option<LightSources>,
    pub(crate) world: World,
    /// What camera rays can meet, if that is much less than the world.
    pub(crate) visible: Option<Visible>,
    pub(crate) wanted: Wanted,
    /// Whether each tile looks for what its camera rays can meet.
    pub(crate) narrows: bool,
    /// The point of the scene that all coordinates are relative to.
    pub(crate) origin: DVec3,
    pub(crate) surroundings: CameraMedium,
    /// Whether the camera or an object moves while the shutter is open.
    pub(crate) moves: bool,
    /// When everything stands still, if it does.
    pub(crate) moment: Option<f64>,
    pub(crate) full: bool,
    /// True if a material in use emits light.
    has_emission: bool,
    /// True if a material in use mirrors or refracts.
    shows_background: bool,
    /// What was foreseen.
    pub(crate) memory: MemoryPrediction,
    pub(crate) build_seconds: f64,
}

impl<'s> RenderPlan<'s> {
    /// Compiles a scene.
    ///
    /// # Errors
    /// If the camera, film or crop is unusable, an index points nowhere, groups contain themselves, a structure cannot be
    /// built, or more memory would be needed than is allowed. Each error names the object.
    pub fn compile(scene: &'s Scene, options: &PlanOptions) -> Result<Self, RenderError> {
        let camera = camera_of(scene, options.camera)?;
        let shot = Shot { camera, size: [scene.film.width, scene.film.height] };
        Self::compile_shot(scene, options, &shot, &camera.name)
    }

    /// Compiles a scene for a camera that it need not contain.
    pub(crate) fn compile_shot(
        scene: &'s Scene,
        options: &PlanOptions,
        shot: &Shot<'_>,
        camera_name: &'s str,
    ) -> Result<Self, RenderError> {
        let started = Instant::now();
        let film = &scene.film;
        film.validate()?;
        let settings = &scene.settings;
        if settings.spp == 0 {
            return Err(RenderError::NoSamples);
        }
        if settings.passes == Some(0) {
            return Err(RenderError::NoPasses);
        }
        if let Some(clamp) = settings.clamp.filter(|&clamp| Clamp::new(clamp).is_none()) {
            return Err(RenderError::Clamp(clamp));
        }
        let origin = rebase::origin(scene, &shot.camera.settings);
        check_shot(scene, options, shot, origin)?;
        let wanted = Wanted { accel: settings.accel, simd: options.simd, quality: options.quality };
        let kept = PerPixel {
            crop: check_crop(options.crop, shot.size[0], shot.size[1])?,
            transparent: options.transparent,
            progressive: options.progressive,
            culls: !options.full && settings.integrator != Integrator::Cost,
        };
        let (memory, most) = MemoryPrediction::of(scene, wanted, &kept)?;
        memory.check(options.memory, most)?;
        let moment = shot.moment();
        let (mut top, mut levels) = flatten(scene, wanted, rebase::plan_from_world(origin), !options.full, moment)?;
        if let (Integrator::Distributed, Some(lamp)) = (settings.integrator, moving_lamp(scene, &top, &levels)) {
            return Err(RenderError::MovingLamp(lamp));
        }
        let emitters = if settings.integrator.samples_area_lights() {
            emitters(scene, &mut top, &mut levels)
        } else {
            EmitterSet::default()
        };
        if !options.full && settings.integrator != Integrator::Uv {
            spare_texture_coordinates(scene, &mut top, &mut levels);
        }
        let used = used_materials(scene, &top, &levels, shot.camera.medium);
        let least = needs(scene, &top, &levels, &used);
        let needs = if options.full { Needs::ALL } else { least };
        let world = if options.full { World::Parts(top, levels) } else { World::specialise(top, levels) };
        let stage = Stage { scene, options, wanted, origin, world: &world, refracts: needs.refraction };
        let outlook = Outlook::of(&stage, shot)?;
        let Outlook { camera, size, crop, visible, narrows, view, surroundings, .. } = outlook;
        let Outlook { moves, passes, pass_spp, simple_pass_spp, .. } = outlook;
        let appearance = rebase::appearance(&scene.appearance, origin);
        let bsdfs = match &view {
            View::Paths(_) if !options.full => BsdfCache::new(&appearance, |material| used[material]),
            _ => BsdfCache::default(),
        };
        let follows_light_paths = settings.integrator == Integrator::Caustics;
        let light_sources = if follows_light_paths { light_sources(&appearance, &emitters, &world) } else { None };
        Ok(Self {
            scene,
            options: *options,
            camera_name,
            pattern: settings.pattern,
            seed: settings.seed,
            filter: film.filter,
            sample_offset: film.sample_offset,
            size,
            crop,
            transparent: options.transparent,
            backdrop: options.backdrop.filter(|_| settings.integrator.follows_light()),
            passes,
            pass_spp,
            simple_pass_spp,
            integrator: settings.integrator,
            view,
            emitters,
            bsdfs,
            depth: settings.depth,
            min_contribution: settings.min_contribution,
            needs,
            appearance,
            light_sources,
            world,
            surroundings,
            moves,
            moment,
            visible,
            wanted,
            narrows,
            origin,
            full: options.full,
            has_emission: least.emission,
            shows_background: least.reflection || least.refraction,
            camera,
            memory,
            build_seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// False if nothing in the scene gives light: it has no light, no surface that emits, and a background that is black or that
    /// no surface takes light from under this integrator.
    pub fn has_light(&self) -> bool {
        let Appearance { lights, ambient, background, .. } = &self.scene.appearance;
        let gathers = self.scene.settings.integrator != Integrator::Whitted || self.shows_background;
        let has_ambient = !ambient.is_black() && !self.scene.settings.integrator.gathers_background();
        !lights.is_empty() || has_ambient || (gathers && !background.is_black()) || self.has_emission
    }

    /// Samples per pixel that [`render`](Self::render) will take: those asked for, split into passes and rounded up to what
    /// the pattern needs in each. With adaptive sampling, the most.
    pub const fn samples_per_pixel(&self) -> u32 {
        self.pass_spp.saturating_mul(self.passes)
    }

    /// Samples of pixels that show no edge, if pixels are told apart in object space.
    pub fn least_samples_per_pixel(&self) -> Option<u32> {
        self.simple_pass_spp.map(|spp| spp.saturating_mul(self.passes))
    }

    /// Independent passes that [`render`](Self::render) will take; with one, it cannot estimate its error.
    pub const fn passes(&self) -> u32 {
        self.passes
    }

    /// Bound on contributions of indirect light, if the integrator follows any and the scene sets a bound.
    pub fn clamp(&self) -> Option<f64> {
        match &self.view {
            View::Paths(PathSettings { max_depth: 1.., clamp, .. }) => clamp.bound(),
            _ => None,
        }
    }

    /// Effect of the bound on indirect light, if there is one.
    pub fn clamping(&self, rendering: &Rendering) -> Option<Clamping> {
        let bound = self.clamp()?;
        let Statistics { shading, samples, .. } = &rendering.statistics;
        let lost = Clamp::new(bound)?.lost(shading) / (*samples).max(1) as f64;
        let pixels = rendering.film.pixels();
        let sum: f64 = pixels.iter().flatten().map(|&value| f64::from(value)).sum();
        let mean = sum / (3.0 * pixels.len().max(1) as f64);
        let lost_share = if lost > 0.0 { lost / (lost + mean.max(0.0)) } else { 0.0 };
        Some(Clamping { bound, contributions: shading.clamped, lost_share })
    }

    /// False if every pass would be the same: fixed patterns, where nothing else is left to chance. Their error cannot be
    /// estimated.
    pub const fn passes_differ(&self) -> bool {
        let is_fixed = matches!(self.pattern, SamplerKind::Centre | SamplerKind::Grid);
        !is_fixed || self.integrator.is_stochastic() || self.camera.has_lens() || self.moves
    }

    /// Where the camera rays of a part of the image run.
    pub(crate) fn view_volume(&self, part: Crop) -> ViewVolume {
        view_volume(&self.camera, self.sample_offset, self.filter, part)
    }

    /// The corners of a part of the image between which its camera rays run, first the one of least coordinates.
    pub(crate) fn raster_of(&self, part: Crop) -> [DVec2; 2] {
        raster_of(self.sample_offset, self.filter, part)
    }

    /// Bytes of memory that the render takes, as they were foreseen before anything was built.
    pub const fn memory(&self) -> MemoryPrediction {
        self.memory
    }

    /// Seconds that compilation took, structures included.
    pub const fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}

impl World {
    /// The tight form for a world of nothing but spheres.
    fn specialise(top: Assembly, levels: Levels) -> Self {
        let sphere = |part: &Part| match part.geometry {
            InstanceGeometry::Shape(Shape::Sphere(sphere)) => Some(sphere),
            _ => None,
        };
        match top.parts.iter().map(sphere).collect::<Option<Vec<_>>>() {
            Some(spheres) => {
                let materials = top.parts.iter().map(|part| part.material).collect();
                let textured = top.parts.iter().map(|part| part.textured).collect();
                let some_cast_none = top.parts.iter().any(|part| !part.casts_shadow);
                let switches = top.parts.iter().map(|part| part.casts_shadow);
                let casts_shadow = if some_cast_none { switches.collect() } else { Vec::new() };
                let some_shine = top.parts.iter().any(|part| part.emitter.is_some());
                let lights = top.parts.iter().map(|part| part.emitter);
                let emitters = if some_shine { lights.collect() } else { Vec::new() };
                let spheres = Spheres::new(spheres);
                Self::Spheres(SphereWorld { spheres, materials, textured, casts_shadow, emitters }, top.structure)
            }
            None => Self::Parts(top, levels),
        }
    }
}

/// The camera with this index, if all that it refers to is there.
fn camera_of(scene: &Scene, index: usize) -> Result<&NamedCamera, RenderError> {
    let camera = scene.cameras.get(index).ok_or(RenderError::NoCamera { index, count: scene.cameras.len() })?;
    let count = scene.appearance.materials.len();
    match camera.medium {
        Some(MaterialId(index)) if index as usize >= count => {
            Err(RenderError::Dangling { object: format!("camera {}", camera.name), what: "material", index, count })
        }
        _ => Ok(camera),
    }
}

/// Pyramids are told apart where the integrator finds edges and the edges stand still, and have an apex.
pub(crate) fn check_adaptive(settings: &Settings, camera: &Camera, moves: bool) -> Result<(), RenderError> {
    match settings.adaptive {
        Some(_) if settings.integrator != Integrator::Whitted => Err(RenderError::Adaptive(settings.integrator.name())),
        Some(_) if camera.has_lens() => Err(RenderError::AdaptiveLens),
        Some(_) if moves => Err(RenderError::AdaptiveMotion),
        _ => Ok(()),
    }
}

pub(crate) fn check_crop(crop: Option<Crop>, film_width: u32, film_height: u32) -> Result<Crop, RenderError> {
    let whole = Crop { x: 0, y: 0, width: film_width, height: film_height };
    let crop = crop.unwrap_or(whole);
    let Crop { x, y, width, height } = crop;
    let inside = |at: u32, length: u32, film: u32| length > 0 && at.checked_add(length).is_some_and(|end| end <= film);
    if inside(x, width, film_width) && inside(y, height, film_height) {
        Ok(crop)
    } else {
        Err(RenderError::Crop { x, y, width, height, film_width, film_height })
    }
}

/// Checks what can be checked before anything is built.
fn check_shot(scene: &Scene, options: &PlanOptions, shot: &Shot<'_>, origin: DVec3) -> Result<(), RenderError> {
    let [width, height] = shot.size;
    check_crop(options.crop, width, height)?;
    let settings = rebase::camera(&shot.camera.settings, origin);
    let camera = Camera::new(&settings, width, height)
        .map_err(|source| RenderError::Camera { name: shot.camera.name.clone(), source })?;
    check_adaptive(&scene.settings, &camera, camera.moves())
}

/// Where the rays of a part of the image run.
pub(crate) fn view_volume(camera: &Camera, sample_offset: DVec2, filter: Filter, part: Crop) -> ViewVolume {
    let [min, max] = raster_of(sample_offset, filter, part);
    camera.view_volume(min, max)
}

/// Where the rays of a part of the image run: through its pixels, moved by the sample offset, as far around as the filter
/// reaches.
fn raster_of(sample_offset: DVec2, filter: Filter, part: Crop) -> [DVec2; 2] {
    // Raster coordinates are rounded to far less than this part of a pixel.
    const ROUNDING: f64 = 1.0 / 1024.0;
    let first = DVec2::new(f64::from(part.x), f64::from(part.y)) + sample_offset;
    let last = first + DVec2::new(f64::from(part.width - 1), f64::from(part.height - 1));
    let reach = filter.radius() + ROUNDING;
    [first - reach, last + reach]
}

/// Notes which surfaces nobody asks for their texture coordinates: those whose material has the same coefficients everywhere.
fn spare_texture_coordinates(scene: &Scene, top: &mut Assembly, levels: &mut Levels) {
    for part in top.parts.iter_mut().chain(levels.groups.iter_mut().flat_map(|group| &mut group.parts)) {
        let material = scene.appearance.materials.get(part.material as usize);
        part.textured = part.geometry.group().is_some() || material.is_none_or(Material::is_textured);
    }
}

/// Whether each material is worn by something that is really there, or fills what is around the camera.
fn used_materials(scene: &Scene, top: &Assembly, levels: &Levels, medium: Option<MaterialId>) -> Vec<bool> {
    let mut used = vec![false; scene.appearance.materials.len()];
    if let Some(MaterialId(material)) = medium {
        used[material as usize] = true;
    }
    for part in top.all_parts(levels) {
        if !matches!(part.geometry.at_rest(), InstanceGeometry::Group(..)) {
            used[part.material as usize] = true;
        }
    }
    used
}

/// What must be computed so that nothing is missed of what is really there.
fn needs(scene: &Scene, top: &Assembly, levels: &Levels, used: &[bool]) -> Needs {
    let mut casts_shadow = false;
    let mut shading_normals = false;
    for part in top.all_parts(levels) {
        casts_shadow |= part.casts_shadow;
        let mesh = match part.geometry.at_rest() {
            InstanceGeometry::Mesh(level, _) => &levels.meshes[*level as usize].mesh,
            InstanceGeometry::Facet(mesh, _) => mesh,
            _ => continue,
        };
        shading_normals |= !mesh.data().normals.is_empty();
    }
    let needs = Needs::of(&scene.appearance, |material| used[material]);
    Needs { shadows: needs.shadows && casts_shadow, shading_normals, ..needs }
}
