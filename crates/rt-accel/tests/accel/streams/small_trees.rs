//! Streams of rays through trees of so few triangles that incoherent rays are tested against all of them.

use rt_accel::{Aabb, Accelerator, Counters, DVec3, Interval, NoProbe, Ray, WideBvh, brute_force};
use rt_geometry::{InteractionFlags, Probe, STREAM_CAPACITY, ShapeHit, Triangle};
use rt_math::Vec3;

use super::{bundles, key, levels, with_odd_ones};
use crate::soup::{Solid, Soup, run_seed};
use rt_tests::Draw;

/// Counts the nodes of rays that the list of triangles leaves open, and of coherent packets.
#[derive(Default)]
struct NodesOfOpenRays(u64);

impl Probe for NodesOfOpenRays {
    fn counts_work(&self) -> bool {
        false
    }

    fn node(&mut self) {
        self.0 += 1;
    }
}

/// Compares streams of many sizes with brute force; returns the number of hits.
fn compare(name: &str, tree: &WideBvh, soup: &Soup, rays: &[(Ray, Interval)], draw: &mut Draw) -> usize {
    let (mut n_hits, mut first) = (0, 0);
    while first < rays.len() {
        let n = draw.pick(&[1, 2, 3, 5, 8, 13, 64, 100, STREAM_CAPACITY]).min(rays.len() - first);
        let rays = &rays[first..first + n];
        let hits = closest!(tree, soup, rays, &mut NoProbe);
        let occluded = occluded!(tree, soup, rays, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            let expected = brute_force::closest(soup, ray, *span, &mut NoProbe);
            assert_eq!(key(hits[i]), key(expected), "{name}: {ray:?} {span:?}");
            let is_occluded = brute_force::occluded(soup, ray, *span, &mut NoProbe);
            assert_eq!(occluded[i], is_occluded, "{name}: {ray:?} {span:?}");
            n_hits += usize::from(expected.is_some());
        }
        first += n;
    }
    n_hits
}

/// Rays from facets that were hit, to both sides, and to points on other facets.
fn spawned(soup: &Soup, rays: &[(Ray, Interval)], draw: &mut Draw) -> Vec<(Ray, Interval)> {
    let mut spawned = Vec::new();
    for (ray, span) in rays {
        let Some(hit) = brute_force::closest(soup, ray, *span, &mut NoProbe) else { continue };
        let Solid::Facet(vertices) = soup.0[hit.primitive as usize] else { continue };
        let Ok(triangle) = Triangle::new(vertices.map(|vertex| vertex.as_dvec3())) else { continue };
        let surface = triangle.surface(ray, &ShapeHit { t: hit.t, uv: hit.uv }, InteractionFlags::NONE);
        if draw.one_in(2) {
            let along = draw.pick(&[DVec3::ZERO, surface.geometric_normal, -surface.geometric_normal, DVec3::X]);
            let direction = (along + draw.point() * draw.pick(&[1.0, 1.0, 1e-3, 0.0])).normalize_or(DVec3::Y);
            spawned.push((surface.spawn_ray(direction, 0.0), Interval::SPAWNED));
        } else if let Solid::Facet([a, b, c]) = draw.pick(&soup.0) {
            let weight = draw.pick(&[0.0, 0.3, 0.5, 1.0]);
            // 0: a point of the edge that both halves of a quadrilateral share.
            let share = if draw.one_in(3) { 0.0 } else { draw.between(0.0, 1.0) as f32 };
            let target = a.lerp(b, share).lerp(c, weight).as_dvec3();
            spawned.push((surface.spawn_shadow_ray(target, 0.0), Interval::SEGMENT));
        }
    }
    spawned
}

/// Triangles of two boxes in a room, in arbitrary positions.
fn boxes_in_a_box(draw: &mut Draw) -> Soup {
    let mut solids = Vec::new();
    for size in [DVec3::ONE, DVec3::new(0.3, 0.6, 0.3), DVec3::new(0.3, 0.3, 0.25)] {
        let at = if solids.is_empty() { DVec3::ZERO } else { draw.point() * 0.5 };
        let corners = Aabb::new(at - size, at + size).corners().map(|corner| corner.as_vec3());
        for [a, b, c, d] in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
            solids.push(Solid::Facet([corners[a], corners[b], corners[c]]));
            solids.push(Solid::Facet([corners[a], corners[c], corners[d]]));
        }
    }
    Soup(solids)
}

/// A triangle without area, one almost without, and one that is tiny.
fn slivers(draw: &mut Draw) -> [Solid; 3] {
    let point = draw.point().as_vec3();
    [
        Solid::Facet([point, point + Vec3::X, point + 2.0 * Vec3::X]),
        Solid::Facet([point, point + Vec3::new(1.0, 0.5, 0.0), point + Vec3::new(2.0, 1.000_001, 0.0)]),
        Solid::Facet([point, point + Vec3::Y * 1e-5, point + Vec3::Z * 1e-5]),
    ]
}

