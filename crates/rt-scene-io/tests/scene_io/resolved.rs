//! Resolved scene files.

use std::path::Path;

use rt_camera::CameraSettings;
use rt_math::{DVec3, Rgb};
use rt_scene_io::format::{SceneFile, json_schema, parse_json, parse_ron, reference_page};
use rt_scene_io::{Content, Integrator, LoadOptions, Scene, SceneNode, resolve};
use rt_shading::{ColorTexture, DeltaLightKind, Texture};

const SCENE: &str = r##"
(
    camera: (look_from: (0, 1, 5), look_at: (0, 1, 0), fov: 30),
    cameras: [(name: "top", transform: [rotate_x(-90), translate(0, 9, 0)], orthographic: 4)],
    film: (size: (320, 240), filter: gaussian(0.5), encoding: gamma(2.2)),
    settings: (sampler: half_jittered, spp: 4, max_depth: 2),
    background: gradient(bottom: gray(0.1), top: hex("#ffffff")),
    lights: [
        point(position: (1, 2, 3), intensity: gray(0.7), shadow_near: 0.5),
        ambient(gray(0.25)),
        ambient(rgb(0.25, 0, 0)),
        spot(position: (0, 5, 0), direction: (0, -2, 0), falloff: inverse_square, casts_shadows: false),
    ],
    materials: {
        "floor": phong(color: checker(even: gray(1), odd: rgb(1, 0, 0)), diffuse: gray(0.5), ambient: gray(0)),
        "unused": phong(emission: gray(1)),
        "glass": phong(diffuse: gray(0), transmission: gray(0.9), mirror: gray(0.1), exponent: 200, highlight: blinn),
    },
    groups: {
        "two pairs": [(instance: "pair"), (transform: [translate(0, 0, -3)], instance: "pair")],
        "pair": [(shape: sphere(), material: "glass"), (shape: sphere(center: (2, 0, 0)))],
    },
    nodes: [
        (name: "floor", shape: plane(), material: "floor"),
        (
            material: "glass",
            transform: [translate(1, 0, 0), scale(2), rotate_z(90)],
            casts_shadow: false,
            instance: None,
            children: [
                (shape: box(min: (0, 0, 0), max: (1, 1, 1))),
                (shape: triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), material: "floor"),
            ],
        ),
        (instance: "two pairs"),
        (shape: quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))),
    ],
    truth: (mean: gray(0.5), note: "made up"),
)
"##;

fn parse(text: &str) -> SceneFile {
    parse_ron(text, Path::new("scene.ron")).unwrap()
}

fn resolved(text: &str) -> Scene {
    resolve(&parse(text), Path::new("folder/test.ron"), &LoadOptions::default()).unwrap()
}

