//! Scenes that are changed, against scenes that are built afresh with the same content.

use std::collections::BTreeMap;

use rt_accel::{
    BuildParams, DVec3, GeometryId, Hit, Interval, MeshError, PointHit, Ray, Scene, SceneBuilder, SceneError, Sphere,
    Spheres, Transform, TriangleMesh,
};
use rt_tests::Draw;

/// Multiples of 1/4, so that surfaces coincide and rays meet edges.
fn point(draw: &mut Draw) -> DVec3 {
    DVec3::from([(); 3].map(|()| draw.below(33) as f64 * 0.25 - 4.0))
}

fn transform(draw: &mut Draw) -> Transform {
    let scale = Transform::scale(DVec3::splat(draw.pick(&[0.5, 1.0, -1.0, 2.0]))).expect("a scale");
    Transform::translate(point(draw)).compose(&scale)
}

fn vertices(draw: &mut Draw) -> Vec<[f64; 3]> {
    (0..8).map(|_| (0.25 * point(draw)).to_array()).collect()
}

const TRIANGLES: [[u32; 3]; 5] = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [0, 4, 7]];

/// The content that a scene should have.
#[derive(Default)]
struct Content {
    /// Vertices of meshes; `None` for spheres.
    geometries: BTreeMap<usize, Option<Vec<[f64; 3]>>>,
    /// Geometry and transform by number of the instance.
    instances: BTreeMap<u32, (usize, Transform)>,
}

fn spheres() -> Spheres {
    let sphere = |x: f64, radius: f64| Sphere::new(DVec3::X * x, radius).expect("a sphere");
    Spheres::new(vec![sphere(-1.0, 0.5), sphere(0.75, 0.75)])
}

impl Content {
    /// A scene built afresh, and the number that each of its instances has in the changed scene.
    fn build(&self) -> (Scene<'static>, Vec<u32>) {
        let mut builder = SceneBuilder::new(BuildParams::BALANCED);
        let mut ids = BTreeMap::new();
        for (&geometry, vertices) in &self.geometries {
            let id = match vertices {
                Some(vertices) => builder.add(TriangleMesh::new(vertices.clone(), TRIANGLES.to_vec()).expect("a mesh")),
                None => builder.add(spheres()),
            };
            ids.insert(geometry, id.expect("a geometry"));
        }
        for (geometry, transform) in self.instances.values() {
            builder.place_at(ids[geometry], transform).expect("an instance");
        }
        (builder.build().expect("a scene"), self.instances.keys().copied().collect())
    }
}

/// One random change of a builder, and of the content that it should have.
fn change(draw: &mut Draw, builder: &mut SceneBuilder<'static>, ids: &mut Vec<GeometryId>, content: &mut Content) {
    let geometries: Vec<usize> = content.geometries.keys().copied().collect();
    let instances: Vec<u32> = content.instances.keys().copied().collect();
    match draw.below(8) {
        0 | 1 if geometries.len() < 6 => {
            let vertices = (draw.below(3) > 0).then(|| vertices(draw));
            let id = match &vertices {
                Some(vertices) => builder.add(TriangleMesh::new(vertices.clone(), TRIANGLES.to_vec()).expect("a mesh")),
                None => builder.add(spheres()),
            };
            let free = (0..ids.len()).find(|index| !content.geometries.contains_key(index)).unwrap_or(ids.len());
            content.geometries.insert(free, vertices);
            let id = id.expect("a geometry");
            match ids.get_mut(free) {
                Some(of_removed) => *of_removed = id,
                None => ids.push(id),
            }
        }
        0..=3 if !geometries.is_empty() => {
            let (geometry, transform) = (geometries[draw.below(geometries.len())], transform(draw));
            let instance = builder.place_at(ids[geometry], &transform).expect("an instance");
            let lowest_free = (0..).find(|id| !content.instances.contains_key(id));
            assert_eq!(Some(instance), lowest_free);
            content.instances.insert(instance, (geometry, transform));
        }
        4 if !instances.is_empty() => {
            let instance = instances[draw.below(instances.len())];
            builder.remove(instance).expect("an instance");
            content.instances.remove(&instance);
            assert_eq!(builder.remove(instance), Err(SceneError::UnknownInstance { instance }));
        }
        5 if !instances.is_empty() => {
            let (instance, transform) = (instances[draw.below(instances.len())], transform(draw));
            builder.set_transform(instance, &transform).expect("an instance");
            content.instances.entry(instance).and_modify(|placed| placed.1 = transform);
        }
        6 if !geometries.is_empty() => {
            let (geometry, vertices) = (geometries[draw.below(geometries.len())], vertices(draw));
            let result = builder.set_vertices(ids[geometry], vertices.clone());
            match content.geometries.get_mut(&geometry) {
                Some(Some(of_mesh)) => {
                    result.expect("a mesh");
                    *of_mesh = vertices;
                }
                _ => assert_eq!(result, Err(SceneError::NotAMesh { geometry: geometry as u32 })),
            }
        }
        7 if !geometries.is_empty() => {
            let geometry = geometries[draw.below(geometries.len())];
            let placed = content.instances.iter().find(|(_, placed)| placed.0 == geometry);
            let expected = match placed {
                Some((&instance, _)) => Err(SceneError::InUse { geometry: geometry as u32, instance }),
                None => Ok(()),
            };
            assert_eq!(builder.remove_geometry(ids[geometry]), expected);
            if placed.is_none() {
                content.geometries.remove(&geometry);
            }
        }
        _ => {}
    }
}

