//! Rays that hits spawn, and what they add to samples.

use crate::{
    InteriorList, Material, RadianceSample, ShadingCounts, ShadingFeatures, StreamQueries,
    lane_set::{Element, LaneSet, set_color},
    lanes::{LANES, each_lane},
    shadow_media::ShadowMedia,
};
use rt_geometry::{HitStream, RayKind, RayStream, STREAM_CAPACITY, StreamArray};
use rt_math::{Interval, Ray, Rgb, Vector3};

/// Delta lights that have a stream each for batches of [`STREAM_CAPACITY`] camera rays. A stream takes 50 kB.
const LIGHTS_OF_FULL_BATCHES: usize = 64;

/// Camera rays to shade together under this number of delta lights: a multiple of 8, for more lights fewer rays. This bounds the memory of
/// [`PathTracer`](crate::PathTracer) and [`Whitted`](crate::Whitted), and changes no image.
pub const fn batch_size(n_delta_lights: usize) -> usize {
    if n_delta_lights <= LIGHTS_OF_FULL_BATCHES {
        return STREAM_CAPACITY;
    }
    let size = STREAM_CAPACITY * LIGHTS_OF_FULL_BATCHES / n_delta_lights / 8 * 8;
    if size == 0 { 8 } else { size }
}

/// Shadow rays to delta lights, in the order of the lights at each vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct DeltaStreams<E: Element> {
    /// Streams, each of the next [`lights_per_stream`](Self::lights_per_stream) lights.
    pub(crate) streams: Vec<ShadowRayStream<E>>,
    /// Lights for which a stream has space, if each ray of a wave has one vertex.
    pub(crate) lights_per_stream: usize,
}

impl<E: Element> DeltaStreams<E> {
    /// Makes space for the shadow rays of one vertex of each ray of a wave.
    pub(crate) fn start(&mut self, n_lights: usize, n_rays: usize) {
        self.lights_per_stream = (STREAM_CAPACITY / n_rays.max(1)).max(1);
        let n_streams = n_lights.div_ceil(self.lights_per_stream);
        if self.streams.len() < n_streams {
            self.streams.resize_with(n_streams, ShadowRayStream::default);
        }
    }
}

/// Shadow rays to a light or to a few, with what these add to samples if they are not occluded.
#[derive(Clone, Debug)]
pub(crate) struct ShadowRayStream<E: Element> {
    rays: RayStream,
    /// Index of the camera ray, or under `whitted` of the branch of its ray tree.
    sample: StreamArray<u32>,
    /// Radiance in the pixel.
    radiance: [StreamArray<E>; 3],
    /// Media in which rays start, by their indices, if these are not the media of the path.
    interiors: Vec<(usize, InteriorList)>,
    occluded: Box<[bool; STREAM_CAPACITY]>,
}

impl<E: Element> Default for ShadowRayStream<E> {
    fn default() -> Self {
        Self {
            rays: RayStream::default(),
            sample: StreamArray::default(),
            radiance: Default::default(),
            interiors: Vec::new(),
            occluded: Box::new([false; STREAM_CAPACITY]),
        }
    }
}

impl<E: Element> ShadowRayStream<E> {
    /// Appends the rays of some lanes, which start on a surface and end at `max`, with their radiance and the samples of all lanes.
    #[inline(always)]
    pub(crate) fn push<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        mask: u8,
        rays: [Vector3<L::D>; 2],
        (max, time): (L::D, Option<L::D>),
        (radiance, samples): (Vector3<L::F>, &[u32; 8]),
    ) {
        if mask == 0 {
            return;
        }
        let end = self.rays.len();
        append(lanes, &mut self.rays, mask, rays, (max, time));
        lanes.compress_vector(radiance, mask, &mut self.radiance, end);
        lanes.compress_u32(samples, mask, self.sample.vector_mut(end));
    }

    pub(crate) fn push_ray(&mut self, (ray, span): (Ray, Interval), sample: u32, radiance: Rgb) {
        let at = self.rays.len();
        self.sample.set(at, sample);
        for (to, component) in self.radiance.iter_mut().zip(radiance.to_array()) {
            to.set(at, E::rounded(component));
        }
        self.rays.push(&ray, span);
    }

    /// Lets the last ray start in these media.
    pub(crate) fn start_in(&mut self, interior: InteriorList) {
        self.interiors.push((self.rays.len().saturating_sub(1), interior));
    }

    /// Traces the rays. [`add_unoccluded`](Self::add_unoccluded) comes next.
    pub(crate) fn trace(&mut self, world: &mut dyn StreamQueries) {
        if !self.rays.is_empty() {
            world.occluded_stream(&self.rays, &mut self.occluded[..self.rays.len()]);
        }
    }

    /// Version of [`trace`](Self::trace) for scenes with media that shadow rays pass. `interior` has the media by the index that each ray
    /// carries.
    pub(crate) fn trace_through_media(
        &mut self,
        world: &mut dyn StreamQueries,
        scene: (&ShadingFeatures, &[Material]),
        interior: impl Fn(u32) -> InteriorList,
        counts: &mut ShadingCounts,
    ) {
        self.trace(world);
        let mut own = self.interiors.drain(..).peekable();
        let start = |at: usize| {
            let own = own.next_if(|(index, _)| *index == at).map(|(_, interior)| interior);
            let media = ShadowMedia::new(own.unwrap_or_else(|| interior(self.sample.get(at))));
            let (ray, span) = self.rays.get(at);
            (at, ray, ShadowMedia::span(span), media)
        };
        let mut waiting: Vec<_> = (0..self.rays.len()).map(start).filter(|(at, ..)| !self.occluded[*at]).collect();
        let (mut rays, mut hits) = (RayStream::default(), HitStream::default());
        while !waiting.is_empty() {
            rays.clear();
            waiting.iter().for_each(|(_, ray, span, _)| rays.push(ray, *span));
            world.closest_stream(&rays, RayKind::Shadow, &mut hits);
            let mut index = 0..;
            waiting.retain_mut(|(at, ray, span, media)| {
                let hit = index.next().and_then(|index| world.surface(ray, &hits, index, scene.0.surface()));
                let rest = hit.as_ref().and_then(|hit| media.pass(scene, (ray, *span), hit, counts));
                self.occluded[*at] = hit.is_some() && rest.is_none();
                if let Some(rest) = rest {
                    *span = rest;
                } else if !self.occluded[*at] {
                    let transmittance = media.transmittance_to(scene.1, ray, span.max);
                    for (radiance, factor) in self.radiance.iter_mut().zip(transmittance.to_array()) {
                        radiance.set(*at, E::rounded(radiance.get(*at).into() * factor));
                    }
                }
                rest.is_some()
            });
        }
    }

    /// Adds the light of the rays that are not occluded, and removes all rays. `bounded` is applied to that light.
    pub(crate) fn add_unoccluded(&mut self, mut bounded: impl FnMut(Rgb) -> Rgb, radiances: &mut [RadianceSample]) {
        let [r, g, b] = &self.radiance;
        for (at, is_occluded) in self.occluded[..self.rays.len()].iter().enumerate() {
            if !is_occluded {
                let radiance = Rgb::new(r.get(at).into(), g.get(at).into(), b.get(at).into());
                radiances[self.sample.get(at) as usize].radiance += bounded(radiance);
            }
        }
        self.rays.clear();
    }
}

