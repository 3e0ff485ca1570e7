//! Layers of a tile, accumulated from the hits of its camera rays.

use core::ops::Range;

use rt_camera::Camera;
use rt_geometry::{Hit, HitStream, InteractionFlags, RayStream, SurfaceInteraction};
use rt_math::{DVec3, Ray, Rgb};
use rt_shading::{Appearance, LaneLevel, Material, MaterialEvalContext, SurfacePoint, surface_points};

use crate::{
    first_hit_layers::{FAR_DEPTH, FirstHitLayer, MAX_LAYER_SAMPLES, TileChannel},
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
    /// Direction of view of a camera at rest.
    pub(crate) view_axis: DVec3,
    pub(crate) appearance: &'a Appearance,
    /// Features of materials by index.
    pub(crate) features: &'a [Option<SurfaceFeatures>],
    /// Origin of render space, in world space.
    pub(crate) origin: DVec3,
    /// Instructions for surfaces in lanes.
    pub(crate) lanes: Option<LaneLevel>,
}

impl LayerContext<'_> {
    /// Depth of a ray at the parameter 1.
    #[inline(always)]
    fn depth_of(&self, ray: &Ray) -> f64 {
        let axis = if self.camera.moves() { self.camera.view_axis_at(ray.time) } else { self.view_axis };
        ray.direction.dot(axis)
    }
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

    /// Adds the camera rays of a stream, with their hits.
    pub(crate) fn add_stream(&mut self, world: &Instances<'_>, rays: &RayStream, hits: &HitStream) {
        let mut first = 0;
        while first < rays.len() {
            let Some((pixel, count, used)) = self.take(rays.len() - first) else { return };
            self.add_samples(world, (rays, hits), first..first + used, pixel);
            first += count;
        }
    }

    /// Adds a camera ray, with its hit.
    pub(crate) fn add(&mut self, world: &Instances<'_>, ray: &Ray, hit: Option<&Hit>) {
        if let Some((pixel, _, 1)) = self.take(1)
            && let Some(hit) = hit
        {
            self.add_hit(world, ray, hit, pixel);
        }
    }

    /// Counts up to `limit` camera rays as those of the next pixel. Returns the pixel, their number, and how many of these the layers
    /// use. `None` if no pixel is left.
    fn take(&mut self, limit: usize) -> Option<(usize, usize, usize)> {
        while self.samples.get(self.next.0)? == &self.next.1 {
            self.next = (self.next.0 + 1, 0);
        }
        let (pixel, so_far) = self.next;
        let count = limit.min((self.samples[pixel] - so_far) as usize);
        let used = count.min(MAX_LAYER_SAMPLES.saturating_sub(so_far) as usize);
        self.next.1 += count as u32;
        Some((pixel, count, used))
    }

    /// Adds camera rays of a pixel. Surfaces without textures are computed in lanes, and all others one by one.
    fn add_samples(
        &mut self,
        world: &Instances<'_>,
        (rays, hits): (&RayStream, &HitStream),
        range: Range<usize>,
        pixel: usize,
    ) {
        let features = self.context.features;
        let plain = |ids| {
            let material = world.untextured_material(ids)?;
            Some((material, features.get(material as usize)?.as_ref()?))
        };
        let ids = |at| [hits.instance.get(at), hits.primitive.get(at)];
        let shape = |at| {
            let is_plain = hits.primitive.get(at) != HitStream::NONE && plain(ids(at)).is_some();
            if is_plain { Some(world.stream_primitive(ids(at))?.shape) } else { None }
        };
        surface_points(self.context.lanes, (rays, hits), range, shape, |at, surface| {
            let Some(hit) = hits.get(at) else { return };
            let (ray, _) = rays.get(at);
            match (surface, plain(ids(at))) {
                (Some(surface), Some((material, features))) => {
                    let sums = &mut self.sums[pixel];
                    let is_inside = sums.add(surface, [0.0; 2], &ray, hit.t * self.context.depth_of(&ray));
                    sums.add_features(features, is_inside);
                    sums.set_ids(world, &hit, material);
                }
                _ => self.add_hit(world, &ray, &hit, pixel),
            }
        });
    }

    /// Adds a hit of a camera ray.
    fn add_hit(&mut self, world: &Instances<'_>, ray: &Ray, hit: &Hit, pixel: usize) {
        // The surface is large, and not moved.
        let Some(surface) = &world.surface(ray, hit, self.needs) else { return };
        let (context, sums) = (&self.context, &mut self.sums[pixel]);
        let SurfaceInteraction { point, geometric_normal, shading_normal, uv, .. } = surface.interaction;
        let at = SurfacePoint { point, geometric_normal, shading_normal };
        let is_inside = sums.add(&at, uv, ray, surface.t * context.depth_of(ray));
        let (appearance, material) = (context.appearance, surface.material as usize);
        if let Some(Some(features)) = context.features.get(material) {
            sums.add_features(features, is_inside);
        } else if let Some(material) = appearance.materials.get(material) {
            sums.add_features(&SurfaceFeatures::at(appearance, material, &surface.interaction), is_inside);
        }
        sums.set_ids(world, hit, surface.material);
    }

    /// Channels of all layers.
    pub(crate) fn channels(&self) -> Vec<TileChannel> {
        let mut channels = Vec::new();
        let has_hits = self.sums.iter().any(|sums| sums.hits > 0);
        for layer in self.layers {
            let pixels = if has_hits { self.sums.len() } else { 1 };
            let mut values = [(); 3].map(|()| Vec::with_capacity(pixels));
            for (sums, samples) in self.sums.iter().zip(&self.samples).take(pixels) {
                let of_pixel = sums.values(self.context.origin, (*samples).min(MAX_LAYER_SAMPLES), *layer);
                values.iter_mut().zip(of_pixel).for_each(|(values, value)| values.push(value as f32));
            }
            channels.extend(values.into_iter().take(layer.channels().len()).map(TileChannel::new));
        }
        channels
    }
}

