//! The loop over tiles, pixels and samples.

use std::{
    sync::{
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    time::Instant,
};

use rt_camera::Film;
use rt_math::{Counters, Rgb};
use rt_scene_io::Integrator;
use rt_shading::{FirstHitView, ShadingCounts};

use crate::{
    Crop, RenderError, RenderPlan, Statistics,
    plan::View,
    tile::{Finished, Worker},
    tiles::{Tile, tiles},
};

/// How to run a plan; none of it changes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits as well as rays.
    pub count: bool,
}

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Camera samples in all.
    pub total_samples: u64,
    /// Rays traced so far, of all kinds.
    pub rays: u64,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture, in linear radiance.
    pub film: Film,
    /// What it took.
    pub statistics: Statistics,
}

impl RenderPlan<'_> {
    /// Renders the picture. `progress` is called on this thread after each tile.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started.
    pub fn render(&self, options: &RunOptions, mut progress: impl FnMut(Progress)) -> Result<Rendering, RenderError> {
        let started = Instant::now();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
        let crop = self.crop;
        let tiles = tiles(crop.x, crop.y, crop.width, crop.height);
        let mut film = Film::new(crop.width, crop.height, self.transparent);
        let mut statistics = Statistics {
            samples: 0,
            counters: Counters::default(),
            primary_rays_spared: 0,
            shading: ShadingCounts::default(),
            bad_samples: 0,
            threads: pool.current_num_threads(),
            build_seconds: self.build_seconds,
            render_seconds: 0.0,
        };
        let total_samples = u64::from(crop.width) * u64::from(crop.height) * u64::from(self.spp);
        let (sender, finished) = mpsc::channel();
        let next = AtomicUsize::new(0);
        // Tiles are rendered in the pool while this thread puts them in their places.
        pool.in_place_scope(|scope| {
            for sender in vec![sender; statistics.threads] {
                let (tiles, next) = (&tiles, &next);
                scope.spawn(move |_| self.work(tiles, next, &sender, options.count));
            }
            for tile in finished {
                self.expose(&mut film, &tile);
                statistics.counters += tile.counters;
                statistics.primary_rays_spared += tile.primary_rays_spared;
                statistics.shading += tile.shading;
                statistics.bad_samples += tile.bad_samples;
                statistics.samples += tile.pixels.len() as u64 * u64::from(self.spp);
                let rays = statistics.counters.total().rays;
                progress(Progress { samples: statistics.samples, total_samples, rays });
            }
        });
        statistics.render_seconds = started.elapsed().as_secs_f64();
        Ok(Rendering { film, statistics })
    }

    /// What one thread does: the next tile that nobody has begun, until there is none.
    fn work(&self, tiles: &[Tile], next: &AtomicUsize, sender: &mpsc::Sender<Finished>, count: bool) {
        let mut worker = Worker::new(self);
        while let Some(tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
            // The receiver outlives this loop, so that sending cannot fail.
            let _ = sender.send(self.render_tile(*tile, count, &mut worker));
        }
    }

    /// The radiance of one pixel as it is before the film rounds it to `f32`; (`x`, `y`) counts from the upper left
    /// corner of the whole image. `None` outside of what the plan renders.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let Crop { x: left, y: top, width, height } = self.crop;
        let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
        let tile = Tile { x, y, width: 1, height: 1 };
        if inside { self.render_tile(tile, false, &mut Worker::new(self)).pixels.first().copied() } else { None }
    }

    /// Rounds a tile to what the film holds, in its place.
    fn expose(&self, film: &mut Film, finished: &Finished) {
        let Tile { x, y, width, height } = finished.tile;
        let stride = film.width() as usize;
        for row in 0..height as usize {
            let at = (y - self.crop.y) as usize * stride + row * stride + (x - self.crop.x) as usize;
            let from = row * width as usize;
            for (place, radiance) in film.pixels_mut()[at..at + width as usize].iter_mut().zip(&finished.pixels[from..])
            {
                *place = radiance.to_array().map(|c| c as f32);
            }
            if let Some(alpha) = film.alpha_mut() {
                for (place, coverage) in alpha[at..at + width as usize].iter_mut().zip(&finished.alpha[from..]) {
                    *place = *coverage as f32;
                }
            }
        }
    }
}

impl View {
    /// What the integrator of the settings looks at.
    pub(crate) fn new(integrator: Integrator, near: f64, far: f64) -> Self {
        match integrator {
            Integrator::Whitted => Self::Light,
            Integrator::Normals => Self::FirstHit(FirstHitView::Normals),
            Integrator::Depth => Self::FirstHit(FirstHitView::Depth { near, far }),
            Integrator::Uv => Self::FirstHit(FirstHitView::Uv),
            Integrator::Cost => Self::Cost,
        }
    }
}
