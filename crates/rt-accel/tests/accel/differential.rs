//! Every accelerator gives the bits of brute force, on rays that look for the seams.

use std::sync::LazyLock;

use crate::soup::rays::{Query, adversarial};
use crate::soup::{Solid, Soup, run_seed};
use rt_accel::{
    Aabb, Accelerator, Bih, BspTree, Bvh, Counters, CylinderTree, DVec3, Hit, Interval, KdTree, LazyBih, Linear,
    NoProbe, Primitives, Ray, SphereTree, SplitMethod, UniformGrid, WideBvh, brute_force,
    wide::{BuildParams, Quality, SimdLevel},
};
use rt_tests::Draw;

/// Rays per scene; the environment variable `RT_RAYS` sets another number for long runs.
fn n_rays() -> usize {
    std::env::var("RT_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(3000)
}

/// Counts of a comparison.
struct Outcome {
    n_hits: usize,
    /// Part of all primitives that were tested: 1 if nothing was culled, and the comparison says nothing.
    tested: f64,
    /// Nodes visited per ray.
    nodes: f64,
}

/// A ray, and its hits by brute force.
struct Answer {
    query: Query,
    closest: Option<Hit>,
    /// All hits, of each eighth ray.
    all: Option<Vec<Hit>>,
}

/// Primitives and rays with the hits of brute force, which many accelerators are compared with.
struct Answers {
    soup: Soup,
    seed: u64,
    rays: Vec<Answer>,
}

impl Answers {
    fn new(soup: Soup, seed: u64) -> Self {
        let bounds = soup.0.iter().filter_map(Solid::bounds);
        let world = Aabb::from_points(bounds.flat_map(|bounds| [bounds.min, bounds.max]));
        let mut draw = Draw::new(seed);
        let linear = Linear::build(&soup).unwrap();
        let answer = |i: usize| {
            let query @ Query { ray, span } = adversarial(&soup, &world, &mut draw);
            let closest = brute_force::closest(&soup, &ray, span, &mut NoProbe);
            let all = i.is_multiple_of(8).then(|| {
                let occluded = brute_force::occluded(&soup, &ray, span, &mut NoProbe);
                assert_eq!(occluded, closest.is_some(), "seed {seed}, ray {i}: {query:?}");
                let mut all = Vec::new();
                linear.all_hits(&soup, &ray, span, &mut all, &mut NoProbe);
                all
            });
            Answer { query, closest, all }
        };
        let rays: Vec<Answer> = (0..n_rays()).map(answer).collect();
        let n_several = rays.iter().filter(|ray| ray.all.as_ref().is_some_and(|all| all.len() > 1)).count();
        assert!(n_several > n_rays() / 400, "seed {seed}: {n_several} rays with several hits");
        Self { soup, seed, rays }
    }

    fn compare<A: Accelerator>(&self, name: &str, accelerator: &A) -> Outcome {
        let Self { soup, seed, rays } = self;
        let mut found_all = Vec::new();
        let mut n_hits = 0;
        let mut counters = Counters::default();
        for (i, Answer { query, closest, all }) in rays.iter().enumerate() {
            let Query { ray, span } = query;
            let found = accelerator.closest(soup, ray, *span, &mut counters);
            let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.instance, hit.primitive));
            assert_eq!(key(found), key(*closest), "{name}, seed {seed}, ray {i}: {query:?}");
            let occluded = accelerator.occluded(soup, ray, *span, &mut NoProbe);
            assert_eq!(occluded, closest.is_some(), "{name}, seed {seed}, ray {i}: {query:?}");
            n_hits += usize::from(occluded);
            if let Some(all) = all {
                accelerator.all_hits(soup, ray, *span, &mut found_all, &mut NoProbe);
                let keys = |hits: &[Hit]| hits.iter().map(|hit| key(Some(*hit))).collect::<Vec<_>>();
                assert_eq!(keys(&found_all), keys(all), "{name}, seed {seed}, ray {i}: {query:?}");
            }
        }
        let tested = counters.total().tests as f64 / (n_rays() * soup.len()) as f64;
        Outcome { n_hits, tested, nodes: counters.total().nodes as f64 / n_rays() as f64 }
    }
}

