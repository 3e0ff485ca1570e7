//! Ready-made scenes against a test of every primitive, one ray at a time and in batches.

use proptest::prelude::*;
use rt_accel::{
    BatchError, BuildParams, DVec3, Hit, HitBatch, Interval, NoProbe, PointHit, Primitives as _, Ray, RayBatch, Scene,
    SceneBuilder, SceneError, Sphere, Spheres, Transform, TriangleMesh, Vectors,
};
use rt_geometry::{ClosestPoint as _, intersect_primitive};
use rt_math::SlabRay;
use rt_math::random::{hash, unit};

type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Closed box from -1 to 1 whose sides are grids of `n` by `n` squares, shared at the edges by position only.
fn grid_box(n: u32) -> Triangles {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = vertices.len() as u32;
            for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                let at = |k: u32| f64::from(k) * 2.0 / f64::from(n) - 1.0;
                let mut vertex = [side; 3];
                (vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]) = (at(i), at(j));
                vertices.push(vertex);
            }
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let corner = |i: u32, j: u32| first + i * (n + 1) + j;
                triangles.push([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)]);
                triangles.push([corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]);
            }
        }
    }
    (vertices, triangles)
}

fn soup(n: usize) -> impl Strategy<Value = Triangles> {
    let number = prop_oneof![-2.0..2.0f64, (-8i8..8).prop_map(|i| f64::from(i) * 0.25)];
    let vertex = [number.clone(), number.clone(), number];
    let vertices = prop::collection::vec(vertex, 3..=n);
    vertices.prop_flat_map(|vertices| {
        let index = 0..vertices.len() as u32;
        let triangle = [index.clone(), index.clone(), index];
        (Just(vertices), prop::collection::vec(triangle, 0..40))
    })
}

fn ray() -> impl Strategy<Value = Ray> {
    let number = || prop_oneof![-4.0..4.0f64, (-16i8..16).prop_map(|i| f64::from(i) * 0.25)];
    let vector = || [number(), number(), number()].prop_map(DVec3::from);
    (vector(), vector()).prop_map(|(origin, direction)| Ray::new(origin, direction))
}

/// Every hit of every triangle in order, by its own test.
fn brute_force(mesh: &TriangleMesh<'_>, ray: &Ray, span: Interval) -> Vec<Hit> {
    let slab = SlabRay::new(ray);
    let test = |index| intersect_primitive(mesh, index, &slab, span, &mut NoProbe);
    let mut hits: Vec<Hit> = (0..mesh.len() as u32).filter_map(test).collect();
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
    hits
}

