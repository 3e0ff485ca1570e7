//! Layers of a tile, accumulated from the hits of its camera rays.

use rt_camera::Camera;
use rt_geometry::{Hit, InteractionFlags, SurfaceInteraction};
use rt_math::{DVec3, Ray, Rgb};
use rt_shading::{Appearance, Material, MaterialEvalContext, SurfaceHit, is_inside};

use crate::{
    first_hit_layers::{FAR_DEPTH, FirstHitLayer, MAX_LAYER_SAMPLES},
    instance::Instances,
};

/// Layers of a tile. Receives the hits of all camera rays in the order of pixels and samples.
pub(crate) struct TileLayers<'a> {
    layers: &'a [FirstHitLayer],
    needs: InteractionFlags,
    context: LayerContext<'a>,
    /// Camera rays of each pixel.
    samples: Vec<u32>,
    sums: Vec<PixelSums>,
    /// Pixel of the next ray, and the number of its rays so far.
    next: (usize, u32),
}

/// Data of the scene that layers depend on.
#[derive(Clone, Copy)]
pub(crate) struct LayerContext<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) appearance: &'a Appearance,
    /// Features of materials by index.
    pub(crate) features: &'a [Option<SurfaceFeatures>],
    /// Origin of render space, in world space.
    pub(crate) origin: DVec3,
}

/// Properties of a material that layers show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceFeatures {
    albedo: Rgb,
    roughness: f64,
    /// Emitted radiance of the front and of the back.
    emission: [Rgb; 2],
}

impl SurfaceFeatures {
    /// Features of the materials of a scene; `None` for those that have textures.
    pub(crate) fn of_all(appearance: &Appearance) -> Vec<Option<Self>> {
        let anywhere = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let of = |material: &Material| (!material.is_textured()).then(|| Self::at(appearance, material, &anywhere));
        appearance.materials.iter().map(of).collect()
    }

    #[inline]
    fn at(appearance: &Appearance, material: &Material, surface: &SurfaceInteraction) -> Self {
        let at = MaterialEvalContext { textures: &appearance.textures, surface, ior: 1.0 };
        let emission = [false, true].map(|is_inside| material.emitted_radiance(at.textures, surface, is_inside));
        Self { albedo: material.albedo(&at), roughness: material.roughness(&at), emission }
    }
}

/// Sums over the samples of a pixel.
#[derive(Clone, Default)]
struct PixelSums {
    hits: u32,
    depth: f64,
    position: DVec3,
    normal: DVec3,
    geometric_normal: DVec3,
    albedo: Rgb,
    roughness: f64,
    emission: Rgb,
    uv: [f64; 2],
    /// Object, material and instance of the first sample that hit a surface, each plus one.
    ids: [u32; 3],
}

impl<'a> TileLayers<'a> {
    /// Layers of pixels with these numbers of camera rays. Without any ray, all of them miss.
    pub(crate) fn new(context: LayerContext<'a>, layers: &'a [FirstHitLayer], samples: Vec<u32>) -> Self {
        let sums = vec![PixelSums::default(); samples.len()];
        Self { layers, needs: FirstHitLayer::needs(layers), context, samples, sums, next: (0, 0) }
    }

    /// Adds the next camera rays, with their hits.
    pub(crate) fn add(&mut self, world: &Instances<'_>, rays: impl ExactSizeIterator<Item = (Ray, Option<Hit>)>) {
        let mut rest = rays;
        while let (true, Some(&samples)) = (rest.len() > 0, self.samples.get(self.next.0)) {
            let count = rest.len().min((samples - self.next.1) as usize);
            let used = count.min(MAX_LAYER_SAMPLES.saturating_sub(self.next.1) as usize);
            let sums = &mut self.sums[self.next.0];
            for (ray, hit) in rest.by_ref().take(used) {
                let Some(hit) = hit else { continue };
                // The surface is large, and not moved.
                if let Some(surface) = &world.surface(&ray, &hit, self.needs) {
                    sums.add(&self.context, &ray, surface);
                    if sums.hits == 1 {
                        let [object, instance] = world.ids(&hit).unwrap_or([u32::MAX; 2]);
                        sums.ids = [object, surface.material, instance].map(|id| id.saturating_add(1));
                    }
                }
            }
            if count > used {
                rest.nth(count - used - 1);
            }
            self.next.1 += count as u32;
            if self.next.1 == samples {
                self.next = (self.next.0 + 1, 0);
            }
        }
    }

    /// Channels of all layers, each with a value per pixel.
    pub(crate) fn channels(&self) -> Vec<Vec<f32>> {
        let channels = self.layers.iter().flat_map(|&layer| (0..layer.channels().len()).map(move |at| (layer, at)));
        let value = |(sums, samples): (&PixelSums, &u32), layer, at| {
            sums.value(self.context.origin, (*samples).min(MAX_LAYER_SAMPLES), layer, at)
        };
        channels
            .map(|(layer, at)| self.sums.iter().zip(&self.samples).map(|of| value(of, layer, at)).collect())
            .collect()
    }
}

impl PixelSums {
    fn add(&mut self, context: &LayerContext<'_>, ray: &Ray, surface: &SurfaceHit) {
        let interaction = &surface.interaction;
        self.hits += 1;
        self.depth += surface.t * ray.direction.dot(context.camera.view_axis_at(ray.time));
        self.position += interaction.point;
        let is_inside = is_inside(ray.direction, interaction);
        let towards_viewer = if is_inside { -1.0 } else { 1.0 };
        self.normal += interaction.shading_normal * towards_viewer;
        self.geometric_normal += interaction.geometric_normal * towards_viewer;
        self.uv[0] += interaction.uv[0];
        self.uv[1] += interaction.uv[1];
        let appearance = context.appearance;
        let material = surface.material as usize;
        let here = || Some(SurfaceFeatures::at(appearance, appearance.materials.get(material)?, interaction));
        if let Some(features) = context.features.get(material).copied().flatten().or_else(here) {
            self.albedo += features.albedo;
            self.roughness += features.roughness;
            self.emission += features.emission[usize::from(is_inside)];
        }
    }

    /// Value of a channel; `samples` are all that were taken.
    fn value(&self, origin: DVec3, samples: u32, layer: FirstHitLayer, channel: usize) -> f32 {
        if self.hits == 0 {
            return if layer == FirstHitLayer::Depth { FAR_DEPTH } else { 0.0 };
        }
        let n = f64::from(self.hits);
        let unit = |normal: DVec3| normal.normalize_or_zero().to_array()[channel];
        let value = match layer {
            FirstHitLayer::Depth => self.depth / n,
            FirstHitLayer::Position => (self.position / n + origin).to_array()[channel],
            FirstHitLayer::Normal => unit(self.normal),
            FirstHitLayer::GeometricNormal => unit(self.geometric_normal),
            FirstHitLayer::Albedo => self.albedo.to_array()[channel] / n,
            FirstHitLayer::Roughness => self.roughness / n,
            FirstHitLayer::Emission => self.emission.to_array()[channel] / n,
            FirstHitLayer::Uv if channel < 2 => self.uv[channel] / n,
            FirstHitLayer::ObjectId => f64::from(self.ids[0]),
            FirstHitLayer::MaterialId => f64::from(self.ids[1]),
            FirstHitLayer::InstanceId => f64::from(self.ids[2]),
            FirstHitLayer::Uv | FirstHitLayer::Coverage => n / f64::from(samples),
        };
        value as f32
    }
}
