//! Documents that are loaded as a whole.

mod animated;
mod used_vertices;

use super::*;
use crate::{Content, MaterialId, MeshId, SceneNode};
use rt_camera::Projection;
use rt_math::{DVec3, Rgb, Vec3};
use rt_shading::{ColorTexture, DeltaLightKind};

/// A unit square: four positions, four texture coordinates as bytes, and the indices of two triangles.
fn square() -> Vec<u8> {
    let mut bytes = Vec::new();
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
        bytes.extend([x, y, 0.0].into_iter().flat_map(f32::to_le_bytes));
    }
    bytes.extend([0, 255, 255, 255, 255, 0, 0, 0]);
    bytes.extend([0, 1, 2, 0, 2, 3]);
    bytes
}

const ARRAYS: &str = r#""bufferViews": [
        {"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 8},
        {"buffer": 0, "byteOffset": 56, "byteLength": 6}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5121, "count": 4, "type": "VEC2", "normalized": true},
        {"bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR"}]"#;

const MESH: &str = r#"{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}"#;

/// The same with the first material.
const TEXTURED: &str = r#"{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0, "indices": 2}"#;

fn load_with(primitives: &str, rest: &str) -> Result<Model, LoadError> {
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 62}}], {ARRAYS},
            "meshes": [{{"name": "square", "primitives": [{primitives}]}}], {rest}}}"#
    );
    load_glb(json, &square(), &LoadOptions::default())
}

fn load_glb(json: String, binary: &[u8], options: &LoadOptions) -> Result<Model, LoadError> {
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let file = container::tests::glb(&[(b"JSON", &json), (b"BIN\0", binary)]);
    load_bytes(&file, Path::new("m.glb"), options)
}

fn load_nodes(rest: &str) -> Model {
    load_with(MESH, rest).expect("a model")
}

fn refused(rest: &str) -> String {
    load_with(MESH, rest).expect_err("a bad model").to_string()
}

