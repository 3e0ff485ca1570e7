//! Claims of reports and lectures about accelerators, with computed verdicts.

use super::{
    figure::{Figure, RayFigure},
    growth::{Costs, Growth},
};
use crate::number::{grouped, three_digits};

/// One line for each claim that was measured.
pub(super) fn of(costs: &Costs) -> Vec<String> {
    let claims = [brute_force, even_spheres, cube_root, logarithm, stadium, fewest, loose, planes, intervals, lazy];
    claims.into_iter().filter_map(|claim| claim(costs)).collect()
}

const TREES: [&str; 8] = ["bvh", "bvh8", "sphere-tree", "cylinder-tree", "kd", "bsp", "bih", "bih-lazy"];

impl Costs {
    /// An accelerator on the largest scene of a name.
    fn largest(&self, scene: &str, accelerator: &str) -> Option<&Figure> {
        let figures = self.figures.iter().filter(|figure| (figure.scene, figure.accelerator) == (scene, accelerator));
        figures.max_by_key(|figure| figure.primitives)
    }

    /// The largest scene of each name, with two accelerators on it.
    fn pairs(&self, a: &str, b: &str) -> Vec<(&Figure, &Figure)> {
        let mut scenes: Vec<&str> = Vec::new();
        for figure in &self.figures {
            if !scenes.contains(&figure.scene) {
                scenes.push(figure.scene);
            }
        }
        scenes.into_iter().filter_map(|scene| Some((self.largest(scene, a)?, self.largest(scene, b)?))).collect()
    }

    fn growth(&self, scene: &str, accelerator: &str) -> Option<&Growth> {
        self.growth.iter().find(|growth| (growth.scene, growth.accelerator) == (scene, accelerator))
    }
}

fn verdict(holds: usize, of: usize) -> String {
    match holds {
        0 => "does not hold".to_owned(),
        all if all == of => "holds".to_owned(),
        some => format!("holds on {some} of {of} scenes"),
    }
}

/// Verdict on a claim that is tested for the work and for the time.
const fn work_and_time(of_work: bool, of_time: bool) -> &'static str {
    match (of_work, of_time) {
        (true, true) => "holds for the work and for the time",
        (true, false) => "holds for the work, but not for the time",
        (false, true) => "holds for the time, but not for the work",
        (false, false) => "holds neither for the work nor for the time",
    }
}

/// Sentence with the verdicts on a claim about the build and about the work.
fn build_and_work(of_build: &str, of_work: &str) -> String {
    if of_build == of_work {
        format!("The claim {of_build}.")
    } else {
        format!("The claim {of_build} for the build and {of_work} for the work.")
    }
}

/// The minimum and the maximum of some numbers.
fn range(numbers: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let numbers: Vec<f64> = numbers.into_iter().collect();
    Some((numbers.iter().copied().reduce(f64::min)?, numbers.iter().copied().reduce(f64::max)?))
}

fn brute_force(costs: &Costs) -> Option<String> {
    let Growth { work, time, .. } = costs.growth("mound", "linear")?;
    let holds = (work.exponent - 1.0).abs() < 0.01 && (time.exponent - 1.0).abs() < 0.2;
    Some(format!(
        "**Brute force takes time in proportion to the number of spheres** (the report). On `mound` the tests of a ray \
         grow as n^{:.2} ± {:.2}, its time as n^{:.2} ± {:.2}. The claim {}.",
        work.exponent,
        work.error,
        time.exponent,
        time.error,
        verdict(usize::from(holds), 1)
    ))
}

fn even_spheres(costs: &Costs) -> Option<String> {
    let grid = costs.largest("mound", "grid")?;
    let trees: Vec<&Figure> = TREES.iter().filter_map(|tree| costs.largest("mound", tree)).collect();
    let fastest = trees.iter().min_by(|a, b| a.seconds_per_ray().total_cmp(&b.seconds_per_ray()))?;
    let leanest = trees.iter().min_by(|a, b| a.work().total_cmp(&b.work()))?;
    Some(format!(
        "**The grid beats trees on evenly spread spheres** (the report). On `mound` with {} spheres a ray takes {} nodes \
         and tests in the grid and {} in the leanest tree, `{}`. The time of a ray is {} times that in the fastest tree, \
         `{}`. The time of the build is {} times that of `bvh`. The claim {}.",
        grouped(grid.primitives as u64),
        three_digits(grid.work()),
        three_digits(leanest.work()),
        leanest.accelerator,
        three_digits(grid.seconds_per_ray() / fastest.seconds_per_ray()),
        fastest.accelerator,
        three_digits(grid.build_seconds / costs.largest("mound", "bvh")?.build_seconds),
        work_and_time(grid.work() < leanest.work(), grid.seconds_per_ray() < fastest.seconds_per_ray()),
    ))
}

