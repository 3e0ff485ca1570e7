//! glTF 2.0 and GLB, through the `gltf` crate.
//!
//! ```text
//! bytes ── Container ──> JSON ── checks ──> Document ── tree ──> nodes, cameras, lights
//!              └──────> buffers ── accessors ── primitives ──> meshes
//!                           └── images ──> textures, Phong
//! ```
//!
//! The crate gives types and defaults; whatever comes from the file is checked before it is used (see `document` and
//! `accessor`). Skins, morph targets and animations are not followed: a model stands as its nodes say.

mod accessor;
mod appearance;
mod buffers;
mod container;
mod description;
mod document;
mod material;
mod primitive;
mod textures;
mod tree;

use std::{
    collections::HashMap,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::Arc,
};

use self::{appearance::Appearance, buffers::Buffers, container::Container, primitive::Content};
use crate::{
    LoadError, LoadOptions, MaterialId, MeshId, Model, NamedMesh, Reason, Warning, files::read_file,
    mesh_build::build_mesh,
};

/// Most memory that all meshes of a model may take.
const MAX_MESH_BYTES: u64 = 1 << 32;

/// Loads the model at `path`.
pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let bytes = read_file(path).map_err(|reason| reason.at(path, ""))?;
    // The last net, below the checks: the `gltf` crate may panic on documents that nobody thought of.
    catch_unwind(AssertUnwindSafe(|| load_bytes(&bytes, path, options))).unwrap_or_else(|_| {
        Err(Reason::Syntax("the document contradicts itself in a way that is not understood".to_owned()).at(path, ""))
    })
}

fn load_bytes(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let mut model = Model::default();
    let container = Container::split(bytes).map_err(|message| Reason::Syntax(message).at(path, ""))?;
    let document = document::parse(container.json, path, &mut model.warnings)?;
    let buffers = Buffers::load(&document, container.blob, path, options)?;
    let mut meshes = Meshes {
        buffers: &buffers,
        appearance: Appearance::new(&document, &buffers, options),
        known: HashMap::new(),
        bytes: 0,
    };
    tree::walk(&document, path, &mut model, |mesh, model| meshes.parts(mesh, model))?;
    if model.meshes.is_empty() {
        let message = "there are no triangles in the scene".to_owned();
        model.warnings.push(Warning { place: "scene".to_owned(), message });
    }
    for warning in &mut model.warnings {
        warning.place = format!("{}: {}", path.display(), warning.place);
    }
    Ok(model)
}

/// The meshes of a document, made when first used.
struct Meshes<'a> {
    buffers: &'a Buffers<'a>,
    appearance: Appearance<'a>,
    /// By index: the primitives, each with its material.
    known: HashMap<usize, Vec<(MeshId, MaterialId)>>,
    bytes: u64,
}