fn compare<A: Accelerator>(name: &str, accelerator: &A, soup: &Soup, seed: u64) -> Outcome {
    Answers::new(soup.clone(), seed).compare(name, accelerator)
}

/// Mixed solids at several distances from the origin and of several sizes, with and without an unbounded one.
fn scenes(seed: u64) -> Vec<(String, Soup)> {
    let mut draw = Draw::new(seed);
    let direction = DVec3::new(1.0, -0.7, 0.3);
    let mut scenes = Vec::new();
    for offset in [0.0, 1e3, 1e5, 1e7] {
        scenes.push((format!("offset {offset:e}"), Soup::mixed(&mut draw).moved(direction * offset)));
    }
    scenes.push(("scale 1e-4".into(), Soup::mixed(&mut draw).scaled(1e-4)));
    scenes.push(("scale 1e-4, offset 1e3".into(), Soup::mixed(&mut draw).scaled(1e-4).moved(direction * 1e3)));
    scenes.push(("scale 1e30".into(), Soup::mixed(&mut draw).scaled(1e30)));
    let mut with_ground = Soup::mixed(&mut draw);
    with_ground.0.insert(17, Solid::Ground { height: -0.4 });
    with_ground.0.push(Solid::Ground { height: -0.4 });
    scenes.push(("unbounded".into(), with_ground));
    scenes
}

fn compare_all<A: Accelerator>(name: &str, most_tested: f64, build: impl Fn(&Soup) -> A) {
    /// Computed once for all accelerators.
    static SCENES: LazyLock<Vec<(String, Answers)>> = LazyLock::new(|| {
        let scenes = scenes(run_seed()).into_iter().zip(run_seed()..);
        scenes.map(|((scene, soup), seed)| (scene, Answers::new(soup, seed))).collect()
    });
    println!("{name}: seed {}", run_seed());
    let mut total = 0;
    for (scene, answers) in SCENES.iter() {
        let accelerator = build(&answers.soup);
        let Outcome { n_hits, tested, .. } = answers.compare(&format!("{name}, {scene}"), &accelerator);
        assert_eq!(accelerator.validate(&answers.soup), Ok(()), "{name}, {scene}");
        println!("{name}, {scene}: {} rays, {n_hits} hits, {tested:.3} of primitives tested, 0 differences", n_rays());
        assert!(n_hits > n_rays() / 10, "{scene}: rays must hit something to mean anything, {n_hits} did");
        assert!(tested < most_tested, "{scene}: {tested} of all primitives were tested");
        total += n_rays();
    }
    println!("{name}: {total} rays");
}

#[test]
fn accelerators_equal_brute_force() {
    compare_all("bvh", 0.1, |soup| Bvh::build(soup).unwrap());
    compare_all("kd", 0.1, |soup| KdTree::build(soup).unwrap());
    compare_all("bsp", 0.1, |soup| BspTree::build(soup).unwrap());
    compare_all("spheres", 0.1, |soup| SphereTree::build(soup).unwrap());
    compare_all("cylinders", 0.1, |soup| CylinderTree::build(soup).unwrap());
    compare_all("bih", 0.1, |soup| Bih::build(soup).unwrap());
    compare_all("lazy bih", 0.1, |soup| LazyBih::build(soup).unwrap());
    compare_all("grid", 0.2, |soup| {
        let grid = UniformGrid::build(soup).unwrap();
        assert!(grid.resolution().iter().all(|&n| n > 3), "{:?}", grid.resolution());
        grid
    });
}

#[test]
fn bvhs_of_other_methods_equal_brute_force() {
    compare_all("bvh by medians", 0.2, |soup| Bvh::build_with(soup, SplitMethod::Median).unwrap());
    compare_all("bvh with spatial splits", 0.1, |soup| Bvh::build_with(soup, SplitMethod::Spatial).unwrap());
}

