//! Layers: attributes of the surfaces that camera rays hit first.
//!
//! They are computed from the plan in a sweep of their own, after the image or without it. So they do not change the image. For
//! the same number of samples they are the same with every integrator, number of threads and accelerator.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_camera::PixelSampler;
use rt_geometry::{Hit, InteractionFlags};
use rt_math::{DVec2, DVec3, Interval, Ray, Rgb, Sampler};
use rt_shading::{MaterialEvalContext, SurfaceHit, is_inside};

use crate::{
    Crop, RenderError, RenderPlan,
    parallel_for::{parallel_for, thread_count},
    work_probe::WorkProbe,
    world::{ShadedPrimitives, World},
};

/// Maximum samples of a pixel: more change an average over a pixel by less than most images show.
pub const MAX_LAYER_SAMPLES: u32 = 16;

/// Depth of misses, as in Blender.
pub const FAR_DEPTH: f32 = 1e10;

/// Pixels are traced together until they have this many rays.
const BATCH_SIZE: usize = 256;

/// Declares the layers with their names and channels.
macro_rules! layers {
    ($($(#[$doc:meta])* $layer:ident = $name:literal, [$($channel:literal),+];)+) => {
        /// Attribute of the surfaces that the camera rays of a pixel hit first.
        ///
        /// Numbers are means over the samples that hit a surface, or zero without any. Samples cover the pixel evenly,
        /// without the reconstruction filter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum FirstHitLayer {
            $($(#[$doc])* $layer,)+
        }

        impl FirstHitLayer {
            /// All layers.
            pub const ALL: &[Self] = &[$(Self::$layer),+];

            /// Name in lower case.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$layer => $name,)+
                }
            }

            /// Names of the channels.
            pub const fn channels(self) -> &'static [&'static str] {
                match self {
                    $(Self::$layer => &[$($channel),+],)+
                }
            }
        }
    };
}

layers! {
    /// Depth along the view axis in world units; [`FAR_DEPTH`] for a miss.
    Depth = "depth", ["Z"];
    /// Hit point in world space.
    Position = "position", ["X", "Y", "Z"];
    /// Unit shading normal in world space, with interpolated normals and normal maps.
    Normal = "normal", ["X", "Y", "Z"];
    /// Unit geometric normal in world space.
    GeometricNormal = "geometric_normal", ["X", "Y", "Z"];
    /// [`Material::albedo`](rt_shading::Material::albedo).
    Albedo = "albedo", ["R", "G", "B"];
    /// [`Material::roughness`](rt_shading::Material::roughness), 0 to 1.
    Roughness = "roughness", ["V"];
    /// Emitted radiance.
    Emission = "emission", ["R", "G", "B"];
    /// Texture coordinates of surfaces with textures. Those of others are zero, as plans leave them out.
    Uv = "uv", ["U", "V"];
    /// Index of the object, plus 1; 0 for none. All indices are those of the first sample that hits a surface.
    ObjectId = "object_id", ["V"];
    /// Index of the material in the scene, plus 1; 0 for none.
    MaterialId = "material_id", ["V"];
    /// Index of the instance of the top level, plus 1; 0 for none.
    InstanceId = "instance_id", ["V"];
    /// Share of the samples that hit a surface.
    Coverage = "coverage", ["V"];
}

/// Values of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerValues {
    /// The attribute.
    pub layer: FirstHitLayer,
    /// For each of its [channels](FirstHitLayer::channels), a value per pixel of the crop, row by row.
    pub channels: Vec<Vec<f32>>,
}

/// Samples of all pixels, and the data that their surfaces need.
struct Sweep {
    spp: u32,
    sampler: PixelSampler,
    flags: InteractionFlags,
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

impl RenderPlan<'_> {
    /// Computes layers of all pixels in the crop, in the order of the request, on `threads` threads or on all processors for 0.
    ///
    /// Each pixel takes `spp` samples, but at most [`MAX_LAYER_SAMPLES`], rounded up as the sample pattern requires.
    ///
    /// # Errors
    /// [`RenderError::LostRows`] after a panic, which only a defect can cause.
    pub fn first_hit_layers(
        &self,
        layers: &[FirstHitLayer],
        spp: u32,
        threads: usize,
    ) -> Result<Vec<LayerValues>, RenderError> {
        let Crop { x, y, width, height } = self.frame.crop;
        let n = width as usize * height as usize;
        let mut values: Vec<LayerValues> = layers
            .iter()
            .map(|&layer| LayerValues { layer, channels: vec![Vec::with_capacity(n); layer.channels().len()] })
            .collect();
        if layers.is_empty() || n == 0 {
            return Ok(values);
        }
        let needs_surface = |layer: &FirstHitLayer| {
            !matches!(layer, FirstHitLayer::Depth | FirstHitLayer::Coverage | FirstHitLayer::Position)
        };
        let flags = if layers.iter().any(needs_surface) { InteractionFlags::ALL } else { InteractionFlags::NONE };
        let spp = self.frame.sampler.round_up(spp.min(MAX_LAYER_SAMPLES));
        let sweep = Sweep { spp, sampler: self.frame.pass_sampler(0, spp), flags };
        let row = |(): &mut (), row: usize| {
            let first = [x, y + row as u32];
            let sums = match &self.scene.world {
                World::Spheres(world, structure) => self.row(world, structure, &sweep, first, width),
                World::Instances(top, levels) => self.row(&top.set(levels), &top.structure, &sweep, first, width),
            };
            let channels = layers.iter().flat_map(|layer| (0..layer.channels().len()).map(move |at| (*layer, at)));
            Some(
                channels
                    .map(|(layer, at)| sums.iter().map(|sums| self.value(sums, spp, layer, at)).collect())
                    .collect(),
            )
        };
        let numbers: Vec<_> = (0..height as usize).collect();
        let mut rows: Vec<Vec<Vec<f32>>> = vec![Vec::new(); numbers.len()];
        let outcome =
            parallel_for(thread_count(threads), &numbers, None, (|| (), row), |row, values| rows[row] = values);
        if !outcome.lost.is_empty() {
            return Err(RenderError::LostRows(outcome.lost.len()));
        }
        for row in rows {
            let channels = values.iter_mut().flat_map(|values| &mut values.channels);
            channels.zip(row).for_each(|(channel, row)| channel.extend(row));
        }
        Ok(values)
    }

