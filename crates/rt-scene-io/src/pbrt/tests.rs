use super::*;
use crate::format::{Background, Color};
use crate::text::tokenizer::Tokenizer;
use crate::{Content, LoadErrorKind, SceneNode};
use rt_camera::{FovAxis, Projection};
use rt_geometry::Shape;
use rt_math::{DVec3, Rgb, Transform};
use rt_shading::bsdf::ComplexIor;
use rt_shading::light::EmissionSides;
use rt_shading::{ColorTexture, DeltaLightKind, MaterialModel, Texture};

/// A scene with most of the supported directives.
const SCENE: &str = r#"
# A comment with "quotes" and [brackets].
Scale 1 1 1
LookAt 0 1 -5  0 1 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" [64] "integer yresolution" 48 "string filename" "a.exr"
Sampler "halton" "integer pixelsamples" 4
WorldBegin
LightSource "infinite" "rgb L" [0.1 0.2 0.3]
LightSource "distant" "point3 from" [0 4 0] "point3 to" [0 0 0] "blackbody L" 5000
AttributeBegin
  Translate 1 2 3
  LightSource "point" "rgb I" [3 3 3] "float scale" 2
  AreaLightSource "diffuse" "rgb L" [5 5 5]
  Shape "disk" "float radius" 0.5
AttributeEnd
Texture "squares" "spectrum" "checkerboard" "float uscale" 8 "float vscale" 8 "rgb tex1" [1 0 0]
MakeNamedMaterial "red" "string type" "diffuse" "texture reflectance" "squares"
MakeNamedMaterial "gold" "string type" "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
NamedMaterial "red"
Shape "trianglemesh" "point3 P" [-1 0 0  1 0 0  0 1 0] "integer indices" [0 1 2]
ObjectBegin "thing"
  NamedMaterial "gold"
  Shape "sphere" "float radius" [0.25]
ObjectEnd
AttributeBegin
  Translate 0 3 0
  ObjectInstance "thing"
AttributeEnd
ObjectInstance "thing"
Material "dielectric" "float eta" 1.25 "float roughness" 0.0625
Shape "cylinder" "float zmin" 0 "float zmax" 2
"#;

fn load(text: &str) -> Result<Model, LoadError> {
    load_text(text, Path::new("m.pbrt"), &LoadOptions::default())
}

