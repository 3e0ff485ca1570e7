//! Adaptive sampling in object space: the objects in the pyramid of a pixel determine its number of samples.
//!
//! Source: Genetti, Gordon and Williams, "Adaptive Supersampling in Object Space Using Pyramidal Rays", 1998.
//!
//! ```text
//!            pixel          object          shaft to the light
//!              ▕╲             ╱▏ ________·
//!     eye ·    ▕ ╲___________╱ ▏‾        ·  light           few samples if nothing else can be in either
//!              ▕╱           ╲ ▏
//! ```
//!
//! The test is conservative: a pixel takes all samples if its pyramid *can* contain an edge of an object or a shadow. Objects
//! smaller than the distance of samples are found as well. Blocks of pixels are tested together and subdivided into quarters,
//! from 16 × 16 pixels down to one.
//!
//! Blocks are aligned to a grid of the whole image. The test depends only on the bounds and forms of primitives. Its result is
//! independent of threads, accelerators and crops.

mod patch;
mod shaft;

use core::ops::ControlFlow;

use rt_accel::{Accelerator as _, AnyAccelerator};
use rt_camera::ViewVolume;
use rt_geometry::{Hit, Primitives as _, padded_bounds};
use rt_math::{Interval, Ray};
use rt_shading::{Background, Material};

use patch::SurfacePatch;
use shaft::{LightShaft, Occlusion};

use crate::{
    Crop, RenderPlan, camera_medium::CameraMedium, frustum_cull::FrustumRegion, instance::Instances, passes::PixelMask,
    primitive_form::PrimitiveForm,
};

/// Side of the largest blocks, in pixels.
const LARGEST_BLOCK: u32 = 16;

/// Maximum number of objects in a largest block. With more, all of its pixels take all samples.
const MAX_BLOCK_OBJECTS: usize = 1024;

/// Maximum number of objects in a block for the visibility test. With more, the block is subdivided.
const MAX_CANDIDATES: usize = 8;

/// Square block of pixels, aligned to a multiple of its side.
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

/// Object in a pyramid, with the hits of the rays along the edges.
struct PyramidHit {
    index: u32,
    form: PrimitiveForm,
    hits: [Option<Hit>; 4],
}

/// Classifier of the pixels of a tile: simple ones have no edge.
struct PixelClassifier<'a> {
    plan: &'a RenderPlan<'a>,
    world: &'a Instances<'a>,
    accelerator: &'a AnyAccelerator,
    tile: Crop,
    simple: Vec<bool>,
}

