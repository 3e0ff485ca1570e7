//! Rays that graze triangles have the same bits in all accelerators, and in batches.

use rt_accel::{
    Accelerator as _, AcceleratorKind, AnyAccelerator, DVec3, HitBatch, Interval, NoProbe, Ray, RayBatch, Scene,
    TriangleMesh,
};
use rt_geometry::WatertightRay;
use rt_math::random::{hash, unit};

fn draw(seed: u64, k: u64) -> f64 {
    2.0 * unit(hash(&[seed, k])) - 1.0
}

fn vector(seed: u64, k: u64) -> DVec3 {
    DVec3::new(draw(seed, k), draw(seed, k + 1), draw(seed, k + 2))
}

/// Ray that starts near a point of a triangle and makes this angle with its plane.
fn grazing_ray([a, b, c]: [DVec3; 3], tilt: f64, seed: u64) -> Ray {
    let point = a + ((b - a) * (1.0 + draw(seed, 0)) + (c - a) * (1.0 + draw(seed, 1))) * 0.25;
    let normal = (b - a).cross(c - a).normalize();
    let along = ((b - a) * draw(seed, 2) + (c - a) * draw(seed, 3)).normalize();
    let direction = along + normal * (tilt * draw(seed, 4).signum());
    Ray::new(point - direction * (draw(seed, 5) * 0.2), direction)
}

/// Regression: packets and lanes had the bound of areas of the scalar test, which left `t` of grazing rays to chance.
#[test]
fn lanes_and_packets_have_the_bits_of_the_scalar_test_for_grazing_rays() {
    const N_RAYS: u64 = 64;
    let mut n_hits = 0;
    for seed in 0..150 {
        // Triangles of single precision are intersected in lanes.
        let triangle = [0, 3, 6].map(|k| vector(seed, k).as_vec3().as_dvec3());
        let mut positions = triangle.map(|vertex| vertex.to_array()).to_vec();
        // Others far away, for trees and for lists.
        for i in 0..if seed % 2 == 0 { 0 } else { 300 } {
            let corner = vector(i, 90).as_vec3().as_dvec3() + DVec3::new(50.0, 0.0, 0.0);
            positions.extend([DVec3::ZERO, DVec3::X, DVec3::Y].map(|edge| (corner + edge * 0.125).to_array()));
        }
        let faces: Vec<[u32; 3]> = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh::new(&positions, &faces).expect("a mesh");
        let scene = Scene::new(mesh.clone()).expect("a scene");
        let accelerators = AcceleratorKind::ALL.iter().map(|kind| AnyAccelerator::build(*kind, &mesh).expect("a tree"));
        let accelerators: Vec<AnyAccelerator> = accelerators.collect();
        let tilt = [1e-15, 1e-14, 1e-13, 1e-12, 1e-9][seed as usize % 5];
        let rays: Vec<Ray> = (0..N_RAYS).map(|i| grazing_ray(triangle, tilt, hash(&[seed, 9, i]))).collect();
        let expected: Vec<Option<f64>> = rays
            .iter()
            .map(|ray| {
                let watertight_ray = WatertightRay::new(ray);
                let triangles = positions.chunks(3).map(|t| [0, 1, 2].map(|i| DVec3::from_array(t[i])));
                let hits = triangles.filter_map(|t| watertight_ray.intersect(t, Interval::FORWARD));
                hits.map(|hit| hit.t).min_by(f64::total_cmp)
            })
            .collect();
        n_hits += expected.iter().flatten().count();
        for accelerator in &accelerators {
            for (ray, t) in rays.iter().zip(&expected) {
                let hit = accelerator.closest(&mesh, ray, Interval::FORWARD, &mut NoProbe);
                assert_eq!(hit.map(|hit| hit.t), *t, "{}: {ray:?}, {triangle:?}", accelerator.kind().name());
            }
        }
        for (ray, t) in rays.iter().zip(&expected) {
            assert_eq!(scene.occluded(ray, Interval::FORWARD), t.is_some(), "{ray:?}, {triangle:?}");
        }
        let origins: Vec<[f64; 3]> = rays.iter().map(|ray| ray.origin.to_array()).collect();
        let directions: Vec<[f64; 3]> = rays.iter().map(|ray| ray.direction.to_array()).collect();
        let batch = RayBatch::new(&origins[..], &directions[..]).expect("a batch");
        let (mut t, mut primitive) = (vec![0.0; rays.len()], vec![0; rays.len()]);
        let mut hits = HitBatch { t: &mut t, primitive: &mut primitive, instance: None, uv: None };
        scene.closest_batch(&batch, &mut hits).expect("equal lengths");
        assert!(t.into_iter().eq(expected.iter().map(|t| t.unwrap_or(f64::INFINITY))), "batch {seed}");
    }
    assert!(n_hits > 3000, "{n_hits}");
}