pub(super) fn good(text: &str) -> Model {
    load(text).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene of one shape with these directives before it.
pub(super) fn world(before: &str) -> String {
    format!("WorldBegin\n{before}\nShape \"sphere\"\n")
}

/// All nodes with their transforms to the world.
fn placed(nodes: &[SceneNode], outer: &Transform) -> Vec<(Transform, SceneNode)> {
    let mut all = Vec::new();
    for node in nodes {
        let place = outer.compose(&node.parent_from_local);
        all.extend(placed(&node.children, &place));
        if node.content.is_some() {
            all.push((place, node.clone()));
        }
    }
    all
}

pub(super) fn shapes(model: &Model) -> Vec<(Transform, SceneNode)> {
    placed(&model.nodes, &Transform::IDENTITY)
}

/// Origin of the last shape in the world of the file.
fn place(model: &Model) -> DVec3 {
    let (world_from_shape, _) = shapes(model).pop().expect("a shape");
    model.nodes[0].parent_from_local.inverse_point(world_from_shape.point(DVec3::ZERO))
}

/// Image position of a point of the file's world: to the right and upwards, −1 to 1 at 45°.
fn seen(model: &Model, file_point: DVec3) -> [f64; 2] {
    let p = model.nodes[0].parent_from_local.point(file_point);
    let p = model.cameras[0].settings.world_from_camera.inverse_point(p);
    assert!(p.z < 0.0, "{p} is behind the camera");
    [p.x / -p.z, p.y / -p.z]
}

#[test]
fn known_values_of_a_scene() {
    let model = good(SCENE);
    assert_eq!(model.warnings, []);
    assert_eq!((model.image_size, model.is_photometric), (Some([64, 48]), false));
    let fov = 40f64.to_radians();
    assert_eq!(model.cameras[0].settings.projection, Projection::Perspective { fov, axis: FovAxis::Vertical });
    assert_eq!(model.background, Some(Background::Constant(Color::from_rgb([0.1, 0.2, 0.3]))));
    assert_eq!(model.notes, ["Sampler \"halton\" is ignored: this program chooses its own."]);

    let DeltaLightKind::Directional { direction } = model.lights[0].kind else { panic!("a sun") };
    assert_eq!(direction, DVec3::NEG_Y);
    // The world is mirrored in z.
    let DeltaLightKind::Point { position, .. } = model.lights[1].kind else { panic!("a lamp") };
    assert_eq!(position, DVec3::new(1.0, 2.0, -3.0));
    assert!((model.lights[1].intensity.g - 6.0).abs() < 1e-12);

    let all = shapes(&model);
    let kinds: Vec<_> = all.iter().map(|(_, node)| node.name.as_str()).collect();
    assert_eq!(kinds, ["line 15", "line 21", "line 24", "line 24", "line 32"]);
    let of = |i: usize| &model.materials[all[i].1.material.0 as usize];
    assert_eq!((of(0).emission, of(0).emission_sides), (ColorTexture::Constant(Rgb::gray(5.0)), EmissionSides::Front));
    let MaterialModel::Diffuse { albedo: ColorTexture::Textured(id, _), .. } = of(1).model else { panic!("squares") };
    let Texture::Mapped { texture, map } = &model.textures[id.0 as usize] else { panic!("mapped") };
    assert_eq!(**texture, Texture::Checker { even: Rgb::new(1.0, 0.0, 0.0), odd: Rgb::BLACK, size: 1.0 });
    assert_eq!(map.rows[0], [8.0, 0.0, 0.0]);
    assert_eq!(of(2).model, MaterialModel::Conductor { ior: ComplexIor::GOLD, roughness: 0.0 });
    assert_eq!(all[2].1.material, all[3].1.material);
    assert_eq!((all[2].0.point(DVec3::ZERO), all[3].0.point(DVec3::ZERO)), (DVec3::Y * 3.0, DVec3::ZERO));
    // α = √(1/16) is ours of 1/2.
    let MaterialModel::Dielectric { roughness, .. } = of(4).model else { panic!("glass") };
    assert_eq!((roughness, of(4).interior.expect("a dielectric").ior), (0.5, 1.25));
}

#[test]
fn right_stays_right_and_the_front_stays_the_front() {
    let middle =
        |text: &str| (seen(&good(text), DVec3::new(1.0, 1.0, 0.0)), seen(&good(text), DVec3::new(0.0, 2.0, 0.0)));
    // A left-handed world seen along +z: +x is to the right.
    assert_eq!(middle(SCENE), ([0.2, 0.0], [0.0, 0.2]));
    // A mirror before the camera.
    assert_eq!(middle(&SCENE.replace("Scale 1 1 1", "Scale -1 1 1")), ([-0.2, 0.0], [0.0, 0.2]));
    // From the other side.
    assert_eq!(middle(&SCENE.replace("LookAt 0 1 -5", "LookAt 0 1 5")), ([-0.2, 0.0], [0.0, 0.2]));
    for text in [SCENE.to_owned(), SCENE.replace("Scale 1 1 1", "Scale -1 1 1")] {
        let model = good(&text);
        assert!(!model.cameras[0].settings.world_from_camera.flips_handedness());
        // The disk faces +z of the file, our mesh has the winding of the file.
        let (place, _) = &shapes(&model)[0];
        let root = model.nodes[0].parent_from_local;
        assert!((place.normal(DVec3::Y).normalize() - root.vector(DVec3::Z)).length() < 1e-12);
        let data = model.mesh_data(0);
        assert_eq!(data.triangles, [[0, 1, 2]]);
        assert_eq!(root.normal(DVec3::Z), root.vector(DVec3::Z));
        assert_eq!(model.nodes[0].is_left_handed, root.flips_handedness());
    }
}

#[test]
fn orientation_is_reversed_with_the_normals() {
    let mesh = |before: &str, normals: &str| {
        let text = format!("WorldBegin\n{before}\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] {normals}");
        good(&text).mesh_data(0).clone()
    };
    assert_eq!(mesh("", "").triangles, [[0, 1, 2]]);
    assert_eq!(mesh("ReverseOrientation", "").triangles, [[0, 2, 1]]);
    let down = "\"normal N\" [0 0 -1 0 0 -1 0 0 -1]";
    assert_eq!(mesh("", down).triangles, [[0, 2, 1]]);
    assert_eq!(mesh("ReverseOrientation", down).triangles, [[0, 1, 2]]);
    let disk = good("WorldBegin ReverseOrientation Shape \"disk\" \"float height\" 2");
    let (place, _) = &shapes(&disk)[0];
    assert_eq!(place.point(DVec3::ZERO), DVec3::Z * -2.0);
    assert!((place.normal(DVec3::Y) - DVec3::Z).length() < 1e-12, "the file's −z, mirrored");
}

/// A colour space was a note that `--strict` accepts, although it changes all colours.
#[test]
fn the_colour_space_srgb_is_no_warning() {
    let model = good(&world("ColorSpace \"srgb\""));
    assert_eq!((&model.warnings[..], &model.notes[..]), (&[][..], &[][..]));
}

/// `u` of a sphere begins at the +x of the file and goes on to its +y.
#[test]
fn shapes_of_revolution_stand_along_z() {
    let model = good("WorldBegin Translate 0 0 7 Shape \"cylinder\" \"float zmin\" 1 \"float zmax\" 3");
    let (place, node) = &shapes(&model)[0];
    let Some(Content::Shape(Shape::Cylinder(cylinder))) = &node.content else { panic!("a cylinder") };
    assert_eq!(cylinder.heights(), [1.0, 3.0]);
    let of_file = |ours: DVec3| model.nodes[0].parent_from_local.inverse_point(place.point(ours));
    assert_eq!(of_file(DVec3::Y * 3.0), DVec3::new(0.0, 0.0, 10.0));
    assert_eq!(of_file(DVec3::NEG_Z), DVec3::new(1.0, 0.0, 7.0));
    assert_eq!(of_file(DVec3::NEG_X), DVec3::new(0.0, 1.0, 7.0));
}

#[test]
fn matrices_stand_column_by_column_and_add_up() {
    let at = |text: &str| place(&good(&world(text)));
    assert_eq!(at("Transform [1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1]"), DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(at("Scale 2 2 2 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 4 5 6 1]"), DVec3::new(8.0, 10.0, 12.0));
    assert!((at("Rotate 90 0 0 1 Translate 1 0 0") - DVec3::Y).length() < 1e-12);
    assert_eq!(at("Translate 1 0 0 CoordinateSystem \"a\" Identity CoordSysTransform \"a\""), DVec3::X);
    assert_eq!(at("AttributeBegin Translate 1 0 0 AttributeEnd Translate 0 1 0"), DVec3::Y);
    assert_eq!(at("ActiveTransform EndTime Translate 1 0 0 ActiveTransform All"), DVec3::ZERO);
}

/// `EndTime` stayed active after its scope, so that later transforms were left out.
#[test]
fn active_transforms_end_with_their_scope() {
    let end = "ActiveTransform EndTime Translate 0 1 0";
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("end.pbrt"), end).expect("written");
    let at = |text: &str| {
        let path = folder.path().join("m.pbrt");
        place(&load_text(&world(text), &path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")))
    };
    for scope in [
        format!("AttributeBegin {end} AttributeEnd"),
        format!("ObjectBegin \"a\" {end} ObjectEnd"),
        "Import \"end.pbrt\"".to_owned(),
    ] {
        assert_eq!(at(&format!("{scope} Translate 1 0 0")), DVec3::X, "{scope}");
    }
    assert_eq!(at("Include \"end.pbrt\" Translate 1 0 0"), DVec3::ZERO, "an included file is no scope");
    assert_eq!(at("ActiveTransform EndTime AttributeBegin AttributeEnd Translate 1 0 0"), DVec3::ZERO);
}

/// `CoordSysTransform` was left out while the end of a motion was active.
#[test]
fn coordinate_systems_replace_the_transforms_of_both_times() {
    let text = "Translate 1 0 0 CoordinateSystem \"a\" Identity ActiveTransform EndTime CoordSysTransform \"a\"";
    let model = good(&world(text));
    assert_eq!(place(&model), DVec3::X);
    assert_eq!(model.warnings, []);
}

#[test]
fn portraits_and_orthographic_views_are_measured_along_the_shorter_side() {
    let tall = SCENE.replace("[64]", "[24]");
    assert!(matches!(
        good(&tall).cameras[0].settings.projection,
        Projection::Perspective { axis: FovAxis::Horizontal, .. }
    ));
    let flat = |text: &str| text.replace("\"perspective\" \"float fov\" 40", "\"orthographic\"");
    let height = |text: &str| good(&flat(text)).cameras[0].settings.projection;
    assert_eq!(height(SCENE), Projection::Orthographic { height: 2.0 });
    assert_eq!(height(&tall), Projection::Orthographic { height: 4.0 });
}

#[test]
fn every_bad_line_is_named_and_all_in_one_run() {
    let cases = [
        ("Shpae \"sphere\"", "m.pbrt:2: unknown directive `Shpae`; did you mean `Shape`?"),
        ("Shape \"cube\"", "m.pbrt:2: unknown shape `cube`"),
        ("Shape \"sphere\" \"float radius\" -1", "m.pbrt:2: \"radius\": -1 must be above 0"),
        ("Shape \"trianglemesh\"", "m.pbrt:2: a mesh has no \"point3 P\": add its vertices"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "m.pbrt:2: \"indices\": 3 is not a vertex",
        ),
        ("Shape \"plymesh\" \"string filename\" \"none.ply\"", "m.pbrt:2: `none.ply` does not exist"),
        ("Shape \"plymesh\" \"string filename\" \"/etc/a.ply\"", "m.pbrt:2: `/etc/a.ply` is absolute"),
        ("Include \"../../../../etc/passwd\"", "m.pbrt:2: `../../../../etc/passwd`"),
        ("Material \"wood\"", "m.pbrt:2: unknown material `wood`"),
        (
            "Material \"diffuse\" \"rgb reflectance\" [1 2]",
            "m.pbrt:2: the parameter \"reflectance\" of type rgb needs 3 numbers",
        ),
        (
            "Material \"diffuse\" \"texture reflectance\" \"t\"",
            "m.pbrt:2: unknown spectrum texture `t`; no spectrum textures are defined",
        ),
        (
            "Texture \"t\" \"float\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"t\"",
            "m.pbrt:2: unknown spectrum texture `t`; no spectrum textures are defined",
        ),
        ("Texture \"t\" \"color\" \"constant\"", "m.pbrt:2: unknown type of a texture `color`"),
        ("NamedMaterial \"m\"", "m.pbrt:2: unknown material `m`; no materials are defined"),
        ("ObjectInstance \"m\"", "m.pbrt:2: unknown object `m`; no objects are defined"),
        ("Texture \"t\" \"float\" \"wood\"", "m.pbrt:2: unknown texture `wood`"),
        ("Texture \"t\" \"spectrum\" \"imagemap\"", "m.pbrt:2: an image has no \"string filename\": add it"),
        ("LightSource \"lamp\"", "m.pbrt:2: unknown light `lamp`"),
        ("LightSource \"spot\" \"float conedeltaangle\" -5", "m.pbrt:2: a cone from 35 to 30 degrees must be angles"),
        ("LightSource \"spot\" \"float coneangle\" 0", "m.pbrt:2: a cone from -5 to 0 degrees must be angles"),
        (
            "LightSource \"distant\" \"point3 to\" [0 0 0]",
            "m.pbrt:2: the direction from [0, 0, 0] to [0, 0, 0] has length 0",
        ),
        ("AreaLightSource \"glow\"", "m.pbrt:2: unknown area light `glow`"),
        ("Camera \"perspective\"", "m.pbrt:2: `Camera` comes after the world has begun"),
        ("AttributeEnd", "m.pbrt:2: `AttributeEnd` has no matching begin"),
        ("AttributeBegin", "m.pbrt:2: the block that begins here has no end"),
        ("ObjectBegin \"a\" AttributeEnd ObjectEnd", "m.pbrt:2: `AttributeEnd` has no matching begin"),
        ("Scale 0 1 1", "m.pbrt:2: "),
        ("Translate 1 x 1", "m.pbrt:2: `x` is not a number; expected a part of the translation"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "m.pbrt:2: the view from [0, 0, 0] to [0, 0, 0]"),
        ("Transform [1 0 0]", "m.pbrt:2: `]` is not a number; expected an element of the matrix"),
        ("CoordSysTransform \"a\"", "m.pbrt:2: unknown coordinate system `a`"),
        ("WorldBegin", "m.pbrt:2: `WorldBegin` is given twice"),
        ("\"float radius\" 1", "m.pbrt:2: `\"float radius\"` is not a directive"),
    ];
    for (bad, message) in cases {
        let error = load(&world(bad)).expect_err(bad).to_string();
        assert!(error.starts_with(message), "{bad}: {error}");
    }
    let two =
        load("Film \"rgb\" \"integer xresolution\" 0\nWorldBegin\nMaterial \"wood\"\nShape \"cube\"\n").unwrap_err();
    let lines: Vec<_> = two.diagnostics().iter().map(|diagnostic| diagnostic.location.to_string()).collect();
    assert_eq!(lines, [":1", ":3", ":4"]);
    assert_eq!(load("Shape \"sphere\"").unwrap_err().to_string().lines().count(), 2, "before the world, and no world");
    assert_eq!(load("WorldBegin").unwrap_err().to_string(), "m.pbrt: has no visible shapes");
}

#[test]
fn what_is_not_supported_is_listed_with_its_line() {
    for (directive, message) in [
        ("Shape \"curve\" \"point3 P\" [0 0 0 1 1 1 2 2 2 3 3 3]", "the shape \"curve\" is not supported"),
        ("Shape \"sphere\" \"float zmin\" 0", "the sphere is whole, without regard"),
        ("Shape \"sphere\" \"float alpha\" 0.5", "\"alpha\" is supported for meshes only: the sphere is opaque"),
        ("Material \"hair\"", "the material \"hair\" is not supported: grey is used"),
        (
            "Material \"diffuse\" \"texture displacement\" \"n\"",
            "the parameter \"displacement\" of Material is not supported",
        ),
        ("Texture \"t\" \"float\" \"fbm\"", "the texture \"fbm\" is not supported"),
        (
            "Texture \"t\" \"spectrum\" \"checkerboard\" \"string mapping\" \"spherical\"",
            "the mapping \"spherical\" is not supported",
        ),
        ("LightSource \"goniometric\"", "the light \"goniometric\" is not supported"),
        ("LightSource \"point\" \"float fov\" 5", "the parameter \"fov\" of LightSource is not supported"),
        ("ColorSpace \"rec2020\"", "the colour space \"rec2020\" is not supported: colours are read as sRGB"),
        ("MediumInterface \"fog\" \"\"", "`MediumInterface` is left out"),
        ("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"", "`MakeNamedMedium` is left out"),
        (
            "AttributeBegin Material \"interface\" Shape \"sphere\" AttributeEnd",
            "a shape without material is invisible",
        ),
        (
            "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
            "a subdivision surface is not smoothed",
        ),
        (
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]",
            "1 bent patches became two flat triangles each",
        ),
    ] {
        let model = good(&world(directive));
        let [warning] = &model.warnings[..] else { panic!("{directive}: {:?}", model.warnings) };
        assert!(warning.message.starts_with(message), "{directive}: {}", warning.message);
        assert_eq!(warning.place, "m.pbrt:2");
    }
    let many = good(&world("Shape \"curve\"\nShape \"curve\""));
    assert_eq!(
        many.warnings[0].message,
        "the shape \"curve\" is not supported: it is left out (2 times, this is the first)"
    );
}

/// Regression: sensors were ignored in silence.
#[test]
fn sensors_of_cameras_are_warnings() {
    let film =
        |sensor: &str| good(&format!("Film \"rgb\" \"string sensor\" \"{sensor}\"\nWorldBegin Shape \"sphere\""));
    let model = film("canon_eos_5d");
    let [warning] = &model.warnings[..] else { panic!("{:?}", model.warnings) };
    assert!(warning.message.starts_with("the sensor \"canon_eos_5d\" is not supported"), "{}", warning.message);
    assert_eq!((warning.place.as_str(), film("cie1931").warnings), ("m.pbrt:1", vec![]));
}

/// Regression: the reflectance rose by Schlick's approximation. The expected values are those of Fresnel's equations for n = 1 and
/// k = 2 √r / √(1 − r), at 60 degrees.
#[test]
fn metals_of_a_reflectance_had_other_colours_aside() {
    let model = good(&world("Material \"conductor\" \"rgb reflectance\" [.5 .2 .1] \"float roughness\" 0"));
    let MaterialModel::Conductor { ior, roughness } = model.materials[0].model else { panic!("a metal") };
    let close = |found: Rgb, expected: Rgb, error: f64| (found - expected).map(f64::abs).max_component() < error;
    assert!(close(ior.fresnel(1.0), Rgb::new(0.5, 0.2, 0.1), 1e-12) && roughness == 0.0, "{ior:?}");
    assert!(close(ior.fresnel(0.5), Rgb::new(0.529, 0.308, 0.218), 6e-4), "{:?}", ior.fresnel(0.5));
    let brightest = good(&world("Material \"conductor\" \"rgb reflectance\" [1 0 2]"));
    let MaterialModel::Conductor { ior, .. } = brightest.materials[0].model else { panic!("a metal") };
    assert!(close(ior.fresnel(1.0), Rgb::new(0.9999, 0.0, 0.9999), 1e-9), "{ior:?}");
}

#[test]
fn a_flat_patch_is_two_triangles_of_its_normal() {
    let model = good("WorldBegin Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]");
    let data = model.mesh_data(0);
    assert_eq!(data.triangles, [[0, 1, 3], [0, 3, 2]]);
    assert_eq!(data.uvs[3], [1.0, 1.0]);
    assert_eq!((model.warnings.len(), model.background), (0, None));
}

#[test]
fn attributes_and_mixes_hold_for_what_follows() {
    let model = good(&world(
        "Attribute \"shape\" \"float radius\" 3\nMakeNamedMaterial \"a\" \"rgb reflectance\" [1 0 0]\n\
         MakeNamedMaterial \"b\" \"string type\" \"thindielectric\"\n\
         Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.25",
    ));
    let (_, node) = &shapes(&model)[0];
    assert!(matches!(&node.content, Some(Content::Shape(Shape::Sphere(sphere))) if sphere.radius() == 3.0));
    let MaterialModel::Mix(parts) = &model.materials[0].model else { panic!("a mix") };
    assert_eq!(parts.iter().map(|(weight, _)| *weight).collect::<Vec<_>>(), [0.75, 0.25]);
    assert_eq!(model.warnings, []);
}

#[test]
fn files_may_include_others_but_not_themselves() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("ball.pbrt", "Translate 1 0 0\nShape \"sphere\"\n");
    write("main.pbrt", "WorldBegin\nImport \"ball.pbrt\"\nInclude \"ball.pbrt\"\nShape \"sphere\"\n");
    write("loop.pbrt", "WorldBegin\nInclude \"other.pbrt\"");
    write("other.pbrt", "\nInclude \"loop.pbrt\"");
    write("bad.pbrt", "WorldBegin\nInclude \"worse.pbrt\"");
    write("worse.pbrt", "\nShape \"cube\"");
    write(
        "t.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    write("mesh.pbrt", "WorldBegin ReverseOrientation Shape \"plymesh\" \"string filename\" \"t.ply\"");
    let load = |name: &str| super::load(&folder.path().join(name), &LoadOptions::default());
    let model = load("main.pbrt").expect("a scene");
    let places: Vec<_> = shapes(&model).iter().map(|(place, _)| place.point(DVec3::ZERO).x).collect();
    assert_eq!(places, [1.0, 1.0, 1.0], "the matrix of an import ends with it");
    let error = load("loop.pbrt").unwrap_err().to_string();
    assert!(error.contains("other.pbrt:2: `loop.pbrt` includes itself"), "{error}");
    assert!(load("bad.pbrt").unwrap_err().to_string().contains("worse.pbrt:2: unknown shape `cube`"));
    assert_eq!(load("mesh.pbrt").expect("a mesh").mesh_data(0).triangles, [[0, 2, 1]]);
    for depth in 0..=17 {
        write(&format!("d{depth}.pbrt"), &format!("Include \"d{}.pbrt\"", depth + 1));
    }
    write("d16.pbrt", "WorldBegin Shape \"sphere\"");
    assert!(load("d0.pbrt").is_ok(), "16 within each other");
    write("d16.pbrt", "Include \"d17.pbrt\"");
    assert!(load("d0.pbrt").unwrap_err().to_string().contains("is one file too many"));
}

#[test]
fn images_are_shown_and_maps_all_around_become_their_mean() {
    let folder = tempfile::tempdir().expect("a folder");
    image::RgbImage::from_fn(2, 2, |x, _| image::Rgb([255 * (x as u8), 0, 0]))
        .save(folder.path().join("a.png"))
        .expect("saved");
    let path = folder.path().join("m.pbrt");
    let text = world(
        "LightSource \"infinite\" \"string filename\" \"a.png\" \"float scale\" 2\n\
         Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string wrap\" \"clamp\" \"float scale\" 0.5\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"",
    );
    let model = load_text(&text, &path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(model.background, Some(Background::Constant(Color::from_rgb([1.0, 0.0, 0.0]))));
    assert!(model.warnings[0].message.contains("became its mean"));
    assert!(matches!(
        model.textures[..],
        [Texture::Image { wrap: [rt_shading::Wrap::Clamp, rt_shading::Wrap::Clamp], smooth: true, .. }]
    ));
    assert!(matches!(model.materials[0].to_phong().diffuse, ColorTexture::Textured(_, rgb) if rgb == Rgb::gray(0.5)));
}

/// Ten lines may stand for a million spheres.
#[test]
fn instances_are_counted_before_they_are_unfolded() {
    let shapes = "Shape \"sphere\"\n".repeat(1000);
    let instances = "ObjectInstance \"a\"\n".repeat(1000);
    let error =
        load(&format!("WorldBegin\nObjectBegin \"a\"\n{shapes}ObjectEnd\n{instances}")).unwrap_err().to_string();
    assert!(
        error.contains("the number of shapes, with expanded instances, is 262")
            && error.contains("above the limit of 262144"),
        "{error}"
    );
    let scopes = load(&world(&"AttributeBegin\n".repeat(2000))).unwrap_err().to_string();
    assert!(scopes.starts_with("m.pbrt:1026: the depth of scopes is 1025, above the limit of 1024"), "{scopes}");
}

/// pbrt-v4 looks names up at the end of the file. They were refused before their definition.
#[test]
fn materials_and_textures_may_be_defined_after_their_use() {
    let uses = "NamedMaterial \"m\"\nShape \"disk\" \"texture alpha\" \"a\"\nObjectBegin \"o\" Shape \"disk\" ObjectEnd\n\
                ObjectInstance \"o\"\n";
    let material = "MakeNamedMaterial \"m\" \"texture reflectance\" \"t\"\n";
    let textures =
        "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [1 0 0]\nTexture \"a\" \"float\" \"constant\"\n";
    let model = good(&world(&format!("AttributeBegin\n{uses}AttributeEnd\n{material}{textures}")));
    assert_eq!((shapes(&model).len(), &model.warnings[..]), (3, &[][..]));
    let (albedo, roughness) = (ColorTexture::Constant(Rgb::new(1.0, 0.0, 0.0)), 0.0);
    assert_eq!(model.materials[0].model, MaterialModel::Diffuse { albedo, roughness });
    assert_eq!(shapes(&model).iter().map(|(_, node)| node.material.0).collect::<Vec<_>>(), [0, 0, 1]);
    // A definition holds for all that comes after it, as before.
    let twice = "MakeNamedMaterial \"m\"\nNamedMaterial \"m\"\nMakeNamedMaterial \"m\" \"rgb reflectance\" [1 0 0]\n";
    let albedo = ColorTexture::Constant(Rgb::gray(0.5));
    assert_eq!(good(&world(twice)).materials[0].model, MaterialModel::Diffuse { albedo, roughness });
    let error = load(&world(&format!("{uses}{material}"))).unwrap_err().to_string();
    assert!(error.starts_with("m.pbrt:2: unknown material `m`; no materials are defined"), "{error}");
    assert_eq!(error.lines().filter(|line| line.contains("unknown")).count(), 3, "{error}");
}

/// Each message lists all names, of which there may be many.
#[test]
fn files_of_nothing_but_mistakes_end_early() {
    let names: String = (0..5000).map(|i| format!("MakeNamedMaterial \"m{i}\"\n")).collect();
    let mistakes = "NamedMaterial \"none\"\n".repeat(20_000);
    let error = load(&world(&(names + &mistakes))).unwrap_err();
    assert!(error.to_string().ends_with("m.pbrt: 980 more errors are not listed; fix these first"), "{error}");
}

#[test]
fn cut_files_never_panic() {
    for length in (0..SCENE.len()).filter(|length| SCENE.is_char_boundary(*length)) {
        let _ = load(&SCENE[..length]);
    }
}

/// pbrt-v4 writes the name of an option without its type.
#[test]
fn options_without_a_type_were_refused() {
    for (option, name) in [
        ("\"disablepixeljitter\" true", "disablepixeljitter"),
        ("\"seed\" 0", "seed"),
        ("\"seed\" [7]", "seed"),
        ("\"rendercoordsys\" \"camera world\"", "rendercoordsys"),
        ("\"msereferenceimage\" [\"a.exr\"]", "msereferenceimage"),
        ("\"bool disablepixeljitter\" true", "disablepixeljitter"),
    ] {
        let model = good(&format!("Option {option}\n{}", world("")));
        let expected = format!("the parameter \"{name}\" of Option is not supported");
        assert_eq!(model.messages(), [expected], "{option}");
    }
    let error = load(&format!("Option \"seed\"\n{}", world(""))).unwrap_err().to_string();
    assert!(error.starts_with("m.pbrt:2: `WorldBegin` is not a number; expected a value of \"seed\""), "{error}");
}

/// A name with a space was read as a parameter.
#[test]
fn names_of_media_with_a_space_were_parameters() {
    let model = good(&world(
        "MakeNamedMedium \"my m\" \"string type\" \"homogeneous\"\nMediumInterface \"my m\" \"no m\"\n\
         MediumInterface \"my m\"\nCoordinateSystem \"my c\" CoordSysTransform \"my c\"\n\
         Texture \"my t\" \"spectrum\" \"constant\"\n\
         MakeNamedMaterial \"my a\" \"string type\" \"diffuse\" \"texture reflectance\" \"my t\"\n\
         NamedMaterial \"my a\"\nObjectBegin \"my o\" Shape \"sphere\" ObjectEnd ObjectInstance \"my o\"",
    ));
    let left_out = |word: &str, times: &str| format!("`{word}` is left out: media are not supported{times}");
    let expected = [left_out("MakeNamedMedium", ""), left_out("MediumInterface", " (2 times, this is the first)")];
    assert_eq!(model.messages(), expected);
    assert_eq!((shapes(&model).len(), model.materials[0].name.as_str()), (2, "my a"));
}

/// Each error copied all names, although few errors are listed.
#[test]
fn errors_about_undefined_names_copied_all_names() {
    let options = LoadOptions::default();
    let mut reader = PbrtReader::new(FileScope { root_file: Path::new("m.pbrt"), options: &options });
    reader.read("WorldBegin\nMakeNamedMaterial \"m1\"\nMakeNamedMaterial \"m2\"\n");
    let error = reader.appearance("NamedMaterial", 1, &mut Tokenizer::new("\"m\"")).expect_err("undefined");
    assert!(matches!(&error.kind, LoadErrorKind::UnknownWord { known, .. } if known.is_empty()), "{error:?}");
}

#[test]
fn errors_about_undefined_names_list_those_of_their_kind() {
    let definitions = "MakeNamedMaterial \"m1\"\nMakeNamedMaterial \"m2\"\nObjectBegin \"o1\" ObjectEnd\n\
                       CoordinateSystem \"c1\"\nTexture \"t1\" \"float\" \"constant\"\n\
                       Texture \"s1\" \"spectrum\" \"constant\"\nMakeNamedMaterial \"\"\n";
    let uses = "NamedMaterial \"m\"\nObjectInstance \"o\"\nCoordSysTransform \"c\"\n\
                Shape \"disk\" \"texture alpha\" \"t\"\nMaterial \"diffuse\" \"texture reflectance\" \"s\"\n\
                Material \"mix\" \"string materials\" [\"m1\" \"n\"]\n";
    let error = load(&world(&format!("{definitions}{uses}"))).unwrap_err();
    let messages: Vec<_> = error.diagnostics().iter().map(|diagnostic| diagnostic.kind.to_string()).collect();
    let expected = [
        "unknown material `m`; did you mean `m2`? Known are `m1`, `m2`",
        "unknown object `o`; did you mean `o1`? Known are `o1`",
        "unknown coordinate system `c`; did you mean `c1`? Known are `c1`, `world`",
        "unknown float texture `t`; did you mean `t1`? Known are `t1`",
        "unknown spectrum texture `s`; did you mean `s1`? Known are `s1`",
        "unknown material `n`; known are `m1`, `m2`",
    ];
    assert_eq!(messages, expected);
}
