//! Faulty samplers in the path tracer.

use std::{f64::consts::PI, sync::Arc};

use rt_camera::{PixelSampler, SamplerKind};
use rt_geometry::{InsideRule, Plane, Polygon, RayStream, Shape};
use rt_math::{DVec3, Interval, Ray, Rgb, Sampler};
use rt_shading::{
    Appearance, BsdfCache, Clamp, ColorTexture, Lighting, Material, PathSettings, PathTracer, Phong, RadianceSample,
    ShadingFeatures, SingleQueries, Transport,
    light::{EmissionSides, LightSampling, LightSet},
};
use rt_tests::ShapeSet;

use super::{
    super::shape_tracer::ShapeTracer,
    Fallible,
    area_light::{ALBEDO, AreaLight},
    closed_form,
};

/// Sample pattern and samples of each estimate with a fault. The rays of an estimate fit into one stream.
pub(super) const PATTERN: SamplerKind = SamplerKind::Jittered;
pub(super) const SPP: u32 = 256;

/// A unit square of light, 1 above the ground.
pub(super) fn area_light() -> AreaLight {
    AreaLight::square(1.0, 0.0)
}

/// Mean irradiance of the unit square under the light.
pub(super) fn truth() -> f64 {
    PI * closed_form::parallel_squares(1.0)
}

/// Repeats one pair.
pub(super) fn repeating(is_wrong: bool, seed: u64) -> Fallible<f64> {
    #[derive(Clone)]
    struct Repeating<S>(S);

    impl<S: Sampler + Clone> Sampler for Repeating<S> {
        fn next_1d(&mut self) -> f64 {
            self.0.clone().next_1d()
        }

        fn next_2d(&mut self) -> [f64; 2] {
            self.0.clone().next_2d()
        }
    }

    if is_wrong { mean(seed, Repeating) } else { mean(seed, |sample| sample) }
}

/// Leaves out what is near to the border, as half-jittered positions do.
pub(super) fn half_jittered(is_wrong: bool, seed: u64) -> Fallible<f64> {
    #[derive(Clone)]
    struct Narrow<S>(S);

    impl<S: Sampler> Sampler for Narrow<S> {
        fn next_1d(&mut self) -> f64 {
            0.25 + 0.5 * self.0.next_1d()
        }

        fn next_2d(&mut self) -> [f64; 2] {
            self.0.next_2d().map(|u| 0.25 + 0.5 * u)
        }
    }

    if is_wrong { mean(seed, Narrow) } else { mean(seed, |sample| sample) }
}

/// Begins each pair with the second number of the one before.
pub(super) fn shifted(is_wrong: bool, seed: u64) -> Fallible<f64> {
    #[derive(Clone)]
    struct Shifted<S>(S, f64);

    impl<S: Sampler> Sampler for Shifted<S> {
        fn next_1d(&mut self) -> f64 {
            self.next_2d()[0]
        }

        fn next_2d(&mut self) -> [f64; 2] {
            let [_, next] = self.0.next_2d();
            [std::mem::replace(&mut self.1, next), next]
        }
    }

    if is_wrong {
        mean(seed, |mut sample| {
            let first = sample.next_1d();
            Shifted(sample, first)
        })
    } else {
        mean(seed, |sample| sample)
    }
}

/// The ground, and the light over it.
fn two_shapes() -> Fallible<ShapeTracer> {
    let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let square = Polygon::new(corners.to_vec(), Vec::new(), InsideRule::Convex)?;
    let shapes = [Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z)?), Shape::Polygon(Arc::new(square))];
    Ok(ShapeTracer { set: ShapeSet::of_shapes(shapes), light: Some(1), rays: Vec::new() })
}

fn appearance() -> Appearance {
    let gray = |value| ColorTexture::Constant(Rgb::gray(value));
    let ground = Phong { ambient: ColorTexture::ZERO, diffuse: gray(ALBEDO), ..Phong::default() };
    let black = Material::new("lamp".into(), Phong::BLACK);
    let area_light = Material { emission: gray(1.0), emission_sides: EmissionSides::Front, ..black };
    Appearance { materials: vec![Material::new("ground".into(), ground), area_light], ..Appearance::default() }
}

/// Mean irradiance by the path tracer, with a sampler made of the correct one.
fn mean<S: Sampler + Clone>(seed: u64, wrapped: impl Fn(rt_camera::SampleStream) -> S) -> Fallible<f64> {
    let mut world = two_shapes()?;
    let appearance = appearance();
    let lights = LightSet::new(vec![area_light().light()?], LightSampling::Tree, 1.0);
    let settings = PathSettings { max_depth: 2, rr_start_depth: 3, transport: Transport::Full, clamp: Clamp::NONE };
    let bsdfs = BsdfCache::new(&appearance, |_| true);
    let lighting = Lighting { appearance: &appearance, lights: &lights, bsdfs: &bsdfs };
    let mut paths = PathTracer::new(settings, ShadingFeatures::of(&appearance, |_| true));
    let sampler = PixelSampler::new(PATTERN, SPP, seed);
    let (mut rays, mut samplers) = (RayStream::default(), Vec::new());
    for index in 0..sampler.spp() {
        let mut sample = wrapped(sampler.sample([0, 0], index));
        let [x, y] = sample.next_2d();
        rays.push(&Ray::new(DVec3::new(x - 0.5, y - 0.5, 0.5), DVec3::NEG_Z), Interval::FORWARD);
        samplers.push(sample);
    }
    let mut seen = vec![RadianceSample::MISS; rays.len()];
    paths.radiance_of_stream(&mut SingleQueries::new(&mut world), lighting, &mut rays, &mut samplers, &mut seen);
    let sum: f64 = seen.iter().map(|seen| seen.radiance.g).sum();
    Ok(sum / seen.len() as f64 * PI / ALBEDO)
}
