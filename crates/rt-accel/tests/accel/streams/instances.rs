//! Streams of rays through sets with instances.

use std::sync::atomic::{AtomicU32, Ordering};

use rt_accel::wide::SmallSet;
use rt_accel::{
    Aabb, Accelerator, Bvh, Counters, DVec3, Hit, HitStream, Interval, NoProbe, PacketKernel, Primitives, Probe, Ray,
    RayStream, WideBvh, brute_force,
};

use super::{bundles, key, levels, with_odd_ones};
use crate::soup::{Solid, Soup, run_seed};
use rt_tests::Draw;

/// A set with instances, with primitives that cast no shadow, and with hits that carry instance ids.
struct Yard<'t, T> {
    things: Vec<Thing<'t, T>>,
    /// Single-ray queries of instances.
    n_single: AtomicU32,
}

struct Thing<'t, T> {
    soup: &'t Soup,
    /// Accelerator of an instance; without one, the only solid of the soup.
    accelerator: Option<&'t T>,
    casts_shadow: bool,
}

impl<T: Accelerator> Primitives for Yard<'_, T> {
    fn len(&self) -> usize {
        self.things.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        let bounds = self.things[index as usize].soup.0.iter().map(Solid::bounds);
        bounds.reduce(|all, one| Some(all?.union(one?))).flatten()
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.intersect_with_stats(index, ray, span, &mut NoProbe)
    }
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.occludes_with_stats(index, ray, span, &mut NoProbe)
    }
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        let Thing { soup, accelerator, .. } = self.things[index as usize];
        let hit = match accelerator {
            Some(accelerator) => {
                self.n_single.fetch_add(1, Ordering::Relaxed);
                accelerator.closest(soup, ray, span, probe)
            }
            None => soup.intersect(0, ray, span),
        };
        hit.map(|hit| Hit { instance: index, ..hit })
    }
    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let Thing { soup, accelerator, casts_shadow } = self.things[index as usize];
        casts_shadow
            && match accelerator {
                Some(accelerator) => {
                    self.n_single.fetch_add(1, Ordering::Relaxed);
                    accelerator.occluded(soup, ray, span, probe)
                }
                None => soup.occludes(0, ray, span),
            }
    }
    fn packet_kernel(&self, index: u32) -> PacketKernel {
        let Thing { soup, accelerator, .. } = self.things[index as usize];
        if accelerator.is_some() { PacketKernel::Instance } else { soup.packet_kernel(0) }
    }
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        [index, 0]
    }
    fn casts_shadow(&self, index: u32) -> bool {
        self.things[index as usize].casts_shadow
    }
    fn intersect_stream<S: Probe>(&self, index: u32, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        let Thing { soup, accelerator, .. } = self.things[index as usize];
        accelerator.unwrap().closest_stream(soup, rays, hits, probe);
        hits.instance.as_mut_slice()[..rays.len()].fill(index);
    }
    fn occludes_stream<S: Probe>(&self, index: u32, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        let Thing { soup, accelerator, casts_shadow } = self.things[index as usize];
        if casts_shadow {
            accelerator.unwrap().occluded_stream(soup, rays, occluded, probe);
        } else {
            occluded.fill(false);
        }
    }
}

/// Compares small sets and trees that contain instances with brute force.
fn compare_yards<T: Accelerator>(seed: u64, build: fn(&Soup) -> T, counts: bool) {
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..25 {
        let scale = draw.pick(&[1.0, 1e-3, 1e12]);
        let offset = DVec3::new(1.0, -0.7, 0.3) * draw.pick(&[0.0, 1e4]);
        let pool = Soup::mixed(draw).0.into_iter().chain(Soup::facets(draw).0).collect::<Vec<_>>();
        let soups: Vec<Soup> = (0..1 + draw.below(SmallSet::CAPACITY))
            .map(|_| {
                let n = draw.pick(&[1, 1, 30]);
                Soup((0..n).map(|_| draw.pick(&pool)).collect()).rounded().scaled(scale).moved(offset)
            })
            .collect();
        let accelerators: Vec<T> = soups.iter().map(build).collect();
        let things = soups
            .iter()
            .zip(&accelerators)
            .map(|(soup, accelerator)| Thing {
                soup,
                accelerator: (soup.0.len() > 1 || draw.one_in(8)).then_some(accelerator),
                casts_shadow: !draw.one_in(4),
            })
            .collect();
        let yard = Yard { things, n_single: AtomicU32::new(0) };
        let everything = Soup(soups.iter().flat_map(|soup| soup.0.clone()).collect());
        let rays = with_odd_ones(bundles(&everything, 600, draw), draw);
        for level in levels() {
            let small_set = SmallSet::new(0..yard.len() as u32).unwrap().with_level(level);
            let wide = WideBvh::build(&yard).unwrap().with_level(level);
            let [mut counted, mut expected] = [Counters::default(); 2];
            for rays in rays.chunks(draw.pick(&[1, 5, 13, 64, 300])) {
                let hits = closest!(small_set, &yard, rays, &mut counted);
                let occluded = occluded!(small_set, &yard, rays, &mut counted);
                let wide_hits = closest!(wide, &yard, rays, &mut NoProbe);
                let wide_occluded = occluded!(wide, &yard, rays, &mut NoProbe);
                for (i, (ray, span)) in rays.iter().enumerate() {
                    let name = format!("round {round}, {}, {ray:?} {span:?}", level.name());
                    let hit = brute_force::closest(&yard, ray, *span, &mut expected);
                    assert_eq!([key(hits[i]), key(wide_hits[i])], [key(hit); 2], "{name}");
                    let is_occluded = brute_force::occluded(&yard, ray, *span, &mut expected);
                    assert_eq!([occluded[i], wide_occluded[i]], [is_occluded; 2], "{name}");
                    n_hits += usize::from(hit.is_some());
                }
            }
            // Rays that miss the bounds of an instance do not enter it.
            let (counted, expected) = (counted.total(), expected.total());
            let is_less = counted.nodes <= expected.nodes && counted.tests <= expected.tests;
            assert!(!counts || is_less && counted.hits == expected.hits, "round {round}: {counted:?} {expected:?}");
        }
    }
    assert!(n_hits > 3000, "{n_hits} hits");
}