/// Long thin solids that cross each other: planes cut through nearly all of them.
#[test]
fn spatial_splits_of_crossing_sticks_equal_brute_force() {
    for (i, offset) in [0.0, 1e7].into_iter().enumerate() {
        let mut sticks = Soup::sticks(300, &mut Draw::new(41));
        sticks.0.extend(Soup::spheres(300, &mut Draw::new(40)).0);
        let sticks = sticks.moved(DVec3::splat(offset));
        let bvh = Bvh::build_with(&sticks, SplitMethod::Spatial).unwrap();
        assert_eq!(bvh.validate(&sticks), Ok(()));
        let [all, whole] = [bvh.build_stats().references, sticks.len()];
        assert!(all > whole + whole / 4, "{all} references to {whole} sticks: hardly any is cut");
        let by_area = Bvh::build(&sticks).unwrap();
        let answers = Answers::new(sticks, 42 + i as u64);
        let [outcome, by_area] = [&bvh, &by_area].map(|bvh| answers.compare("sticks", bvh));
        assert!(outcome.nodes < by_area.nodes, "{} and {} nodes", outcome.nodes, by_area.nodes);
    }
}

#[test]
fn bvh_over_one_primitive_equals_brute_force() {
    for count in 1..=3 {
        let soup = Soup(Soup::mixed(&mut Draw::new(3)).0.into_iter().take(count).collect());
        assert_eq!(soup.len(), count);
        compare("bvh", &Bvh::build(&soup).unwrap(), &soup, 5);
    }
}

/// Each kind of leaf, near and far, large and small, by all instructions that the processor has.
#[test]
fn wide_equals_brute_force_with_all_leaves_and_instructions() {
    let seed = run_seed();
    println!("wide: seed {seed}");
    type Kind = (&'static str, fn(&mut Draw) -> Soup);
    let kinds: [Kind; 7] = [
        ("facets", Soup::facets),
        ("triangles", Soup::triangles),
        ("facets and others", |draw| Soup::facets(draw).with_others(draw)),
        ("triangles and others", |draw| Soup::triangles(draw).with_others(draw)),
        ("spheres", |draw| Soup::spheres(300, draw)),
        ("marbles", Soup::marbles),
        ("mixed", Soup::mixed),
    ];
    let n_levels = SimdLevel::ALL.iter().filter(|level| level.is_available()).count();
    for (k, (name, soup)) in kinds.into_iter().enumerate() {
        for (j, (scale, offset)) in [(1.0, 0.0), (1e-3, 0.0), (1e3, 7e3), (1.0, 1e4), (1e12, 0.0)].iter().enumerate() {
            let soup = soup(&mut Draw::new(seed)).scaled(*scale).moved(DVec3::new(1.0, -0.7, 0.3) * *offset);
            let answers = Answers::new(soup, seed + (5 * k + j) as u64);
            for (i, &level) in SimdLevel::ALL.iter().filter(|level| level.is_available()).enumerate() {
                // The default level meets each kind of leaf at each scale, and others take turns.
                if level != SimdLevel::best() && !(i + j + k).is_multiple_of(3) {
                    continue;
                }
                let wide = WideBvh::build(&answers.soup).unwrap().with_level(level);
                assert_eq!((wide.level(), wide.validate(&answers.soup)), (level, Ok(())));
                let name = format!("{} {name}, scale {scale:e}, offset {offset:e}", level.name());
                let outcome = answers.compare(&name, &wide);
                assert!(outcome.n_hits > n_rays() / 10, "{name}: {} hits", outcome.n_hits);
                assert!(outcome.tested < 0.15, "{name}: {} of all primitives were tested", outcome.tested);
            }
        }
    }
    assert!(n_levels >= 1);
}

/// Many near one place, or few; one of another size than the rest; some within others.
fn heaps(draw: &mut Draw) -> Vec<(&'static str, Soup)> {
    let mut uneven = Soup::spheres(60, draw);
    uneven.0.push(Solid::Sphere { centre: DVec3::NEG_Y * 1001.0, radius: 1000.0 });
    uneven.0.push(Solid::Sphere { centre: DVec3::ZERO, radius: 1e-7 });
    uneven.0.push(Solid::Sphere { centre: DVec3::ZERO, radius: 1.5 });
    let mut with_ground = Soup::spheres(20, draw);
    with_ground.0.insert(3, Solid::Ground { height: -0.3 });
    vec![
        ("one", Soup::spheres(1, draw)),
        ("three", Soup::spheres(3, draw)),
        ("sixteen", Soup::spheres(16, draw)),
        ("seventeen", Soup::spheres(17, draw)),
        ("many", Soup::spheres(600, draw)),
        ("uneven", uneven),
        ("with ground", with_ground),
        ("mixed", Soup(Soup::mixed(draw).0.into_iter().take(40).collect())),
    ]
}

/// Not only the answers are those of brute force, but also what is counted on the way.
#[test]
fn linear_equals_brute_force_to_the_last_test() {
    let seed = run_seed();
    println!("linear: seed {seed}");
    let (mut n_hits, mut n_tested) = (0, 0);
    for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
        for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e3, 7e3), (1.0, 1e4), (1e-3, 1e5), (1e12, 0.0), (1e-50, 0.0)]
        {
            let mut draw = Draw::new(seed);
            for (name, soup) in heaps(&mut draw) {
                let soup = soup.scaled(scale).moved(DVec3::new(1.0, -0.7, 0.3) * offset);
                let linear = Linear::build(&soup).unwrap().with_level(level);
                assert_eq!(linear.validate(&soup), Ok(()), "{name}");
                let bounds = soup.0.iter().filter_map(Solid::bounds);
                let world = Aabb::from_points(bounds.flat_map(|bounds| [bounds.min, bounds.max]));
                for i in 0..n_rays() / 10 {
                    let query @ Query { ray, span } = adversarial(&soup, &world, &mut draw);
                    let [mut expected, mut counted] = [Counters::default(); 2];
                    let hit = brute_force::closest(&soup, &ray, span, &mut expected);
                    let found = linear.closest(&soup, &ray, span, &mut counted);
                    let occluded = brute_force::occluded(&soup, &ray, span, &mut expected);
                    let found_occluded = linear.occluded(&soup, &ray, span, &mut counted);
                    let name = format!("{} {name}, scale {scale:e}, offset {offset:e}, ray {i}", level.name());
                    assert_eq!((found, found_occluded), (hit, occluded), "{name}: {query:?}");
                    assert_eq!(counted.total(), expected.total(), "{name}: {query:?}");
                    n_hits += usize::from(occluded);
                    n_tested += 1;
                }
            }
        }
    }
    println!("linear: {n_tested} rays, {n_hits} hits, 0 differences");
    assert!(n_hits > n_tested / 4);
}

