//! Cost view: false colours for the traversal cost of camera rays.

use rt_geometry::{InteractionFlags, RayKind, RayStats};
use rt_math::{Interval, Ray, Rgb};
use rt_shading::{RadianceSample, SceneQueries};

use crate::tracer::SceneTracer;

/// Traversal cost of a camera ray as a colour: nodes plus primitive tests, on a logarithmic scale.
///
/// Black is 1 step, white 1024 or more; between them are blue, red and yellow.
pub(crate) fn cost(tracer: &mut SceneTracer<'_>, ray: &Ray) -> RadianceSample {
    let work = |tally: RayStats| tally.nodes + tally.tests;
    let before = work(tracer.probe.counters(tracer.rays).of(RayKind::Primary));
    let needs = InteractionFlags::NONE;
    let hit = tracer.closest(ray, Interval::FORWARD, RayKind::Primary, needs);
    let steps = work(tracer.probe.counters(tracer.rays).of(RayKind::Primary)) - before;
    let heat = (rt_math::transcendental::log2(steps.max(1) as f64) / 10.0).min(1.0);
    RadianceSample { radiance: heat_colour(heat), hit: hit.is_some() }
}

fn heat_colour(heat: f64) -> Rgb {
    const STOPS: [Rgb; 5] =
        [Rgb::BLACK, Rgb::new(0.0, 0.05, 0.8), Rgb::new(0.8, 0.0, 0.05), Rgb::new(1.0, 0.8, 0.0), Rgb::WHITE];
    let position = heat * (STOPS.len() - 1) as f64;
    let index = (position as usize).min(STOPS.len() - 2);
    STOPS[index].lerp(STOPS[index + 1], position - index as f64)
}