impl PixelSums {
    /// Adds a surface that a ray hits at a depth; returns true if it is seen from behind.
    #[inline(always)]
    fn add(&mut self, surface: &SurfacePoint, uv: [f64; 2], ray: &Ray, depth: f64) -> bool {
        self.hits += 1;
        self.depth += depth;
        self.position += surface.point;
        let is_inside = ray.direction.dot(surface.geometric_normal) > 0.0;
        let towards_viewer = if is_inside { -1.0 } else { 1.0 };
        self.normal += surface.shading_normal * towards_viewer;
        self.geometric_normal += surface.geometric_normal * towards_viewer;
        self.uv[0] += uv[0];
        self.uv[1] += uv[1];
        is_inside
    }

    #[inline(always)]
    fn add_features(&mut self, features: &SurfaceFeatures, is_inside: bool) {
        self.albedo += features.albedo;
        self.roughness += features.roughness;
        self.emission += features.emission[usize::from(is_inside)];
    }

    /// Keeps the numbers of the first hit.
    #[inline(always)]
    fn set_ids(&mut self, world: &Instances<'_>, hit: &Hit, material: u32) {
        if self.hits == 1 {
            let [object, instance] = world.ids(hit).unwrap_or([u32::MAX; 2]);
            self.ids = [object, material, instance].map(|id| id.saturating_add(1));
        }
    }

    /// Values of the channels of a layer, as many as it has; `samples` are all that were taken.
    fn values(&self, origin: DVec3, samples: u32, layer: FirstHitLayer) -> [f64; 3] {
        if self.hits == 0 {
            return [if layer == FirstHitLayer::Depth { f64::from(FAR_DEPTH) } else { 0.0 }; 3];
        }
        let n = f64::from(self.hits);
        let coverage = n / f64::from(samples);
        match layer {
            FirstHitLayer::Depth => [self.depth / n; 3],
            FirstHitLayer::Position => (self.position / n + origin).to_array(),
            FirstHitLayer::Normal => self.normal.normalize_or_zero().to_array(),
            FirstHitLayer::GeometricNormal => self.geometric_normal.normalize_or_zero().to_array(),
            FirstHitLayer::Albedo => self.albedo.to_array().map(|sum| sum / n),
            FirstHitLayer::Roughness => [self.roughness / n; 3],
            FirstHitLayer::Emission => self.emission.to_array().map(|sum| sum / n),
            FirstHitLayer::Uv => [self.uv[0] / n, self.uv[1] / n, coverage],
            FirstHitLayer::ObjectId => [f64::from(self.ids[0]); 3],
            FirstHitLayer::MaterialId => [f64::from(self.ids[1]); 3],
            FirstHitLayer::InstanceId => [f64::from(self.ids[2]); 3],
            FirstHitLayer::Coverage => [coverage; 3],
        }
    }
}