#[test]
fn lists_of_spheres_answer_useless_rays_and_spans_as_brute_force_does() {
    let soup = Soup::spheres(50, &mut Draw::new(3));
    let numbers = [0.0, -0.0, 0.5, -1.0, 1e-320, 1e-30, 1e30, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
        let linear = Linear::build(&soup).unwrap().with_level(level);
        let mut draw = Draw::new(4);
        for _ in 0..n_rays() {
            let mut vector = || DVec3::new(draw.pick(&numbers), draw.pick(&numbers), draw.pick(&numbers));
            let ray = Ray::new(vector(), vector());
            let span = Interval { min: draw.pick(&numbers), max: draw.pick(&numbers) };
            let found = linear.closest(&soup, &ray, span, &mut NoProbe);
            let bits = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive));
            assert_eq!(bits(found), bits(brute_force::closest(&soup, &ray, span, &mut NoProbe)), "{ray:?} {span:?}");
            let expected = brute_force::occluded(&soup, &ray, span, &mut NoProbe);
            assert_eq!(linear.occluded(&soup, &ray, span, &mut NoProbe), expected, "{ray:?} {span:?}");
        }
    }
}

#[test]
fn wide_of_every_quality_equals_brute_force() {
    for quality in [Quality::Low, Quality::Medium, Quality::High] {
        let build =
            |soup: &Soup| WideBvh::build_with(soup, &BuildParams { quality, ..BuildParams::default() }).unwrap();
        compare_all(&format!("wide, {quality:?}"), 0.1, build);
    }
}

#[test]
fn fine_and_lopsided_grids_equal_brute_force() {
    for resolution in [[64, 64, 64], [2, 0, 100]] {
        compare_all(&format!("grid {resolution:?}"), 5.0, |soup| {
            UniformGrid::with_resolution(soup, resolution).unwrap()
        });
    }
}