#[test]
fn changed_scenes_equal_scenes_that_are_built_afresh() {
    let mut found = 0;
    for seed in 0..6 {
        let mut draw = Draw::new(seed);
        let mut scene = SceneBuilder::new(BuildParams::BALANCED).build().expect("a scene");
        let (mut ids, mut content) = (Vec::new(), Content::default());
        for step in 0..60 {
            let mut builder = scene.to_builder();
            for _ in 0..5 {
                change(&mut draw, &mut builder, &mut ids, &mut content);
            }
            scene = builder.build().expect("a scene");
            let (fresh, numbers) = content.build();
            assert_eq!(scene.n_instances(), numbers.len(), "seed {seed}, step {step}");
            let renumbered = |hit: Hit| Hit { instance: numbers[hit.instance as usize], ..hit };
            let (mut all, mut expected) = (Vec::new(), Vec::new());
            for _ in 0..40 {
                let (origin, target) = (point(&mut draw), point(&mut draw));
                let ray = Ray::new(origin, target - origin);
                let closest = fresh.closest(&ray, Interval::FORWARD).map(renumbered);
                assert_eq!(scene.closest(&ray, Interval::FORWARD), closest, "seed {seed}, step {step}: {ray:?}");
                assert_eq!(scene.occluded(&ray, Interval::FORWARD), closest.is_some(), "seed {seed}, step {step}");
                scene.all_hits(&ray, Interval::FORWARD, &mut all);
                fresh.all_hits(&ray, Interval::FORWARD, &mut expected);
                expected.iter_mut().for_each(|hit| *hit = renumbered(*hit));
                assert_eq!(all, expected, "seed {seed}, step {step}: {ray:?}");
                let nearest = fresh.nearest_point(origin, f64::INFINITY);
                let nearest = nearest.map(|hit| PointHit { instance: numbers[hit.instance as usize], ..hit });
                let distance = |hit: Option<PointHit>| hit.map(|hit| (hit.instance, hit.distance));
                assert_eq!(distance(scene.nearest_point(origin, f64::INFINITY)), distance(nearest), "seed {seed}");
                found += usize::from(closest.is_some());
            }
        }
    }
    assert!(found > 4000, "{found} hits");
}

#[test]
fn a_scene_stays_as_it_is_while_its_copy_changes() {
    let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut builder = SceneBuilder::new(BuildParams::FAST);
    let id = builder.add(TriangleMesh::new(vertices, vec![[0, 1, 2]]).expect("a mesh")).expect("a geometry");
    builder.place(id).expect("an instance");
    let before = builder.build().expect("a scene");
    let mut builder = before.to_builder();
    let raised = vec![[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]];
    builder.set_vertices(id, raised).expect("a mesh");
    let after = builder.build().expect("a scene");
    let t = |scene: &Scene<'_>| {
        let ray = Ray::new(DVec3::new(0.25, 0.25, 4.0), DVec3::NEG_Z);
        scene.closest(&ray, Interval::FORWARD).map(|hit| hit.t)
    };
    assert_eq!((t(&before), t(&after)), (Some(4.0), Some(2.0)));
}

#[test]
fn refused_changes_change_nothing() {
    let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut builder = SceneBuilder::new(BuildParams::FAST);
    let mesh = builder.add(TriangleMesh::new(vertices, vec![[0, 1, 2]]).expect("a mesh")).expect("a geometry");
    let round = builder.add(spheres()).expect("a geometry");
    let (first, second) = (builder.place(mesh).expect("an instance"), builder.place(round).expect("an instance"));
    let stretch = Transform::scale(DVec3::new(1.0, 2.0, 1.0)).expect("a scale");
    assert_eq!(builder.set_transform(second, &stretch), Err(SceneError::NotUniform { geometry: 1 }));
    let lost = Transform::translate(DVec3::new(0.0, f64::NAN, 0.0));
    assert_eq!(builder.set_transform(first, &lost), Err(SceneError::Transform { instance: first }));
    assert_eq!(builder.place_at(mesh, &lost), Err(SceneError::Transform { instance: 2 }));
    assert_eq!(builder.set_transform(7, &stretch), Err(SceneError::UnknownInstance { instance: 7 }));
    let short = builder.set_vertices(mesh, vec![[0.0f64; 3]; 2]);
    let source = MeshError::VertexIndex { triangle: 0, index: 2, n_vertices: 2 };
    assert_eq!(short, Err(SceneError::Vertices { geometry: 0, source }));
    assert_eq!(
        short.unwrap_err().to_string(),
        "geometry 0: triangle 0: vertex index 2 is out of range: there are 2 vertices"
    );
    let broken = builder.set_vertices(mesh, vec![[0.0, f64::NAN, 0.0]; 3]);
    assert_eq!(broken, Err(SceneError::Vertices { geometry: 0, source: MeshError::Coordinate { vertex: 0 } }));
    let scene = builder.build().expect("a scene");
    let ray = Ray::new(DVec3::new(0.25, 0.25, 4.0), DVec3::NEG_Z);
    assert_eq!(scene.closest(&ray, Interval::FORWARD).map(|hit| hit.instance), Some(second));
    let mut builder = scene.to_builder();
    builder.remove(second).expect("an instance");
    builder.remove_geometry(round).expect("a geometry");
    assert_eq!(builder.place(round), Err(SceneError::UnknownGeometry { geometry: 1 }));
    let scene = builder.build().expect("a scene");
    assert_eq!(scene.closest(&ray, Interval::FORWARD).map(|hit| hit.instance), Some(first));
}
