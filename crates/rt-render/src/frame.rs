//! Camera-dependent part of a plan: film, sampler and background of one frame.
//!
//! ```text
//!   compile               scene ──────────> CompiledScene ──┐
//!                                                           ├──> RenderPlan
//!   compile, set_camera   camera, film ──> Frame ───────────┘
//! ```

use rt_camera::{Camera, FilmSettings, Filter, PixelSampler, SampleStream, SamplerKind, ViewVolume};
use rt_math::{Aabb, DVec2, Rgb, Sampler};
use rt_scene_io::{Accel, Integrator, MaterialId, NamedCamera, RenderSettings, Scene};

use crate::{
    Crop, RenderError, RenderSpace,
    camera_medium::CameraMedium,
    compiled_scene::CompiledScene,
    frustum_cull::VisibleSet,
    passes::{PassSpec, default_passes, pass_seed},
    plan_options::PlanOptions,
};

/// Validated camera in render space, with the size and crop of its image.
#[derive(Debug)]
pub(crate) struct CameraView<'a> {
    /// In world space.
    pub(crate) named: &'a NamedCamera,
    pub(crate) camera: Camera,
    /// Width and height of the whole image in pixels.
    size: [u32; 2],
    pub(crate) crop: Crop,
    pub(crate) space: RenderSpace,
}

impl<'a> CameraView<'a> {
    pub(crate) fn new(
        scene: &Scene,
        options: &PlanOptions,
        named: &'a NamedCamera,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        let [width, height] = size;
        FilmSettings { width, height, ..scene.film }.validate()?;
        let crop = check_crop(options.crop, width, height)?;
        let space = RenderSpace::of(scene, &named.settings);
        let camera = Camera::new(&space.camera(&named.settings), width, height)
            .map_err(|source| RenderError::Camera { name: named.name.clone(), source })?;
        check_adaptive(&scene.settings, &camera, camera.moves())?;
        Ok(Self { named, camera, size, crop, space })
    }

    /// Time of the exposure, if the shutter opens for a single time.
    pub(crate) fn static_time(&self) -> Option<f64> {
        let [opens, closes] = self.named.settings.shutter;
        (opens == closes).then_some(opens)
    }
}

/// Camera, film, sampler and background of an image.
#[derive(Debug)]
pub(crate) struct Frame {
    pub(crate) camera: Camera,
    /// Dielectrics around the camera.
    pub(crate) medium: CameraMedium,
    /// Width and height of the whole image.
    pub(crate) size: [u32; 2],
    pub(crate) crop: Crop,
    pub(crate) filter: Filter,
    pub(crate) sample_offset: DVec2,
    pub(crate) sampler: SamplerKind,
    pub(crate) seed: u64,
    /// Independent passes of a render with a fixed number of samples.
    pub(crate) passes: u32,
    /// Samples per pixel of each pass.
    pub(crate) pass_spp: u32,
    /// Samples per pass of pixels without an edge, with adaptive sampling in object space.
    pub(crate) simple_pass_spp: Option<u32>,
    pub(crate) transparent: bool,
    /// Radiance of camera rays that hit nothing, instead of the background.
    pub(crate) backdrop: Option<Rgb>,
    /// Objects in view, if these are much fewer than all.
    pub(crate) visible: Option<VisibleSet>,
    /// True if each tile culls objects by its own view volume.
    pub(crate) culls_tiles: bool,
    /// True if the camera or an object moves while the shutter is open.
    pub(crate) has_motion: bool,
}

