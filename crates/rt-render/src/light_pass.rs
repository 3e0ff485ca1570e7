//! Passes of light paths: light that comes to the camera by mirrors and glass.

use rt_accel::AnyAccelerator;
use rt_camera::{PixelSampler, SampleStream, SamplerKind};
use rt_geometry::{Counters, NoProbe, Shape};
use rt_math::{Sampler, random::hash};
use rt_shading::{
    Appearance, Ball, CameraWiSample, LightSources, LightTracingIntegrator, LightTracingScene, Lighting, ShadingCounts,
    Targets, emitter::EmitterSet,
};

use crate::{
    RenderPlan,
    passes::pass_seed,
    plan::World,
    splats::{Splat, spread},
    surroundings::{holds, reach_of_transparent_bodies},
    tile::Countable,
    trace::{Surfaces, WorldTracer},
    visible::InView,
    world::{InstanceGeometry, Levels, Part},
};

/// Paths that a thread takes at a time.
const CHUNK: u64 = 4096;

/// Paths that are traced together.
const WAVE: u64 = 256;

/// Tells the random numbers of light paths from those of pixels.
const LIGHT_PATHS: u64 = 0x6c69_6768_7420_7061;

/// The paths from lights of a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightPass {
    pass: u32,
    /// As many as the pass takes camera samples over the whole image, whatever part of it is rendered.
    paths: u64,
}

/// What some of the paths did.
pub(crate) struct LitChunk {
    pub(crate) splats: Vec<Splat>,
    pub(crate) counters: Counters,
    pub(crate) shading: ShadingCounts,
    /// Light that is not a radiance: NaN, infinite or negative.
    pub(crate) bad: u64,
}

impl LightPass {
    /// The number of chunks that the paths are shared out in.
    pub(crate) const fn chunks(&self) -> u64 {
        self.paths.div_ceil(CHUNK)
    }
}

impl RenderPlan<'_> {
    /// The light paths of a pass of so many samples per pixel; `None` if the plan follows none.
    pub(crate) fn light_pass(&self, pass: u32, spp: u32) -> Option<LightPass> {
        let [width, height] = self.size.map(u64::from);
        let paths = width * height * u64::from(spp);
        self.light_sources.as_ref().map(|_| LightPass { pass, paths })
    }

    /// Follows the paths of a chunk. One `match` for each axis.
    pub(crate) fn trace_light(
        &self,
        pass: LightPass,
        chunk: u64,
        count: bool,
        tracer: &mut LightTracingIntegrator<SampleStream>,
    ) -> LitChunk {
        if count {
            self.trace_light_with::<Counters>(pass, chunk, tracer)
        } else {
            self.trace_light_with::<NoProbe>(pass, chunk, tracer)
        }
    }

    fn trace_light_with<S: Countable>(
        &self,
        pass: LightPass,
        chunk: u64,
        tracer: &mut LightTracingIntegrator<SampleStream>,
    ) -> LitChunk {
        match &self.world {
            World::Spheres(world, structure) => self.trace_light_in::<_, S>(world, structure, pass, chunk, tracer),
            World::Parts(top, levels) => {
                let world = &top.set(levels);
                self.trace_light_in::<_, S>(world, &top.structure, pass, chunk, tracer)
            }
        }
    }

    fn trace_light_in<W: Surfaces, S: Countable>(
        &self,
        world: &W,
        structure: &AnyAccelerator,
        pass: LightPass,
        chunk: u64,
        tracer: &mut LightTracingIntegrator<SampleStream>,
    ) -> LitChunk {
        let mut lit =
            LitChunk { splats: Vec::new(), counters: Counters::default(), shading: ShadingCounts::default(), bad: 0 };
        let Some(sources) = &self.light_sources else { return lit };
        let lighting = Lighting { appearance: &self.appearance, emitters: &self.emitters, bsdfs: &self.bsdfs };
        let mut world = WorldTracer::new(world, structure, InView::All(structure), S::default());
        // Sobol' points whatever the pattern of the camera's samples: they need not be arranged in a pixel.
        let seed = hash(&[pass_seed(self.seed, pass.pass), LIGHT_PATHS]);
        let sampler = PixelSampler::new(SamplerKind::Sobol, 1, seed);
        let share = 1.0 / pass.paths as f64;
        let end = pass.paths.min((chunk + 1) * CHUNK);
        for first in (chunk * CHUNK..end).step_by(WAVE as usize) {
            let indices = first..end.min(first + WAVE);
            let samplers = indices.map(|index| {
                let mut sample = sampler.sample([(index >> 32) as u32, 0], index as u32);
                let time = self.draw_moment(&mut sample);
                (sample, time)
            });
            let scene = LightTracingScene { lighting, sources };
            let sight = |point, time, sampler: &mut SampleStream| {
                let on_lens = if self.camera.has_lens() { sampler.next_2d() } else { [0.5; 2] };
                let sight = self.camera.sample_wi(point, on_lens, time)?;
                Some(CameraWiSample { origin: sight.origin, raster: sight.raster, importance: sight.importance })
            };
            tracer.trace(&mut world, scene, samplers, sight, |raster, light| {
                if light.to_array().iter().all(|c| (0.0..f64::INFINITY).contains(c)) {
                    let add = |splat| lit.splats.push(splat);
                    spread(self.filter, self.crop, self.sample_offset, raster, light * share, add);
                } else {
                    lit.bad += 1;
                }
            });
        }
        lit.counters = world.probe.counters(world.rays);
        lit.shading = tracer.take_counts();
        lit
    }
}

/// The lights of the world as beginnings of paths; `None` if none of them can shine on a sharp mirror or glass.
pub(crate) fn light_sources(appearance: &Appearance, emitters: &EmitterSet, world: &World) -> Option<LightSources> {
    let is_sharp =
        |material: u32| appearance.materials.get(material as usize).is_some_and(rt_shading::Material::is_sharp);
    let targets = match world {
        World::Spheres(world, _) => {
            let sharp = world.spheres.as_slice().iter().zip(&world.materials);
            let sharp = sharp.filter(|(_, material)| is_sharp(**material));
            let ball =
                |(sphere, _): (&rt_geometry::Sphere, _)| Ball { centre: sphere.centre(), radius: sphere.radius() };
            Targets::new(sharp.map(ball).collect())
        }
        World::Parts(top, levels) => targets(&top.parts, levels, &is_sharp),
    };
    let bodies = reach_of_transparent_bodies(&appearance.materials, world);
    let sources = LightSources::new(&appearance.lights, emitters, targets, world.bounds(), bodies);
    (!sources.is_empty()).then_some(sources)
}

fn targets(parts: &[Part], levels: &Levels, is_sharp: &impl Fn(u32) -> bool) -> Targets {
    let ball = |part: &Part| match &part.geometry {
        InstanceGeometry::Shape(Shape::Sphere(sphere)) => {
            Some(Ball { centre: sphere.centre(), radius: sphere.radius() })
        }
        _ => part.bounds.map(|bounds| Ball { centre: bounds.centre(), radius: 0.5 * bounds.extent().length() }),
    };
    let sharp = parts.iter().filter(|part| holds(part, levels, is_sharp));
    sharp.map(ball).collect::<Option<Vec<_>>>().map_or(Targets::EVERYWHERE, Targets::new)
}
