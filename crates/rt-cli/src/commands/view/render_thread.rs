//! Rendering of views: a coarse preview at once, then pass after pass.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytesize::ByteSize;
use rt_image::Image;
use rt_render::{
    Checkpoint, CheckpointRef, Crop, ErrorEstimate, MemoryPrediction, Observer, RenderError, RenderPlan,
    RenderSnapshot, RunOptions, StopRule, Stopped,
};
use rt_scene_io::Integrator;

use super::frame_budget::FrameBudget;
use super::shared_state::{ErrorPoint, Pick, SharedState, Task, View, ViewImage};

/// Shortest and longest time from one image of a view to the next.
const INTERVAL: [Duration; 2] = [Duration::from_millis(50), Duration::from_secs(1)];

/// Share of the time since a view began that passes before its next image. Encoding images takes time from rendering.
const INTERVAL_SHARE: f64 = 0.1;

/// Least ratio of the sample counts of two points of the error plot, which bounds their number.
const ERROR_SPACING: f64 = 1.02;

/// Bytes of the copies of an image beyond those of its render. These are the canvas, the published image, and the one before it. An EXR
/// file that is encoded takes up to three more.
pub(super) fn copy_bytes([width, height]: [u32; 2], transparent: bool) -> u64 {
    const COPIES: u64 = 6;
    let channels = if transparent { 4 } else { 3 };
    u64::from(width) * u64::from(height) * channels * size_of::<f32>() as u64 * COPIES
}

/// Renderer of the views that pages want.
pub(super) struct Renderer<'a> {
    pub(super) shared: &'a SharedState,
    /// 0 for one for each processor.
    pub(super) threads: usize,
    /// Most bytes of memory.
    pub(super) memory: Option<u64>,
    /// Pixels of the image that memory was predicted for.
    pub(super) predicted_pixels: u64,
    /// True for images with an alpha channel.
    pub(super) transparent: bool,
    pub(super) budget: FrameBudget,
}

impl Renderer<'_> {
    /// Renders with the plan until a view wants another integrator, which is returned.
    pub(super) fn work(&mut self, mut plan: RenderPlan<'_>, integrator: Integrator) -> Integrator {
        loop {
            match self.shared.next_task(integrator) {
                Task::Compile(integrator) => return integrator,
                Task::Pick(view, picks) => answer(&plan, view, picks),
                Task::Render(view) => {
                    let rendered = self
                        .check_memory(&plan.memory(), view.size)
                        .and_then(|()| self.render(&mut plan, &view).map_err(|error| error.to_string()));
                    if let Err(message) = rendered {
                        self.shared.show(|state| state.message = Some(message));
                    }
                }
            }
        }
    }

    /// Refuses an image that needs more memory than is allowed.
    fn check_memory(&self, predicted: &MemoryPrediction, [width, height]: [u32; 2]) -> Result<(), String> {
        let factor = f64::from(width) * f64::from(height) / self.predicted_pixels.max(1) as f64;
        let film = (predicted.film as f64 * factor) as u64;
        let render = MemoryPrediction { film, ..*predicted }.peak();
        let needed = render.saturating_add(copy_bytes([width, height], self.transparent));
        match self.memory {
            Some(most) if needed > most => Err(format!(
                "an image of {width}x{height} needs {} of memory, above the limit of {} (raise --memory)",
                ByteSize(needed),
                ByteSize(most)
            )),
            _ => Ok(()),
        }
    }

    fn render(&mut self, plan: &mut RenderPlan<'_>, view: &View) -> Result<(), RenderError> {
        let (preview, pixel_side) = self.preview(plan, view)?;
        let film = enlarged(&preview, pixel_side, view.size);
        let image = ViewImage { view: view.number, size: view.size, pixel_side: 1, ..ViewImage::default() };
        let shown = ViewImage { film: Some(Arc::new(preview)), pixel_side, ..image.clone() };
        self.shared.show(|state| state.image = shown);
        if self.shared.is_outdated() {
            return Ok(());
        }
        plan.set_camera(&view.camera, view.size)?;
        let mut canvas = Canvas {
            plan,
            shared: self.shared,
            film,
            image,
            pass: 0,
            spent: Duration::ZERO,
            resumed: Instant::now(),
            shown: Instant::now(),
            checkpoint: None,
        };
        let run =
            RunOptions { threads: self.threads, interrupt: Some(self.shared.interrupt()), ..RunOptions::default() };
        let rule = StopRule { max_spp: view.max_spp, ..StopRule::default() };
        loop {
            canvas.resumed = Instant::now();
            let from = canvas.checkpoint.take();
            let rendering = canvas.plan.render_shard(&run, Some(&rule), from, &mut canvas)?.into_rendering();
            if rendering.stopped != Stopped::Interrupted {
                canvas.film = rendering.film;
                canvas.image.spp = rendering.samples_per_pixel.min;
                canvas.image.is_finished = true;
                canvas.add_error(rendering.error);
                canvas.publish();
                return Ok(());
            }
            canvas.spent += canvas.resumed.elapsed();
            if !self.shared.wait_for_client() {
                return Ok(());
            }
        }
    }

    /// The whole image in coarse pixels of one sample each, and their side. An outdated preview is finished as well: it shows
    /// the motion of a camera that never rests.
    fn preview(&mut self, plan: &mut RenderPlan<'_>, view: &View) -> Result<(Image, u32), RenderError> {
        let started = Instant::now();
        let pixel_side = self.budget.pixel_side(view.size);
        plan.set_camera(&view.camera, view.size.map(|length| length.div_ceil(pixel_side)))?;
        let run = RunOptions { threads: self.threads, ..RunOptions::default() };
        let rule = StopRule { max_spp: 1, ..StopRule::default() };
        let coarse = plan.render_until(&run, &rule, |_: rt_render::Progress| {})?.film;
        self.budget.learn(coarse.pixels().len(), started.elapsed());
        Ok((coarse, pixel_side))
    }
}