proptest! {
    #[test]
    fn a_scene_of_one_mesh_gives_the_hits_of_its_triangles(
        (vertices, triangles) in soup(24),
        rays in prop::collection::vec(ray(), 1..40),
        narrow in any::<bool>(),
    ) {
        let single: Vec<[f32; 3]> = vertices.iter().map(|vertex| vertex.map(|c| c as f32)).collect();
        let mesh = if narrow {
            TriangleMesh::new(&single, &triangles)
        } else {
            TriangleMesh::new(&vertices, &triangles)
        };
        let mesh = mesh.expect("a mesh");
        let scene = Scene::new(mesh.clone()).expect("a scene");
        let mut all = Vec::new();
        for ray in &rays {
            let expected = brute_force(&mesh, ray, Interval::FORWARD);
            prop_assert_eq!(scene.closest(ray, Interval::FORWARD), expected.first().copied());
            prop_assert_eq!(scene.occluded(ray, Interval::FORWARD), !expected.is_empty());
            scene.all_hits(ray, Interval::FORWARD, &mut all);
            prop_assert_eq!(&all, &expected);
        }
    }

    #[test]
    fn instances_give_the_hits_of_each_in_its_own_space(
        (vertices, triangles) in soup(16),
        rays in prop::collection::vec(ray(), 1..20),
        offsets in prop::collection::vec(-3.0..3.0f64, 1..6),
    ) {
        let mesh = TriangleMesh::new(&vertices, &triangles).expect("a mesh");
        let mut builder = SceneBuilder::new(BuildParams::FAST);
        let id = builder.add(mesh.clone()).expect("a geometry");
        let stretch = Transform::scale(DVec3::new(1.0, -0.5, 2.0)).expect("a scale");
        let place = |x: f64| Transform::translate(DVec3::new(x, 0.5 * x, 1.0)).compose(&stretch);
        let mut transforms = vec![Transform::IDENTITY];
        transforms.extend(offsets.into_iter().map(place));
        for transform in &transforms {
            builder.place_at(id, transform).expect("an instance");
        }
        let scene = builder.build().expect("a scene");
        let mut all = Vec::new();
        for ray in &rays {
            let mut expected: Vec<Hit> = Vec::new();
            for (instance, transform) in transforms.iter().enumerate() {
                let local = if instance == 0 { *ray } else { transform.inverse_ray(ray) };
                let hits = brute_force(&mesh, &local, Interval::FORWARD);
                expected.extend(hits.into_iter().map(|hit| Hit { instance: instance as u32, ..hit }));
            }
            expected.sort_by(|a, b| a.t.total_cmp(&b.t).then(
                (a.instance, a.primitive).cmp(&(b.instance, b.primitive))));
            prop_assert_eq!(scene.closest(ray, Interval::FORWARD), expected.first().copied());
            prop_assert_eq!(scene.occluded(ray, Interval::FORWARD), !expected.is_empty());
            scene.all_hits(ray, Interval::FORWARD, &mut all);
            prop_assert_eq!(&all, &expected);
        }
    }

    #[test]
    fn nearest_points_are_those_of_the_nearest_triangle(
        (vertices, triangles) in soup(16),
        point in [-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64],
        shift in -2.0..2.0f64,
    ) {
        let point = DVec3::from(point);
        let mesh = TriangleMesh::new(&vertices, &triangles).expect("a mesh");
        let transform = Transform::translate(DVec3::splat(shift))
            .compose(&Transform::scale(DVec3::new(0.5, 2.0, 1.0)).expect("a scale"));
        let image: Vec<[f64; 3]> = vertices.iter().map(|v| transform.point(DVec3::from(*v)).to_array()).collect();
        let image = TriangleMesh::new(&image, &triangles).expect("a mesh");
        let mut builder = SceneBuilder::new(BuildParams::BALANCED);
        let id = builder.add(mesh.clone()).expect("a geometry");
        builder.place(id).expect("an instance");
        builder.place_at(id, &transform).expect("an instance");
        let scene = builder.build().expect("a scene");
        let distances = |mesh: &TriangleMesh<'_>| -> f64 {
            let each = (0..mesh.len() as u32).filter_map(|i| mesh.nearest_point(i, point));
            each.map(|nearest| nearest.distance(point)).fold(f64::INFINITY, f64::min)
        };
        let expected = distances(&mesh).min(distances(&image));
        let found = scene.nearest_point(point, f64::INFINITY);
        prop_assert_eq!(found.is_none(), triangles.is_empty());
        if let Some(found) = found {
            prop_assert!((found.distance - expected).abs() <= 1e-11, "{} is not {}", found.distance, expected);
            prop_assert!((found.point.distance(point) - found.distance).abs() <= 1e-11);
        }
    }

    #[test]
    fn points_of_a_box_are_inside(point in [-1.5..1.5f64, -1.5..1.5f64, -1.5..1.5f64], on_grid in any::<bool>()) {
        let (vertices, triangles) = grid_box(4);
        let scene = Scene::new(TriangleMesh::new(&vertices, &triangles).expect("a mesh")).expect("a scene");
        // On the grid, the point is in the planes of edges, and on the surface if a coordinate is one.
        let point = if on_grid { point.map(|c| (c * 4.0).round() / 4.0) } else { point };
        let is_inside = point.iter().all(|c| c.abs() <= 1.0);
        prop_assert_eq!(scene.contains(DVec3::from(point)), is_inside);
        let outside = point.map(|c: f64| (c.abs() - 1.0).max(0.0));
        let expected = if is_inside {
            point.iter().map(|c| c.abs() - 1.0).fold(f64::NEG_INFINITY, f64::max)
        } else {
            DVec3::from(outside).length()
        };
        let distance = scene.signed_distance(DVec3::from(point)).expect("a surface");
        prop_assert!((distance - expected).abs() <= 1e-12, "{} is not {}", distance, expected);
        prop_assert!(distance != 0.0 || distance.is_sign_positive());
    }
}

