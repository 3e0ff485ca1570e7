//! Adaptive sampling in object space (Genetti, Gordon and Williams, "Adaptive Supersampling in Object Space Using Pyramidal
//! Rays", 1998): what lies in the pyramid between the eye and a pixel decides how many samples the pixel takes.
//!
//! ```text
//!            pixel          object          shaft to the light
//!              ▕╲             ╱▏ ________·
//!     eye ·    ▕ ╲___________╱ ▏‾        ·  light           few samples if nothing else can be in either
//!              ▕╱           ╲ ▏
//! ```
//!
//! Nothing is looked at through samples, so that nothing is so small that it falls between them: a pixel in which an edge of an
//! object, or of a shadow, *can* be takes all samples. Like pyramidal rays, the squares of pixels that are looked at
//! together are cut in four where they show more than one thing; here from 16 × 16 pixels down to one.
//!
//! Squares lie on a grid of the whole image, and what is found in them depends on boxes and forms alone, so that a pixel is
//! judged the same by each thread, with each structure, and in each part of the image.

mod patch;
mod shaft;

use core::ops::ControlFlow;

use rt_accel::{Accelerator as _, AnyAccelerator};
use rt_camera::ViewVolume;
use rt_geometry::{Hit, padded_bounds};
use rt_math::{Interval, Ray};
use rt_shading::Background;

use patch::SurfacePatch;
use shaft::{LightShaft, Occlusion};

use crate::{
    Crop, RenderPlan, camera_medium::CameraMedium, frustum_cull::FrustumRegion, passes::PixelMask,
    primitive_form::PrimitiveForm, tiles::Tile, world::ShadedPrimitives,
};

/// Pixels along the side of the squares that are looked at first.
const LARGEST_BLOCK: u32 = 16;

/// Objects in a largest square with which it is worth looking for pixels that show but one of them.
const MAX_BLOCK_OBJECTS: usize = 1024;

/// Objects in a square with which it is worth asking which of them is in front.
const MAX_CANDIDATES: usize = 8;

/// Some pixels, at a multiple of their side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PixelBlock {
    x: u32,
    y: u32,
    side: u32,
}

/// View volume of a block of pixels, and the rays along its edges.
struct Pyramid {
    volume: ViewVolume,
    edges: [Ray; 4],
}

/// An object in a pyramid, where it meets the rays along the edges.
struct PyramidHit {
    index: u32,
    form: PrimitiveForm,
    hits: [Option<Hit>; 4],
}

/// The pixels of a tile being judged.
struct PixelClassifier<'a, W> {
    plan: &'a RenderPlan<'a>,
    world: &'a W,
    structure: &'a AnyAccelerator,
    tile: Tile,
    simple: Vec<bool>,
}

impl RenderPlan<'_> {
    /// The pixels of a tile that show a single smooth surface, or nothing, in light without edges.
    pub(crate) fn simple_pixels<W: ShadedPrimitives>(
        &self,
        tile: Tile,
        world: &W,
        structure: &AnyAccelerator,
    ) -> PixelMask {
        let simple = vec![false; tile.width as usize * tile.height as usize];
        let mut classifier = PixelClassifier { plan: self, world, structure, tile, simple };
        if matches!(&self.frame.medium, CameraMedium::Constant(interior) if interior.is_empty()) {
            PixelBlock::around(tile).for_each(|block| classifier.look_into(block));
        }
        PixelMask::new(tile, classifier.simple)
    }

    fn pyramid(&self, block: PixelBlock) -> Pyramid {
        let PixelBlock { x, y, side } = block;
        let part = Crop { x, y, width: side, height: side };
        let [min, max] = self.frame.raster_bounds(part);
        let corners = [min, min.with_x(max.x), max, min.with_y(max.y)];
        Pyramid {
            volume: self.frame.view_volume(part),
            edges: corners.map(|corner| self.frame.camera.ray(corner, 0.0)),
        }
    }
}

impl PixelBlock {
    /// The largest squares that have a pixel in common with the tile.
    fn around(tile: Tile) -> impl Iterator<Item = Self> {
        let starts = |first: u32, length: u32| {
            (first / LARGEST_BLOCK * LARGEST_BLOCK..first + length).step_by(LARGEST_BLOCK as usize)
        };
        starts(tile.y, tile.height)
            .flat_map(move |y| starts(tile.x, tile.width).map(move |x| Self { x, y, side: LARGEST_BLOCK }))
    }

    fn quarters(self) -> [Self; 4] {
        let side = self.side / 2;
        [(0, 0), (side, 0), (0, side), (side, side)].map(|(x, y)| Self { x: self.x + x, y: self.y + y, side })
    }

    /// The pixels of the tile that lie in the square.
    fn within(self, tile: Tile) -> impl Iterator<Item = [u32; 2]> {
        let common = |first: u32, start: u32, length: u32| first.max(start)..(first + self.side).min(start + length);
        let (columns, rows) = (common(self.x, tile.x, tile.width), common(self.y, tile.y, tile.height));
        rows.flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }
}

impl Pyramid {
    /// True only if no ray of the pyramid meets the primitive.
    fn passes_by<W: ShadedPrimitives>(&self, world: &W, index: u32) -> bool {
        match world.form(index) {
            PrimitiveForm::Sphere { centre, radius } => self.volume.excludes_ball(centre, radius),
            _ => padded_bounds(world, index).is_some_and(|own| self.volume.excludes(&own)),
        }
    }

