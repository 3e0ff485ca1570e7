//! Film: containers between a radiance sample and an image file.
//!
//! ```text
//!   radiance sample ──> pixel accumulator ──> film tile ──> film ──> image ──> file
//!                              f64                f32                 f32
//! ```
//!
//! | container | one per | holds |
//! |---|---|---|
//! | pixel accumulator | pixel | filtered sum of a pass (`PixelAccumulator`); mean and standard error over passes (`PixelEstimate`) |
//! | film tile | tile | radiance rounded to `f32`; optional alpha, standard errors and sample counts (`FilmTile`) |
//! | film | render | tile by tile: finished film tiles ([`Shard`](crate::Shard)); pass by pass: all pixel accumulators (`PassState`) |
//! | image | file | all pixels, row by row ([`Image`](rt_image::Image)) |
//!
//! Threads return the pixel accumulators of a tile with its counters (`TileResult`). Checkpoints are serialised films.

pub(crate) mod film_tile;
pub(crate) mod pixel_accumulator;
pub(crate) mod pixel_estimate;
pub(crate) mod tile_accumulator;
