//! The measurements of one scene.

use std::time::{Duration, Instant};

use rt_accel::{Accelerator as _, AcceleratorKind, AnyAccelerator, Bvh};
use rt_geometry::Primitives;

use super::{
    figure::{Figure, RayFigure},
    query::{RayAnswer, RaySample, count, time},
};
use crate::{
    error::TaskError,
    scenes::{
        Scene, Surfaces,
        rays::{self, RaySet},
    },
    timings::{Spread, Timings},
};

/// An accelerator that needs more nodes and tests than this for all rays of a set is given fewer rays.
const AFFORDABLE: f64 = 5e7;
/// Rays to find out with.
const PILOT: usize = 50;
/// Builds that take longer than this together are not repeated.
const PATIENCE: Duration = Duration::from_secs(2);

/// Measures every accelerator on one scene.
///
/// Traces `rays` rays of each kind, at most; random rays are one of the kinds if `with_random`.
pub(crate) fn scene<P: Surfaces>(
    scene: &Scene<P>,
    rays: u32,
    repeats: u32,
    with_random: bool,
) -> Result<Vec<Figure>, TaskError> {
    let mut sets = Vec::from(ray_sets(scene, rays)?);
    if with_random {
        sets.push(rays::random(&scene.view, rays));
    }
    let mut answers = vec![Vec::new(); sets.len()];
    let mut accelerators = Vec::new();
    let mut figures = Vec::new();
    // A tree sets the answers for all rays of a set, and brute force confirms those that it can afford.
    let mut kinds = AcceleratorKind::ALL.to_vec();
    kinds.sort_by_key(|kind| *kind != AcceleratorKind::Bvh);
    for kind in kinds {
        let build = || AnyAccelerator::build(kind, &scene.primitives).map_err(TaskError::other);
        let (accelerator, timings) = Timings::of(repeats, PATIENCE, build)?;
        let build_seconds = Spread::of(timings.wall).min;
        let mut rays = Vec::new();
        for (set, expected) in sets.iter().zip(&mut answers) {
            rays.push(first_pass(&accelerator, scene, set, expected)?);
        }
        figures.push(figure(scene, &accelerator, build_seconds, rays));
        accelerators.push(accelerator);
    }
    // Accelerators take turns, so that a machine that slows down meanwhile slows them all.
    for _ in 0..repeats {
        for (accelerator, figure) in accelerators.iter().zip(&mut figures) {
            for (set, figure) in sets.iter().zip(&mut figure.rays) {
                let seconds = time(accelerator, &scene.primitives, RaySample { set, rays: figure.rays });
                figure.seconds = figure.seconds.min(seconds);
            }
        }
    }
    figures.sort_by_key(|figure| AcceleratorKind::ALL.iter().position(|kind| kind.name() == figure.accelerator));
    Ok(figures)
}

fn ray_sets<P: Surfaces>(scene: &Scene<P>, count: u32) -> Result<[RaySet; 3], TaskError> {
    let primary = rays::primary(&scene.view, count);
    let bvh = Bvh::build(&scene.primitives).map_err(TaskError::other)?;
    let surfaces = rays::surfaces(&scene.primitives, &bvh, &primary);
    let shadow = rays::shadow(&scene.view, &surfaces, count);
    let diffuse = rays::diffuse(&surfaces, &primary, count);
    Ok([primary, shadow, diffuse])
}

/// Counts, and compares the answers with those of the first accelerator.
fn first_pass<P: Primitives>(
    accelerator: &AnyAccelerator,
    scene: &Scene<P>,
    set: &RaySet,
    expected: &mut Vec<RayAnswer>,
) -> Result<RayFigure, TaskError> {
    let started = Instant::now();
    let pilot = RaySample { set, rays: set.rays.len().min(PILOT) };
    let (_, tally) = count(accelerator, &scene.primitives, pilot);
    let work = (tally.nodes + tally.tests) as f64 / pilot.rays as f64;
    let sample = RaySample { set, rays: set.rays.len().min((AFFORDABLE / work) as usize).max(pilot.rays) };
    let (answers, tally) = count(accelerator, &scene.primitives, sample);
    let first_seconds = started.elapsed().as_secs_f64();
    if expected.is_empty() {
        expected.clone_from(&answers);
    }
    if sample.places().zip(&answers).any(|(place, answer)| expected.get(place) != Some(answer)) {
        let (scene, kind, name) = (scene.name, set.kind, accelerator.kind().name());
        return Err(TaskError::Other(format!("{scene}, {kind} rays: {name} gives another answer")));
    }
    let hits = answers.iter().filter(|answer| **answer != RayAnswer::Miss).count();
    let (nodes, tests) = (tally.nodes, tally.tests);
    Ok(RayFigure { kind: set.kind, rays: sample.rays, hits, nodes, tests, seconds: f64::INFINITY, first_seconds })
}

fn figure<P: Primitives>(
    scene: &Scene<P>,
    accelerator: &AnyAccelerator,
    build_seconds: f64,
    rays: Vec<RayFigure>,
) -> Figure {
    let stats = accelerator.build_stats();
    Figure {
        scene: scene.name,
        primitives: scene.primitives.len(),
        accelerator: accelerator.kind().name(),
        build_seconds,
        bytes: accelerator.memory(),
        nodes: stats.nodes,
        leaves: stats.leaves,
        references: stats.references,
        max_depth: stats.max_depth,
        rays,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    #[test]
    fn every_accelerator_is_measured_and_brute_force_tests_everything() {
        let figures = scene(&scenes::mound(700).unwrap(), 400, 1, true).unwrap();
        assert_eq!(figures.len(), AcceleratorKind::ALL.len());
        for figure in &figures {
            assert!(figure.build_seconds > 0.0 && figure.bytes > 0);
            for rays in &figure.rays {
                assert!(rays.rays == 400 && rays.seconds.is_finite() && rays.tests > 0, "{figure:?}");
            }
        }
        let [linear, others @ ..] = figures.as_slice() else { panic!("no figures") };
        let tests = |figure: &Figure, kind| figure.of(kind).unwrap().tests;
        assert_eq!(tests(linear, "primary"), 700 * 400);
        assert!(others.iter().all(|figure| tests(figure, "primary") < 700 * 400 / 4));
        assert!(others.iter().all(|figure| figure.of("diffuse").unwrap().hits == linear.of("diffuse").unwrap().hits));
    }

    #[test]
    fn another_answer_is_noticed() {
        let scene = scenes::mound(50).unwrap();
        let set = rays::primary(&scene.view, 100);
        let accelerator = AnyAccelerator::build(AcceleratorKind::Linear, &scene.primitives).unwrap();
        let mut expected = Vec::new();
        first_pass(&accelerator, &scene, &set, &mut expected).unwrap();
        first_pass(&accelerator, &scene, &set, &mut expected).unwrap();
        expected[57] = RayAnswer::Occluded;
        assert!(first_pass(&accelerator, &scene, &set, &mut expected).is_err());
    }
}
