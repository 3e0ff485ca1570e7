//! The runs: every method, at every number of samples, with every seed.

use rt_image::Image;
use serde::Serialize;

use super::laboratory::{Laboratory, Shot};
use super::methods::{Method, MethodName};
use super::yardstick::{Errors, Yardstick};
use crate::error::Failure;

/// What was measured.
#[derive(Debug)]
pub(super) struct Study {
    pub(super) methods: Vec<Measured>,
    /// Samples per pixel that were asked for, and that the time did not suffice for.
    pub(super) left_out: Vec<u32>,
    /// NaN, infinite or negative samples in all renders; they count as black.
    pub(super) bad_samples: u64,
    /// Threads that worked.
    pub(super) threads: usize,
}

/// What was measured of one method.
#[derive(Debug)]
pub(super) struct Measured {
    pub(super) name: MethodName,
    /// With more and more samples.
    pub(super) points: Vec<Point>,
    /// With the fewest and with the most samples, of the first seed.
    pub(super) pictures: [Option<Picture>; 2],
}

/// A picture to look at.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) spp: u32,
    pub(super) film: Image,
}

/// One method at one number of samples.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Samples per pixel that were taken.
    pub(super) spp: u32,
    /// One for each seed.
    pub(super) runs: Vec<Run>,
    /// What is seen of the error with the first seed; `None` without a picture to compare with.
    pub(super) flip: Option<f64>,
}

/// One render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Run {
    pub(super) seed: u64,
    #[serde(flatten)]
    pub(super) errors: Errors,
    /// Processor time of all threads for rendering.
    pub(super) cpu_seconds: f64,
    pub(super) wall_seconds: f64,
    pub(super) build_seconds: f64,
}

/// What a run takes, to tell what the next one will.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// For building and measuring.
    fixed: f64,
    /// For rendering.
    per_sample: f64,
}

/// How many samples, and how often.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent<'a> {
    /// Samples per pixel, ascending.
    pub(super) series: &'a [u32],
    pub(super) seeds: u32,
}

impl Extent<'_> {
    /// Samples of all renders together.
    pub(super) fn samples(&self, methods: &[Method]) -> u64 {
        let of = |method: &Method| self.series.iter().map(|&spp| method.samples(spp)).sum::<u64>();
        methods.iter().map(of).sum::<u64>() * u64::from(self.seeds)
    }
}

/// Runs all of it, or what there is time for: a number of samples is measured with all methods and seeds, or left out; the
/// first is measured in any case. `after` is called whenever one is complete.
///
/// Methods take turns, so that whatever else the machine does slows all of them alike.
pub(super) fn run(
    laboratory: &mut Laboratory<'_>,
    methods: &mut [Method],
    extent: Extent<'_>,
    yardstick: &Yardstick,
    mut after: impl FnMut(&Study) -> Result<(), Failure>,
) -> Result<Study, Failure> {
    let empty = |method: &Method| Measured { name: method.name.clone(), points: Vec::new(), pictures: [None, None] };
    let mut study =
        Study { methods: methods.iter().map(empty).collect(), left_out: Vec::new(), bad_samples: 0, threads: 0 };
    let first_seeds: Vec<u64> = methods.iter().map(|method| method.scene.settings.seed).collect();
    let mut costs: Vec<Option<Cost>> = vec![None; methods.len()];
    for (wave, &spp) in extent.series.iter().enumerate() {
        let needed: f64 = methods.iter().zip(&costs).map(|(method, cost)| predicted(method, *cost, spp)).sum();
        let mut is_complete = wave == 0 || laboratory.clock.has(needed * f64::from(extent.seeds));
        let mut points = vec![Point { spp: 0, runs: Vec::new(), flip: None }; methods.len()];
        let mut films: Vec<Option<Image>> = vec![None; methods.len()];
        'wave: for number in 0..extent.seeds {
            for (index, method) in methods.iter_mut().enumerate() {
                is_complete &= wave == 0 || laboratory.clock.has(predicted(method, costs[index], spp));
                if !is_complete {
                    break 'wave;
                }
                let started = laboratory.clock.elapsed();
                let seed = first_seeds[index].wrapping_add(number.into());
                let shot = laboratory.render(method, spp, seed)?;
                points[index].add(&shot, seed, yardstick, method)?;
                let samples = method.samples(spp) as f64;
                let elapsed = laboratory.clock.elapsed() - started;
                let fixed = (elapsed - shot.wall_seconds).max(0.0);
                costs[index] = Some(Cost { fixed, per_sample: shot.wall_seconds / samples });
                study.bad_samples += shot.bad_samples;
                study.threads = shot.threads;
                if number == 0 {
                    films[index] = Some(shot.film);
                }
            }
        }
        if !is_complete {
            study.left_out = extent.series[wave..].to_vec();
            break;
        }
        for ((measured, point), film) in study.methods.iter_mut().zip(points).zip(films) {
            measured.add(point, film);
        }
        after(&study)?;
    }
    Ok(study)
}

/// Seconds that a render with so many samples per pixel will take: none as long as nothing is known.
fn predicted(method: &Method, cost: Option<Cost>, spp: u32) -> f64 {
    cost.map_or(0.0, |cost| cost.fixed + cost.per_sample * method.samples(spp) as f64)
}

impl Measured {
    /// Adds a point, unless the sampler rounded up to as many samples as before.
    fn add(&mut self, point: Point, film: Option<Image>) {
        let Some(film) = film.filter(|_| self.points.last().is_none_or(|last| last.spp != point.spp)) else { return };
        let place = usize::from(self.pictures[0].is_some());
        self.pictures[place] = Some(Picture { spp: point.spp, film });
        self.points.push(point);
    }

    /// The picture with the most samples.
    pub(super) fn last_picture(&self) -> Option<&Picture> {
        self.pictures.iter().flatten().last()
    }
}

impl Point {
    fn add(&mut self, shot: &Shot, seed: u64, yardstick: &Yardstick, method: &Method) -> Result<(), Failure> {
        let unlike = |source| Failure::Pair { test: "the render".into(), reference: "the reference".into(), source };
        let errors = yardstick.measure(&shot.film).map_err(unlike)?;
        if self.runs.is_empty() {
            let development = &method.scene.film.development;
            let flip = yardstick.reference().map(|reference| reference.flip(&shot.film, development));
            self.flip = flip.transpose().map_err(unlike)?;
        }
        self.spp = shot.spp;
        let Shot { cpu_seconds, wall_seconds, build_seconds, .. } = *shot;
        self.runs.push(Run { seed, errors, cpu_seconds, wall_seconds, build_seconds });
        Ok(())
    }
}
