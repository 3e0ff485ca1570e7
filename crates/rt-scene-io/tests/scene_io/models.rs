//! Bare models, models within scenes, and scenes converted from models.

use std::fs;
use std::path::{Path, PathBuf};

use rt_math::Rgb;
use rt_scene_io::{Content, LoadOptions, Scene, SceneNode, convert, load};
use rt_shading::ColorTexture;
use tempfile::TempDir;

const OBJ: &str = "mtllib a.mtl
v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1
usemtl red\nf 1/1 2/2 3/3
usemtl picture\nf 1/1 3/3 4/2\n";

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNs 50\nnewmtl picture\nKd 1 1 1\nmap_Kd a.png\n";

/// A folder with a model in it, and the path of the model.
fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("a.obj");
    fs::write(&model, OBJ).unwrap();
    fs::write(folder.path().join("a.mtl"), MTL).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([10, 200, 30])).save(folder.path().join("a.png")).unwrap();
    (folder, model)
}

/// Version of [`folder`] with options whose assets may lie anywhere in it.
fn rooted() -> (TempDir, PathBuf, LoadOptions) {
    let (folder, model) = folder();
    let root = LoadOptions { root: Some(folder.path().to_path_buf()), ..LoadOptions::default() };
    (folder, model, root)
}

/// Writes the scene that `input` becomes, and checks that it gives the same image. Returns its text.
#[cfg(unix)]
fn converted(input: &Path, output: &Path, options: &LoadOptions) -> String {
    let text = convert(input, output, options).unwrap().text;
    fs::write(output, &text).unwrap();
    assert_eq!(image(&load(output, options).unwrap()), image(&load(input, options).unwrap()), "{}", input.display());
    text
}

fn scene(folder: &Path, text: &str) -> Scene {
    let path = folder.join("scene.ron");
    fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default()).unwrap()
}

/// All that an image depends on.
fn image(scene: &Scene) -> String {
    let Scene { name, cameras, film, settings, appearance, meshes, groups, nodes, .. } = scene;
    format!("{name:?}\n{cameras:?}\n{film:?}\n{settings:?}\n{appearance:#?}\n{meshes:?}\n{groups:?}\n{nodes:?}")
}

/// Names of the materials of all shapes and meshes, in order.
fn materials_of(scene: &Scene) -> Vec<&str> {
    fn collect<'a>(nodes: &[SceneNode], scene: &'a Scene, names: &mut Vec<&'a str>) {
        for node in nodes {
            if let Some(Content::Shape(_) | Content::Mesh(_)) = node.content {
                names.push(&scene.appearance.materials[node.material.0 as usize].name);
            }
            collect(&node.children, scene, names);
        }
    }
    let mut names = Vec::new();
    collect(&scene.nodes, scene, &mut names);
    names
}

fn diffuse(scene: &Scene, name: &str) -> ColorTexture {
    scene.appearance.materials.iter().find(|material| material.name == name).unwrap().to_phong().diffuse
}

#[test]
fn a_bare_model_gets_a_camera_light_and_ground() {
    let (_folder, model) = folder();
    let bare = load(&model, &LoadOptions::default()).unwrap();
    assert_eq!((bare.name.as_str(), bare.cameras.len(), bare.appearance.lights.len()), ("a", 1, 2));
    assert_eq!(bare.notes.len(), 2, "{:?}", bare.notes);
    let on_ground = load(&model, &LoadOptions { ground: true, ..LoadOptions::default() }).unwrap();
    assert_eq!(on_ground.nodes.len(), 2);
    assert_eq!(on_ground.notes.len(), 3, "{:?}", on_ground.notes);
    // The plane does not change what the camera sees.
    assert_eq!(on_ground.cameras, bare.cameras);
}

#[test]
fn the_camera_suits_the_requested_size() {
    let (_folder, model) = folder();
    let sized = |size| load(&model, &LoadOptions { size, ..LoadOptions::default() }).unwrap();
    let (own, narrow) = (sized(None), sized(Some([100, 1000])));
    assert_eq!((narrow.film.width, narrow.film.height), (100, 1000));
    let distance = |scene: &Scene| {
        let eye = scene.cameras[0].settings.world_from_camera.translation();
        (eye - scene.bounds().centre()).length()
    };
    assert!(distance(&narrow) > 3.0 * distance(&own));
}