fn grid_rays(n: usize) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let at = |i: usize| (i % 97) as f64 / 48.0 - 1.0;
    let origins = (0..n).map(|i| [at(i), at(i / 97), 5.0]).collect();
    let directions = (0..n).map(|i| [0.25 * at(i / 5), 0.25 * at(3 * i), -1.0]).collect();
    (origins, directions)
}

#[test]
fn batches_give_the_hits_of_single_rays() {
    let (vertices, triangles) = grid_box(6);
    let mesh = TriangleMesh::new(&vertices, &triangles).expect("a mesh");
    let mut builder = SceneBuilder::new(BuildParams::BALANCED);
    let id = builder.add(mesh.clone()).expect("a geometry");
    let spheres = Spheres::new(vec![Sphere::new(DVec3::Z * 2.0, 0.5).expect("a sphere")]);
    let spheres = builder.add(spheres).expect("a geometry");
    builder.place(id).expect("an instance");
    builder.place_at(spheres, &Transform::translate(DVec3::X)).expect("an instance");
    let n = 40_000;
    let (origins, directions) = grid_rays(n);
    let limits: Vec<f64> = (0..n).map(|i| (i % 11) as f64).collect();
    let rays = RayBatch::new(&origins[..], &directions[..]).and_then(|rays| rays.with_t_range(0.0, &limits[..]));
    let rays = rays.expect("a batch");
    for scene in [Scene::new(mesh).expect("a scene"), builder.build().expect("a scene")] {
        let (mut t, mut primitive, mut instance, mut uv) = (vec![0.0; n], vec![0; n], vec![0; n], vec![[0.0; 2]; n]);
        let (mut occluded, mut counts) = (vec![false; n], vec![0; n]);
        let lists = scene.all_hits_batch(&rays).expect("memory");
        let mut of_one = Vec::new();
        #[cfg(feature = "parallel")]
        {
            assert_eq!(scene.par_all_hits_batch(&rays).as_ref(), Ok(&lists));
        }
        for threads in [false, true] {
            let mut hits =
                HitBatch { t: &mut t, primitive: &mut primitive, instance: Some(&mut instance), uv: Some(&mut uv) };
            if threads {
                scene.par_closest_batch(&rays, &mut hits).expect("equal lengths");
                scene.par_occluded_batch(&rays, &mut occluded).expect("equal lengths");
                scene.par_count_hits_batch(&rays, &mut counts).expect("equal lengths");
            } else {
                scene.closest_batch(&rays, &mut hits).expect("equal lengths");
                scene.occluded_batch(&rays, &mut occluded).expect("equal lengths");
                scene.count_hits_batch(&rays, &mut counts).expect("equal lengths");
            }
            let mut found = 0;
            for i in 0..n {
                let ray = Ray::new(DVec3::from(origins[i]), DVec3::from(directions[i]));
                let span = Interval::new(0.0, limits[i]);
                let single = scene.closest(&ray, span);
                let batched = (primitive[i] != HitBatch::MISS).then_some(Hit {
                    t: t[i],
                    instance: instance[i],
                    primitive: primitive[i],
                    uv: uv[i],
                });
                assert_eq!(batched, single, "ray {i}");
                assert_eq!((occluded[i], t[i] == f64::INFINITY), (single.is_some(), single.is_none()), "ray {i}");
                scene.all_hits(&ray, span, &mut of_one);
                assert_eq!(&lists.hits[lists.offsets[i]..lists.offsets[i + 1]], &of_one, "ray {i}");
                assert_eq!(counts[i] as usize, of_one.len());
                found += usize::from(single.is_some());
            }
            assert!((n / 4..n).contains(&found), "{found} hits");
        }
    }
}

