//! Layers of tiles that have none after a render, with camera rays of their own.

use rt_geometry::{HitStream, RayKind};
use rt_shading::StreamQueries;

use crate::{
    RenderError, RenderPlan, Rendering,
    first_hit_layers::{FilmLayers, FirstHitLayer, LayerValues, MAX_LAYER_SAMPLES, TileChannel},
    frustum_cull::PrimaryTarget,
    parallel_for::{parallel_for, thread_count},
    passes::PassSpec,
    primary_rays::PrimaryRayBatch,
    tile::tiles,
    tile_job::TileJob,
    tile_layers::{LayerContext, SurfaceFeatures, TileLayers},
    tracer::SceneTracer,
    work_probe::WorkProbe,
};

impl RenderPlan<'_> {
    /// Computes layers of all pixels in the crop, in the order of the request, on `threads` threads or on all processors for 0.
    ///
    /// A pixel has the samples that an image of `spp` samples per pixel starts with, at most [`MAX_LAYER_SAMPLES`].
    ///
    /// # Errors
    /// [`RenderError::LostTiles`] after a panic, which only a defect can cause.
    pub fn first_hit_layers(
        &self,
        layers: &[FirstHitLayer],
        spp: u32,
        threads: usize,
    ) -> Result<Vec<LayerValues>, RenderError> {
        if layers.is_empty() {
            return Ok(Vec::new());
        }
        let mut film = FilmLayers::new(self.frame.crop, layers, spp == self.samples_per_pixel());
        self.fill(&mut film, spp, threads)?;
        Ok(film.values())
    }

    /// Computes the [layers](Rendering::layers) of rendered tiles that have none. These are all tiles of a render pass by pass,
    /// and otherwise those from a checkpoint. Unfinished tiles of an interrupted render stay zero, as in the image.
    ///
    /// # Errors
    /// [`RenderError::LostTiles`] after a panic, which only a defect can cause.
    pub fn complete_layers(&self, rendering: &mut Rendering, threads: usize) -> Result<(), RenderError> {
        match &mut rendering.layers {
            Some(layers) => self.fill(layers, rendering.samples_per_pixel.max, threads),
            None => Ok(()),
        }
    }

    /// Data of the scene that layers depend on.
    pub(crate) fn layer_context(&self) -> LayerContext<'_> {
        let appearance = &self.scene.source.appearance;
        LayerContext {
            camera: &self.frame.camera,
            view_axis: self.frame.camera.view_axis(),
            appearance,
            features: self.surface_features.get_or_init(|| SurfaceFeatures::of_all(appearance)),
            origin: self.scene.space.origin(),
            lanes: self.scene.accel.lane_level(),
        }
    }

    fn fill(&self, film: &mut FilmLayers, spp: u32, threads: usize) -> Result<(), RenderError> {
        let pass_spec = if film.is_fixed() {
            self.frame.all_passes()
        } else {
            let spp = self.frame.sampler.round_up(spp.min(MAX_LAYER_SAMPLES));
            PassSpec { first: 0, count: 1, spp, simple_spp: None, pixels: None }
        };
        let (layers, tiles) = (film.layers().to_vec(), tiles(self.frame.crop));
        let trace = |batch: &mut PrimaryRayBatch, number: usize| {
            let job = TileJob::new(tiles[number], &pass_spec, None);
            Some(self.trace_layers(&job, &layers, batch))
        };
        let missing = film.missing_tiles();
        let finished = |number: usize, channels| film.insert(tiles[number], channels);
        let outcome = parallel_for(thread_count(threads), &missing, None, (PrimaryRayBatch::default, trace), finished);
        if outcome.lost.is_empty() { Ok(()) } else { Err(RenderError::LostTiles(outcome.lost.len())) }
    }

    /// Channels of the layers of a tile, from the first camera rays of its pixels.
    fn trace_layers(
        &self,
        job: &TileJob<'_>,
        layers: &[FirstHitLayer],
        batch: &mut PrimaryRayBatch,
    ) -> Vec<TileChannel> {
        let (world, accelerator) = (&self.scene.world.instances(), &self.scene.world.top.accelerator);
        let pass_spec = job.pass_spec;
        let simple = pass_spec.simple_spp.map(|_| self.simple_pixels(job.tile, world, accelerator));
        let job = &TileJob { simple: simple.as_ref(), ..*job };
        let samples = |pixel| job.samples_of(pixel).min(MAX_LAYER_SAMPLES);
        let mut tracer = SceneTracer::new(world, accelerator, PrimaryTarget::All(accelerator), WorkProbe::default());
        let samples_of_pixels = job.tile.pixels().map(samples).collect();
        tracer.layers = Some(TileLayers::new(self.layer_context(), layers, samples_of_pixels));
        let mut hits = HitStream::default();
        let mut trace = |batch: &mut PrimaryRayBatch| {
            tracer.closest_stream(batch.rays(), RayKind::Primary, &mut hits);
            batch.clear();
        };
        for pixel in job.tile.pixels() {
            let (spp, mut left) = (job.spp_of(pixel), samples(pixel));
            for pass in 0..pass_spec.count {
                let count = left.min(spp);
                left -= count;
                if batch.free_slots() < count as usize {
                    trace(batch);
                }
                let sampler = self.frame.pass_sampler(pass_spec.first + pass, spp);
                self.generate(&sampler, pixel, 0, count as usize, batch);
                if left == 0 {
                    break;
                }
            }
        }
        trace(batch);
        tracer.layers.map(|layers| layers.channels()).unwrap_or_default()
    }
}