    fn row<W: ShadedPrimitives>(
        &self,
        world: &W,
        structure: &AnyAccelerator,
        sweep: &Sweep,
        [first, y]: [u32; 2],
        width: u32,
    ) -> Vec<PixelSums> {
        let Sweep { spp, flags, .. } = *sweep;
        let mut sums = vec![PixelSums::default(); width as usize];
        let (mut rays, mut hits): (Vec<(Ray, Interval)>, Vec<Option<Hit>>) = Default::default();
        let pixels = (BATCH_SIZE / spp as usize).max(1);
        for (block, sums) in sums.chunks_mut(pixels).enumerate() {
            rays.clear();
            for x in (first + (block * pixels) as u32..).take(sums.len()) {
                rays.extend((0..spp).map(|sample| (self.layer_ray(&sweep.sampler, [x, y], sample), Interval::FORWARD)));
            }
            hits.clear();
            hits.resize(rays.len(), None);
            structure.closest_batch(world, &rays, &mut hits, &mut WorkProbe::default());
            for ((ray, _), (i, hit)) in rays.iter().zip(hits.iter().enumerate()) {
                let surface = hit.as_ref().and_then(|hit| Some((hit, world.surface_at(ray, hit, flags)?)));
                if let Some((hit, surface)) = surface {
                    self.add(&mut sums[i / spp as usize], ray, world.instance_at(hit), &surface);
                }
            }
        }
        sums
    }

    /// Camera ray of a sample, which covers the pixel evenly.
    fn layer_ray(&self, sampler: &PixelSampler, [x, y]: [u32; 2], sample: u32) -> Ray {
        let mut random = sampler.sample([x, y], sample);
        let [u, v] = random.next_2d();
        let centre = DVec2::new(f64::from(x), f64::from(y)) + self.frame.sample_offset;
        let on_lens = if self.frame.camera.has_lens() { random.next_2d() } else { [0.5; 2] };
        let time = self.frame.sample_time(&mut random);
        self.frame.camera.generate_ray(centre + DVec2::new(u, v) - 0.5, on_lens, time)
    }

    fn add(&self, sums: &mut PixelSums, ray: &Ray, instance: u32, surface: &SurfaceHit) {
        let interaction = &surface.interaction;
        sums.hits += 1;
        sums.depth += surface.t * ray.direction.dot(self.frame.camera.view_axis_at(ray.time));
        sums.position += interaction.point;
        sums.normal += interaction.shading_normal;
        sums.geometric_normal += interaction.geometric_normal;
        sums.uv[0] += interaction.uv[0];
        sums.uv[1] += interaction.uv[1];
        let appearance = &self.scene.source.appearance;
        if let Some(material) = appearance.materials.get(surface.material as usize) {
            let is_inside = is_inside(ray.direction, interaction);
            let at = MaterialEvalContext { textures: &appearance.textures, surface: interaction, ior: 1.0 };
            sums.albedo += material.albedo(&at);
            sums.roughness += material.roughness(&at);
            sums.emission += material.emitted_radiance(&appearance.textures, interaction, is_inside);
        }
        if sums.hits == 1 {
            sums.ids = [surface.object, surface.material, instance].map(|id| id.saturating_add(1));
        }
    }

    fn value(&self, sums: &PixelSums, spp: u32, layer: FirstHitLayer, channel: usize) -> f32 {
        if sums.hits == 0 {
            return if layer == FirstHitLayer::Depth { FAR_DEPTH } else { 0.0 };
        }
        let n = f64::from(sums.hits);
        let unit = |normal: DVec3| normal.normalize_or_zero().to_array()[channel];
        let value = match layer {
            FirstHitLayer::Depth => sums.depth / n,
            FirstHitLayer::Position => (sums.position / n + self.scene.space.origin()).to_array()[channel],
            FirstHitLayer::Normal => unit(sums.normal),
            FirstHitLayer::GeometricNormal => unit(sums.geometric_normal),
            FirstHitLayer::Albedo => sums.albedo.to_array()[channel] / n,
            FirstHitLayer::Roughness => sums.roughness / n,
            FirstHitLayer::Emission => sums.emission.to_array()[channel] / n,
            FirstHitLayer::Uv => sums.uv[channel] / n,
            FirstHitLayer::ObjectId => f64::from(sums.ids[0]),
            FirstHitLayer::MaterialId => f64::from(sums.ids[1]),
            FirstHitLayer::InstanceId => f64::from(sums.ids[2]),
            FirstHitLayer::Coverage => n / f64::from(spp),
        };
        value as f32
    }
}