#[test]
fn one_origin_serves_all_directions() {
    let (vertices, triangles) = grid_box(2);
    let scene = Scene::new(TriangleMesh::new(&vertices, &triangles).expect("a mesh")).expect("a scene");
    let directions = [[1.0f32, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, f32::NAN]];
    let rays = RayBatch::new(&[[0.0f64; 3]][..], &directions[..]).expect("a batch");
    let (mut t, mut primitive) = ([0.0; 3], [0; 3]);
    let mut hits = HitBatch { t: &mut t, primitive: &mut primitive, instance: None, uv: None };
    scene.closest_batch(&rays, &mut hits).expect("equal lengths");
    assert_eq!((t, primitive[2]), ([1.0, 0.5, f64::INFINITY], HitBatch::MISS));
    let numbers = [0.0; 8];
    let origins = Vectors::strided_f64(&numbers, 2, 4, 1).expect("a view");
    let wrong = RayBatch::new(origins, &directions[..]);
    assert_eq!(wrong, Err(BatchError::Length { what: "origins", found: 2, expected: 3 }));
    let mut short = HitBatch { t: &mut t, primitive: &mut [0; 2], instance: None, uv: None };
    let expected = BatchError::Length { what: "numbers of primitives", found: 2, expected: 3 };
    assert_eq!(scene.closest_batch(&rays, &mut short), Err(expected));
    assert_eq!(expected.to_string(), "there are 2 numbers of primitives for 3 rays");
}

#[test]
fn spheres_are_placed_by_similarities_only() {
    let spheres = || Spheres::new(vec![Sphere::new(DVec3::ZERO, 1.0).expect("a sphere")]);
    let mut builder = SceneBuilder::new(BuildParams::HIGH);
    let id = builder.add(spheres()).expect("a geometry");
    let stretch = Transform::scale(DVec3::new(1.0, 2.0, 1.0)).expect("a scale");
    assert_eq!(builder.place_at(id, &stretch), Err(SceneError::NotUniform { geometry: 0 }));
    let triple = Transform::translate(DVec3::X * 10.0).compose(&Transform::scale(DVec3::splat(2.0)).expect("a scale"));
    builder.place_at(id, &triple).expect("an instance");
    let other = SceneBuilder::new(BuildParams::HIGH).place(id);
    assert_eq!(other, Err(SceneError::UnknownGeometry { geometry: 0 }));
    let scene = builder.build().expect("a scene");
    let mut hits = Vec::new();
    scene.all_hits(&Ray::new(DVec3::ZERO, DVec3::X), Interval::FORWARD, &mut hits);
    assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [8.0, 12.0]);
    assert!(scene.contains(DVec3::X * 8.0) && !scene.contains(DVec3::X * 7.9));
    assert_eq!(scene.signed_distance(DVec3::X * 9.0), Some(-1.0));
    for beyond in [1e61, 1e200, f64::INFINITY, f64::NAN] {
        assert_eq!(scene.nearest_point(DVec3::X * beyond, f64::INFINITY), None);
        assert_eq!((scene.signed_distance(DVec3::X * beyond), scene.contains(DVec3::X * beyond)), (None, false));
    }
}