impl Meshes<'_> {
    fn parts(&mut self, mesh: &gltf::Mesh<'_>, model: &mut Model) -> Result<Vec<(MeshId, MaterialId)>, LoadError> {
        if let Some(parts) = self.known.get(&mesh.index()) {
            return Ok(parts.clone());
        }
        let mut parts = Vec::new();
        for primitive in mesh.primitives() {
            let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            parts.extend(self.part(mesh, &primitive, &place, model)?);
        }
        self.known.insert(mesh.index(), parts.clone());
        Ok(parts)
    }

    fn part(
        &mut self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        place: &str,
        model: &mut Model,
    ) -> Result<Option<(MeshId, MaterialId)>, LoadError> {
        let path = self.buffers.path();
        let warning = |message: &str| Warning { place: place.to_owned(), message: message.to_owned() };
        let has_colors = primitive.get(&gltf::Semantic::Colors(0)).is_some();
        let material = self.appearance.material(&primitive.material(), has_colors, model)?;
        let data = match primitive::read(primitive, &material.wants, self.buffers, place)? {
            Content::Triangles(data, notes) => {
                model.warnings.extend(notes.into_iter().map(warning));
                data
            }
            Content::NoSurface => {
                model.warnings.push(warning("points and lines have no surface; they are left out"));
                return Ok(None);
            }
        };
        let built = build_mesh(data, place, &mut model.warnings).map_err(|e| Reason::from(e).at(path, place))?;
        let Some(built) = built else { return Ok(None) };
        self.bytes += built.memory() as u64;
        if self.bytes > MAX_MESH_BYTES {
            let (value, limit) = (self.bytes, MAX_MESH_BYTES);
            return Err(Reason::TooLarge { what: "the memory of all meshes in bytes", value, limit }.at(path, place));
        }
        let id = MeshId(model.meshes.len() as u32);
        model.meshes.push(NamedMesh { name: mesh.name().unwrap_or_default().to_owned(), mesh: Arc::new(built) });
        Ok(Some((id, material.id)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Content, Node};
    use rt_camera::Projection;
    use rt_math::{DVec3, Rgb, Vec3};
    use rt_shading::{Coefficient, LightKind};

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

    fn load_with(primitives: &str, rest: &str) -> Result<Model, LoadError> {
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 62}}], {ARRAYS},
                "meshes": [{{"name": "square", "primitives": [{primitives}]}}], {rest}}}"#
        );
        let mut json = json.into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let file = container::tests::glb(&[(b"JSON", &json), (b"BIN\0", &square())]);
        load_bytes(&file, Path::new("m.glb"), &LoadOptions::default())
    }

    fn load_nodes(rest: &str) -> Model {
        load_with(MESH, rest).expect("a model")
    }

    fn refused(rest: &str) -> String {
        load_with(MESH, rest).expect_err("a bad model").to_string()
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
        assert_eq!(model.meshes[0].mesh.data().triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(model.meshes[0].mesh.data().uvs.is_empty(), "no texture reads them");
    }

    #[test]
    fn primitives_become_nodes_with_their_materials() {
        let two = format!(r#"{MESH}, {{"attributes": {{"POSITION": 0}}, "mode": 5, "material": 0}}"#);
        let rest = r#""nodes": [{"mesh": 0, "name": "n"}],
            "materials": [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0}}]"#;
        let model = load_with(&two, rest).expect("a model");
        let [strip] = &model.nodes[0].children[1..] else { panic!("two primitives") };
        assert_eq!((&strip.content, strip.material), (&Some(Content::Mesh(MeshId(1))), MaterialId(1)));
        assert_eq!(model.meshes[1].mesh.data().triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(model.materials[1].phong.diffuse, Coefficient::Constant(Rgb::new(1.0, 0.0, 0.0)));
    }

    #[test]
    fn images_are_read_from_data_uris_at_the_given_coordinates() {
        let mut png = std::io::Cursor::new(Vec::new());
        image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0]))
            .write_to(&mut png, image::ImageFormat::Png)
            .expect("a png");
        let uri: String = png.into_inner().iter().map(|byte| format!("%{byte:02x}")).collect();
        let textured = MESH.replace("\"indices\"", "\"material\": 0, \"indices\"");
        let rest = format!(
            r#""nodes": [{{"mesh": 0}}], "images": [{{"uri": "data:image/png,{uri}"}}],
                "samplers": [{{"wrapS": 33071, "magFilter": 9728}}], "textures": [{{"source": 0, "sampler": 0}}],
                "materials": [{{"pbrMetallicRoughness": {{"metallicFactor": 0, "baseColorTexture": {{"index": 0,
                    "extensions": {{"KHR_texture_transform": {{"scale": [2, 1], "offset": [0.5, 0]}}}}}}}}}}]"#
        );
        let model = load_with(&textured, &rest).expect("a model");
        assert_eq!(model.meshes[0].mesh.data().uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let rt_shading::Texture::Mapped { texture, map } = &model.textures[0] else { panic!("mapped") };
        assert_eq!((map.rows, map.is_second), ([[2.0, 0.0, 0.5], [0.0, 1.0, 0.0]], false));
        let rt_shading::Texture::Image { bitmap, wrap, smooth } = &**texture else { panic!("an image") };
        assert_eq!((bitmap.pixels[0], *smooth), ([1.0, 0.0, 0.0], false));
        assert_eq!(*wrap, [rt_shading::Wrap::Clamp, rt_shading::Wrap::Repeat]);
        assert!(matches!(model.materials[0].phong.diffuse, Coefficient::Textured(_, Rgb::WHITE)));
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
            matches!(model.lights[0].kind, LightKind::Point { position, .. } if position == DVec3::new(0.0, 3.0, 0.0))
        );
        let LightKind::Spot { direction, cos_inner, cos_outer, .. } = model.lights[1].kind else { panic!("a spot") };
        assert!((direction - DVec3::NEG_Y).length() < 1e-6, "{direction}");
        assert!(cos_inner > cos_outer && cos_inner - cos_outer < 1e-12);
    }

    #[test]
    fn trees_with_cycles_or_two_parents_are_refused() {
        let own_child = refused(r#""nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}], "scene": 0"#);
        assert!(
            own_child.starts_with("m.glb: nodes[0]: is a root of the scene, but also below the node 0"),
            "{own_child}"
        );
        assert!(refused(r#""nodes": [{"children": [1]}, {"children": [0]}]"#).contains("they form a cycle"));
        let shared = refused(r#""nodes": [{"children": [2]}, {"children": [2]}, {}]"#);
        assert!(shared.starts_with("m.glb: nodes[2]: has two parents, 0 and 1"), "{shared}");
    }

    #[test]
    fn deep_trees_are_refused_and_less_deep_ones_walked() {
        let chain = |depth: usize| {
            let links: Vec<String> = (1..depth).map(|child| format!(r#"{{"children": [{child}]}}"#)).collect();
            format!(r#""nodes": [{}, {{"mesh": 0}}]"#, links.join(","))
        };
        assert!(refused(&chain(50_000)).contains("the depth of the tree is 1025, the limit is 1024"));
        let mut node: &Node = &load_nodes(&chain(1024)).nodes[0].clone();
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
        assert!(model.warnings[0].message.contains("flattens space"));
        let skewed = load_nodes(r#""nodes": [{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1], "mesh": 0}]"#);
        assert!(skewed.warnings[0].message.contains("last row"));
    }

    #[test]
    fn bad_arrays_are_refused() {
        let refuse = |primitive: &str| load_with(primitive, r#""nodes": [{"mesh": 0}]"#).expect_err("bad").to_string();
        let out_of_range = r#"{"attributes": {"POSITION": 0}, "indices": 0}"#;
        assert!(refuse(out_of_range).starts_with("m.glb: accessors[0]: indices must be unsigned"));
        let mismatched = r#"{"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 2}"#;
        assert!(refuse(mismatched).contains("has 1 components, where 3 are needed"));
        let points =
            load_with(r#"{"attributes": {"POSITION": 0}, "mode": 0}"#, r#""nodes": [{"mesh": 0}]"#).expect("empty");
        assert_eq!(points.warnings[0].message, "points and lines have no surface; they are left out");
    }

    #[test]
    fn arrays_without_indices_run_in_order() {
        let model =
            load_with(r#"{"attributes": {"POSITION": 0}, "mode": 6}"#, r#""nodes": [{"mesh": 0}]"#).expect("a fan");
        let data = model.meshes[0].mesh.data();
        assert_eq!(data.triangles, [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(data.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert!(data.normals.is_empty(), "flat, as the specification asks");
    }
}