fn cube_root(costs: &Costs) -> Option<String> {
    let slope = costs.growth("mound", "grid")?.work;
    Some(format!(
        "**A ray in a grid visits ∛n cells** (the lecture). The work of a ray on `mound` grows as n^{:.2} ± {:.2}. The \
         exponent would be 0.33 for rays that cross the whole grid; most end at a surface before.",
        slope.exponent, slope.error
    ))
}

fn logarithm(costs: &Costs) -> Option<String> {
    let sizes: Vec<usize> =
        costs.figures.iter().filter(|figure| figure.scene == "mound").map(|figure| figure.primitives).collect();
    let (min, most) = (*sizes.iter().min()? as f64, *sizes.iter().max()? as f64);
    let log = rt_math::transcendental::log;
    let expected = log(log(most) / log(min)) / log(most / min);
    let slopes = |accelerator: &str| {
        let slopes = costs.growth.iter().filter(|growth| growth.accelerator == accelerator);
        let (min, max) = range(slopes.map(|growth| growth.work.exponent))?;
        Some(format!("`{accelerator}` {min:.2}–{max:.2}"))
    };
    let slopes: Vec<String> = TREES.iter().filter_map(|tree| slopes(tree)).collect();
    Some(format!(
        "**Hierarchies need O(log n)** (the lecture). Over these sizes log n grows like n^{expected:.2}. Exponents of \
         the work over all scenes: {}.",
        slopes.join(", ")
    ))
}

fn stadium(costs: &Costs) -> Option<String> {
    let [grid, bvh] = [costs.largest("stadium", "grid")?, costs.largest("stadium", "bvh")?];
    let ratio = grid.work() / bvh.work();
    Some(format!(
        "**A teapot in a stadium defeats the grid** (Haines). A ray takes {} nodes and tests in the grid and {} in `bvh`. \
         These are {} times as many, and they take {} times as long. In the grid this work grows as n^{:.2}. The claim {}.",
        three_digits(grid.work()),
        three_digits(bvh.work()),
        three_digits(ratio),
        three_digits(grid.seconds_per_ray() / bvh.seconds_per_ray()),
        costs.growth("stadium", "grid")?.work.exponent,
        verdict(usize::from(ratio > 10.0), 1)
    ))
}

fn fewest(costs: &Costs) -> Option<String> {
    let scenes = costs.pairs("kd", "kd");
    if scenes.is_empty() {
        return None;
    }
    let min = |cost: fn(&RayFigure) -> f64| {
        let best = |scene: &str| {
            let cost = |figure: &Figure| figure.rays.iter().map(cost).sum::<f64>();
            let figures = TREES.iter().filter_map(|tree| costs.largest(scene, tree));
            figures.min_by(|a, b| cost(a).total_cmp(&cost(b))).map(|figure| (figure.scene, figure.accelerator))
        };
        scenes.iter().filter_map(|(figure, _)| best(figure.scene)).collect::<Vec<_>>()
    };
    let list = |winners: &[(&str, &str)]| {
        winners.iter().map(|(scene, accelerator)| format!("{scene} `{accelerator}`")).collect::<Vec<_>>().join(", ")
    };
    let (nodes, tests) = (min(RayFigure::nodes_per_ray), min(RayFigure::tests_per_ray));
    let holds = nodes.iter().filter(|(_, accelerator)| *accelerator == "kd").count();
    Some(format!(
        "**The kd-tree visits the fewest nodes of all trees** (the lecture). Fewest nodes visited: {}. Fewest primitives \
         tested: {}. The claim {}. A visit of a node of `bvh8` tests eight boxes, of `bvh` two boxes, and of `kd` one \
         plane.",
        list(&nodes),
        list(&tests),
        verdict(holds, nodes.len())
    ))
}

/// Ratios of one accelerator to another, as a range over all scenes.
fn ratios(costs: &Costs, a: &str, b: &str, cost: fn(&Figure) -> f64) -> Option<String> {
    let (min, max) = range(costs.pairs(a, b).into_iter().map(|(a, b)| cost(a) / cost(b)))?;
    Some(format!("{} to {}", three_digits(min), three_digits(max)))
}

fn loose(costs: &Costs) -> Option<String> {
    let against = |accelerator| ratios(costs, accelerator, "bvh", Figure::work);
    let pairs = [costs.pairs("sphere-tree", "bvh"), costs.pairs("cylinder-tree", "bvh")].concat();
    let holds = pairs.iter().filter(|(volume, bvh)| volume.work() > bvh.work()).count();
    Some(format!(
        "**Boxes fit better than spheres and cylinders** (the lecture). In `sphere-tree` a ray takes {} times the nodes and \
         tests of `bvh`, in `cylinder-tree` {} times. Boxes need less work in {holds} of {} comparisons.",
        against("sphere-tree")?,
        against("cylinder-tree")?,
        pairs.len()
    ))
}

