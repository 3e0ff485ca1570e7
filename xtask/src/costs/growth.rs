//! Growth of costs with the number of primitives: slopes in log–log diagrams.

use rt_math::transcendental::log;
use serde::Serialize;

use super::figure::Figure;
use crate::line_fit::LineFit;

/// The exponent k of cost ~ nᵏ, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Slope {
    pub exponent: f64,
    pub error: f64,
}

/// Growth of the costs of an accelerator with the size of a scene.
#[derive(Debug, Serialize)]
pub(super) struct Growth {
    pub scene: &'static str,
    pub accelerator: &'static str,
    pub build: Slope,
    pub memory: Slope,
    /// Nodes and tests of a ray.
    pub work: Slope,
    /// Time of a ray.
    pub time: Slope,
}

/// All that was measured and what follows from it.
#[derive(Debug, Default, Serialize)]
pub(super) struct Costs {
    pub figures: Vec<Figure>,
    pub growth: Vec<Growth>,
}

/// Growth of every accelerator on every scene with three sizes or more.
pub(super) fn of(figures: &[Figure]) -> Vec<Growth> {
    let mut growth = Vec::new();
    for (index, first) in figures.iter().enumerate() {
        let same = |figure: &&Figure| (figure.scene, figure.accelerator) == (first.scene, first.accelerator);
        if figures[..index].iter().any(|figure| same(&figure)) {
            continue;
        }
        let series: Vec<&Figure> = figures.iter().filter(same).collect();
        let slope = |cost: fn(&Figure) -> f64| {
            fit(&series.iter().map(|figure| (figure.primitives as f64, cost(figure))).collect::<Vec<_>>())
        };
        if let (Some(build), Some(memory), Some(work), Some(time)) = (
            slope(|figure| figure.build_seconds),
            slope(|figure| figure.bytes as f64),
            slope(Figure::work),
            slope(Figure::seconds_per_ray),
        ) {
            growth.push(Growth { scene: first.scene, accelerator: first.accelerator, build, memory, work, time });
        }
    }
    growth
}

/// Exponent of a power law through points; `None` for fewer than three.
fn fit(points: &[(f64, f64)]) -> Option<Slope> {
    let logs: Vec<[f64; 2]> = points.iter().map(|&(x, y)| [log(x), log(y)]).collect();
    let LineFit { slope, slope_error, .. } = LineFit::of(&logs);
    (points.len() > 2).then_some(Slope { exponent: slope, error: slope_error })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_found_exactly() {
        let points = [1e3, 1e4, 1e5].map(|n: f64| (n, 7.0 * n.sqrt()));
        let slope = fit(&points).unwrap();
        assert!((slope.exponent - 0.5).abs() < 1e-12 && slope.error < 1e-12);
    }

    #[test]
    fn two_points_are_no_series() {
        assert_eq!(fit(&[(1.0, 1.0), (2.0, 2.0)]), None);
    }
}
