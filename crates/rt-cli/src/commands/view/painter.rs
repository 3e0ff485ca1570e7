//! The thread that renders: coarsely at first, and then finer pass by pass.

use std::time::{Duration, Instant};

use rt_image::{Development, Image};
use rt_render::{Crop, Observer, PickResult, RenderError, RenderPlan, RenderSnapshot, RunOptions, StopRule, Stopped};

use super::desk::{Desk, Order, Picture, Shot};
use super::pace::Pace;

/// Time from one picture to the next.
const INTERVAL: Duration = Duration::from_millis(50);

/// What the painter tells the window.
#[derive(Debug)]
pub(super) enum News {
    /// A picture lies on the desk.
    Painted,
    /// What the last pixel that was asked for shows; nothing for the background.
    PickResult(Option<Box<PickResult>>),
    /// A camera that nothing can be seen through.
    Refused(RenderError),
    /// The painter is gone, whatever happened.
    Gone,
}

/// Renders what the desk asks for.
pub(super) struct Painter<'a, 's, T> {
    pub(super) plan: RenderPlan<'s>,
    pub(super) desk: &'a Desk,
    /// 0 for one for each processor.
    pub(super) threads: usize,
    /// Samples of a pixel that is refined.
    pub(super) spp: u32,
    pub(super) development: Development,
    pub(super) pace: Pace,
    pub(super) tell: T,
}

impl<T: Fn(News)> Painter<'_, '_, T> {
    /// Works until the desk is closed.
    pub(super) fn work(&mut self) {
        loop {
            match self.desk.next_order() {
                Order::Close => break,
                Order::Pick(pixel) => pick(&self.plan, pixel, &self.tell),
                Order::Paint(shot) => {
                    if let Err(error) = self.paint(&shot) {
                        (self.tell)(News::Refused(error));
                    }
                }
            }
        }
    }

    fn paint(&mut self, shot: &Shot) -> Result<(), RenderError> {
        let sketch = self.sketch(shot)?;
        self.plan.look_through(&shot.camera, shot.size)?;
        let mut canvas = Canvas {
            plan: &self.plan,
            desk: self.desk,
            development: self.development,
            tell: &self.tell,
            film: sketch,
            spp: 0,
            shown: Instant::now(),
        };
        canvas.show(false);
        let run = RunOptions { threads: self.threads, interrupt: Some(self.desk.outdated()), ..RunOptions::default() };
        let rule = StopRule { max_spp: self.spp, ..StopRule::default() };
        let rendering = self.plan.render_until(&run, &rule, &mut canvas)?;
        if rendering.stopped != Stopped::Interrupted {
            (canvas.film, canvas.spp) = (rendering.film, rendering.samples_per_pixel.least);
            canvas.show(true);
        }
        Ok(())
    }

    /// The whole picture, of coarse pixels with one sample each. It is not given up for the next one, or nothing would be seen
    /// of a camera that moves all the time.
    fn sketch(&mut self, shot: &Shot) -> Result<Image, RenderError> {
        let started = Instant::now();
        let side = self.pace.coarseness(shot.size);
        self.plan.look_through(&shot.camera, shot.size.map(|length| length.div_ceil(side)))?;
        let run = RunOptions { threads: self.threads, interrupt: Some(self.desk.closed()), ..RunOptions::default() };
        let rule = StopRule { max_spp: 1, ..StopRule::default() };
        let coarse = self.plan.render_until(&run, &rule, |_: rt_render::Progress| {})?.film;
        self.pace.learn(coarse.pixels().len(), started.elapsed());
        Ok(enlarged(&coarse, side, shot.size))
    }
}

/// A picture of squares.
fn enlarged(coarse: &Image, side: u32, [width, height]: [u32; 2]) -> Image {
    let mut film = Image::new(width, height, false);
    let rows = film.pixels_mut().chunks_mut(width.max(1) as usize);
    for (y, row) in rows.enumerate() {
        let first = (y / side as usize) * coarse.width() as usize;
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = coarse.pixels()[first + x / side as usize];
        }
    }
    film
}

fn pick(plan: &RenderPlan<'_>, [x, y]: [u32; 2], tell: impl Fn(News)) {
    tell(News::PickResult(plan.pick(x, y).map(Box::new)));
}

/// A picture that tiles are painted over.
struct Canvas<'a, T> {
    plan: &'a RenderPlan<'a>,
    desk: &'a Desk,
    development: Development,
    tell: T,
    film: Image,
    /// Samples of the pixel that has fewest.
    spp: u32,
    /// When it was shown last.
    shown: Instant,
}

impl<T: Fn(News)> Canvas<'_, T> {
    fn show(&mut self, is_refined: bool) {
        self.shown = Instant::now();
        let bytes = self.development.develop_over_black(&self.film).bytes;
        let pixels = bytes.chunks_exact(3).map(|rgb| u32::from_be_bytes([0, rgb[0], rgb[1], rgb[2]])).collect();
        let size = [self.film.width(), self.film.height()];
        self.desk.hand_over(Picture { size, pixels, spp: self.spp, is_refined });
        (self.tell)(News::Painted);
    }
}

impl<T: Fn(News)> Observer for &mut Canvas<'_, T> {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        let Crop { x, y, width, .. } = so_far.tile();
        let stride = self.film.width() as usize;
        for (row, pixels) in so_far.pixels().chunks(width as usize).enumerate() {
            let first = (y as usize + row) * stride + x as usize;
            self.film.pixels_mut()[first..first + pixels.len()].copy_from_slice(pixels);
        }
        self.spp = so_far.progress().pass.map_or(0, |pass| pass.spp);
        if let Some(pixel) = self.desk.take_pick() {
            pick(self.plan, pixel, &self.tell);
        }
        if self.shown.elapsed() >= INTERVAL {
            self.show(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_pixels_are_squares() {
        let mut coarse = Image::new(2, 2, false);
        for (pixel, value) in coarse.pixels_mut().iter_mut().zip([1.0, 2.0, 3.0, 4.0]) {
            *pixel = [value; 3];
        }
        let large = enlarged(&coarse, 4, [7, 5]);
        let values: Vec<f32> = large.pixels().iter().map(|pixel| pixel[0]).collect();
        let upper = [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
        let lower = [3.0, 3.0, 3.0, 3.0, 4.0, 4.0, 4.0];
        assert_eq!(values, [upper, upper, upper, upper, lower].concat());
    }
}