#[test]
fn a_converted_model_gives_the_same_image() {
    let (folder, model) = folder();
    for options in [LoadOptions::default(), LoadOptions { ground: true, ..LoadOptions::default() }] {
        let direct = load(&model, &options).unwrap();
        for extension in ["ron", "json"] {
            let output = folder.path().join("out").with_extension(extension);
            fs::write(&output, convert(&model, &output, &options).unwrap().text).unwrap();
            let again = load(&output, &LoadOptions::default()).unwrap();
            assert_eq!(image(&again), image(&direct));
            assert!(again.notes.is_empty(), "everything is written out: {:?}", again.notes);
        }
    }
}

#[test]
fn a_converted_model_is_written_to_be_edited() {
    let (folder, model) = folder();
    insta::assert_snapshot!(convert(&model, &folder.path().join("out.ron"), &LoadOptions::default()).unwrap().text);
}

#[test]
fn references_follow_a_scene_to_another_folder() {
    let (folder, model, root) = rooted();
    fs::create_dir(folder.path().join("scenes")).unwrap();
    let output = folder.path().join("scenes/out.ron");
    let text = convert(&model, &output, &root).unwrap().text;
    assert!(text.contains("model: \"../a.obj\""), "{text}");
    assert!(text.starts_with("// ") && text.contains("render it with --asset-root"), "{text}");
    fs::write(&output, text).unwrap();
    assert!(load(&output, &LoadOptions::default()).unwrap_err().to_string().contains("lies outside"));
    let moved = load(&output, &root).unwrap();
    assert_eq!(image(&moved), image(&load(&model, &root).unwrap()));
    // And back again, through JSON.
    let back = folder.path().join("back.json");
    let text = convert(&output, &back, &root).unwrap().text;
    assert!(text.contains(r#""model": "a.obj""#), "{text}");
}

/// The reference named the target of the link, whose folder lacks the material library.
#[cfg(unix)]
#[test]
fn a_converted_scene_refers_to_the_link_to_a_model() {
    let (folder, model, root) = rooted();
    let at = |name: &str| folder.path().join(name);
    ["real", "out"].iter().for_each(|name| fs::create_dir(at(name)).unwrap());
    fs::rename(&model, at("real/t.obj")).unwrap();
    std::os::unix::fs::symlink("real/t.obj", &model).unwrap();
    let text = converted(&model, &at("out/t.ron"), &root);
    assert!(text.contains("model: \"../a.obj\""), "{text}");
}

/// A scene with a link next to it needs the root of the target of the link.
#[cfg(unix)]
#[test]
fn a_converted_scene_names_the_root_of_links_that_leave_its_folder() {
    let (folder, model) = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("out")).unwrap();
    std::os::unix::fs::symlink("../a.obj", at("out/link.obj")).unwrap();
    fs::write(at("scene.ron"), "(nodes: [(model: \"out/link.obj\")])").unwrap();
    fs::copy(model.with_extension("mtl"), at("out/a.mtl")).unwrap();
    fs::copy(model.with_extension("png"), at("out/a.png")).unwrap();
    let converted = convert(&at("scene.ron"), &at("out/t.ron"), &LoadOptions::default()).unwrap();
    assert!(converted.text.contains("model: \"link.obj\""), "{}", converted.text);
    assert!(converted.notes.iter().any(|note| note.contains("--asset-root")), "{:?}", converted.notes);
}

/// The scene could not be read: `c:d.obj` looks like an absolute path, and `file:d.obj` like a URL.
#[cfg(unix)]
#[test]
fn a_converted_scene_refers_to_a_model_with_a_colon_in_its_name() {
    let (folder, model, root) = rooted();
    fs::create_dir(folder.path().join("c:")).unwrap();
    for needed in ["a.mtl", "a.png"] {
        fs::copy(folder.path().join(needed), folder.path().join("c:").join(needed)).unwrap();
    }
    for name in ["c:d.obj", "file:d.obj", "c:/d.obj"] {
        let input = folder.path().join(name);
        fs::copy(&model, &input).unwrap();
        for output in ["out.ron", "c:/out.ron"] {
            converted(&input, &folder.path().join(output), &root);
        }
    }
}

/// The text named another file, with slashes or replacement characters.
#[cfg(unix)]
#[test]
fn names_that_no_scene_can_refer_to_are_refused() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    let (folder, model, root) = rooted();
    fs::create_dir(folder.path().join("e")).unwrap();
    fs::copy(&model, folder.path().join("e/f.obj")).unwrap();
    for name in [&b"a\\b.obj"[..], b"e\\f.obj", b"\xFF.obj"] {
        let input = folder.path().join(OsStr::from_bytes(name));
        fs::copy(&model, &input).unwrap();
        for output in ["out.ron", "e/out.ron"] {
            let message = convert(&input, &folder.path().join(output), &root).unwrap_err().to_string();
            let rule = "contains a backslash or is not UTF-8: rename it";
            assert!(message.contains(rule), "{}: {message}", input.display());
        }
    }
}