/// Radiance over these distances, attenuated by the transmittances of the lanes of a mask.
#[inline(never)]
pub(crate) fn attenuated<L: LaneSet>(
    lanes: L,
    (radiance, distance): &(Vector3<L::F>, L::D),
    mask: u8,
    transmittance: impl Fn(usize, f64) -> Rgb,
) -> Vector3<L::F> {
    lanes.vectorize(
        #[inline(always)]
        || {
            let mut distances = [0.0; LANES];
            lanes.store_f64(*distance, &mut distances);
            let mut transmittances = [[L::Element::rounded(1.0); LANES]; 3];
            for lane in each_lane(mask) {
                set_color(&mut transmittances, lane, transmittance(lane, distances[lane & 7]));
            }
            let [r, g, b] = &transmittances;
            radiance.scaled_by(Vector3::new(lanes.load(r), lanes.load(g), lanes.load(b)))
        },
    )
}

/// Adds radiance to the samples of some lanes. `samples` has the indices of all lanes.
#[inline(always)]
pub(crate) fn add_radiance<L: LaneSet>(
    lanes: L,
    mask: u8,
    radiance: Vector3<L::F>,
    is_hit: bool,
    samples: &[u32; 8],
    radiances: &mut [RadianceSample],
) {
    let [r, g, b] = lanes.store_vector(radiance);
    for lane in each_lane(mask) {
        let radiance_sample = &mut radiances[samples[lane & 7] as usize];
        radiance_sample.radiance += Rgb::new(r[lane & 7].into(), g[lane & 7].into(), b[lane & 7].into());
        radiance_sample.hit |= is_hit;
    }
}

/// Times of the rays from index `at` on; `None` if all are 0.
#[inline(always)]
pub(crate) fn times<L: LaneSet>(lanes: L, rays: &RayStream, at: usize, has_time: bool) -> Option<L::D> {
    if has_time { Some(lanes.load_f64(rays.time.vector(at))) } else { None }
}

/// Appends the rays of some lanes, which start on a surface. Without times, all rays ever appended are at time 0.
#[inline(always)]
pub(crate) fn append<L: LaneSet>(
    lanes: L,
    rays: &mut RayStream,
    mask: u8,
    [origin, direction]: [Vector3<L::D>; 2],
    (max, time): (L::D, Option<L::D>),
) {
    let end = rays.len();
    lanes.compress_point(origin, mask, &mut rays.origin, end);
    lanes.compress_point(direction, mask, &mut rays.direction, end);
    lanes.store_f64(lanes.splat_f64(Interval::SPAWNED.min), rays.min.vector_mut(end));
    lanes.compress_f64(max, mask, rays.max.vector_mut(end));
    if let Some(time) = time {
        lanes.compress_f64(time, mask, rays.time.vector_mut(end));
    }
    rays.grow(mask.count_ones() as usize);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_thousand_lights_took_a_quarter_of_a_gigabyte_per_thread() {
        assert_eq!([0, 1, 64, 65, 128, 2048, 1 << 20].map(batch_size), [256, 256, 256, 248, 128, 8, 8]);
        for n_lights in [65, 100, 1000, 10_000] {
            let mut streams = DeltaStreams::<f32>::default();
            streams.start(n_lights, batch_size(n_lights));
            assert!(streams.streams.len() <= 128.max(n_lights / 31), "{n_lights} lights");
            assert!(streams.streams.len() * streams.lights_per_stream >= n_lights);
            assert!(streams.lights_per_stream * batch_size(n_lights) <= STREAM_CAPACITY);
        }
    }
}
