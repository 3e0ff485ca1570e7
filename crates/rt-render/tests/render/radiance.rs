//! Images with pixels in closed form.

use rt_geometry::{MeshData, Shape, Triangle};
use rt_math::{DVec2, DVec3, Rgb, Transform, Vec3};
use rt_render::{PlanOptions, Precision, RunOptions};
use rt_scene_io::{Content, Integrator, MaterialId, MeshId, NamedMesh, Scene};
use rt_shading::{Alpha, AlphaMode, Background, ColorTexture, InteriorMedium, Material, Phong, Transmission};

use crate::support::{camera, compile_with, cuboid, film, mesh, node, plane, point_light, scene, sphere};

/// A white diffuse scene under one light at (0, 4, 0) of strength 1, seen straight from above.
fn from_above(content: Content) -> Scene {
    let white = ColorTexture::Constant(Rgb::WHITE);
    let material = Material::new("white".into(), Phong { diffuse: white, ..Phong::BLACK });
    let camera = camera([0.0, 5.0, 0.0], [0.0; 3], DVec3::NEG_Z, 0.8);
    let mut scene = scene(camera, [33, 33], vec![material], vec![node(content, 0)]);
    (scene.settings.spp, scene.settings.pattern) = (1, rt_camera::SamplerKind::Centre);
    scene.appearance.lights = vec![point_light([0.0, 4.0, 0.0], 1.0)];
    scene
}

/// Each pixel shows the cosine of the light on a floor at height 0, without a shadow anywhere.
fn assert_lit_floor(scene: &Scene) {
    let film = film(scene);
    let half = rt_math::transcendental::tan(0.4);
    for (i, pixel) in film.pixels().iter().enumerate() {
        let (x, y) = ((i % 33) as f64 - 16.0, (i / 33) as f64 - 16.0);
        let distance = DVec2::new(x, y).length() / 16.5 * half * 5.0;
        let expected = 4.0 / (16.0 + distance * distance).sqrt();
        assert!((f64::from(pixel[0]) - expected).abs() < 1e-6, "pixel {x}, {y}: {} not {expected}", pixel[0]);
    }
}

/// Two triangles at a height.
fn square(height: f32) -> NamedMesh {
    let positions = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, height, z)).to_vec();
    mesh("square", MeshData { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshData::default() })
}

#[test]
fn a_floor_at_height_zero_does_not_shadow_itself() {
    let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let (slab, sheet) = (cuboid([-9.0, -1.0, -9.0], [9.0, 0.0, 9.0]), cuboid(corner(-9.0, -9.0), corner(9.0, 9.0)));
    let triangle = Triangle::new([corner(-99.0, 9.0), corner(99.0, 9.0), corner(0.0, -99.0)]).expect("a triangle");
    for floor in [plane(DVec3::ZERO, DVec3::Y), slab, sheet, Content::Shape(Shape::Triangle(triangle))] {
        assert_lit_floor(&from_above(floor.clone()));
        let mut turned = from_above(floor);
        turned.nodes[0].parent_from_local = Transform::rotate(DVec3::Y, 0.3).expect("an axis");
        assert_lit_floor(&turned);
    }
    let mut scene = from_above(Content::Mesh(MeshId(0)));
    scene.meshes = vec![square(0.0)];
    assert_lit_floor(&scene);
}

#[test]
fn the_inside_of_a_sphere_is_lit_uniformly() {
    // Light from the centre of a sphere has normal incidence: radiance is 1 in every pixel.
    let scene = from_above(sphere(0.0, 4.0, 0.0, 30.0));
    assert!(film(&scene).pixels().iter().flatten().all(|c| (c - 1.0).abs() < 1e-6));
}

#[test]
fn whitted_absorbed_no_light_on_the_way_from_a_light() {
    let mut scene = from_above(plane(DVec3::ZERO, DVec3::Y));
    scene.settings.depth = 0;
    let absorption = Rgb::new(0.1, 0.2, 0.4);
    let clear = Transmission { coefficient: ColorTexture::Constant(Rgb::WHITE), fresnel: true };
    let glass = Material::new("glass".into(), Phong { transmission: Some(clear), ..Phong::BLACK });
    let interior = Some(InteriorMedium { absorption, ..InteriorMedium::clear(1.5) });
    scene.appearance.materials.push(Material { interior, ..glass });
    scene.nodes.push(node(cuboid([-20.0; 3], [20.0; 3]), 1));
    scene.cameras[0].medium = Some(MaterialId(1));
    let half = rt_math::transcendental::tan(0.4);
    for (integrator, precision) in [
        (Integrator::Whitted, Precision::F32),
        (Integrator::Whitted, Precision::F64),
        (Integrator::Direct, Precision::F32),
    ] {
        scene.settings.integrator = integrator;
        let plan = compile_with(&scene, PlanOptions { precision, ..PlanOptions::default() });
        let film = plan.render(&RunOptions::default(), |_| {}).expect("threads start").film;
        for (i, pixel) in film.pixels().iter().enumerate() {
            let at = DVec2::new((i % 33) as f64 - 16.0, (i / 33) as f64 - 16.0).length() / 16.5 * half * 5.0;
            let [to_light, to_camera] = [4.0, 5.0].map(|height: f64| (height * height + at * at).sqrt());
            let lit = absorption.map(|a| 4.0 / to_light * rt_math::transcendental::exp(-a * (to_light + to_camera)));
            for (seen, expected) in pixel.iter().zip(lit.to_array()) {
                let off = (f64::from(*seen) / expected - 1.0).abs();
                assert!(off < 1e-5, "{integrator:?} {precision:?} pixel {i}: {seen} not {expected}");
            }
        }
    }
}

#[test]
fn blended_layers_of_several_meshes_shared_one_random_number() {
    let layers = [(0.5, 0.0), (0.3, -0.5), (0.7, -1.0)];
    let black = |factor| {
        let alpha = Alpha { mode: AlphaMode::Blend, factor, ..Alpha::OPAQUE };
        Material { alpha, ..Material::new("black".into(), Phong::BLACK) }
    };
    let camera = camera([0.0, 5.0, 0.0], [0.0; 3], DVec3::NEG_Z, 0.8);
    let nodes = (0..3).map(|i| node(Content::Mesh(MeshId(i)), i)).collect();
    let materials = layers.iter().map(|(alpha, _)| black(*alpha)).collect();
    let mut scene = scene(camera, [64, 64], materials, nodes);
    scene.settings.spp = 16;
    scene.meshes = layers.iter().map(|(_, height)| square(*height)).collect();
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    for integrator in [Integrator::Path, Integrator::Whitted] {
        scene.settings.integrator = integrator;
        let film = film(&scene);
        let mean = film.pixels().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / film.pixels().len() as f64;
        // 5 standard errors of 64·64·16 samples.
        assert!((mean - 0.5 * 0.7 * 0.3).abs() < 0.006, "{integrator:?}: {mean}");
    }
}