impl Frame {
    pub(crate) fn new(
        compiled: &CompiledScene<'_>,
        options: &PlanOptions,
        view: CameraView<'_>,
    ) -> Result<Self, RenderError> {
        let CompiledScene { source: scene, world, .. } = compiled;
        let CameraView { named, camera, size, crop, .. } = view;
        let (settings, integrator) = (&scene.settings, scene.settings.integrator);
        let has_motion = camera.moves() || world.has_motion();
        check_adaptive(settings, &camera, has_motion)?;
        let medium = if integrator.follows_light() && compiled.features.refraction {
            CameraMedium::of(named, &camera, has_motion, scene, world)
        } else {
            CameraMedium::air()
        };
        let stochastic = integrator.is_stochastic() || camera.has_lens() || has_motion;
        let passes = settings.passes.unwrap_or_else(|| default_passes(settings.pattern, settings.spp, stochastic));
        let pass_spp = |spp: u32| settings.pattern.round_up(spp.div_ceil(passes));
        let simple_spp = settings.adaptive.map(|adaptive| adaptive.simple_spp(settings.spp).min(settings.spp));
        // The cost view shows the work of the whole acceleration structure; a moving camera has many view volumes.
        let may_cull = !options.full && integrator != Integrator::Cost && !camera.moves();
        let mut frame = Self {
            camera,
            medium,
            size,
            crop,
            filter: scene.film.filter,
            sample_offset: scene.film.sample_offset,
            sampler: settings.pattern,
            seed: settings.seed,
            passes,
            pass_spp: pass_spp(settings.spp),
            simple_pass_spp: simple_spp.map(pass_spp),
            transparent: options.transparent,
            backdrop: options.backdrop.filter(|_| integrator.follows_light()),
            visible: None,
            culls_tiles: may_cull && compiled.accel.accel == Accel::Auto,
            has_motion,
        };
        if may_cull {
            let volume = frame.view_volume(crop);
            let visible = VisibleSet::build(compiled.accel, &world.instances(), &volume);
            frame.visible = visible.map_err(|source| RenderError::Build { object: scene.name.clone(), source })?;
        }
        Ok(frame)
    }

    pub(crate) fn pass_sampler(&self, pass: u32, spp: u32) -> PixelSampler {
        PixelSampler::new(self.sampler, spp, pass_seed(self.seed, pass))
    }

    /// All passes of a render with a fixed number of samples.
    pub(crate) const fn all_passes(&self) -> PassSpec<'static> {
        PassSpec { first: 0, count: self.passes, spp: self.pass_spp, simple_spp: self.simple_pass_spp, pixels: None }
    }

    /// Time of a sample; uses a random number only in scenes with motion.
    pub(crate) fn sample_time(&self, sample: &mut SampleStream) -> f64 {
        if self.has_motion { self.camera.shutter_time(sample.next_1d()) } else { 0.0 }
    }

    /// View volume of a rectangle of the image.
    pub(crate) fn view_volume(&self, part: Crop) -> ViewVolume {
        let [min, max] = self.raster_bounds(part);
        self.camera.view_volume(min, max)
    }

    /// Lower and upper corner of the raster positions sampled by a rectangle of the image. Pixels are shifted by the sample offset
    /// and padded by the filter radius.
    pub(crate) fn raster_bounds(&self, part: Crop) -> [DVec2; 2] {
        // Exceeds the rounding error of raster coordinates, in pixels.
        const ROUNDING: f64 = 1.0 / 1024.0;
        let first = DVec2::new(f64::from(part.x), f64::from(part.y)) + self.sample_offset;
        let last = first + DVec2::new(f64::from(part.width - 1), f64::from(part.height - 1));
        let padding = self.filter.radius() + ROUNDING;
        [first - padding, last + padding]
    }

    /// Nearest and farthest depth of a box, along the view axis.
    pub(crate) fn depth_range(&self, bounds: &Aabb) -> [f64; 2] {
        if bounds.is_empty() {
            return [0.0, 1.0];
        }
        let depths = bounds.corners().map(|corner| self.camera.depth(corner));
        let near = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
        let far = depths.into_iter().fold(0.0, f64::max);
        if near < far { [near, far] } else { [near, near + 1.0] }
    }
}

/// Camera of a scene by index, if its medium exists.
pub(crate) fn camera_of(scene: &Scene, index: usize) -> Result<&NamedCamera, RenderError> {
    let camera = scene.cameras.get(index).ok_or(RenderError::NoCamera { index, count: scene.cameras.len() })?;
    let count = scene.appearance.materials.len();
    match camera.medium {
        Some(MaterialId(index)) if index as usize >= count => {
            Err(RenderError::Dangling { object: format!("camera {}", camera.name), what: "material", index, count })
        }
        _ => Ok(camera),
    }
}

/// Checks that adaptive sampling in object space applies: to an integrator with edges, without motion or a lens.
fn check_adaptive(settings: &RenderSettings, camera: &Camera, has_motion: bool) -> Result<(), RenderError> {
    match settings.adaptive {
        Some(_) if settings.integrator != Integrator::Whitted => Err(RenderError::Adaptive(settings.integrator.name())),
        Some(_) if camera.has_lens() => Err(RenderError::AdaptiveLens),
        Some(_) if has_motion => Err(RenderError::AdaptiveMotion),
        _ => Ok(()),
    }
}

fn check_crop(crop: Option<Crop>, film_width: u32, film_height: u32) -> Result<Crop, RenderError> {
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
