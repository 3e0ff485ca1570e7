//! A laser scanner in a forest: primitives of a program of its own, in every accelerator, with most of the queries of rt-accel.
//!
//! `cargo run --release --manifest-path examples/lidar/Cargo.toml`

use std::error::Error;
use std::ops::ControlFlow;
use std::time::Instant;

use rt_accel::{
    Aabb, Accelerator, AnyAccelerator, SphereRegion, Bvh, Counters, DVec3, Hit, Interval, ClosestPoint, NoProbe, Primitives, Ray,
    Refit, AcceleratorKind,
};

/// An upright trunk: where it stands, how thick and how high it is.
#[derive(Clone, Copy)]
struct Trunk {
    foot: DVec3,
    radius: f64,
    height: f64,
}

/// All that rt-accel has to know: how many there are, the box of each, and where a ray meets one.
struct Forest(Vec<Trunk>);

impl Primitives for Forest {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        let Trunk { foot, radius, height } = self.0[index as usize];
        let reach = DVec3::new(radius, 0.0, radius);
        Some(Aabb::new(foot - reach, foot + reach + DVec3::Y * height))
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let Trunk { foot, radius, height } = self.0[index as usize];
        // The circle that is seen from above, and then the height of what is met.
        let (o, d) = (ray.origin - foot, ray.direction);
        let a = d.x * d.x + d.z * d.z;
        let half_b = o.x * d.x + o.z * d.z;
        let c = o.x * o.x + o.z * o.z - radius * radius;
        let root = (half_b * half_b - a * c).sqrt();
        let is_on_trunk = |t: &f64| span.contains(*t) && (0.0..=height).contains(&(o.y + t * d.y));
        let t = [(-half_b - root) / a, (-half_b + root) / a].into_iter().find(is_on_trunk)?;
        Some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
    }
}

impl ClosestPoint for Forest {
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
        let Trunk { foot, radius, height } = self.0[index as usize];
        let beside = (point - foot).with_y(0.0);
        let side = beside.normalize_or(DVec3::X) * radius;
        Some(foot + side + DVec3::Y * (point.y - foot.y).clamp(0.0, height))
    }
}

/// Numbers between 0 and 1 that look random and are the same everywhere (Roberts 2018).
fn scatter(i: u32, k: u32) -> f64 {
    (f64::from(i)
        * [0.754_877_666_246_693, 0.569_840_290_998_053, 0.618_033_988_749_895, 0.414_213_562_373_095][k as usize % 4])
        .fract()
}

fn forest(count: u32) -> Forest {
    let trunk = |i: u32| Trunk {
        foot: DVec3::new(scatter(i, 0) - 0.5, 0.0, scatter(i, 1) - 0.5) * 200.0,
        radius: 0.1 + 0.3 * scatter(i, 2),
        height: 4.0 + 20.0 * scatter(i, 3),
    };
    Forest((0..count).map(trunk).collect())
}

/// A scan: rings of rays from 2 m above the ground.
fn scan() -> Vec<Ray> {
    let ray = |i: u32| {
        let angle = f64::from(i % 1000) / 1000.0 * std::f64::consts::TAU;
        let rise = f64::from(i / 1000) / 40.0 - 0.2;
        Ray::new(DVec3::Y * 2.0, DVec3::new(angle.cos(), rise, angle.sin()))
    };
    (0..20_000).map(ray).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut forest = forest(5000);
    let rays = scan();
    println!("{:11} {:>8} {:>8} {:>10} {:>10}", "accelerator", "Mrays/s", "KiB", "nodes/ray", "tests/ray");
    let mut answers: Vec<Vec<Option<u64>>> = Vec::new();
    for &kind in AcceleratorKind::ALL {
        let accelerator = AnyAccelerator::build(kind, &forest)?;
        accelerator.validate(&forest)?;
        let start = Instant::now();
        let hits: Vec<_> =
            rays.iter().map(|ray| accelerator.closest(&forest, ray, Interval::FORWARD, &mut NoProbe)).collect();
        let speed = rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6;

        // Once more with a probe that counts; `NoProbe` costs nothing.
        let mut counters = Counters::default();
        for ray in &rays {
            accelerator.closest(&forest, ray, Interval::FORWARD, &mut counters);
        }
        let per_ray = |count: u64| count as f64 / rays.len() as f64;
        let (nodes, tests) = (per_ray(counters.total().nodes), per_ray(counters.total().tests));
        let kib = accelerator.memory() as f64 / 1024.0;
        println!("{:11} {speed:8.2} {kib:8.1} {nodes:10.2} {tests:10.2}", kind.name());
        answers.push(hits.iter().map(|hit| hit.map(|hit| hit.t.to_bits())).collect());
    }
    if answers.windows(2).any(|pair| pair[0] != pair[1]) {
        return Err("the accelerators disagree, which cannot be".into());
    }
    println!("All of them give the same {} hits, bit for bit.\n", answers[0].iter().flatten().count());

    let mut bvh = Bvh::build(&forest)?;
    let me = DVec3::new(3.0, 1.5, 4.0);
    if let Some(nearest) = bvh.nearest_point(&forest, me, 50.0) {
        println!("The nearest trunk is number {}, {:.2} m away.", nearest.primitive, nearest.distance);
    }
    let mut n_near = 0;
    bvh.visit_overlapping(&forest, &SphereRegion { centre: me, radius: 10.0 }, |_| {
        n_near += 1;
        ControlFlow::Continue(())
    });
    println!("{n_near} trunks may stand within 10 m.");
    let mut first = [None; 3];
    let found = bvh.first_hits(&forest, &Ray::new(me, DVec3::X), Interval::FORWARD, &mut first, &mut NoProbe);
    println!(
        "Eastward, the first {found} hits are at {:?} m.",
        first.iter().flatten().map(|hit| hit.t).collect::<Vec<_>>()
    );
    // A storm moves the trees; the tree of boxes follows.
    for (i, trunk) in (0..).zip(&mut forest.0) {
        trunk.foot += DVec3::new(scatter(i, 2), 0.0, scatter(i, 3)) - 0.5;
    }
    bvh.refit(&forest)?;
    bvh.validate(&forest)?;
    println!(
        "After the storm, the nearest is {:.2} m away.",
        bvh.nearest_point(&forest, me, 50.0).map_or(0.0, |p| p.distance)
    );
    Ok(())
}