#[test]
fn attributes_of_unknown_names_are_not_met_by_a_panic_when_room_is_reserved() {
    let named = r#"{"attributes": {"POSITION": 0, "COLOUR": 0, "_OWN": 0}, "indices": 2}"#;
    let model = load_with(named, r#""nodes": [{"mesh": 0}]"#).expect("a model");
    assert_eq!(model.mesh_data(0).triangles.len(), 2);
}

#[test]
fn instances_share_their_mesh() {
    let model = load_nodes(
        r#""nodes": [{"children": [1, 2]}, {"mesh": 0, "translation": [1, 2, 3]}, {"mesh": 0, "scale": [2, 2, 2]}]"#,
    );
    assert_eq!((model.nodes.len(), model.meshes.len(), model.materials.len()), (1, 1, 1));
    let children = &model.nodes[0].children;
    assert!(children.iter().all(|node| node.content == Some(Content::Mesh(MeshId(0)))));
    assert_eq!(children[0].parent_from_local.point(DVec3::ZERO), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(children[1].parent_from_local.point(DVec3::ONE), DVec3::splat(2.0));
    assert_eq!(model.mesh_data(0).triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(model.mesh_data(0).uvs.is_empty(), "no texture reads them");
}

#[test]
fn primitives_become_nodes_with_their_materials() {
    let two = format!(r#"{MESH}, {{"attributes": {{"POSITION": 0}}, "mode": 5, "material": 0}}"#);
    let rest = r#""nodes": [{"mesh": 0, "name": "n"}],
        "materials": [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0}}]"#;
    let model = load_with(&two, rest).expect("a model");
    let [strip] = &model.nodes[0].children[1..] else { panic!("two primitives") };
    assert_eq!((&strip.content, strip.material), (&Some(Content::Mesh(MeshId(1))), MaterialId(1)));
    assert_eq!(model.mesh_data(1).triangles, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(model.materials[1].to_phong().diffuse, ColorTexture::Constant(Rgb::new(1.0, 0.0, 0.0)));
}

#[test]
fn factors_out_of_range_were_clamped_without_a_word() {
    let mesh = r#"{"attributes": {"POSITION": 0}, "mode": 5, "material": 0}"#;
    let rest = r#""nodes": [{"mesh": 0}], "materials": [{"name": "m", "pbrMetallicRoughness":
        {"baseColorFactor": [2, 0, 0, 1], "metallicFactor": 1, "roughnessFactor": -5}}]"#;
    let model = load_with(mesh, rest).expect("a model");
    let clamped = |name: &str| format!("its `{name}` is not between 0 and 1: it is clamped");
    assert_eq!(model.messages(), [clamped("baseColorFactor"), clamped("roughnessFactor")]);
}

/// Data URI of a red image.
fn red_png() -> String {
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::RgbImage::from_pixel(2, 1, image::Rgb([255, 0, 0]));
    image.write_to(&mut png, image::ImageFormat::Png).expect("a png");
    let bytes = png.into_inner().iter().map(|byte| format!("%{byte:02x}")).collect::<String>();
    format!("data:image/png,{bytes}")
}

#[test]
fn images_are_read_from_data_uris_at_the_given_coordinates() {
    let rest = format!(
        r#""nodes": [{{"mesh": 0}}], "images": [{{"uri": "{}"}}],
            "samplers": [{{"wrapS": 33071, "magFilter": 9728}}], "textures": [{{"source": 0, "sampler": 0}}],
            "materials": [{{"pbrMetallicRoughness": {{"metallicFactor": 0, "baseColorTexture": {{"index": 0,
                "extensions": {{"KHR_texture_transform": {{"scale": [2, 1], "offset": [0.5, 0]}}}}}}}}}}]"#,
        red_png()
    );
    let model = load_with(TEXTURED, &rest).expect("a model");
    assert_eq!(model.mesh_data(0).uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let rt_shading::Texture::Mapped { texture, map } = &model.textures[0] else { panic!("mapped") };
    assert_eq!((map.rows, map.is_second), ([[2.0, 0.0, 0.5], [0.0, 1.0, 0.0]], false));
    let rt_shading::Texture::Image { bitmap, wrap, smooth } = &**texture else { panic!("an image") };
    assert_eq!((bitmap.pixels[0], *smooth), ([1.0, 0.0, 0.0], false));
    assert_eq!(*wrap, [rt_shading::Wrap::Clamp, rt_shading::Wrap::Repeat]);
    assert!(matches!(model.materials[0].to_phong().diffuse, ColorTexture::Textured(_, Rgb::WHITE)));
}

/// The image of the summed colours had neither the transform of its texture nor vertex colours.
#[test]
fn specular_glossiness_keeps_transforms_sets_and_vertex_colours_as_phong() {
    let uri = red_png();
    let base_color = |attributes: &str, textures: &str| {
        let primitive =
            format!(r#"{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1{attributes}}}, "indices": 2, "material": 0}}"#);
        let rest = format!(
            r#""nodes": [{{"mesh": 0}}], "images": [{{"uri": "{uri}"}}], "textures": [{{"source": 0}}],
                "materials": [{{"extensions": {{"KHR_materials_pbrSpecularGlossiness": {{
                    "specularFactor": [0, 0, 0], {textures}}}}}}}]"#
        );
        let model = load_with(&primitive, &rest).expect("a model");
        let ColorTexture::Textured(id, _) = model.materials[0].to_phong().diffuse else { panic!("textured") };
        model.textures[id.0 as usize].clone()
    };
    let texture = |name: &str, offset: f64| {
        format!(r#""{name}": {{"index": 0, "extensions": {{"KHR_texture_transform": {{"offset": [{offset}, 0]}}}}}}"#)
    };
    let (diffuse, shine) = (texture("diffuseTexture", 0.5), texture("specularGlossinessTexture", 0.25));
    let offset = |texture: &rt_shading::Texture| match texture {
        rt_shading::Texture::Mapped { map, .. } => map.rows[0][2],
        _ => panic!("mapped: {texture:?}"),
    };
    assert_eq!(offset(&base_color("", &format!("{diffuse}, {shine}"))), 0.5);
    assert_eq!(offset(&base_color("", &shine)), 0.25, "without a diffuse texture the image is that of the other");
    let tinted = base_color(r#", "COLOR_0": 0"#, &format!("{diffuse}, {shine}"));
    let rt_shading::Texture::VertexColor(Some(below)) = &tinted else { panic!("vertex colours: {tinted:?}") };
    assert_eq!(offset(below), 0.5);
}

/// Their texture coordinates were read only for textures: without one, the surface was isotropic.
#[test]
fn anisotropy_without_tangents_and_textures_runs_along_the_first_texture_coordinates() {
    let rest = r#""nodes": [{"mesh": 0}],
        "materials": [{"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}}]"#;
    let model = load_with(TEXTURED, rest).expect("a model");
    assert_eq!(model.mesh_data(0).tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
    assert!(model.mesh_data(0).uvs.is_empty(), "no texture reads them");
    assert_eq!(model.warnings, []);
    let model = load_with(&TEXTURED.replace(r#", "TEXCOORD_0": 1"#, ""), rest).expect("a model");
    assert!(model.mesh_data(0).tangents.is_empty());
    assert_eq!(model.warnings[0].message, "its normal map or anisotropy needs tangents or TEXCOORD_0: it is left out");
}

/// Each accessor was within its limit, but a file of 1 kB could have any number of them: ten primitives took five seconds.
#[test]
fn accessors_without_a_buffer_are_limited_in_their_sum() {
    let zeros = |count: usize, targets: usize| {
        let target = vec![r#"{"POSITION": 0}"#; targets].join(", ");
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
                "accessors": [{{"componentType": 5126, "count": {count}, "type": "VEC3"}}],
                "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "targets": [{target}]}}],
                    "weights": {:?}}}]}}"#,
            vec![1; targets]
        );
        load_bytes(json.as_bytes(), Path::new("m.gltf"), &LoadOptions::default())
    };
    let error = zeros(limits::GLTF_ZEROS, 9).expect_err("too many zeros").to_string();
    let expected =
        "m.gltf: accessors[0]: the sum of all counts without a bufferView is 20971520, above the limit of 16777216";
    assert_eq!(error, expected);
    assert!(zeros(3, 9).is_ok());
}

/// A material with KHR_materials_transmission and KHR_materials_volume.
fn volume(base_color: &str, metallic: f64, transmission: f64, thickness: f64) -> rt_shading::Material {
    let rest = format!(
        r#""nodes": [{{"mesh": 0}}], "materials": [{{
            "pbrMetallicRoughness": {{"metallicFactor": {metallic}, "baseColorFactor": {base_color}}},
            "extensions": {{"KHR_materials_transmission": {{"transmissionFactor": {transmission}}},
                "KHR_materials_volume": {{"thicknessFactor": {thickness}}}}}}}]"#
    );
    load_with(TEXTURED, &rest).expect("a model").materials[0].clone()
}

#[test]
fn metallic_opaque_and_thin_volumes_enclose_no_medium() {
    let medium = |base_color, metallic, transmission, thickness| {
        volume(base_color, metallic, transmission, thickness).interior.map(|inside| inside.ior)
    };
    assert_eq!(medium("[1, 1, 1, 1]", 0.0, 1.0, 1.0), Some(1.5));
    // It transmits no light, and reflects as glass does.
    assert_eq!(medium("[0, 0, 0, 1]", 0.0, 1.0, 1.0), Some(1.5), "black");
    assert_eq!(medium("[1, 1, 1, 1]", 1.0, 1.0, 1.0), None, "metallic");
    assert_eq!(medium("[1, 1, 1, 1]", 0.0, 0.0, 1.0), None, "opaque");
    assert_eq!(medium("[1, 1, 1, 1]", 0.0, 1.0, 0.0), None, "thin");
}

#[test]
fn matrices_are_columns_and_nest() {
    let model = load_nodes(
        r#""nodes": [{"matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 5,6,7,1], "children": [1]}, {"camera": 0, "translation": [1,0,0]}],
            "cameras": [{"type": "perspective", "name": "c", "perspective": {"yfov": 0.5, "znear": 0.1}}]"#,
    );
    let camera = &model.cameras[0];
    assert_eq!(camera.name, "c");
    // The x axis of the outer node is turned to y.
    let eye = camera.settings.world_from_camera.point(DVec3::ZERO);
    assert_eq!(eye, DVec3::new(5.0, 7.0, 7.0));
    assert!(matches!(camera.settings.projection, Projection::Perspective { fov, .. } if fov == 0.5));
}

#[test]
fn a_rotation_of_zero_is_named_as_such() {
    let model = load_nodes(r#""nodes": [{"mesh": 0}, {"mesh": 0, "rotation": [0, 0, 0, 0]}]"#);
    let warning = model.warnings.first().map(ToString::to_string).unwrap_or_default();
    let expected = "its rotation has no direction, because the quaternion is zero; it and its children are left out";
    assert!(warning.contains("nodes[1]") && warning.ends_with(expected), "{warning}");
}

#[test]
fn lights_stand_where_their_nodes_are() {
    let model = load_nodes(
        r#""nodes": [{"translation": [0, 3, 0], "scale": [2, 2, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
                     {"rotation": [-0.70710678, 0, 0, 0.70710678], "extensions": {"KHR_lights_punctual": {"light": 1}}}],
            "extensions": {"KHR_lights_punctual": {"lights": [
                {"type": "point", "intensity": 10, "color": [1, 0.5, 0]},
                {"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}}]}}"#,
    );
    assert_eq!(model.lights[0].intensity, Rgb::new(10.0, 5.0, 0.0));
    assert!(
        matches!(model.lights[0].kind, DeltaLightKind::Point { position, .. } if position == DVec3::new(0.0, 3.0, 0.0))
    );
    let DeltaLightKind::Spot { direction, cos_inner, cos_outer, .. } = model.lights[1].kind else { panic!("a spot") };
    assert!((direction - DVec3::NEG_Y).length() < 1e-6, "{direction}");
    assert!(cos_inner > cos_outer && cos_inner - cos_outer < 1e-12);
}

#[test]
fn deep_trees_are_refused_and_less_deep_ones_walked() {
    let chain = |depth: usize| {
        let links: Vec<String> = (1..depth).map(|child| format!(r#"{{"children": [{child}]}}"#)).collect();
        format!(r#""nodes": [{}, {{"mesh": 0}}]"#, links.join(","))
    };
    assert!(refused(&chain(50_000)).contains("the depth of the tree is 1025, above the limit of 1024"));
    let mut node: &SceneNode = &load_nodes(&chain(1024)).nodes[0].clone();
    let mut depth = 1;
    while let [child] = node.children.as_slice() {
        node = child;
        depth += 1;
    }
    assert_eq!((depth, &node.content), (1024, &Some(Content::Mesh(MeshId(0)))));
}

#[test]
fn flattened_nodes_are_left_out_with_a_warning() {
    let model = load_nodes(r#""nodes": [{"name": "gone", "scale": [1, 0, 1], "mesh": 0}, {"mesh": 0}]"#);
    assert_eq!(model.nodes.len(), 1);
    assert_eq!(model.warnings[0].place, "m.glb: node `gone`");
    assert!(model.warnings[0].message.contains("is singular"));
    let skewed = load_nodes(r#""nodes": [{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1], "mesh": 0}]"#);
    assert!(skewed.warnings[0].message.contains("last row"));
}

#[test]
fn bad_arrays_are_refused() {
    let refuse = |primitive: &str| load_with(primitive, r#""nodes": [{"mesh": 0}]"#).expect_err("bad").to_string();
    let out_of_range = r#"{"attributes": {"POSITION": 0}, "indices": 0}"#;
    assert!(refuse(out_of_range).contains("indices: the accessor of indices must hold unsigned scalars"));
    let mismatched = r#"{"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 2}"#;
    assert!(refuse(mismatched).contains("attributes.NORMAL: accessors[2] must be VEC3"));
    let points =
        load_with(r#"{"attributes": {"POSITION": 0}, "mode": 0}"#, r#""nodes": [{"mesh": 0}]"#).expect("empty");
    assert_eq!(points.warnings[0].message, "points and lines are not supported; they are left out");
}

#[test]
fn arrays_without_indices_run_in_order() {
    let model = load_with(r#"{"attributes": {"POSITION": 0}, "mode": 6}"#, r#""nodes": [{"mesh": 0}]"#).expect("a fan");
    let data = model.mesh_data(0);
    assert_eq!(data.triangles, [[1, 2, 0], [2, 3, 0]]);
    assert_eq!(data.positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert!(data.normals.is_empty(), "flat, as the specification asks");
}

/// A document of arrays of numbers, each an accessor of its own.
#[derive(Default)]
struct Arrays {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Arrays {
    /// A triangle with the corners (0, 0, 0), (1, 0, 0) and (0, 1, 0) as the first accessor.
    fn triangle() -> Self {
        Self::default().with("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    }

    fn with(mut self, kind: &str, numbers: &[f32]) -> Self {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.push(kind, 5126, numbers.len(), &bytes);
        self
    }

    /// A triangle that follows the first joint of its skin, by the accessors 1 and 2.
    fn skinned() -> Self {
        Self::triangle().with_bytes("VEC4", &[0; 12]).with("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3))
    }

    fn with_bytes(mut self, kind: &str, bytes: &[u8]) -> Self {
        self.push(kind, 5121, bytes.len(), bytes);
        self
    }

    fn push(&mut self, kind: &str, component: u32, numbers: usize, bytes: &[u8]) {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.views.push(format!(
            r#"{{"buffer": 0, "byteOffset": {}, "byteLength": {}}}"#,
            self.bytes.len(),
            bytes.len()
        ));
        self.accessors.push(format!(
            r#"{{"bufferView": {}, "componentType": {component}, "count": {}, "type": "{kind}"}}"#,
            self.views.len() - 1,
            numbers / width
        ));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn load(&self, rest: &str, options: &LoadOptions) -> Result<Model, LoadError> {
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {}}}], "bufferViews": [{}],
                "accessors": [{}], {rest}}}"#,
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        );
        load_glb(json, &self.bytes, options)
    }

    fn refused(&self, rest: &str, options: &LoadOptions) -> String {
        self.load(rest, options).expect_err("a bad model").to_string()
    }

    fn model(&self, rest: &str) -> Model {
        self.load(rest, &LoadOptions::default()).expect("a model")
    }

    fn at(&self, time: f64, rest: &str) -> Model {
        self.load(rest, &LoadOptions { at_time: Some(time), ..LoadOptions::default() }).expect("a model")
    }
}

const TRIANGLE: &str = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]"#;

#[test]
fn instances_of_a_node_share_its_mesh() {
    let arrays = Arrays::triangle()
        .with("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 7.0, 0.0])
        .with("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.0, 1.0, 1.0]);
    let rest = format!(
        r#"{TRIANGLE}, "extensionsRequired": ["EXT_mesh_gpu_instancing"], "nodes": [{{"mesh": 0, "translation": [0, 0, 1],
            "extensions": {{"EXT_mesh_gpu_instancing": {{"attributes": {{"TRANSLATION": 1, "SCALE": 2, "_ID": 9}}}}}}}}]"#
    );
    let model = arrays.model(&rest);
    assert_eq!((model.meshes.len(), &model.nodes[0].content), (1, &None));
    let [first, second] = model.nodes[0].children.as_slice() else { panic!("two instances") };
    assert!([first, second].iter().all(|node| node.content == Some(Content::Mesh(MeshId(0)))));
    assert_eq!(second.parent_from_local.point(DVec3::ONE), DVec3::new(7.0, 2.0, 2.0));
    assert!(model.warnings[0].message.starts_with("1 of its instances have an invalid transform"));
    let refused = |attributes: &str| {
        arrays.refused(&rest.replace(r#""TRANSLATION": 1, "SCALE": 2"#, attributes), &LoadOptions::default())
    };
    assert!(refused(r#""TRANSLATION": 7"#).contains("there is no accessor 7"));
    assert!(refused(r#""_OTHER": 1"#).contains("has none of TRANSLATION, ROTATION and SCALE"));
    let shorter = arrays.accessors[2].replace("\"count\": 3", "\"count\": 2");
    let accessors = vec![arrays.accessors[0].clone(), arrays.accessors[1].clone(), shorter];
    let arrays = Arrays { bytes: arrays.bytes.clone(), views: arrays.views.clone(), accessors };
    let error = arrays.refused(&rest, &LoadOptions::default());
    assert!(error.starts_with("m.glb: nodes[0].extensions.EXT_mesh_gpu_instancing: the counts"), "{error}");
}

#[test]
fn variants_choose_the_material() {
    let rest = r#""extensions": {"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}},
        "materials": [{"name": "white"}, {"name": "black"}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions":
            {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}}]}]"#;
    let with = |name: &str| LoadOptions { variant: Some(name.to_owned()), ..LoadOptions::default() };
    let shown =
        |options: &LoadOptions| Arrays::triangle().load(rest, options).expect("a model").materials[0].name.clone();
    assert_eq!(shown(&LoadOptions::default()), "white");
    assert_eq!((shown(&with("day")), shown(&with("night"))), ("white".to_owned(), "black".to_owned()));
    let error = Arrays::triangle().refused(rest, &with("knight"));
    assert!(error.contains("unknown variant `knight`; did you mean `night`? Known are `day`, `night`"), "{error}");
    let error = Arrays::triangle().refused(&rest.replace("\"material\": 1", "\"material\": 2"), &with("night"));
    assert!(error.contains("2 is not the index of a material; there are 2"), "{error}");
}

/// A data URI without its scheme is the name of a file, of any length.
#[test]
fn messages_about_long_references_are_short() {
    let long = "A".repeat(200);
    for (scheme, count) in [("", 10_000), (",base64/", 1), ("../", 10_000)] {
        let uri = scheme.to_owned() + &long.repeat(count);
        let json = format!(r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 1, "uri": "{uri}"}}]}}"#);
        let error = load_bytes(json.as_bytes(), Path::new("m.gltf"), &LoadOptions::default()).expect_err("no file");
        let message = error.to_string();
        assert!(message.contains("m.gltf: buffers[0].uri: `") && message.len() < 700, "{message}");
    }
    let rest = format!(
        r#""nodes": [{{"mesh": 0}}], "images": [{{"uri": "{}.png"}}], "textures": [{{"source": 0}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}]"#,
        "folder/".repeat(100)
    );
    let model = load_with(TEXTURED, &rest).expect("a model");
    let message = &model.warnings[0].message;
    assert!(message.ends_with("the plain colour is used") && message.len() < 500, "{message}");
}

/// 1e-9 in the last row left out the node and all below it.
#[test]
fn rounding_of_the_last_row_of_a_matrix_is_no_error() {
    let model = load_nodes(r#""nodes": [{"matrix": [1,0,0,1e-9, 0,1,0,-1e-7, 0,0,1,0, 5,0,0,0.9999999], "mesh": 0}]"#);
    assert_eq!(
        (model.nodes[0].parent_from_local, model.warnings),
        (rt_math::Transform::translate(DVec3::X * 5.0), vec![])
    );
    let skewed = load_nodes(r#""nodes": [{"matrix": [1,0,0,1e-5, 0,1,0,0, 0,0,1,0, 0,0,0,1], "mesh": 0}]"#);
    assert!(skewed.warnings[0].message.contains("last row"));
}

/// RFC 3986, section 5.2.4: dot segments are removed from a URI before its path is used.
#[test]
fn dot_segments_of_uris_needed_their_directories() {
    let outer = tempfile::tempdir().expect("a folder");
    let inner = outer.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder");
    for folder in [outer.path(), &inner] {
        std::fs::write(folder.join("a.bin"), [1, 2, 3]).expect("written");
    }
    let options = LoadOptions::default();
    let read = |uri: &str, options: &LoadOptions| buffers::fetch(uri, &inner.join("m.gltf"), options);
    for uri in ["./x/../a.bin", "x/./y/../../a.bin", "x\\..\\a.bin", "x/%2E%2E/a.bin", "./a.bin"] {
        let bytes = read(uri, &options).unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(bytes, [1, 2, 3], "{uri}");
    }
    let refused = |uri: &str| read(uri, &options).expect_err(uri).to_string();
    for uri in ["../a.bin", "x/../../a.bin", "../x/../a.bin", "./../inner/../a.bin"] {
        assert!(refused(uri).starts_with(&format!("`{uri}` lies outside of ")), "{uri}: {}", refused(uri));
    }
    assert!(refused("x/..//etc/passwd").contains("does not exist"));
    for uri in ["/../a.bin", "./C:/a.bin", "x/../C:/a.bin"] {
        assert!(refused(uri).contains("is absolute"), "{uri}: {}", refused(uri));
    }
    assert!(refused("x://../a.bin").contains("is a URL"));
    assert!(refused("x/../b.bin").starts_with("`x/../b.bin` does not exist"), "{}", refused("x/../b.bin"));
    let root = LoadOptions { root: Some(outer.path().to_owned()), ..LoadOptions::default() };
    assert_eq!(read("x/../../a.bin", &root).expect("within the root"), [1, 2, 3]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(outer.path().join("a.bin"), inner.join("link.bin")).expect("linked");
        assert!(refused("x/../link.bin").contains("lies outside of "));
    }
}
