//! Streams of paths, and their state between vertices.

use super::settings::Lighting;
use crate::{
    bsdf::BsdfSample, interior_list::InteriorList, lane_set::Element, medium_tracker::MediumTracker, ray_kind::kind_of,
    shadow_media::ShadowMedia,
};
use rt_geometry::{RayKind, RayStream, STREAM_CAPACITY, StreamArray};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Rays of paths, one array for each number.
#[derive(Clone, Debug, Default)]
pub(super) struct PathStream<E: Element> {
    pub(super) rays: RayStream,
    /// Index of the camera ray.
    pub(super) sample: StreamArray<u32>,
    /// Throughput (β): weight of radiance in the pixel.
    pub(super) throughput: [StreamArray<E>; 3],
    /// Density of the direction over solid angle; 0 for camera rays and delta directions, which have no competing light sample.
    pub(super) pdf: StreamArray<E>,
    /// Normal for the sampling of lights at the previous vertex; 0 without one.
    pub(super) normal: [StreamArray<E>; 3],
}

/// A path of a [`PathStream`], without its ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathRecord {
    pub(super) sample: u32,
    pub(super) throughput: Rgb,
    pub(super) pdf: f64,
    pub(super) normal: DVec3,
}

/// State of a path that only some scenes need.
#[derive(Clone, Debug)]
pub(super) struct WavePathState {
    pub(super) medium_tracker: MediumTracker,
    /// Accumulated η² from refraction (pbrt's `etaScale`); Russian roulette uses `throughput * eta_scale`.
    pub(super) eta_scale: f64,
    /// Point from which lights were sampled at the previous vertex, unless that is the origin of the ray.
    pub(super) vertex: Option<DVec3>,
    /// True if the first surface sampled a lobe that is not a delta lobe.
    pub(super) first_bounce_nonspecular: bool,
    /// True if the path ends after the emission of the next surface.
    pub(super) emission_only: bool,
    /// True if the background is black for the next ray.
    pub(super) omits_background: bool,
    /// True if the light samples of a previous vertex have passed all objects since then. The next ray does not find their lights again.
    pub(super) omits_sampled_lights: bool,
}

/// Previous vertex of a path, for the MIS weights of lights that it hits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrevVertex {
    pub(crate) point: DVec3,
    /// Normal for the sampling of lights; `None` if the surface transmits light.
    pub(crate) normal: Option<DVec3>,
    /// Density of the direction by the BSDF, in 1/sr.
    pub(crate) pdf: f64,
}

/// Part of a ray behind an object that casts no shadow.
#[derive(Clone, Debug)]
pub(super) struct LightBehind {
    pub(super) ray: Ray,
    pub(super) span: Interval,
    /// Index of the camera ray.
    pub(super) sample: u32,
    pub(super) throughput: Rgb,
    pub(super) from: PrevVertex,
    /// The object, whose own light is not behind it.
    pub(super) object: u32,
    /// Media behind it.
    pub(super) media: ShadowMedia,
}

/// Streams of a wave, by the kind of their rays: rays of a kind are coherent, and counted as such.
#[derive(Clone, Debug, Default)]
pub(super) struct PathStreamsByKind<E: Element> {
    pub(super) reflected: PathStream<E>,
    pub(super) refracted: PathStream<E>,
    pub(super) diffuse: PathStream<E>,
}

impl Default for WavePathState {
    fn default() -> Self {
        Self {
            medium_tracker: MediumTracker::default(),
            eta_scale: 1.0,
            vertex: None,
            first_bounce_nonspecular: false,
            emission_only: false,
            omits_background: false,
            omits_sampled_lights: false,
        }
    }
}

impl WavePathState {
    /// Restarts with a camera ray in these media, and keeps its memory.
    pub(super) fn restart(&mut self, camera_media: &InteriorList) {
        let mut medium_tracker = core::mem::take(&mut self.medium_tracker);
        medium_tracker.restart(camera_media);
        *self = Self { medium_tracker, ..Self::default() };
    }
}