fn planes(costs: &Costs) -> Option<String> {
    let pairs = costs.pairs("bsp", "kd");
    let holds = pairs.iter().filter(|(bsp, kd)| bsp.work() < kd.work()).count();
    Some(format!(
        "**Planes of any direction fit better than those along the axes** (the lecture). In `bsp` a ray takes {} times the \
         nodes and tests of `kd`. The build takes {} times as long. The claim {} for the work.",
        ratios(costs, "bsp", "kd", Figure::work)?,
        ratios(costs, "bsp", "kd", |figure| figure.build_seconds)?,
        verdict(holds, pairs.len())
    ))
}

fn intervals(costs: &Costs) -> Option<String> {
    let pairs = costs.pairs("bih", "bvh");
    let builds = pairs.iter().filter(|(bih, bvh)| bih.build_seconds < bvh.build_seconds).count();
    let walks = pairs.iter().filter(|(bih, bvh)| bih.work() > bvh.work()).count();
    Some(format!(
        "**A bounding interval hierarchy is built faster than a tree of boxes and traversed more slowly** (Wächter and Keller). \
         `bih` takes {} times the build time of `bvh` and {} times its memory. It takes {} times its nodes and tests. {}",
        ratios(costs, "bih", "bvh", |figure| figure.build_seconds)?,
        ratios(costs, "bih", "bvh", Figure::bytes_per_primitive)?,
        ratios(costs, "bih", "bvh", Figure::work)?,
        build_and_work(&verdict(builds, pairs.len()), &verdict(walks, pairs.len()))
    ))
}

/// Build and first image; NaN without primary rays.
fn first_image(figure: &Figure) -> f64 {
    figure.build_seconds + figure.of("primary").map_or(f64::NAN, |rays| rays.first_seconds)
}

fn lazy(costs: &Costs) -> Option<String> {
    let pairs = costs.pairs("bih-lazy", "bih");
    let rays = pairs.first()?.0.of("primary")?.rays;
    let holds = pairs.iter().filter(|(lazy, full)| first_image(lazy) < first_image(full)).count();
    Some(format!(
        "**Building where rays go shows the first image sooner** (Wächter and Keller). For build and {} \
         first rays, `bih-lazy` takes {} times as long as `bih`, and {} times as long as `bvh`. Compared with `bih` \
         the claim {}.",
        grouped(rays as u64),
        ratios(costs, "bih-lazy", "bih", first_image)?,
        ratios(costs, "bih-lazy", "bvh", first_image)?,
        verdict(holds, pairs.len())
    ))
}

#[cfg(test)]
mod tests {
    use super::{super::growth, *};

    fn figure(scene: &'static str, primitives: usize, accelerator: &'static str, work: u64) -> Figure {
        let rays = |kind| RayFigure {
            kind,
            rays: 10,
            hits: 5,
            nodes: work * 10,
            tests: 0,
            seconds: work as f64,
            first_seconds: 1.0,
        };
        Figure {
            scene,
            primitives,
            accelerator,
            build_seconds: 1.0,
            bytes: primitives,
            nodes: 1,
            leaves: 1,
            references: 1,
            max_depth: 1,
            rays: ["primary", "shadow", "diffuse"].map(rays).into(),
        }
    }

    /// `grid_work` on the largest mound, where the tree takes 20.
    fn costs(grid_work: u64) -> Costs {
        let mut figures = Vec::new();
        for (size, work) in [(10, 5), (100, 10), (1000, 20)] {
            figures.push(figure("mound", size, "linear", size as u64));
            figures.push(figure("mound", size, "grid", grid_work * work / 20));
            figures.push(figure("mound", size, "bvh", work));
            figures.push(figure("rock", size, "bvh", work));
        }
        Costs { growth: growth::of(&figures), figures }
    }

    #[test]
    fn verdicts_follow_the_figures() {
        assert!(even_spheres(&costs(10)).unwrap().ends_with("The claim holds for the work and for the time."));
        let slow = even_spheres(&costs(40)).unwrap();
        assert!(slow.ends_with("The claim holds neither for the work nor for the time."), "{slow}");
        assert!(slow.contains("40.0 nodes and tests in the grid and 20.0 in the leanest tree, `bvh`"), "{slow}");
        assert!(
            brute_force(&costs(10)).unwrap().contains("n^1.00 ± 0.00, its time as n^1.00 ± 0.00. The claim holds.")
        );
    }

    #[test]
    fn equal_verdicts_are_stated_once() {
        assert_eq!(build_and_work("holds", "holds"), "The claim holds.");
        let differing = "The claim does not hold for the build and holds for the work.";
        assert_eq!(build_and_work("does not hold", "holds"), differing);
    }

    #[test]
    fn what_was_not_measured_is_not_claimed() {
        assert_eq!(of(&Costs::default()), [""; 0]);
        assert!(stadium(&costs(10)).is_none());
    }

    #[test]
    fn pairs_are_of_the_largest_scenes() {
        let costs = costs(10);
        let pairs = costs.pairs("bvh", "bvh");
        assert_eq!(
            pairs.iter().map(|(a, _)| (a.scene, a.primitives)).collect::<Vec<_>>(),
            [("mound", 1000), ("rock", 1000)]
        );
    }
}