/// Regression: both hits were moved to the entry into the bounds, and reported as two.
#[test]
fn hits_of_a_placed_sphere_that_rounding_makes_one_are_reported_once() {
    let centre = DVec3::new(-0.8680696281147711, -0.4206944169432767, -0.178013034380613);
    let origin = DVec3::new(-8393519.713830033, -2660634.9067347622, 9203582.440621035);
    let tiny = Sphere::new(centre, 1.1463327598662916e-9).expect("a sphere");
    let mut builder = SceneBuilder::new(BuildParams::FAST);
    let id = builder.add(Spheres::new(vec![tiny])).expect("a geometry");
    builder.place_at(id, &Transform::translate(DVec3::X)).expect("an instance");
    let scene = builder.build().expect("a scene");
    let mut hits = Vec::new();
    scene.all_hits(&Ray::new(origin, centre + DVec3::X - origin), Interval::FORWARD, &mut hits);
    assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [1.0]);
}

/// Regression: the radius was divided by the scale, and distances in world space were not compared with it.
#[test]
fn placed_spheres_are_found_within_the_radius_inclusive() {
    let number = |words: &[u64]| 2.0 * unit(hash(words)) - 1.0;
    let vector = |seed: u64, i: u64| DVec3::new(number(&[seed, i, 0]), number(&[seed, i, 1]), number(&[seed, i, 2]));
    for i in 0..3000 {
        let mut builder = SceneBuilder::new(BuildParams::FAST);
        let sphere = Sphere::new(vector(21, i), 0.3).expect("a sphere");
        let id = builder.add(Spheres::new(vec![sphere])).expect("a geometry");
        let scale = Transform::scale(DVec3::splat(3.0 + number(&[22, i]))).expect("a scale");
        builder.place_at(id, &Transform::translate(100.0 * vector(23, i)).compose(&scale)).expect("an instance");
        let scene = builder.build().expect("a scene");
        let point = 100.0 * vector(24, i);
        let distance = scene.nearest_point(point, f64::INFINITY).expect("a point").distance;
        assert_eq!(scene.nearest_point(point, distance).map(|hit| hit.distance), Some(distance), "{i}");
        assert_eq!(scene.nearest_point(point, distance.next_down()), None, "{i}");
    }
}

/// A tree over the instances finds what a scene of each of them finds.
#[test]
fn points_are_compared_with_each_of_many_instances() {
    let (vertices, triangles) = grid_box(2);
    let number = |words: &[u64]| 2.0 * unit(hash(words)) - 1.0;
    let vector = |seed: u64, i: u64| DVec3::new(number(&[seed, i, 0]), number(&[seed, i, 1]), number(&[seed, i, 2]));
    let list = (0..20).map(|i| Sphere::new(vector(1, i), 0.2).expect("a sphere")).collect();
    let (mesh, spheres) = (TriangleMesh::new(&vertices, &triangles).expect("a mesh"), Spheres::new(list));
    let build = |instances: core::ops::Range<u64>| {
        let mut builder = SceneBuilder::new(BuildParams::FAST);
        let mesh = builder.add(mesh.clone()).expect("a geometry");
        let spheres = builder.add(spheres.clone()).expect("a geometry");
        for i in instances {
            let turn = Transform::rotate(vector(2, i), i as f64).expect("a rotation");
            let placed = Transform::translate(10.0 * vector(3, i)).compose(&turn);
            builder.place_at(if i % 3 == 0 { spheres } else { mesh }, &placed).expect("an instance");
        }
        builder.build().expect("a scene")
    };
    let all = build(0..300);
    let each: Vec<_> = (0..300).map(|i| build(i..i + 1)).collect();
    let (mut n_inside, mut n_found) = (0, 0);
    for k in 0..2000 {
        let point = 12.0 * vector(4, k);
        let radius = [f64::INFINITY, 1.0, 0.25][k as usize % 3];
        let nearest = each.iter().enumerate().filter_map(|(i, one)| Some((one.nearest_point(point, radius)?, i)));
        let expected = nearest.min_by(|(a, _), (b, _)| a.distance.total_cmp(&b.distance));
        let found = all.nearest_point(point, radius);
        assert_eq!(found, expected.map(|(hit, i)| PointHit { instance: i as u32, ..hit }), "{point} within {radius}");
        assert_eq!(all.contains(point), each.iter().any(|one| one.contains(point)), "{point}");
        (n_inside, n_found) = (n_inside + u32::from(all.contains(point)), n_found + u32::from(found.is_some()));
    }
    assert!(n_inside > 150 && (1000..2000).contains(&n_found), "{n_inside} inside, {n_found} found");
}

