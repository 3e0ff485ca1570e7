//! Rays that programs have answered wrongly, with answers by rational arithmetic. The cases, and how they were made, are in
//! `bindings/python/tests/field_cases`, and are tested from Python as well.

use std::fs;
use std::path::Path;

use rt_accel::{
    Accelerator as _, AcceleratorKind, AnyAccelerator, DVec3, Hit, HitBatch, Interval, NoProbe, Ray, RayBatch, Scene,
    TriangleMesh,
};
use serde_json::Value;

/// Error of t over the distance of the farthest vertex from the origin of the ray, in lengths of its direction.
const ROUNDING: f64 = 1.0 / (1u64 << 44) as f64;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn ids(value: &Value) -> Vec<u32> {
    numbers(value).into_iter().map(|number| number as u32).collect()
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().expect("a list").iter()
}

/// Compares all hits of a ray with the exact answer.
fn check(context: &str, mesh: &TriangleMesh<'_>, ray: &Ray, hits: &[Hit], expected: &Value) {
    let (certain, border) = (ids(&expected["primitive"]), ids(&expected["border"]));
    let mut found: Vec<u32> = hits.iter().map(|hit| hit.primitive).collect();
    found.sort_unstable();
    assert_eq!(found, ids(&expected["exact"]), "{context}: {ray:?}");
    let known =
        certain.iter().chain(&border).zip([&expected["t"], &expected["border_t"]].into_iter().flat_map(numbers));
    let known: Vec<(u32, f64)> = known.map(|(id, t)| (*id, t)).collect();
    for (i, hit) in hits.iter().enumerate() {
        let (_, t) = known.iter().find(|(id, _)| *id == hit.primitive).unwrap_or_else(|| panic!("{context}: {hit:?}"));
        let corners = mesh.triangle(hit.primitive).expect("a triangle");
        let distance = corners.map(|corner| (corner - ray.origin).abs().max_element()).into_iter().fold(0.0, f64::max);
        let bound = ROUNDING * distance / ray.direction.abs().max_element();
        assert!((hit.t - t).abs() <= bound, "{context}: {} instead of {t}", hit.t);
        assert!(i == 0 || hits[i - 1].precedes(hit), "{context}: out of order");
    }
}

#[test]
fn all_accelerators_give_the_exact_answers() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bindings/python/tests/field_cases/cases.json");
    let cases: Value = serde_json::from_str(&fs::read_to_string(path).expect("the cases")).expect("valid JSON");
    let mut n_rays = 0;
    for case in list(&cases) {
        let name = case["name"].as_str().expect("a name");
        let vertices: Vec<[f64; 3]> = list(&case["vertices"]).map(|vertex| vector(vertex).to_array()).collect();
        let faces: Vec<[u32; 3]> = list(&case["faces"]).map(|face| ids(face).try_into().expect("three")).collect();
        let mesh = TriangleMesh::new(&vertices, &faces).expect("a mesh");
        let scene = Scene::new(mesh.clone()).expect("a scene");
        let span =
            Interval::new(case["t_min"].as_f64().expect("a number"), case["t_max"].as_f64().unwrap_or(f64::INFINITY));
        let rays: Vec<Ray> = list(&case["rays"]).map(|ray| Ray::new(vector(&ray[0]), vector(&ray[1]))).collect();
        let mut all = Vec::new();
        let mut closest = Vec::new();
        for (ray, expected) in rays.iter().zip(list(&case["hits"])) {
            scene.all_hits(ray, span, &mut all);
            check(name, &mesh, ray, &all, expected);
            assert_eq!(scene.closest(ray, span), all.first().copied(), "{name}");
            assert_eq!(scene.occluded(ray, span), !all.is_empty(), "{name}");
            closest.push(all.first().copied());
            n_rays += 1;
        }
        for kind in AcceleratorKind::ALL {
            let accelerator = AnyAccelerator::build(*kind, &mesh).expect("an accelerator");
            for (ray, hit) in rays.iter().zip(&closest) {
                assert_eq!(accelerator.closest(&mesh, ray, span, &mut NoProbe), *hit, "{name}, {}", kind.name());
            }
        }
        let origins: Vec<[f64; 3]> = rays.iter().map(|ray| ray.origin.to_array()).collect();
        let directions: Vec<[f64; 3]> = rays.iter().map(|ray| ray.direction.to_array()).collect();
        let batch =
            RayBatch::new(&origins[..], &directions[..]).and_then(|batch| batch.with_t_range(span.min, span.max));
        let (mut t, mut primitive) = (vec![0.0; rays.len()], vec![0; rays.len()]);
        let mut hits = HitBatch { t: &mut t, primitive: &mut primitive, instance: None, uv: None };
        scene.closest_batch(&batch.expect("a batch"), &mut hits).expect("equal lengths");
        let expected =
            closest.iter().map(|hit| hit.map_or((f64::INFINITY, HitBatch::MISS), |hit| (hit.t, hit.primitive)));
        assert!(t.into_iter().zip(primitive).eq(expected), "{name}: batch");
    }
    assert!(n_rays >= 390, "{n_rays} rays");
}
