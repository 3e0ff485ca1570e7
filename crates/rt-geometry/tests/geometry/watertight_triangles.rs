//! No ray slips through an edge or a vertex of a closed mesh.

use rt_geometry::WatertightRay;
use rt_math::{DVec3, Interval, Ray, random};
use rt_tests::icosphere;

const GRID: f64 = (1u32 << 18) as f64;

/// Targets of the rays.
#[derive(Clone, Copy, Debug)]
enum Target {
    EdgeMiddle,
    Vertex,
}

/// Möller-Trumbore test (1997), which uses rounded products.
fn plain_test([a, b, c]: [DVec3; 3], ray: &Ray) -> bool {
    let (e, f) = (b - a, c - a);
    let p = ray.direction.cross(f);
    let inverse = 1.0 / e.dot(p);
    let s = ray.origin - a;
    let v = s.dot(p) * inverse;
    let q = s.cross(e);
    let (w, t) = (ray.direction.dot(q) * inverse, f.dot(q) * inverse);
    v >= 0.0 && w >= 0.0 && v + w <= 1.0 && t >= 0.0
}

/// Rays from inside a closed mesh that miss all of its triangles: with the watertight test, with the plain one.
fn leaks(offset: f64, scale: f64, target: Target, rays: u64) -> (usize, usize) {
    let (vertices, triangles) = icosphere(1);
    assert_eq!((vertices.len(), triangles.len()), (42, 80));
    let centre = DVec3::new(offset, offset * 0.75, -offset);
    // On a grid coarse enough for the middles of edges to be exact as well.
    let place = |v: &DVec3| (*v * GRID).round() / GRID * scale + centre;
    let vertices: Vec<DVec3> = vertices.iter().map(place).collect();
    let draw = |ray: u64, k: u64| random::unit(random::hash(&[ray, k]));
    let (mut watertight, mut plain) = (0, 0);
    for ray in 0..rays {
        let origin = centre + (DVec3::new(draw(ray, 0), draw(ray, 1), draw(ray, 2)) - 0.5) * scale;
        let triangle = triangles[(draw(ray, 3) * triangles.len() as f64) as usize];
        let along = match target {
            Target::EdgeMiddle => 0.5,
            Target::Vertex => 0.0,
        };
        let aim = vertices[triangle[0]].lerp(vertices[triangle[1]], along);
        let ray = Ray::new(origin, aim - origin);
        let sheared = WatertightRay::new(&ray);
        let corners = || triangles.iter().map(|t| t.map(|i| vertices[i]));
        watertight += usize::from(!corners().any(|t| sheared.intersect(t, Interval::FORWARD).is_some()));
        plain += usize::from(!corners().any(|t| plain_test(t, &ray)));
    }
    (watertight, plain)
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    const RAYS: u64 = 20_000;
    let small = 1.0 / 1024.0;
    for target in [Target::EdgeMiddle, Target::Vertex] {
        for (offset, scale) in [(0.0, 1.0), (100.0, 1.0), (1e4, 1.0), (1e7, 1.0), (0.0, 1e-6), (1e7, small)] {
            let (watertight, plain) = leaks(offset, scale, target, RAYS);
            assert_eq!(watertight, 0, "{target:?} at offset {offset}, scale {scale}");
            // The rays are hard: some slip through a test that rounds.
            assert!(plain > 0, "{target:?} at offset {offset}, scale {scale}");
        }
    }
}

/// Regression: rays that start on a triangle missed it, because it lay a rounding error before their origin.
#[test]
fn a_ray_that_starts_in_the_plane_of_a_triangle_meets_it_at_zero() {
    let draw = |i: u64, k: u64| (random::unit(random::hash(&[i, k])) * 2.0 - 1.0) as f32;
    let mut tried = 0;
    for i in 0..20_000 {
        let corner = |k: u64| [draw(i, k), draw(i, k + 1), draw(i, k + 2)].map(f64::from);
        // In planes at right angles to an axis, which hold points exactly.
        let axis = (i % 3) as usize;
        let mut vertices = [corner(0), corner(3), corner(6)].map(DVec3::from_array);
        vertices.iter_mut().for_each(|vertex| vertex[axis] = f64::from(draw(i, 9)) * 1e3);
        let [a, b, c] = vertices;
        let mut origin = a * 0.25 + b * 0.25 + c * 0.5;
        origin[axis] = a[axis];
        let direction = DVec3::from_array(corner(10));
        let above = Ray::new(origin, direction);
        let hit = WatertightRay::new(&above).intersect(vertices, Interval::FORWARD);
        assert_eq!(hit.map(|hit| hit.t), Some(0.0), "ray {i}: {above:?}");
        // One step to either side of the plane.
        for aside in [origin[axis].next_up(), origin[axis].next_down()] {
            let mut start = origin;
            start[axis] = aside;
            let ray = Ray::new(start, direction);
            let is_ahead = (a[axis] - aside) * direction[axis] > 0.0;
            let hit = WatertightRay::new(&ray).intersect(vertices, Interval::FORWARD);
            assert_eq!(hit.is_some(), is_ahead, "ray {i}: {ray:?}");
            tried += 1;
        }
    }
    assert_eq!(tried, 40_000);
}