    fn meet<W: ShadedPrimitives>(&self, world: &W, index: u32) -> PyramidHit {
        let hits = self.edges.map(|ray| world.intersect(index, &ray, Interval::FORWARD));
        PyramidHit { index, form: world.form(index), hits }
    }
}

impl PyramidHit {
    /// True for a plane that is behind the horizon all over the pyramid: depth is the inverse of a linear function of the image,
    /// which is negative everywhere if at the corners.
    fn is_out_of_sight(&self) -> bool {
        matches!(self.form, PrimitiveForm::Plane { .. }) && self.hits.iter().all(Option::is_none)
    }

    /// True if the patch hides all of the primitive.
    fn is_behind<W: ShadedPrimitives>(
        &self,
        world: &W,
        volume: &ViewVolume,
        patch: &SurfacePatch,
        front: &Self,
    ) -> bool {
        match self.form {
            // The inverse of the patch's depth is concave over the image, and that of a plane is linear.
            PrimitiveForm::Plane { .. } => {
                let is_deeper = |(own, front): (&Option<Hit>, &Option<Hit>)| match (own, front) {
                    (Some(own), Some(front)) => own.t > front.t,
                    (None, _) => true,
                    (Some(_), None) => false,
                };
                self.hits.iter().zip(&front.hits).all(is_deeper)
            }
            PrimitiveForm::Sphere { centre, radius } => volume.least_depth_of_ball(centre, radius) > patch.farthest,
            PrimitiveForm::Flat | PrimitiveForm::Faces | PrimitiveForm::Other => {
                padded_bounds(world, self.index).is_some_and(|own| volume.least_depth(&own) > patch.farthest)
            }
        }
    }
}

impl<W: ShadedPrimitives> PixelClassifier<'_, W> {
    /// Judges the pixels of one of the largest squares.
    fn look_into(&mut self, block: PixelBlock) {
        let pyramid = self.plan.pyramid(block);
        let mut near = Vec::new();
        let mut are_many = false;
        self.structure.visit_overlapping(self.world, &FrustumRegion(&pyramid.volume), |index| {
            are_many = near.len() == MAX_BLOCK_OBJECTS;
            if are_many {
                return ControlFlow::Break(());
            }
            near.push(index);
            ControlFlow::Continue(())
        });
        if !are_many {
            near.sort_unstable();
            self.divide(block, &pyramid, &near);
        }
    }

    /// Judges the pixels of a square that shows no other objects than these, in the order of their numbers.
    fn divide(&mut self, block: PixelBlock, pyramid: &Pyramid, among: &[u32]) {
        if block.within(self.tile).next().is_none() {
            return;
        }
        let near: Vec<u32> = among.iter().copied().filter(|&index| !pyramid.passes_by(self.world, index)).collect();
        if self.is_simple(pyramid, &near) {
            let Tile { x: left, y: top, width, .. } = self.tile;
            for [x, y] in block.within(self.tile) {
                self.simple[((y - top) * width + x - left) as usize] = true;
            }
        } else if block.side > 1 {
            for quarter in block.quarters() {
                self.divide(quarter, &self.plan.pyramid(quarter), &near);
            }
        }
    }

    /// True if the pyramid shows one smooth surface, or nothing, and light without edges.
    fn is_simple(&self, pyramid: &Pyramid, near: &[u32]) -> bool {
        if near.len() > MAX_CANDIDATES {
            return false;
        }
        let mut met: Vec<PyramidHit> = near.iter().map(|&index| pyramid.meet(self.world, index)).collect();
        met.retain(|met| !met.is_out_of_sight());
        if met.is_empty() {
            return !matches!(self.plan.scene.appearance.background, Background::Environment(_));
        }
        let depth = |met: &PyramidHit| met.hits[0].map(|hit| hit.t);
        let nearest = met
            .iter()
            .filter(|met| depth(met).is_some())
            .min_by(|a, b| depth(a).partial_cmp(&depth(b)).unwrap_or(core::cmp::Ordering::Equal));
        let Some(front) = nearest else { return false };
        let patch = SurfacePatch::new(self.world, front.index, &pyramid.edges, &front.hits);
        patch.is_some_and(|patch| {
            let is_hidden = |other: &PyramidHit| other.is_behind(self.world, &pyramid.volume, &patch, front);
            met.iter().all(|met| met.index == front.index || is_hidden(met)) && self.is_evenly_lit(&patch)
        })
    }

    /// True if no light, and no shadow, changes much over the patch.
    fn is_evenly_lit(&self, patch: &SurfacePatch) -> bool {
        let appearance = &self.plan.scene.appearance;
        let Some(material) = patch.plain_material(appearance) else { return false };
        let phong = &material.to_phong();
        if phong.diffuse.is_zero() && phong.specular.is_zero() {
            return true;
        }
        let mut reaching = appearance.lights.iter().filter(|light| !patch.turns_away_from(light));
        // Shafts take longest, and most squares that are too large fail before.
        reaching.clone().all(|light| patch.is_even_under(light, phong))
            && reaching.all(|light| {
                let shaft = LightShaft::new(patch, light);
                !light.casts_shadows || shaft.blocked(self.world, self.structure, patch.index) != Occlusion::Somewhere
            })
    }
}