impl RenderPlan<'_> {
    /// Pixels of a tile without an edge: they show one evenly lit smooth surface, or only the background.
    pub(crate) fn simple_pixels(&self, tile: Crop, world: &Instances<'_>, accelerator: &AnyAccelerator) -> PixelMask {
        let simple = vec![false; tile.width as usize * tile.height as usize];
        let mut classifier = PixelClassifier { plan: self, world, accelerator, tile, simple };
        if matches!(&self.frame.medium, CameraMedium::Constant(interior) if interior.is_empty()) {
            PixelBlock::around(tile).for_each(|block| classifier.classify(block));
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
    /// Largest blocks that overlap the tile.
    fn around(tile: Crop) -> impl Iterator<Item = Self> {
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

    /// Pixels of the block within the tile.
    fn within(self, tile: Crop) -> impl Iterator<Item = [u32; 2]> {
        let common = |first: u32, start: u32, length: u32| first.max(start)..(first + self.side).min(start + length);
        let (columns, rows) = (common(self.x, tile.x, tile.width), common(self.y, tile.y, tile.height));
        rows.flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }
}

impl Pyramid {
    /// True only if no ray of the pyramid hits the primitive.
    fn misses(&self, world: &Instances<'_>, index: u32) -> bool {
        match world.form(index) {
            PrimitiveForm::Sphere { centre, radius } => self.volume.excludes_sphere(centre, radius),
            _ => padded_bounds(world, index).is_some_and(|own| self.volume.excludes(&own)),
        }
    }

    fn hit_by_edges(&self, world: &Instances<'_>, index: u32) -> PyramidHit {
        let hits = self.edges.map(|ray| world.intersect(index, &ray, Interval::FORWARD));
        PyramidHit { index, form: world.form(index), hits }
    }
}

impl PyramidHit {
    /// True for a plane that no ray of the pyramid hits. Inverse depth is a linear function of raster coordinates: if it is
    /// negative at all corners, it is negative everywhere.
    fn is_out_of_sight(&self) -> bool {
        matches!(self.form, PrimitiveForm::Plane { .. }) && self.hits.iter().all(Option::is_none)
    }

    /// True if the patch occludes the whole primitive.
    fn is_behind(&self, world: &Instances<'_>, volume: &ViewVolume, patch: &SurfacePatch, front: &Self) -> bool {
        match self.form {
            // Over the image, inverse depth is concave for the patch and linear for a plane.
            PrimitiveForm::Plane { .. } => {
                let is_deeper = |(hit, front): (&Option<Hit>, &Option<Hit>)| match (hit, front) {
                    (Some(hit), Some(front)) => hit.t > front.t,
                    (None, _) => true,
                    (Some(_), None) => false,
                };
                self.hits.iter().zip(&front.hits).all(is_deeper)
            }
            PrimitiveForm::Sphere { centre, radius } => volume.min_depth_of_sphere(centre, radius) > patch.farthest,
            PrimitiveForm::Flat | PrimitiveForm::Faces | PrimitiveForm::Other => {
                padded_bounds(world, self.index).is_some_and(|own| volume.min_depth(&own) > patch.farthest)
            }
        }
    }
}

impl PixelClassifier<'_> {
    /// Classifies the pixels of a largest block.
    fn classify(&mut self, block: PixelBlock) {
        let pyramid = self.plan.pyramid(block);
        let mut near = Vec::new();
        let mut are_many = false;
        self.accelerator.visit_overlapping(self.world, &FrustumRegion(&pyramid.volume), |index| {
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

    /// Classifies the pixels of a block, recursively. `among` are the indices of all objects that it can show, ascending.
    fn divide(&mut self, block: PixelBlock, pyramid: &Pyramid, among: &[u32]) {
        if block.within(self.tile).next().is_none() {
            return;
        }
        let near: Vec<u32> = among.iter().copied().filter(|&index| !pyramid.misses(self.world, index)).collect();
        if self.is_simple(pyramid, &near) {
            let Crop { x: left, y: top, width, .. } = self.tile;
            for [x, y] in block.within(self.tile) {
                self.simple[((y - top) * width + x - left) as usize] = true;
            }
        } else if block.side > 1 {
            for quarter in block.quarters() {
                self.divide(quarter, &self.plan.pyramid(quarter), &near);
            }
        }
    }

    /// True if the pyramid contains one evenly lit smooth surface, or only the background.
    fn is_simple(&self, pyramid: &Pyramid, near: &[u32]) -> bool {
        if near.len() > MAX_CANDIDATES {
            return false;
        }
        let mut hits: Vec<PyramidHit> = near.iter().map(|&index| pyramid.hit_by_edges(self.world, index)).collect();
        hits.retain(|hit| !hit.is_out_of_sight());
        if hits.is_empty() {
            return !matches!(self.plan.scene.appearance.background, Background::Environment(_));
        }
        let depth = |object: &PyramidHit| object.hits[0].map(|hit| hit.t);
        let nearest = hits
            .iter()
            .filter(|hit| depth(hit).is_some())
            .min_by(|a, b| depth(a).partial_cmp(&depth(b)).unwrap_or(core::cmp::Ordering::Equal));
        let Some(front) = nearest else { return false };
        let patch = SurfacePatch::new(self.world, front.index, &pyramid.edges, &front.hits);
        patch.is_some_and(|patch| {
            let is_hidden = |other: &PyramidHit| other.is_behind(self.world, &pyramid.volume, &patch, front);
            hits.iter().all(|hit| hit.index == front.index || is_hidden(hit)) && self.is_evenly_lit(&patch)
        })
    }

    /// True if the patch has no edge of a shadow, and no light varies much over it.
    fn is_evenly_lit(&self, patch: &SurfacePatch) -> bool {
        let appearance = &self.plan.scene.appearance;
        let Some(material) = patch.plain_material(appearance) else { return false };
        let phong = &material.to_phong();
        if phong.diffuse.is_zero() && phong.specular.is_zero() {
            return true;
        }
        let attenuates =
            |material: u32| appearance.materials.get(material as usize).is_some_and(Material::attenuates_shadow_rays);
        let mut reaching = appearance.lights.iter().filter(|light| !patch.turns_away_from(light));
        // Test shafts last: they cost most, and most blocks that are too large fail before.
        reaching.clone().all(|light| patch.is_even_under(light, phong))
            && reaching.all(|light| {
                let shaft = LightShaft::new(patch, light);
                !light.casts_shadows
                    || shaft.occluded(self.world, self.accelerator, (patch.index, &attenuates)) != Occlusion::Somewhere
            })
    }
}