impl<E: Element> PathStream<E> {
    /// Replaces the rays by camera rays, each of its own sample. `rays` is an unspecified stream afterwards.
    pub(super) fn start(&mut self, rays: &mut RayStream) {
        core::mem::swap(&mut self.rays, rays);
        for (sample, number) in self.sample.as_mut_slice().iter_mut().zip(0..) {
            *sample = number;
        }
        for throughput in &mut self.throughput {
            throughput.as_mut_slice().fill(E::rounded(1.0));
        }
        self.pdf.as_mut_slice().fill(E::rounded(0.0));
    }

    /// Appends a path. Nothing happens if the stream is full.
    pub(super) fn push(&mut self, ray: &Ray, span: Interval, path: &PathRecord) {
        let at = self.rays.len();
        if at == STREAM_CAPACITY {
            return;
        }
        self.sample.set(at, path.sample);
        self.pdf.set(at, E::rounded(path.pdf));
        for (to, component) in self.throughput.iter_mut().zip(path.throughput.to_array()) {
            to.set(at, E::rounded(component));
        }
        for (to, coordinate) in self.normal.iter_mut().zip(path.normal.to_array()) {
            to.set(at, E::rounded(coordinate));
        }
        self.rays.push(ray, span);
    }

    /// Appends a path of another stream.
    pub(super) fn push_from(&mut self, other: &Self, from: usize) {
        let at = self.rays.len();
        let (ray, span) = other.rays.get(from);
        self.sample.set(at, other.sample.get(from));
        self.pdf.set(at, other.pdf.get(from));
        for (to, numbers) in self.throughput.iter_mut().zip(&other.throughput) {
            to.set(at, numbers.get(from));
        }
        for (to, numbers) in self.normal.iter_mut().zip(&other.normal) {
            to.set(at, numbers.get(from));
        }
        self.rays.push(&ray, span);
    }

    pub(super) fn get(&self, at: usize) -> PathRecord {
        let [x, y, z] = &self.normal;
        let normal = DVec3::new(x.get(at).into(), y.get(at).into(), z.get(at).into());
        let (sample, throughput) = (self.sample.get(at), self.throughput(at));
        PathRecord { sample, throughput, pdf: self.pdf.get(at).into(), normal }
    }

    pub(super) fn throughput(&self, at: usize) -> Rgb {
        let [r, g, b] = &self.throughput;
        Rgb::new(r.get(at).into(), g.get(at).into(), b.get(at).into())
    }

    /// Previous vertex of a path that is in this state.
    pub(super) fn prev_vertex(&self, at: usize, state: &WavePathState) -> PrevVertex {
        let PathRecord { pdf, normal, .. } = self.get(at);
        let point = state.vertex.unwrap_or_else(|| self.rays.get(at).0.origin);
        PrevVertex { point, normal: (normal != DVec3::ZERO).then_some(normal), pdf }
    }
}

impl PrevVertex {
    /// Density of sampling a direction to the environment; 0 where no light sample competes.
    pub(super) fn pdf_li_environment(&self, lighting: &Lighting<'_>, direction: DVec3) -> f64 {
        if self.pdf > 0.0 && lighting.lights.environment().is_some() {
            lighting.lights.pdf_li_environment(self.point, self.normal, direction)
        } else {
            0.0
        }
    }
}

impl<E: Element> PathStreamsByKind<E> {
    pub(super) fn is_empty(&self) -> bool {
        [&self.reflected, &self.refracted, &self.diffuse].iter().all(|paths| paths.rays.is_empty())
    }

    pub(super) const fn clear(&mut self) {
        self.reflected.rays.clear();
        self.refracted.rays.clear();
        self.diffuse.rays.clear();
    }

    /// Appends the ray of a sampled direction.
    pub(super) fn push(&mut self, sample: &BsdfSample, ray: &Ray, path: &PathRecord) {
        let paths = match kind_of(Some(sample)) {
            RayKind::Refraction => &mut self.refracted,
            RayKind::Reflection => &mut self.reflected,
            _ => &mut self.diffuse,
        };
        paths.push(ray, Interval::SPAWNED, path);
    }
}
