//! Nearest points of instances that transforms move beyond the range of coordinates of geometries.

use rt_accel::{
    Accelerator as _, AcceleratorKind, AnyAccelerator, BuildParams, DVec3, Geometry, PointHit, Scene, SceneBuilder,
    Sphere, Spheres, Transform, TriangleMesh,
};

/// A square of two triangles from 0 to 1, at z = 0.
fn square() -> Geometry<'static> {
    let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    TriangleMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh").into()
}

fn one_sphere(radius: f64) -> Geometry<'static> {
    Spheres::new(vec![Sphere::new(DVec3::ZERO, radius).expect("a sphere")]).into()
}

fn placed(geometry: Geometry<'static>, transforms: impl IntoIterator<Item = Transform>) -> Scene<'static> {
    let mut builder = SceneBuilder::new(BuildParams::BALANCED);
    let id = builder.add(geometry).expect("a geometry");
    for transform in transforms {
        builder.place_at(id, &transform).expect("an instance");
    }
    builder.build().expect("a scene")
}

fn scale(factor: f64) -> Transform {
    Transform::scale(DVec3::splat(factor)).expect("a scale")
}

fn is_near(hit: Option<PointHit>, distance: f64) -> bool {
    hit.is_some_and(|hit| (hit.distance / distance - 1.0).abs() <= 1e-14)
}

/// Regression: the square of the distance overflowed, and an infinite distance was returned with a primitive.
#[test]
fn instances_far_away_have_the_right_distance() {
    for far in [1e61, 1e153, 1e154, 1e155, 1e160, 1e300] {
        for geometry in [square(), one_sphere(1.0)] {
            let scene = placed(geometry, [Transform::translate(DVec3::new(3.0, -4.0, 12.0) * far)]);
            for point in [DVec3::ZERO, DVec3::new(-7.0, 0.5, 1e9)] {
                let found = scene.nearest_point(point, f64::INFINITY);
                assert!(is_near(found, 13.0 * far), "{far:e}: {found:?}");
                assert_eq!(scene.signed_distance(point), found.map(|hit| hit.distance));
                let distance = found.expect("a point").distance;
                assert_eq!(scene.nearest_point(point, distance), found, "{far:e}: within its own distance");
                assert_eq!(scene.nearest_point(point, distance.next_down()), None, "{far:e}");
                assert_eq!(scene.nearest_point(point, 1.0), None, "{far:e}");
            }
        }
    }
}

#[test]
fn distances_beyond_the_range_of_numbers_are_misses() {
    for geometry in [square(), one_sphere(1.0)] {
        let scene = placed(geometry, [Transform::translate(DVec3::splat(1.5e308))]);
        assert_eq!(scene.nearest_point(DVec3::ZERO, f64::INFINITY), None);
        assert_eq!(scene.signed_distance(DVec3::ZERO), None);
    }
}

/// The nearest of 3 is found by a list, and of 40 by the tree over the instances.
#[test]
fn the_nearest_of_many_instances_far_away_is_found() {
    for n in [3, 40] {
        for geometry in [square(), one_sphere(0.5)] {
            let along = |i: i32| Transform::translate(DVec3::X * f64::from((i * 7) % n + 2) * 1e200);
            let scene = placed(geometry.clone(), (0..n).map(along));
            let found = scene.nearest_point(DVec3::Y, f64::INFINITY);
            assert!(is_near(found, 2e200) && found.is_some_and(|hit| hit.instance == 0), "{found:?}");
            // One at hand is nearer than all of them.
            let scene = placed(geometry, (0..n).map(along).chain([Transform::translate(DVec3::Z * 5.0)]));
            let found = scene.nearest_point(DVec3::ZERO, f64::INFINITY);
            assert!(found.is_some_and(|hit| hit.instance == n as u32 && hit.distance <= 5.0), "{found:?}");
        }
    }
}

#[test]
fn large_and_small_instances_have_the_right_distance() {
    for size in [1e100, 1e155, 1e250, 1e300] {
        let scene = placed(square(), [scale(size)]);
        let point = DVec3::new(1.0, 3.0, 2.0);
        let above = scene.nearest_point(point, f64::INFINITY);
        // The ends of its edges are far away, and the point is next to one of them.
        let outside = scene.nearest_point(DVec3::new(50.0, -1.0, 0.0), f64::INFINITY);
        if size < 1e160 {
            assert!(is_near(above, 2.0) && is_near(outside, 1.0), "{size:e}: {above:?} {outside:?}");
        }
        let is_right = |hit: Option<PointHit>| hit.is_some_and(|hit| hit.distance <= size * 1e-15);
        assert!(is_right(above) && is_right(outside), "{size:e}: {above:?} {outside:?}");

        let scene = placed(one_sphere(1.0), [scale(size)]);
        assert!(is_near(scene.nearest_point(DVec3::splat(2.0), f64::INFINITY), size));
        // Away from its centre by as much as its transform says: the point in its space is out of range.
        let scene = placed(one_sphere(2.0), [Transform::translate(DVec3::X * 3.0).compose(&scale(1.0 / size))]);
        let found = scene.nearest_point(DVec3::X * 1e50, f64::INFINITY);
        assert!(is_near(found, 1e50), "a sphere of {:e}: {found:?}", 1.0 / size);
    }
}

/// Accelerators of primitives without transforms have no finite number either.
#[test]
fn accelerators_return_no_infinite_distance() {
    let spheres = Spheres::new(vec![Sphere::new(DVec3::ZERO, 1.0).expect("a sphere")]);
    for kind in AcceleratorKind::ALL {
        let accelerator = AnyAccelerator::build(*kind, &spheres).expect("an accelerator");
        let found = accelerator.nearest_point(&spheres, DVec3::X * 1e160, f64::INFINITY);
        assert_eq!(found, None, "{kind:?}");
    }
}