/// Bit-identical results, with no more work than brute force where the instances' accelerator counts streams as single rays.
#[test]
fn streams_through_instances_equal_single_queries() {
    let seed = run_seed();
    println!("instances: seed {seed}");
    compare_yards(seed, |soup| Bvh::build(soup).unwrap(), true);
    compare_yards(seed, |soup| WideBvh::build(soup).unwrap(), false);
}

/// Results do not depend on streams of instances, so this test counts single-ray queries.
#[test]
fn packets_enter_instances_together() {
    let draw = &mut Draw::new(3);
    let place = |i: usize| DVec3::new((i % 4) as f64, 0.0, (i / 4) as f64) * 2.5;
    let soups: Vec<Soup> = (0..12).map(|i| Soup::facets(draw).moved(place(i))).collect();
    let accelerators: Vec<WideBvh> = soups.iter().map(|soup| WideBvh::build(soup).unwrap()).collect();
    let thing = |(soup, accelerator)| Thing { soup, accelerator: Some(accelerator), casts_shadow: true };
    let yard = Yard { things: soups.iter().zip(&accelerators).map(thing).collect(), n_single: AtomicU32::new(0) };
    // Groups of sixteen neighbouring rays, as those of a pixel, and five more at the end.
    let eye = DVec3::new(3.7, 9.0, -6.0);
    let rays: Vec<_> = (0..16 * 400 + 5)
        .map(|i: u64| {
            let at = |k: u64| rt_math::random::unit(rt_math::random::hash(&[5, i / 16, k]));
            let neighbour = DVec3::new((i % 4) as f64, 0.0, (i / 4 % 4) as f64) * 1e-3;
            (Ray::new(eye, DVec3::new(8.0 * at(0), 0.0, 6.0 * at(1)) + neighbour - eye), Interval::FORWARD)
        })
        .collect();
    let expected: Vec<_> =
        rays.iter().map(|(ray, span)| brute_force::closest(&yard, ray, *span, &mut NoProbe)).collect();
    for level in levels() {
        let tree = WideBvh::build(&yard).unwrap().with_level(level);
        let small_set = SmallSet::new(0..12).unwrap().with_level(level);
        // A stream of four is a packet of four.
        for (wide, together) in [(true, rays.len()), (true, 4), (false, rays.len())] {
            yard.n_single.store(0, Ordering::Relaxed);
            let (mut hits, mut occluded) = (Vec::new(), Vec::new());
            for rays in rays.chunks(together) {
                if wide {
                    hits.extend(closest!(tree, &yard, rays, &mut NoProbe));
                    occluded.extend(occluded!(tree, &yard, rays, &mut NoProbe));
                } else {
                    hits.extend(closest!(small_set, &yard, rays, &mut NoProbe));
                    occluded.extend(occluded!(small_set, &yard, rays, &mut NoProbe));
                }
            }
            let n_single = yard.n_single.load(Ordering::Relaxed);
            for (i, &hit) in expected.iter().enumerate() {
                assert_eq!((key(hits[i]), occluded[i]), (key(hit), hit.is_some()));
            }
            let n_hits = hits.iter().flatten().count();
            assert!(n_hits > 2000 && (n_single as usize) < rays.len() / 4, "{n_hits} hits, {n_single} single queries");
        }
    }
}
