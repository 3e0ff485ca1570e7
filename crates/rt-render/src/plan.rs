//! Render plan: a scene compiled to the parts that its image depends on.

use std::{sync::OnceLock, time::Instant};

use rt_camera::{CameraSettings, SamplerKind};
use rt_scene_io::{Integrator, NamedCamera, RenderSettings, Scene};
use rt_shading::Clamp;

use crate::{
    RenderError,
    accel_choice::AccelOptions,
    compiled_scene::{CompiledScene, has_light},
    frame::{CameraView, Frame, camera_of},
    integrator::IntegratorState,
    memory::{MemoryPrediction, PerPixel},
    plan_options::PlanOptions,
    tile_layers::SurfaceFeatures,
};

/// A scene compiled for rendering, for one camera and one integrator.
#[derive(Debug)]
pub struct RenderPlan<'s> {
    pub(crate) options: PlanOptions,
    pub(crate) scene: CompiledScene<'s>,
    pub(crate) frame: Frame,
    pub(crate) integrator: IntegratorState,
    /// Name of the camera.
    pub(crate) camera_name: &'s str,
    /// Features of materials, for layers.
    pub(crate) surface_features: OnceLock<Vec<Option<SurfaceFeatures>>>,
    memory: MemoryPrediction,
    build_seconds: f64,
}

impl<'s> RenderPlan<'s> {
    /// Compiles a scene.
    ///
    /// # Errors
    /// If the camera, film or crop is unusable, an index points nowhere, groups contain themselves, an acceleration structure
    /// cannot be built, or more memory would be needed than is allowed. Each error names the object.
    pub fn compile(scene: &'s Scene, options: &PlanOptions) -> Result<Self, RenderError> {
        let camera = camera_of(scene, options.camera)?;
        Self::compile_view(scene, options, camera, [scene.film.width, scene.film.height], &camera.name)
    }

    /// Compiles a scene for a camera that need not be in the scene.
    fn compile_view(
        scene: &'s Scene,
        options: &PlanOptions,
        camera: &NamedCamera,
        size: [u32; 2],
        camera_name: &'s str,
    ) -> Result<Self, RenderError> {
        let started = Instant::now();
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
        let view = CameraView::new(scene, options, camera, size)?;
        let per_pixel = PerPixel {
            crop: view.crop,
            transparent: options.transparent,
            progressive: options.progressive,
            maps: options.maps,
            culls: !options.full && settings.integrator != Integrator::Cost,
        };
        let (memory, largest) = MemoryPrediction::of(scene, AccelOptions::new(scene, options), &per_pixel)?;
        memory.check(options.memory, largest)?;
        let compiled = CompiledScene::build(scene, options, view.space, view.static_time(), camera.medium)?;
        let frame = Frame::new(&compiled, options, view)?;
        Ok(Self {
            options: *options,
            integrator: integrator(settings, &compiled, &frame),
            scene: compiled,
            frame,
            camera_name,
            surface_features: OnceLock::new(),
            memory,
            build_seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// Replaces the camera and the size of the image, without a crop. The camera keeps its name and its medium.
    ///
    /// The image is bit-identical to that of a plan compiled with this camera in the scene. Acceleration structures are kept, so
    /// that it takes milliseconds. A change of render space (in scenes far from the origin) compiles everything again. So does a shutter
    /// that switches between a single time and an interval.
    ///
    /// # Errors
    /// Those of [`compile`](Self::compile); the plan is then unchanged.
    pub fn set_camera(&mut self, camera: &CameraSettings, size: [u32; 2]) -> Result<(), RenderError> {
        let scene = self.scene.source;
        let options = PlanOptions { crop: None, ..self.options };
        let medium = scene.cameras.get(options.camera).and_then(|before| before.medium);
        let camera = NamedCamera { name: self.camera_name.to_owned(), settings: *camera, medium };
        let view = CameraView::new(scene, &options, &camera, size)?;
        if view.space != self.scene.space || view.static_time() != self.scene.static_time {
            *self = Self::compile_view(scene, &options, &camera, size, self.camera_name)?;
            return Ok(());
        }
        self.frame = Frame::new(&self.scene, &options, view)?;
        self.integrator = integrator(&scene.settings, &self.scene, &self.frame);
        self.options = options;
        Ok(())
    }

    /// Name of the camera in the scene.
    pub const fn camera_name(&self) -> &str {
        self.camera_name
    }

    /// False if the scene has no light: no delta light and no emissive surface, and the integrator gathers no light from the
    /// background.
    pub fn has_light(&self) -> bool {
        has_light(self.scene.source, &self.scene.used_features)
    }

    /// True if a surface emits light.
    pub const fn has_emission(&self) -> bool {
        self.scene.used_features.emission
    }

    /// Samples per pixel of [`render`](Self::render), in all passes; with adaptive sampling, the largest number.
    pub const fn samples_per_pixel(&self) -> u32 {
        self.frame.pass_spp.saturating_mul(self.frame.passes)
    }

    /// Samples per pixel without an edge, with adaptive sampling in object space.
    pub fn min_samples_per_pixel(&self) -> Option<u32> {
        self.frame.simple_pass_spp.map(|spp| spp.saturating_mul(self.frame.passes))
    }

    /// Independent passes of [`render`](Self::render); a single one cannot estimate its error.
    pub const fn passes(&self) -> u32 {
        self.frame.passes
    }

    /// False if all passes are equal: fixed sample patterns without another random choice. Their error is unknown.
    pub const fn passes_differ(&self) -> bool {
        let is_fixed = matches!(self.frame.sampler, SamplerKind::Centre | SamplerKind::Grid);
        !is_fixed || self.integrator_kind().is_stochastic() || self.frame.camera.has_lens() || self.frame.has_motion
    }

    pub(crate) const fn integrator_kind(&self) -> Integrator {
        self.scene.source.settings.integrator
    }

    /// Predicted bytes of memory.
    pub const fn memory(&self) -> MemoryPrediction {
        self.memory
    }

    /// Seconds of compilation, acceleration structures included.
    pub const fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}

fn integrator(settings: &RenderSettings, scene: &CompiledScene<'_>, frame: &Frame) -> IntegratorState {
    let has_unsampled_emitters = settings.integrator == Integrator::Distributed && scene.has_unsampled_emitters();
    IntegratorState::new(settings, frame.depth_range(&scene.world.bounds()), has_unsampled_emitters)
}