#[test]
fn empty_scenes_are_missed() {
    let empty = Scene::new(TriangleMesh::new(Vec::<[f32; 3]>::new(), Vec::new()).expect("a mesh")).expect("a scene");
    let nothing = SceneBuilder::new(BuildParams::FAST).build().expect("a scene");
    for scene in [empty, nothing] {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        let mut hits = Vec::new();
        scene.all_hits(&ray, Interval::FORWARD, &mut hits);
        assert_eq!((scene.closest(&ray, Interval::FORWARD), hits.len()), (None, 0));
        assert_eq!((scene.nearest_point(DVec3::ZERO, f64::INFINITY), scene.contains(DVec3::ZERO)), (None, false));
        assert_eq!(scene.signed_distance(DVec3::ZERO), None);
        let rays = RayBatch::new(&[][..] as &[[f64; 3]], &[][..] as &[[f64; 3]]).expect("a batch");
        assert_eq!(scene.all_hits_batch(&rays).map(|lists| lists.offsets), Ok(vec![0]));
    }
}

/// More rays than there are addresses: one vector serves all of them.
#[test]
fn lists_without_memory_are_an_error() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = Scene::new(TriangleMesh::new(&vertices, &[[0, 1, 2]]).expect("a mesh")).expect("a scene");
    for n in [1 << 60, usize::MAX] {
        let down = Vectors::strided_f64(&[0.0, 0.0, -1.0], n, 0, 1).expect("vectors");
        let rays = RayBatch::new(&[[0.1, 0.1, 1.0]][..], down).expect("a batch");
        assert_eq!(scene.all_hits_batch(&rays), Err(BatchError::Memory));
        #[cfg(feature = "parallel")]
        assert_eq!(scene.par_all_hits_batch(&rays), Err(BatchError::Memory));
    }
}

/// Regression: next to an edge, rays passed it on another side than that of their own numbers. So points were on the wrong side of
/// the surface. The exact side of each face is that of a determinant.
#[test]
fn points_within_a_rounding_error_of_the_edges_of_a_tetrahedron_are_on_the_right_side() {
    const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    let coordinates = |[x, y, z]: [f64; 3]| robust::Coord3D { x, y, z };
    let (mut n_inside, mut n_outside) = (0, 0);
    for seed in 0..200 {
        let draw = |k: u64| unit(hash(&[seed, k])) * 2.0 - 1.0;
        let mut corners = [0, 3, 6, 9].map(|k| [draw(k), draw(k + 1), draw(k + 2)]);
        let side = |[a, b, c]: [[f64; 3]; 3], p: [f64; 3]| {
            robust::orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(p))
        };
        if side([corners[0], corners[1], corners[2]], corners[3]) < 0.0 {
            corners.swap(0, 1);
        }
        let scene = Scene::new(TriangleMesh::new(&corners[..], &FACES[..]).expect("a mesh")).expect("a scene");
        for [from, to] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            for step in 0..27 {
                let moved = |axis: usize, by: u32| {
                    let middle: f64 = (corners[from][axis] + corners[to][axis]) * 0.5;
                    [middle, middle.next_up(), middle.next_down()][by as usize % 3]
                };
                let point = [moved(0, step), moved(1, step / 3), moved(2, step / 9)];
                let is_inside =
                    FACES.iter().all(|face| side(face.map(|corner| corners[corner as usize]), point) >= 0.0);
                assert_eq!(scene.contains(DVec3::from(point)), is_inside, "seed {seed}: {point:?} in {corners:?}");
                *if is_inside { &mut n_inside } else { &mut n_outside } += 1;
            }
        }
    }
    assert!(n_inside > 5000 && n_outside > 5000, "{n_inside} inside, {n_outside} outside");
}