/// Answers picks with a plan for the view of this number.
fn answer(plan: &RenderPlan<'_>, view: u64, picks: Vec<Pick>) {
    for ([x, y], answer) in picks {
        // The page may have gone meanwhile.
        drop(answer.send((view, plan.pick(x, y))));
    }
}

/// The film enlarged to squares of pixels, and cropped to a size.
fn enlarged(coarse: &Image, side: u32, [width, height]: [u32; 2]) -> Image {
    let mut film = Image::new(width, height, coarse.alpha().is_some());
    let places = (0..height).flat_map(|y| (0..width).map(move |x| ((y / side) * coarse.width() + x / side) as usize));
    for (pixel, place) in film.pixels_mut().iter_mut().zip(places.clone()) {
        *pixel = coarse.pixels()[place];
    }
    if let (Some(large), Some(small)) = (film.alpha_mut(), coarse.alpha()) {
        large.iter_mut().zip(places).for_each(|(alpha, place)| *alpha = small[place]);
    }
    film
}

/// Image that finished tiles are copied to.
struct Canvas<'a> {
    plan: &'a RenderPlan<'a>,
    shared: &'a SharedState,
    film: Image,
    /// Data other than the film.
    image: ViewImage,
    /// Passes whose error is known.
    pass: u32,
    /// Render time before the last interruption.
    spent: Duration,
    resumed: Instant,
    shown: Instant,
    /// State of a render that was interrupted.
    checkpoint: Option<Checkpoint>,
}

impl Canvas<'_> {
    fn seconds(&self) -> f64 {
        (self.spent + self.resumed.elapsed()).as_secs_f64()
    }

    fn publish(&mut self) {
        self.shown = Instant::now();
        self.image.seconds = self.seconds();
        let shown = ViewImage { film: Some(Arc::new(self.film.clone())), ..self.image.clone() };
        self.shared.show(|state| state.image = shown);
    }

    fn add_error(&mut self, error: Option<ErrorEstimate>) {
        let Some(error) = error.filter(|error| error.relative_rmse().is_finite()) else { return };
        let ViewImage { spp, is_finished, ref mut errors, .. } = self.image;
        let last = errors.last().map_or(0.0, |point| f64::from(point.spp));
        if is_finished || f64::from(spp) >= ERROR_SPACING * last {
            errors.push(ErrorPoint { spp, rmse: error.relative_rmse(), interval: error.relative_interval() });
        }
    }
}

impl Observer for &mut Canvas<'_> {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        let Crop { x, y, width, .. } = so_far.tile();
        let (columns, stride) = (width as usize, self.film.width() as usize);
        let first = |row: usize| (y as usize + row) * stride + x as usize;
        for (row, pixels) in so_far.pixels().chunks(columns).enumerate() {
            self.film.pixels_mut()[first(row)..][..pixels.len()].copy_from_slice(pixels);
        }
        if let (Some(film), Some(alpha)) = (self.film.alpha_mut(), so_far.alpha()) {
            for (row, alpha) in alpha.chunks(columns).enumerate() {
                film[first(row)..][..alpha.len()].copy_from_slice(alpha);
            }
        }
        let progress = so_far.progress();
        let seconds = self.seconds();
        self.image.mega_rays_per_second = if seconds > 0.0 { progress.rays as f64 * 1e-6 / seconds } else { 0.0 };
        if let Some(pass) = progress.pass {
            self.image.spp = pass.spp;
            if pass.finished > self.pass {
                self.pass = pass.finished;
                self.add_error(so_far.error());
            }
        }
        answer(self.plan, self.image.view, self.shared.take_picks());
        self.shared.pause_without_client();
        let interval = Duration::from_secs_f64(seconds * INTERVAL_SHARE).clamp(INTERVAL[0], INTERVAL[1]);
        if self.shown.elapsed() >= interval && !self.shared.is_outdated() {
            self.publish();
        }
    }

    fn unfinished(&mut self, kept: &CheckpointRef<'_>) {
        // An outdated view does not go on.
        if !self.shared.is_outdated() {
            self.checkpoint = Some(kept.to_checkpoint());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_pixels_are_squares() {
        let mut coarse = Image::new(2, 2, true);
        for (index, pixel) in coarse.pixels_mut().iter_mut().enumerate() {
            *pixel = [index as f32; 3];
        }
        coarse.alpha_mut().expect("alpha").copy_from_slice(&[0.0, 0.1, 0.2, 0.3]);
        let large = enlarged(&coarse, 4, [7, 5]);
        let expected =
            [[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0].repeat(4), vec![2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0]].concat();
        let values: Vec<f32> = large.pixels().iter().map(|pixel| pixel[0]).collect();
        assert_eq!(values, expected);
        let alpha: Vec<f32> = expected.iter().map(|value| value * 0.1).collect();
        assert_eq!(large.alpha(), Some(alpha.as_slice()));
    }
}
