//! The measurements themselves.

use std::time::Instant;

use cpu_time::ThreadTime;
use rt_accel::{AcceleratorKind, AcceleratorQueries as _, AnyAccelerator, Bvh};
use rt_geometry::Primitives;

use super::{BuildFigure, Figures, Options, TraceFigure, query::count_hits};
use crate::{
    bench::spread::Spread,
    error::TaskError,
    scenes::{
        Scene, Surfaces,
        rays::{self, RaySet},
    },
};

/// Brute force gets as many rays as make about this many primitive tests.
const LINEAR_TESTS: usize = 30_000_000;

/// Measures every structure on one scene.
pub(super) fn scene<P: Surfaces>(scene: &Scene<P>, options: &Options, figures: &mut Figures) -> Result<(), TaskError> {
    let structures = build(scene, options, figures)?;
    for set in ray_sets(scene, options.rays)? {
        check(scene, &structures, &set)?;
        figures.traces.extend(trace(scene, &structures, &set, options.reps));
    }
    Ok(())
}

fn build<P: Primitives>(
    scene: &Scene<P>,
    options: &Options,
    figures: &mut Figures,
) -> Result<Vec<(AcceleratorKind, AnyAccelerator)>, TaskError> {
    let mut built = Vec::new();
    for &kind in AcceleratorKind::ALL {
        let mut seconds = Vec::new();
        let mut last = None;
        for _ in 0..options.reps {
            let started = Instant::now();
            let structure = AnyAccelerator::build(kind, &scene.primitives).map_err(not_built)?;
            seconds.push(started.elapsed().as_secs_f64());
            last = Some(structure);
        }
        let Some(structure) = last else { continue };
        figures.builds.push(BuildFigure {
            scene: scene.name,
            primitives: scene.primitives.len(),
            structure: kind.name(),
            seconds: Spread::of(seconds),
            bytes: structure.memory(),
        });
        built.push((kind, structure));
    }
    Ok(built)
}

fn ray_sets<P: Surfaces>(scene: &Scene<P>, count: u32) -> Result<[RaySet; 4], TaskError> {
    let primary = rays::primary(&scene.view, count);
    let bvh = Bvh::build(&scene.primitives).map_err(not_built)?;
    let surfaces = rays::surfaces(&scene.primitives, &bvh, &primary);
    let shadow = rays::shadow(&scene.view, &surfaces, count);
    let diffuse = rays::diffuse(&surfaces, &primary, count);
    let random = rays::random(&scene.view, count);
    Ok([primary, shadow, diffuse, random])
}

/// Structures take turns; the first round only warms up. The clock is that of the processor, on which neighbours do
/// not count.
fn trace<P: Primitives>(
    scene: &Scene<P>,
    structures: &[(AcceleratorKind, AnyAccelerator)],
    set: &RaySet,
    reps: u32,
) -> Vec<TraceFigure> {
    let mut seconds = vec![Vec::new(); structures.len()];
    let mut hits = vec![0; structures.len()];
    for round in 0..=reps {
        for (index, (kind, structure)) in structures.iter().enumerate() {
            let started = ThreadTime::now();
            hits[index] = count_hits(structure, &scene.primitives, set, ray_count(*kind, scene, set));
            if round > 0 {
                seconds[index].push(started.elapsed().as_secs_f64());
            }
        }
    }
    let figure = |((kind, _), (seconds, hits)): (&(AcceleratorKind, AnyAccelerator), (Vec<f64>, u64))| TraceFigure {
        scene: scene.name,
        structure: kind.name(),
        kind: set.kind,
        rays: ray_count(*kind, scene, set),
        hits,
        seconds: Spread::of(seconds),
    };
    structures.iter().zip(seconds.into_iter().zip(hits)).map(figure).collect()
}

fn ray_count<P: Primitives>(kind: AcceleratorKind, scene: &Scene<P>, set: &RaySet) -> usize {
    let affordable =
        if kind == AcceleratorKind::Linear { (LINEAR_TESTS / scene.primitives.len()).max(1) } else { usize::MAX };
    set.rays.len().min(affordable)
}

/// A figure means nothing if the answers differ: on the rays that brute force traced, all must hit as often.
fn check<P: Primitives>(
    scene: &Scene<P>,
    structures: &[(AcceleratorKind, AnyAccelerator)],
    set: &RaySet,
) -> Result<(), TaskError> {
    let count = ray_count(AcceleratorKind::Linear, scene, set);
    let hits = |structure: &AnyAccelerator| count_hits(structure, &scene.primitives, set, count);
    let expected =
        structures.iter().find(|(kind, _)| *kind == AcceleratorKind::Linear).map(|(_, structure)| hits(structure));
    for (kind, structure) in structures {
        if expected.is_some_and(|expected| hits(structure) != expected) {
            let (scene, rays, structure) = (scene.name, set.kind, kind.name());
            return Err(TaskError::Other(format!("{scene}, {rays} rays: {structure} differs from brute force")));
        }
    }
    Ok(())
}

fn not_built(error: rt_accel::BuildError) -> TaskError {
    TaskError::Other(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_run_measures_everything_and_all_structures_agree() {
        let options = Options { write: false, rays: 400, reps: 1 };
        let all = AcceleratorKind::ALL.len();
        let mut figures = Figures::default();
        scene(&crate::scenes::mound(1_000).unwrap(), &options, &mut figures).unwrap();
        assert_eq!((figures.builds.len(), figures.traces.len()), (all, 4 * all));
        for figure in &figures.traces {
            assert_eq!(figure.rays, 400, "{figure:?}");
            assert!(figure.hits > 40 && figure.seconds.min > 0.0, "{figure:?}");
        }
    }
}