#[test]
fn streams_through_few_triangles_equal_brute_force() {
    let seed = run_seed();
    println!("small trees: seed {seed}");
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..40 {
        let mut soup = if round % 2 == 0 { boxes_in_a_box(draw) } else { Soup::facets(draw) };
        let n = draw.pick(&[1, 2, 9, 16, 31, 40, 64, 70]).min(soup.0.len());
        let first = if round % 2 == 0 { 0 } else { draw.below(soup.0.len() - n + 1) };
        soup.0 = soup.0[first..first + n].to_vec();
        if n >= 9 {
            // Two that coincide, and one that only its own test intersects.
            soup.0[n - 1] = soup.0[0];
            soup.0[4] = draw.pick(&[soup.0[4], Solid::Box(Aabb::new(DVec3::splat(-0.2), DVec3::splat(0.1)))]);
            if draw.one_in(3) {
                soup.0.splice(2..2, slivers(draw));
            }
        }
        if draw.one_in(10) {
            soup.0.push(Solid::Ground { height: -0.4 });
        }
        let (scale, offset) = (draw.pick(&[1.0, 1.0, 1e-3, 500.0, 1e12, 1e-30]), draw.pick(&[0.0, 0.0, 3.0, 1e4]));
        let soup = soup.scaled(scale).moved(DVec3::new(1.0, -0.7, 0.3) * offset * scale);
        let mut rays = with_odd_ones(bundles(&soup, 1200, draw), draw);
        rays.extend(spawned(&soup, &rays, draw));
        // Neighbours are no longer coherent.
        for i in 0..rays.len() {
            let other = draw.below(rays.len());
            if !draw.one_in(4) {
                rays.swap(i, other);
            }
        }
        for level in levels() {
            let tree = WideBvh::build(&soup).unwrap().with_level(level);
            let name = format!("round {round}, {n} at {scale:e} and {offset:e}, {}", level.name());
            n_hits += compare(&name, &tree, &soup, &rays, draw);
        }
    }
    assert!(n_hits > 20_000, "{n_hits} hits");
}

/// The list has only the first of equal triangles.
#[test]
fn streams_hit_the_first_of_equal_triangles() {
    let quad = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let corners: Vec<Vec3> = quad.iter().chain(&quad).chain(&[Vec3::Z]).copied().collect();
    let triangles = [[0, 1, 8], [0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let soup = Soup(triangles.map(|of: [usize; 3]| Solid::Facet(of.map(|corner| corners[corner]))).to_vec());
    // Rays of different octants go through the list.
    let rays = [(0.2, DVec3::new(0.3, 0.1, -1.0)), (0.8, DVec3::new(-0.3, -0.1, -1.0))]
        .map(|(x, direction)| (Ray::new(DVec3::new(x, 0.5, 0.0) - direction, direction), Interval::FORWARD));
    let tree = WideBvh::build(&soup).unwrap();
    for (at, hit) in closest!(tree, &soup, &rays.repeat(5), &mut NoProbe).into_iter().enumerate() {
        assert_eq!(hit.map(|hit| hit.primitive), Some(2 - (at as u32 % 2)));
    }
}

/// Results would also be right if all rays were left open, so this test counts nodes. Every ray starts on a triangle, and most
/// of them leave its plane.
#[test]
fn few_rays_need_the_nodes_of_a_small_tree() {
    let draw = &mut Draw::new(11);
    let soup = boxes_in_a_box(draw);
    let mut rays = Vec::new();
    for _ in 0..2000 {
        let Solid::Facet([a, b, c]) = draw.pick(&soup.0) else { continue };
        let [v, w] = [draw.between(0.01, 0.5), draw.between(0.01, 0.49)];
        let triangle = Triangle::new([a, b, c].map(|vertex| vertex.as_dvec3())).unwrap();
        let surface = triangle.surface(
            &Ray::new(DVec3::ZERO, DVec3::X),
            &ShapeHit { t: 0.0, uv: [v, w] },
            InteractionFlags::NONE,
        );
        let side = draw.pick(&[1.0, -1.0]);
        let direction = surface.geometric_normal * side + draw.point() * 0.57;
        rays.push((surface.spawn_ray(direction, 0.0), Interval::SPAWNED));
    }
    // Rays that end just before a triangle, as those to light sources do.
    let mut segments = Vec::new();
    for (ray, _) in &rays {
        let Solid::Facet([a, b, c]) = draw.pick(&soup.0) else { continue };
        let target = a.lerp(b, draw.between(0.1, 0.9) as f32).lerp(c, draw.between(0.1, 0.9) as f32).as_dvec3();
        let direction = (target - ray.origin) * (1.0 - 1e-12);
        segments.push((Ray { direction, ..*ray }, Interval::SEGMENT));
    }
    for level in levels() {
        let tree = WideBvh::build(&soup).unwrap().with_level(level);
        let mut to_lights = NodesOfOpenRays::default();
        let occluded = occluded!(tree, &soup, &segments, &mut to_lights);
        let n_free = occluded.iter().filter(|is_occluded| !**is_occluded).count();
        assert!(n_free > 300 && to_lights.0 <= 700, "{}: {} nodes, {n_free} rays free", level.name(), to_lights.0);
        let (mut closest, mut any) = (NodesOfOpenRays::default(), NodesOfOpenRays::default());
        closest!(tree, &soup, &rays, &mut closest);
        occluded!(tree, &soup, &rays, &mut any);
        assert!(closest.0 <= 40 && any.0 <= 40, "{}: {} and {} nodes", level.name(), closest.0, any.0);
        let mut counted = Counters::default();
        closest!(tree, &soup, &rays, &mut counted);
        assert!(counted.total().nodes >= rays.len() as u64, "queries that count take the tree");
    }
}