/// A line for each thing in the scene, with children indented.
fn outline(scene: &Scene) -> String {
    let mut lines = vec![format!("{:?}", scene.name)];
    lines.extend(scene.cameras.iter().map(|camera| {
        let CameraSettings { world_from_camera, projection, .. } = camera.settings;
        let (from, along) = (world_from_camera.translation(), world_from_camera.vector(DVec3::NEG_Z));
        format!("camera {:?} at {from:.3} along {along:.3}: {projection:?}", camera.name)
    }));
    lines.push(format!("{:?}", scene.film));
    lines.push(format!("{:?}", scene.settings));
    lines.extend(scene.appearance.materials.iter().map(|material| format!("{material:?}")));
    lines.extend(scene.appearance.textures.iter().map(|texture| format!("{texture:?}")));
    lines.extend(scene.appearance.lights.iter().map(|light| format!("{light:?}")));
    lines.push(format!("ambient {:?}, background {:?}", scene.appearance.ambient, scene.appearance.background));
    lines.extend(scene.meshes.iter().map(|mesh| format!("mesh {:?}: {:?}", mesh.name, mesh.mesh.data())));
    for group in &scene.groups {
        lines.push(format!("group {:?}", group.name));
        outline_nodes(&group.nodes, 1, &mut lines);
    }
    outline_nodes(&scene.nodes, 0, &mut lines);
    lines.push(format!("truth {:?}", scene.truth));
    lines.extend(scene.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

fn outline_nodes(nodes: &[SceneNode], depth: usize, lines: &mut Vec<String>) {
    for SceneNode { name, parent_from_local, moves_to, content, material, casts_shadow, children, .. } in nodes {
        let (axes, origin) = (parent_from_local.linear(), parent_from_local.translation());
        let indent = "    ".repeat(depth);
        let place =
            if parent_from_local.is_identity() { String::new() } else { format!(" at {origin:.3} in {axes:.3}") };
        let shadow = if *casts_shadow { "" } else { " without shadow" };
        let motion = moves_to.map_or_else(String::new, |end| format!(" moving to {:.3}", end.translation()));
        lines.push(format!("{indent}node {name:?}: {content:?} of {material:?}{place}{motion}{shadow}"));
        outline_nodes(children, depth + 1, lines);
    }
}

#[test]
fn a_material_that_only_instances_or_models_would_inherit_is_a_warning() {
    let warnings = |nodes: &str| -> Vec<String> {
        let scene = resolved(&format!("(nodes: [{nodes}], groups: {{\"g\": [(shape: sphere())]}})"));
        scene.warnings.iter().map(ToString::to_string).collect()
    };
    let red = "material: diffuse(albedo: (1, 0, 0))";
    let message = "nodes[0].material: has no effect: the instance \"g\" below does not inherit it; write it at the nodes of the \
                   group";
    assert_eq!(warnings(&format!("({red}, children: [(instance: \"g\")])")), [message]);
    assert_eq!(warnings(&format!("({red}, children: [(children: [(instance: \"g\")])])")), [message]);
    for used in [
        format!("({red}, children: [(instance: \"g\"), (shape: sphere())])"),
        format!("({red}, shape: sphere(), children: [(instance: \"g\")])"),
        "(children: [(instance: \"g\")])".to_owned(),
    ] {
        assert_eq!(warnings(&used), [""; 0], "{used}");
    }
}

#[test]
fn a_scene_is_resolved() {
    insta::assert_snapshot!(outline(&resolved(SCENE)));
}

#[test]
fn three_lines_are_a_scene() {
    insta::assert_snapshot!(outline(&resolved(include_str!("../../../../scenes/gallery/three_lines.ron"))));
}

#[test]
fn steps_are_applied_in_the_order_in_which_they_are_written() {
    let scene = resolved(SCENE);
    // Moved to x = 1, doubled to x = 2, turned onto the y axis.
    let origin = scene.nodes[1].parent_from_local.point(DVec3::ZERO);
    assert!((origin - DVec3::new(0.0, 2.0, 0.0)).length() < 1e-12, "{origin}");
}

#[test]
fn materials_are_inherited_and_only_used_ones_are_kept() {
    let scene = resolved(SCENE);
    let name = |node: &SceneNode| scene.appearance.materials[node.material.0 as usize].name.as_str();
    let names: Vec<&str> = scene.nodes[1].children.iter().map(name).collect();
    assert_eq!(names, ["glass", "floor"]);
    assert_eq!(name(&scene.nodes[3]), "default");
    assert!(scene.appearance.materials.iter().all(|material| material.name != "unused"));
    // Materials do not cross into groups: the second sphere of the pair has none.
    let pair = scene.groups.iter().find(|group| group.name == "pair").unwrap();
    assert_eq!(pair.nodes.iter().map(name).collect::<Vec<_>>(), ["glass", "default"]);
}

#[test]
fn groups_come_after_those_that_they_contain() {
    let scene = resolved(SCENE);
    let names: Vec<&str> = scene.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["pair", "two pairs"]);
    let Some(Content::Instance(id)) = scene.nodes[2].content else { panic!("{:?}", scene.nodes[2]) };
    assert_eq!(scene.groups[id.0 as usize].name, "two pairs");
    assert!(scene.bounds().min.z < -3.9);
}

#[test]
fn colour_is_a_factor_for_ambient_and_diffuse() {
    let scene = resolved(SCENE);
    let floor = scene.appearance.materials.iter().find(|material| material.name == "floor").unwrap();
    assert!(matches!(floor.to_phong().diffuse, ColorTexture::Textured(_, scale) if scale == Rgb::gray(0.5)));
    assert!(floor.to_phong().ambient.is_zero());
    assert!(matches!(scene.appearance.textures[..], [Texture::Checker { size: 1.0, .. }]));
}

#[test]
fn fresnel_glass_mirrors_unless_the_file_says_otherwise() {
    let mirror = |glass: &str| {
        let scene = resolved(&format!(
            r#"(materials: {{"glass": phong({glass})}}, nodes: [(shape: sphere(), material: "glass")])"#
        ));
        scene.appearance.materials[0].to_phong().mirror
    };
    let gray = |value| ColorTexture::Constant(Rgb::gray(value));
    assert_eq!(mirror("transmission: gray(1), fresnel: true"), gray(1.0));
    assert_eq!(mirror("transmission: gray(1), fresnel: true, mirror: gray(0)"), gray(0.0));
    assert_eq!(mirror("transmission: gray(1)"), gray(0.0));
    assert_eq!(mirror("fresnel: true"), gray(0.0), "nothing passes, so there is nothing to share");
}

#[test]
fn lights_are_as_written() {
    let scene = resolved(SCENE);
    assert_eq!(scene.appearance.ambient, Rgb::new(0.5, 0.25, 0.25));
    let [point, spot] = &scene.appearance.lights[..] else { panic!("{:?}", scene.appearance.lights) };
    assert!(matches!(point.kind, DeltaLightKind::Point { shadow_near: 0.5, .. }) && point.casts_shadows);
    let DeltaLightKind::Spot { direction, cos_inner, cos_outer, .. } = spot.kind else { panic!("{spot:?}") };
    assert_eq!(direction, DVec3::NEG_Y);
    assert!((cos_inner - 0.939_692_620_785_908_4).abs() < 1e-15);
    assert!((cos_outer - 0.866_025_403_784_438_6).abs() < 1e-15);
}

#[test]
fn bright_textures_of_dim_factors_were_no_lights() {
    let with = |emission: &str| {
        let material = format!("material: diffuse(emission: {emission})");
        resolved(&format!("(settings: (integrator: path), nodes: [(shape: sphere(), {material})])"))
    };
    for (emission, lights) in [
        ("checker(even: (2, 1, 0), odd: (2, 1, 0))", 0),
        ("checker(even: 0, odd: (0, 0, 30))", 0),
        ("checker(even: 1, odd: (0.5, 1, 0.2))", 2),
        ("(0.1, 0, 0)", 0),
    ] {
        assert_eq!(with(emission).appearance.lights.len(), lights, "{emission}");
    }
}

#[test]
fn what_is_left_open_is_chosen_and_noted() {
    let studio = resolved("(nodes: [(shape: sphere())])");
    assert_eq!(studio.notes.len(), 2, "{:?}", studio.notes);
    assert_eq!((studio.appearance.lights.len(), studio.cameras.len()), (2, 1));
    // An empty list means darkness, and a camera that has a place keeps it.
    let dark = resolved("(nodes: [(shape: sphere())], lights: [], camera: (look_from: (0, 0, 5)))");
    assert!(dark.notes.is_empty() && dark.appearance.lights.is_empty());
    assert!(dark.appearance.ambient.is_black());
    // An empty scene is a scene.
    assert_eq!(resolved("(nodes: [])").cameras.len(), 1);
}

#[test]
fn ron_and_json_hold_the_same_model() {
    let file = parse(SCENE);
    assert_eq!(parse(&file.to_ron()), file);
    assert_eq!(parse_json(&file.to_json(), Path::new("scene.json")).unwrap(), file);
    insta::assert_snapshot!(file.to_ron());
}

/// Fails if a file of the repository is out of date, after it has been rewritten.
fn is_up_to_date(file: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    if std::fs::read_to_string(&path).ok().as_deref() != Some(text) {
        std::fs::write(&path, text).unwrap();
        panic!("{} was out of date; it has been rewritten: commit it", path.display());
    }
}

#[test]
fn the_schema_in_the_repository_is_up_to_date() {
    is_up_to_date("scenes/scene.schema.json", json_schema());
}

#[test]
fn the_reference_page_in_the_repository_is_up_to_date() {
    is_up_to_date("docs/SCENE-FORMAT.md", &reference_page());
}

/// The documented default radius of 0 was refused.
#[test]
fn a_lens_without_radius_is_a_pinhole() {
    for lens in ["()", "(focus: 4)", "(blades: 6)"] {
        for camera in ["look_from: (0, 0, 5), ", "transform: [translate(0, 0, 5)], ", ""] {
            let scene = resolved(&format!("(camera: ({camera}lens: {lens}), nodes: [(shape: sphere())])"));
            let found = scene.cameras[0].settings.lens.expect("a lens");
            assert_eq!(found.radius, 0.0, "{camera}{lens}");
        }
    }
}

/// The settings of the file were checked before the command line overrode them.
#[test]
fn overridden_adaptive_sampling_is_not_checked() {
    let text = |settings: &str| format!("(settings: ({settings}), nodes: [(shape: sphere())])");
    let error = |settings: &str, options: &LoadOptions| {
        let result = resolve(&parse(&text(settings)), Path::new("scene.ron"), options);
        result.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let own = LoadOptions::default();
    let more = LoadOptions { spp: Some(256), ..LoadOptions::default() };
    let off = LoadOptions { overrides_adaptive: true, ..LoadOptions::default() };
    let whitted = LoadOptions { integrator: Some(Integrator::Whitted), ..LoadOptions::default() };
    let many = "adaptive: object_space(min_spp: 32)";
    assert!(error(many, &own).contains("settings.adaptive.min_spp: 32 must lie between 1 and 16"));
    assert_eq!((error(many, &more), error(many, &off)), Default::default());
    let path = "integrator: path, adaptive: object_space()";
    let refused = "scene.ron: settings.adaptive: object_space supports the integrator `whitted` only, not `path`";
    assert!(error(path, &own).starts_with(refused), "{}", error(path, &own));
    assert_eq!((error(path, &off), error(path, &whitted)), Default::default());
}

#[test]
fn a_contribution_above_the_whole_pixel_is_refused() {
    let text = "(settings: (min_contribution: 2), nodes: [])";
    let error = resolve(&parse(text), Path::new("scene.ron"), &LoadOptions::default()).expect_err(text).to_string();
    assert_eq!(error, "scene.ron: settings.min_contribution: 2 must lie between 0 and 1");
}
