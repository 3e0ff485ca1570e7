//! Depth of field.

use rt_camera::{Lens, Projection};
use rt_math::DVec3;
use rt_scene_io::{Integrator, Scene};

use crate::support::{compile, everything, film, film_with, full, node, point_light, sphere, spheres};

const LENS: Lens = Lens { radius: 0.4, focus: 8.0, blades: Some(6), rotation: 0.3 };

pub(crate) fn through_a_lens(mut scene: Scene) -> Scene {
    scene.cameras[0].settings.lens = Some(LENS);
    scene
}

#[test]
fn a_lens_of_no_size_changes_no_bit() {
    let mut scene = everything();
    for integrator in Integrator::ALL {
        scene.settings.integrator = integrator;
        scene.cameras[0].settings.lens = None;
        let sharp = film(&scene);
        scene.cameras[0].settings.lens = Some(Lens { radius: 0.0, ..LENS });
        assert_eq!(film(&scene), sharp, "{integrator:?}");
        scene.cameras[0].settings.lens = Some(LENS);
        assert_ne!(film(&scene), sharp, "{integrator:?}");
    }
}

/// Spheres in all directions around the camera. Most lie outside the view, some partly and near the lens.
#[test]
fn culling_covers_rays_through_all_points_of_the_lens() {
    let mut scene = through_a_lens(spheres());
    let eye = scene.cameras[0].settings.world_from_camera.translation();
    scene.appearance.lights = vec![point_light((eye + 0.5).to_array(), 0.8)];
    scene.nodes = (0..600u64)
        .map(|i| {
            let unit = |k| 2.0 * rt_math::random::unit(rt_math::random::hash(&[i, k])) - 1.0;
            let place = DVec3::new(unit(0), unit(1), unit(2)).normalize() * (1.0 + (i % 9) as f64) + eye;
            node(sphere(place.x, place.y, place.z, 0.2), 0)
        })
        .collect();
    let view = scene.cameras[0].settings.projection;
    for (projection, radius, focus) in
        [(view, 0.05, 8.0), (view, 0.4, 2.0), (view, 1.5, 5.0), (Projection::Orthographic { height: 3.0 }, 0.4, 4.0)]
    {
        scene.cameras[0].settings.projection = projection;
        scene.cameras[0].settings.lens = Some(Lens { radius, focus, ..LENS });
        let plan = compile(&scene);
        let left_out = plan.explain().left_out;
        assert!(left_out.iter().any(|left| left.what == "objects, for camera rays"), "{radius} {focus}");
        let full = film_with(&scene, full(), 0);
        assert_eq!(film(&scene), full, "{radius} {focus}");
    }
}

/// A lens at the boundary of a smoke sphere: some rays start inside, some outside.
#[test]
fn each_ray_starts_in_the_medium_of_its_lens_point() {
    let mut scene = through_a_lens(everything());
    let eye = scene.cameras[0].settings.world_from_camera.translation();
    scene.nodes.push(node(sphere(eye.x + 0.5, eye.y, eye.z, 0.5), 3));
    let plan = compile(&scene);
    assert!(plan.explain().to_string().contains("the medium of each camera ray is determined at its origin"));
    let full = film_with(&scene, full(), 0);
    assert_eq!(film(&scene), full);
}
