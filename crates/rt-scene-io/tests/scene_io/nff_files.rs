//! The Standard Procedural Databases as others generated them. Without the folder of test data next to the repository these
//! tests have nothing to do.

use rt_geometry::Shape;
use rt_scene_io::{Content, LoadOptions, Model, convert, load, load_model};
use rt_tests::shared_or_skip;

/// Numbers of spheres, cylinders and cones, single polygons, and triangles of meshes.
fn census(model: &Model) -> [usize; 4] {
    let mut census = [0; 4];
    for node in &model.nodes {
        match node.content {
            Some(Content::Shape(Shape::Sphere(_))) => census[0] += 1,
            Some(Content::Shape(Shape::Cylinder(_) | Shape::Cone(_) | Shape::Frustum(_))) => census[1] += 1,
            Some(Content::Shape(Shape::Polygon(_) | Shape::Triangle(_))) => census[2] += 1,
            _ => {}
        }
    }
    census[3] = model.meshes.iter().map(|named| named.mesh.data().triangles.len()).sum();
    census
}

#[test]
fn databases_have_all_of_their_objects() {
    let Some(folder) = shared_or_skip("data") else { return };
    let expected = [
        ("balls-s1", 3, [10, 0, 1, 0]),
        ("balls-s2", 3, [91, 0, 1, 0]),
        ("balls-s3", 3, [820, 0, 1, 0]),
        ("lattice-s2", 6, [27, 54, 0, 0]),
        ("rings-s2", 3, [150, 150, 1, 0]),
        ("teapot-s2", 2, [0, 0, 4, 240]),
        ("tetra-s2", 1, [0, 0, 16, 0]),
        ("tetra-s4", 1, [0, 0, 0, 256]),
    ];
    for (name, lights, objects) in expected {
        let path = folder.join("nff-spd").join(name).with_extension("nff");
        let model = load_model(&path, &LoadOptions::default()).expect(name);
        assert_eq!((model.lights.len(), census(&model)), (lights, objects), "{name}");
        assert_eq!((model.cameras.len(), model.image_size), (1, Some([512, 512])), "{name}");
        assert!(model.lights.iter().all(|light| light.units == rt_shading::LightUnits::Classical));
        assert_eq!(model.warnings, [], "{name}");
    }
}

#[test]
fn a_converted_database_gives_the_same_scene() {
    let Some(folder) = shared_or_skip("data") else { return };
    let place = tempfile::tempdir().expect("a folder");
    let input = place.path().join("m.nff");
    std::fs::copy(folder.join("nff-spd/rings-s2.nff"), &input).expect("copied");
    let output = place.path().join("m.ron");
    let text = convert(&input, &output, &LoadOptions::default()).expect("converted").text;
    std::fs::write(&output, text).expect("written");
    let [direct, again] = [&input, &output].map(|path| load(path, &LoadOptions::default()).expect("a scene"));
    assert_eq!((again.film, &again.cameras, &again.settings), (direct.film, &direct.cameras, &direct.settings));
    assert_eq!(format!("{:?}", again.appearance), format!("{:?}", direct.appearance));
    assert_eq!(format!("{:?}", again.nodes), format!("{:?}", direct.nodes));
}
