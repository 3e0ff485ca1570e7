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

/// Regression: the shear was rounded, so that rays next to an edge found other sides of it than those of their own numbers. Rays from the
/// rounded middles of edges, if these are inside, left the mesh.
#[test]
fn no_ray_leaves_a_closed_mesh_from_within_a_rounding_error_of_an_edge() {
    const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    let coordinates = |p: DVec3| robust::Coord3D { x: p.x, y: p.y, z: p.z };
    let mut n_inside = 0;
    for seed in 0..100 {
        let draw = |k: u64| random::unit(random::hash(&[seed, k])) * 2.0 - 1.0;
        let mut corners = [0, 3, 6, 9].map(|k| DVec3::new(draw(k), draw(k + 1), draw(k + 2)));
        let side = |[a, b, c]: [DVec3; 3], p: DVec3| {
            robust::orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(p))
        };
        if side([corners[0], corners[1], corners[2]], corners[3]) < 0.0 {
            corners.swap(0, 1);
        }
        let faces = FACES.map(|face| face.map(|corner| corners[corner]));
        for [from, to] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            for step in 0..27 {
                let moved = |x: f64, by: u64| [x, x.next_up(), x.next_down()][(by % 3) as usize];
                let middle = (corners[from] + corners[to]) * 0.5;
                let origin = DVec3::new(moved(middle.x, step), moved(middle.y, step / 3), moved(middle.z, step / 9));
                if !faces.iter().all(|face| side(*face, origin) > 0.0) {
                    continue;
                }
                n_inside += 1;
                let direction = DVec3::new(draw(20 + 3 * step), draw(21 + 3 * step), draw(22 + 3 * step));
                let ray = WatertightRay::new(&Ray::new(origin, direction));
                let is_hit = faces.iter().any(|face| ray.intersect(*face, Interval::FORWARD).is_some());
                assert!(is_hit, "seed {seed}: {origin:?}, {direction:?}, {corners:?}");
            }
        }
    }
    assert!(n_inside > 700, "{n_inside}");
}

/// Regression: a ray through a common edge missed one of its triangles where the shear was rounded, although all differences are exact.
#[test]
fn a_ray_through_a_common_edge_or_vertex_hits_all_triangles_there_at_the_same_t() {
    let (mut n_edges, mut n_vertices) = (0, 0);
    for seed in 0..6_000 {
        let integer = |k: u64| (random::hash(&[seed, k]) % 17) as f64 - 8.0;
        let vector = |k: u64| DVec3::new(integer(k), integer(k + 1), integer(k + 2));
        let (a, b, direction) = (vector(0), vector(3), vector(6));
        // Its parameter on the edge is 0, a quarter, a half, three quarters or 1; all numbers are exact.
        let at = random::hash(&[seed, 9]) % 5;
        let target = a + (b - a) * (at as f64 / 4.0);
        let t = 1.0 + (random::hash(&[seed, 10]) % 3) as f64;
        let ray = Ray::new(target - direction * t, direction);
        let hits: Vec<f64> = [12, 15, 18, 21]
            .into_iter()
            .filter(|k| {
                // The edge and the direction of the ray do not lie in the plane of the triangle.
                let normal = (b - a).cross(vector(*k) - a);
                normal.dot(direction) != 0.0
            })
            .map(|k| {
                let hit = WatertightRay::new(&ray).intersect([a, b, vector(k)], Interval::FORWARD);
                let turned = WatertightRay::new(&ray).intersect([b, vector(k), a], Interval::FORWARD);
                assert_eq!(hit.map(|hit| hit.t), turned.map(|hit| hit.t), "seed {seed}");
                hit.unwrap_or_else(|| panic!("seed {seed}: {ray:?} misses {a:?}, {b:?}, {:?}", vector(k))).t
            })
            .collect();
        if let [first, others @ ..] = hits.as_slice() {
            assert!(others.iter().all(|other| other == first), "seed {seed}: {hits:?}");
            assert!((first - t).abs() < 1e-13, "seed {seed}: {first}, {t}");
            if at.is_multiple_of(4) { n_vertices += 1 } else { n_edges += 1 }
        }
    }
    assert!(n_edges > 3000 && n_vertices > 1500, "{n_edges} edges, {n_vertices} vertices");
}