/// The unused material made the scene choose `path`, and the model `whitted`.
#[test]
fn a_converted_model_without_surfaces_keeps_its_integrator() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("a.gltf");
    let points = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0, "material": 0}]}],
        "materials": [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 12}],
        "buffers": [{"byteLength": 12, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}]}"#;
    fs::write(&model, points).unwrap();
    for options in [LoadOptions::default(), LoadOptions { ground: true, ..LoadOptions::default() }] {
        let output = folder.path().join("out.ron");
        let text = convert(&model, &output, &options).unwrap().text;
        assert!(text.contains("\"red\""), "{text}");
        fs::write(&output, text).unwrap();
        let again = load(&output, &LoadOptions::default()).unwrap();
        assert_eq!(again.settings, load(&model, &options).unwrap().settings);
    }
}

#[test]
fn a_scene_changes_materials_of_its_models_by_name() {
    let (folder, _) = folder();
    let scene = scene(
        folder.path(),
        r#"(
            materials: {"picture": phong(color: rgb(1, 0, 0), mirror: gray(0.25)), "red": phong(diffuse: gray(0.5))},
            nodes: [(model: "a.obj")],
        )"#,
    );
    assert_eq!(diffuse(&scene, "red"), ColorTexture::Constant(Rgb::gray(0.5)));
    // The texture stays and is tinted.
    assert!(matches!(diffuse(&scene, "picture"), ColorTexture::Textured(_, scale) if scale == Rgb::new(1.0, 0.0, 0.0)));
    let red = scene.appearance.materials.iter().find(|material| material.name == "red").unwrap();
    assert_eq!(red.to_phong().specular, ColorTexture::Constant(Rgb::gray(0.5)), "what is not given stays");
}

#[test]
fn a_model_is_placed_many_times_and_loaded_once() {
    let (folder, _) = folder();
    let scene = scene(
        folder.path(),
        r#"(
            materials: {"gold": phong()},
            nodes: [(model: "a.obj"), (model: "a.obj", transform: [translate(5, 0, 0)], material: "gold")],
        )"#,
    );
    assert_eq!(materials_of(&scene), ["red", "picture", "gold", "gold"]);
    assert_eq!((scene.meshes.len(), scene.appearance.textures.len()), (2, 1));
    assert!((scene.bounds().max.x - 7.0).abs() < 1e-9);
}

#[test]
fn problems_of_a_model_name_its_file() {
    let (folder, model) = folder();
    fs::write(&model, "v 0 0\n").unwrap();
    let path = folder.path().join("scene.ron");
    fs::write(&path, r#"(nodes: [(model: "a.obj"), (model: "b.obj")])"#).unwrap();
    let error = load(&path, &LoadOptions::default()).unwrap_err().to_string();
    let error = error.replace(&folder.path().display().to_string(), "");
    let lines: Vec<&str> = error.lines().collect();
    assert!(lines[3].starts_with("/a.obj:1: "), "{error}");
    assert!(lines[0].starts_with("/scene.ron:1:29: nodes[1].model: `b.obj` does not exist"), "{error}");
}
