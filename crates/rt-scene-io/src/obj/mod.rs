//! Wavefront OBJ with MTL materials, through `tobj`.
//!
//! ```text
//! bytes ── lines ──> Document ── tobj ──> polygons ── triangles, normals ──> meshes
//!                        └── mtllib ── mtl ── tobj ──> Phong
//! ```
//!
//! Each object, group, material and smoothing group becomes a mesh of its own under a node of its own. Normals of a smoothing
//! group are computed over all of its meshes. What a file leaves out is replaced, with a warning: a missing library or
//! image, a name that no library defines.

mod bump_to_normal;
mod document;
mod face_shape;
mod library;
mod material;
mod mtl;
mod smoothing;
mod texture_map;
mod textures;

use std::{collections::BTreeMap, path::Path};

use rt_geometry::{Face, MeshData, MeshError};
use rt_image::Encoding;
use rt_math::Vec3;

use self::{
    document::{NO_COLOUR, ObjDocument, ObjPart},
    face_shape::FaceShapes,
    library::MaterialLibrary,
};
use crate::{
    Content, LoadError, LoadErrorKind, LoadOptions, Model, SceneNode, Warning,
    build_mesh::build_mesh,
    diagnostics::Diagnostics,
    error::{ErrorAt, LineError, times},
    files::refuse_utf16,
    memory::{FileSample, load_within_budget},
    tangents,
    text::lines::decode,
};

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| load_bytes(&bytes, path, options))
}

/// Bytes of memory that loading takes at its peak.
fn peak_bytes(sample: &FileSample) -> u64 {
    let [vertices, attributes, corners] = sample.over_lines(|line| match line.trim_ascii_start() {
        [b'v', b' ' | b'\t', ..] => [1, 0, 0],
        [b'v', b't' | b'n', ..] => [0, 1, 0],
        [b'f', b' ' | b'\t', rest @ ..] => {
            [0, 0, rest.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).count() as u64]
        }
        _ => [0; 3],
    });
    // The text twice, as it is and sorted; vertices three times over, as arrays and in two tables that find them again.
    2 * sample.size + 160 * vertices + 48 * attributes + 48 * corners
}

/// Loads the model that `bytes` hold; `path` is for messages and for references to other files.
pub(crate) fn load_bytes(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    refuse_utf16(bytes).at(path, "")?;
    let (source, not_utf8) = decode(bytes);
    let document = ObjDocument::parse(&source).map_err(|lines| refuse(lines, path))?;

    let mut model = Model::default();
    if let Some(line) = not_utf8 {
        model.warn(format_args!("{}:{line}", path.display()), "bytes that are not UTF-8 were read as Latin-1");
    }
    for (what, (count, line)) in &document.skipped {
        model.warn(format_args!("{}:{}", path.display(), *line), format!("{what}: left out{}", times(*count)));
    }

    // `tobj` finds no libraries in the sorted statements; they are read below.
    let no_library = |_: &Path| Err(tobj::LoadError::GenericFailure);
    let how = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let parsed = tobj::load_obj_buf(&mut document.text.as_bytes(), &how, no_library);
    let (groups, _) = parsed.map_err(|error| explain(error, &source, path))?;

    let mut library = MaterialLibrary::open(&document.libraries, path, options, &mut model)?;
    let mut parts = Vec::new();
    for group in groups {
        let Some(part) = group.name.parse().ok().and_then(|i: usize| document.parts.get(i)) else { continue };
        let mut shapes = FaceShapes::default();
        let data = mesh_data(&group.mesh, &mut shapes).at(path, display_name(part))?;
        parts.push((part, shapes, data));
    }
    add_normals(&mut parts);

    for (part, shapes, mut data) in parts {
        let place = format!("{}: {}", path.display(), display_name(part));
        let warnings = shapes.messages().map(|message| Warning { place: place.clone(), message });
        model.warnings.extend(warnings);
        if library.needs_tangents(part.material.as_deref()) {
            if data.uvs.is_empty() {
                model.warn(&place, "bump maps and anisotropy need texture coordinates: they are left out");
            } else {
                let uvs = data.uvs.clone();
                tangents::generate(&mut data, &uvs);
            }
        }
        let mesh = build_mesh(data, &place, &mut model.warnings).at(path, display_name(part))?;
        let Some(mesh) = mesh else { continue };
        let has_colours = !mesh.data().colors.is_empty();
        let material = library.material(part.material.as_deref(), has_colours, &mut model)?;
        let id = model.add_mesh(part.name.clone(), mesh);
        model.nodes.push(SceneNode { name: part.name.clone(), ..SceneNode::new(Content::Mesh(id), material) });
    }
    if model.meshes.is_empty() {
        return Err(model.empty("has no usable triangles", path));
    }
    Ok(model)
}

/// Adds normals to the parts without normals. Parts that are smoothed together are adjacent.
fn add_normals(parts: &mut [(&ObjPart, FaceShapes, MeshData)]) {
    let mut surfaces: BTreeMap<_, Vec<&mut MeshData>> = BTreeMap::new();
    for (part, _, data) in parts {
        surfaces.entry(part.smoothed_surface()).or_default().push(data);
    }
    for ((smoothing, _), meshes) in surfaces {
        smoothing::add_normals(meshes, smoothing);
    }
}

fn display_name(part: &ObjPart) -> String {
    if part.name.is_empty() { "unnamed object".to_owned() } else { format!("object `{}`", part.name) }
}

/// All bad lines as one error.
fn refuse(lines: Vec<LineError>, path: &Path) -> LoadError {
    let mut diagnostics = Diagnostics::new(path);
    diagnostics.add(lines.into_iter().map(|line| line.in_file(path)));
    diagnostics.finish().err().unwrap_or_else(|| LoadErrorKind::Empty.at(path, ""))
}

/// Finds the bad statements: `tobj` reports only their keyword.
fn explain(error: tobj::LoadError, source: &str, path: &Path) -> LoadError {
    let keyword = match error {
        tobj::LoadError::PositionParseError => "v",
        tobj::LoadError::NormalParseError => "vn",
        tobj::LoadError::TexcoordParseError => "vt",
        _ => return LoadErrorKind::Syntax(error.to_string()).at(path, ""),
    };
    match ObjDocument::find_bad_numbers(source, keyword) {
        lines if lines.is_empty() => LoadErrorKind::Syntax(error.to_string()).at(path, ""),
        lines => refuse(lines, path),
    }
}

/// The arrays of a group, with its polygons cut into triangles.
fn mesh_data(mesh: &tobj::Mesh, shapes: &mut FaceShapes) -> Result<MeshData, MeshError> {
    let vectors = |numbers: &[f32]| numbers.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<Vec3>>();
    let positions = vectors(&mesh.positions);
    faces(mesh).for_each(|face| shapes.check(&positions, face.outline));
    let data = MeshData::from_polygons(positions, faces(mesh))?;
    let colors = linear_colours(&mesh.vertex_color);
    let uvs = mesh.texcoords.chunks_exact(2).map(|uv| [uv[0], uv[1]]).collect();
    Ok(MeshData { normals: vectors(&mesh.normals), uvs, colors, ..data })
}

/// The colours of vertices as light, white for vertices without one; none if no vertex has a colour. The programs that write
/// them (MeshLab, ZBrush, Blender) write display colours: sRGB.
fn linear_colours(shown: &[f32]) -> Vec<[f32; 4]> {
    let colours = || shown.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]);
    if colours().all(|colour| colour == NO_COLOUR) {
        return Vec::new();
    }
    let light = |part: f32| Encoding::Srgb.decode_signal(f64::from(part)) as f32;
    let linear = |[r, g, b]: [f32; 3]| [light(r), light(g), light(b), 1.0];
    colours().map(|colour| if colour == NO_COLOUR { [1.0; 4] } else { linear(colour) }).collect()
}

fn faces(mesh: &tobj::Mesh) -> impl Iterator<Item = Face<'_>> {
    let mut rest = mesh.indices.as_slice();
    // `tobj` leaves the number of corners out where all faces are triangles.
    let all_triangles = std::iter::repeat_n(3, if mesh.face_arities.is_empty() { rest.len() / 3 } else { 0 });
    mesh.face_arities.iter().copied().chain(all_triangles).map(move |corners| {
        let (outline, after) = rest.split_at(corners as usize);
        rest = after;
        Face { outline, holes: &[] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_model;
    use rt_math::Rgb;
    use rt_shading::{Channel, ColorTexture, FloatTexture, LayeredBase, MaterialModel, Texture, TextureId};
    use std::fs;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn load_text(text: &str) -> Result<Model, LoadError> {
        load_bytes(text.as_bytes(), Path::new("m.obj"), &LoadOptions::default())
    }

    fn good(text: &str) -> Model {
        load_text(text).expect("a model")
    }

    fn refused(text: &str) -> String {
        load_text(text).expect_err("a bad file").to_string()
    }

    fn warnings(model: &Model) -> Vec<String> {
        model.warnings.iter().map(ToString::to_string).collect()
    }

    /// The model of a file with a library. Its images are `n.png`, with (0.2, 0.4, 0.8) everywhere, and the heights `h.png`,
    /// which rise to the right and, less steeply, downwards.
    fn load_with_library(mtl: &str, text: &str) -> Model {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |name: &str| folder.path().join(name);
        image::RgbImage::from_pixel(2, 1, image::Rgb([51, 102, 204])).save(place("n.png")).expect("written");
        let heights = image::GrayImage::from_fn(3, 3, |x, y| image::Luma([100 * x as u8 + 20 * y as u8]));
        heights.save(place("h.png")).expect("written");
        fs::write(place("m.mtl"), mtl).expect("written");
        fs::write(place("m.obj"), format!("mtllib m.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\n{text}")).expect("written");
        load_model(&place("m.obj"), &LoadOptions::default()).expect("a model")
    }

    #[test]
    fn objects_and_materials_become_nodes() {
        let model = good(&format!("{SQUARE}o a\nf 1 2 3\nusemtl m\nf 1 3 4\no b\nf 1 2 3 4\n"));
        let names: Vec<_> = model.nodes.iter().map(|n| (n.name.as_str(), n.material.0)).collect();
        assert_eq!(names, [("a", 0), ("a", 1), ("b", 1)]);
        let sizes: Vec<_> = model.meshes.iter().map(|m| m.mesh.data().triangles.len()).collect();
        assert_eq!(sizes, [1, 1, 2]);
        assert_eq!(
            warnings(&model),
            ["m.obj: the material `m` is not defined in a library (there are none); plain grey is used"]
        );
    }

    #[test]
    fn vertices_are_shared_and_attributes_follow_them() {
        let text = format!(
            "{SQUARE}vt 0 0\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/1/1\nf 1/1/1 3/1/1 4/2/1\nf 1/2/1 2/2/1 3/1/1\n"
        );
        let model = good(&text);
        let data = model.mesh_data(0);
        assert_eq!(data.triangles, [[0, 1, 2], [0, 2, 3], [4, 1, 2]]);
        assert_eq!(data.positions[4], data.positions[0]);
        assert_eq!((data.uvs[0], data.uvs[4]), ([0.0, 0.0], [1.0, 1.0]));
        assert!(data.normals.iter().all(|n| *n == Vec3::Z));
    }

    #[test]
    fn colours_of_vertices_tint_the_material() {
        let text =
            "v 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\no white\nf 4 5 6\n";
        let model = good(text);
        let colors = &model.mesh_data(0).colors;
        assert_eq!((colors[0], colors[2]), ([1.0, 0.0, 0.0, 1.0], [1.0; 4]));
        // The sRGB curve takes 1/2 to 0.214.
        assert!((colors[1][0] - 0.214_041).abs() < 1e-6 && colors[1][3] == 1.0, "{colors:?}");
        assert!(model.mesh_data(1).colors.is_empty());
        let diffuse = |node: usize| model.materials[model.nodes[node].material.0 as usize].to_phong().diffuse;
        assert!(matches!(diffuse(0), ColorTexture::Textured(TextureId(0), _)));
        assert_eq!(model.textures, [Texture::VertexColor(None)]);
        assert!(matches!(diffuse(1), ColorTexture::Constant(_)));
    }

    /// White colours of vertices were dropped, so that a mesh without material was grey.
    #[test]
    fn white_colours_of_vertices_are_kept() {
        let white = "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n";
        let model = good(white);
        assert_eq!(model.mesh_data(0).colors, [[1.0; 4]; 3]);
        assert_eq!(model.textures, [Texture::VertexColor(None)]);
        let plain = good(&white.replace(" 1 1 1", ""));
        assert!(plain.mesh_data(0).colors.is_empty());
    }

    #[test]
    fn a_concave_face_covers_its_own_area_only() {
        let model = good("v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 1 2 3 4");
        let data = model.mesh_data(0);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| data.positions[i as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        assert_eq!(data.triangles.iter().map(area).collect::<Vec<_>>(), [0.5, 0.5]);
    }

    #[test]
    fn smoothing_follows_the_file() {
        let bend = "v 0 0 0\nv 0 1 0\nv -1 0 0\nv 1 0 5\n";
        let faces = "f 1 2 3\nf 1 4 2\n";
        let normals = |smoothing: &str| {
            let model = good(&format!("{bend}{smoothing}{faces}"));
            model.mesh_data(0).normals.len()
        };
        assert_eq!(normals("s off\n"), 0);
        assert_eq!(normals("s 1\n"), 4);
        assert_eq!(normals(""), 6, "the sharp edge is kept: its two vertices are repeated");
    }

    /// Normals at the ridge of a roof of two sides, corner by corner.
    fn ridge_normals(height: f32, faces: &str) -> Vec<Vec3> {
        let roof =
            format!("v -2 -2 0\nv 0 -2 {height}\nv 0 2 {height}\nv -2 2 0\nv 2 -2 0\nv 2 2 0\nvt 0 0\nvn 0 0 1\n");
        let model = good(&format!("{roof}{faces}"));
        let mut normals = Vec::new();
        for data in model.meshes.iter().map(|m| m.mesh.data()) {
            let corners = data.triangles.iter().flatten().map(|&i| i as usize);
            let at_ridge = corners.filter(|&i| data.positions[i].x == 0.0);
            normals.extend(at_ridge.map(|i| data.normals.get(i).copied().unwrap_or(Vec3::NAN)));
        }
        normals
    }

    /// Normals were computed for each combination of name, material and attributes: an edge between two of them was sharp.
    #[test]
    fn smoothing_groups_extend_across_materials_groups_objects_and_texture_coordinates() {
        let ridge = |faces: &str| ridge_normals(1.0, faces);
        let smooth = ridge("s 1\nf 1 2 3 4\nf 2 5 6 3\n");
        assert!(smooth.iter().all(|n| n.x.abs() < 0.2), "{smooth:?}");
        for between in ["usemtl b", "g b", "o b", "o b\nusemtl b\ng c"] {
            assert_eq!(ridge(&format!("s 1\nf 1 2 3 4\n{between}\nf 2 5 6 3\n")), smooth, "{between}");
        }
        assert_eq!(ridge("s 1\nf 1/1 2/1 3/1 4/1\nf 2 5 6 3\n"), smooth);
        // Faces with normals keep them, and count for the others.
        assert_eq!(ridge("s 1\nf 1//1 2//1 3//1 4//1\nf 2 5 6 3\n")[3..], smooth[3..]);
        let separate = ridge("s 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n");
        assert!(separate.iter().all(|n| n.x.abs() > 0.4), "{separate:?}");
        assert!(ridge("s 1\nf 1 2 3 4\ns off\nf 2 5 6 3\n")[3..].iter().all(|n| n.is_nan()));
    }

    /// The same without smoothing groups: materials and groups make no edge sharp, objects remain separate.
    #[test]
    fn gentle_edges_are_smoothed_across_materials_and_groups_of_an_object() {
        let ridge = |between: &str| ridge_normals(0.2, &format!("o a\nf 1 2 3 4\n{between}\nf 2 5 6 3\n"));
        let smooth = ridge("");
        assert!(smooth.iter().all(|n| n.x.abs() < 0.04), "{smooth:?}");
        assert_eq!([ridge("usemtl b"), ridge("g b"), ridge("g b\no a")], [smooth.clone(), smooth.clone(), smooth]);
        for normal in [ridge("o b"), ridge("o b\ng a")].concat() {
            assert!(normal.x.abs() > 0.09, "{normal}");
        }
    }

    #[test]
    fn bad_numbers_are_found_by_line() {
        assert_eq!(refused("v 0 0 0\nv 1,5 0 0\nv 0 1 0\nf 1 2 3"), "m.obj:2: `1,5` is not a number");
        assert_eq!(refused(&format!("{SQUARE}\nvn 0 zero 1\nf 1 2 3")), "m.obj:6: `zero` is not a number");
        assert_eq!(refused(&format!("{SQUARE}f 1 2 9")).split(':').nth(1), Some("5"));
    }

    #[test]
    fn files_without_faces_are_refused() {
        for text in ["", "# nothing\n", SQUARE] {
            assert_eq!(refused(text), "m.obj: has no usable triangles");
        }
        assert_eq!(
            refused("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
            "m.obj: has no usable triangles (warning: m.obj: unnamed object: triangles without area were dropped: 1 of \
             1)"
        );
    }

    #[test]
    fn triangles_that_are_not_finite_are_dropped_and_counted() {
        let model = good(&format!("{SQUARE}v nan 0 0\nv 1e400 0 0\nf 1 2 3\nf 1 2 5\nf 1 6 3\n"));
        assert_eq!(model.mesh_data(0).triangles.len(), 1);
        let expected = "m.obj: unnamed object: triangles with a NaN or infinite vertex were dropped: 2 of 3; vertices of meshes \
                        are stored in single precision, and numbers above 3.4e38 count as infinite";
        assert_eq!(warnings(&model), [expected]);
    }

    #[test]
    fn materials_come_from_libraries_next_to_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |name: &str| folder.path().join(name);
        fs::write(place("my lib.mtl"), "newmtl red\nKd 1 0 0\nmap_Kd missing.png\nKs 1\n").expect("written");
        fs::write(place("b.mtl"), "newmtl blue\nKd 0 0 1\nmap_Kd t.png\nnewmtl red\nKd 0 1 0\n").expect("written");
        image::RgbImage::new(2, 1).save(place("t.png")).expect("written");
        let head = format!("mtllib my lib.mtl\nmtllib none.mtl b.mtl\nmtllib\n{SQUARE}");
        fs::write(place("m.obj"), head + "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n").expect("written");

        let model = load_model(&place("m.obj"), &LoadOptions::default()).expect("a model");
        assert_eq!(model.materials[0].to_phong().diffuse, ColorTexture::Constant(Rgb::new(1.0, 0.0, 0.0)));
        assert!(matches!(model.materials[1].to_phong().diffuse, ColorTexture::Textured(..)));
        assert!(matches!(&model.textures[0], Texture::Image { bitmap, .. } if bitmap.width == 2));
        let what = model.messages();
        assert_eq!(what[0], "the material library `none.mtl` does not exist; plain grey is used for its materials");
        assert_eq!(what[1], "`mtllib` names no material library; plain grey is used for its materials");
        assert_eq!(what[2], "the image `missing.png` does not exist; the plain colour is used");
        assert_eq!(what.len(), 3);
    }

    /// Exporters write them for each material: warnings would hide the others.
    #[test]
    fn ambient_colours_and_maps_are_ignored_without_a_warning() {
        let mtl = "newmtl m\nKa 1 0 0\nmap_Ka missing.png\nKd 1 1 1\n";
        let model = load_with_library(mtl, "usemtl m\nf 1 2 3\n");
        assert_eq!(model.warnings, []);
        assert_eq!(model.materials[0].to_phong().ambient, ColorTexture::Constant(Rgb::gray(0.1)));
    }

    #[test]
    fn maps_of_numbers_cuts_and_bumps_are_read() {
        let mtl = "newmtl m\nKd 1\nPr 0.5\nmap_Pr -imfchan g n.png\nmap_d n.png\nmap_Bump -bm 2 h.png\n\
                   newmtl glass\nillum 7\nPr 0\nmap_Pr n.png\nPc 1\ndisp n.png\n";
        let model = load_with_library(mtl, "usemtl m\nf 1/1 2/2 3/3\nusemtl glass\nf 1 2 3\n");
        let material = &model.materials[0];
        let bitmap = |id: TextureId| model.textures[id.0 as usize].bitmap().expect("an image");
        let MaterialModel::Layered(layers) = &material.model else { panic!("layers") };
        let LayeredBase::MetallicRoughness { roughness, .. } = layers.base else { panic!("{layers:?}") };
        let FloatTexture::Textured { texture: id, channel: Channel::Green, factor: 0.5, mean } = roughness else {
            panic!("the green of a texture: {roughness:?}")
        };
        assert!((mean - 0.5 * 0.4).abs() < 1e-7, "{mean}");
        assert_eq!(bitmap(id).pixels[0], [0.2, 0.4, 0.8], "numbers, not sRGB");
        assert_eq!(bitmap(material.alpha.texture.expect("a cut")).alpha, [0.2; 2]);
        let normal_map = material.normal_map.expect("bumps");
        assert_eq!(normal_map.scale, 2.0);
        assert!(bitmap(normal_map.texture).pixels[1][0] < 0.5, "the slope rises to the right");
        assert_eq!(model.mesh_data(0).tangents[0], [1.0, 0.0, 0.0, 1.0]);
        assert!(model.mesh_data(1).tangents.is_empty());
        assert_eq!(model.messages(), ["`disp` is not supported", "`map_Pr` is not supported", "`Pc` is not supported"]);
    }

    #[test]
    fn mirrored_bump_maps_had_inverted_slopes() {
        let maps = ["map_Bump h.png", "map_Bump -s -1 1 1 h.png", "map_Bump -s 2 -1 1 h.png", "norm -s -3 1 1 h.png"];
        let mtl: String = (0..).zip(maps).map(|(index, map)| format!("newmtl m{index}\n{map}\n")).collect();
        let faces: String = (0..maps.len()).map(|index| format!("usemtl m{index}\nf 1/1 2/2 3/3\n")).collect();
        let model = load_with_library(&mtl, &faces);
        let normals = |material: usize| {
            let mut texture = &model.textures[model.materials[material].normal_map.expect("bumps").texture.0 as usize];
            while let Texture::Mapped { texture: inner, .. } = texture {
                texture = inner;
            }
            let Texture::Image { bitmap, .. } = texture else { panic!("{texture:?}") };
            bitmap.pixels.iter().map(|pixel| pixel.map(|part| 2.0 * part - 1.0)).collect::<Vec<_>>()
        };
        let plain = normals(0);
        for (material, signs) in [(1, [-1.0, 1.0]), (2, [1.0, -1.0]), (3, [-1.0, 1.0])] {
            for ([x, y, z], mirrored) in plain.iter().zip(normals(material)) {
                let expected = [signs[0] * x, signs[1] * y, *z];
                assert!(expected.iter().zip(mirrored).all(|(a, b)| (a - b).abs() < 1e-6), "{material}: {mirrored:?}");
            }
        }
    }

    #[test]
    fn physical_glass_with_a_black_filter_encloses_no_medium() {
        let mtl = "newmtl black\nillum 7\nNi 1.5\nPr 0\nTf 0 0 0\nnewmtl clear\nillum 7\nNi 1.5\nPr 0\n";
        let model = load_with_library(mtl, "usemtl black\nf 1 2 3\nusemtl clear\nf 1 2 3\n");
        let iors: Vec<_> = model.materials.iter().map(|material| material.interior.map(|inside| inside.ior)).collect();
        assert_eq!(iors, [None, Some(1.5)]);
    }

    #[test]
    fn absolute_libraries_are_warnings_and_directories_name_the_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let load = |statement: &str| {
            let path = folder.path().join("m.obj");
            fs::write(&path, format!("{SQUARE}{statement}\nf 1 2 3\n")).expect("written");
            load_model(&path, &LoadOptions::default())
        };
        for absolute in ["/library.mtl", "/my files/x.mtl", "C:\\x.mtl", "\\\\host\\x.mtl"] {
            let model = load(&format!("mtllib {absolute}")).expect("a model");
            let expected = format!(
                "m.obj:5: the path of the material library `{absolute}` is absolute; plain grey is used for its materials"
            );
            assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
            assert!(model.warnings[0].to_string().ends_with(&expected), "{}", model.warnings[0]);
        }
        let error = load("mtllib .").expect_err("a directory").to_string();
        assert!(error.ends_with("m.obj:5: `.` is a directory; give the path of a file"), "{error}");
        fs::write(folder.path().join("m.mtl"), "newmtl m\nmap_Kd .\n").expect("written");
        let error = load("mtllib m.mtl\nusemtl m").expect_err("a directory").to_string();
        assert!(error.ends_with("m.mtl: material `m`: `.` is a directory; give the path of a file"), "{error}");
    }

    #[test]
    fn references_must_not_leave_the_folder() {
        let outer = tempfile::tempdir().expect("a folder");
        let inner = outer.path().join("inner");
        fs::create_dir(&inner).expect("a folder");
        fs::write(outer.path().join("secret.mtl"), "newmtl m\n").expect("written");
        fs::write(inner.join("m.obj"), format!("mtllib ../secret.mtl\n{SQUARE}f 1 2 3\n")).expect("written");
        let error = load_model(&inner.join("m.obj"), &LoadOptions::default()).expect_err("an escape").to_string();
        assert!(error.contains("m.obj:1: `../secret.mtl` lies outside"), "{error}");
        let options = LoadOptions { root: Some(outer.path().to_owned()), ..LoadOptions::default() };
        assert!(load_model(&inner.join("m.obj"), &options).is_ok());
    }

    /// The system reports a name that is too long, or a file in place of a folder, by errors of their own.
    #[test]
    fn missing_files_of_long_names_and_below_files_were_errors() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
        let load = |library: &str| {
            write("m.obj", &format!("mtllib {library}\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"));
            load_model(&folder.path().join("m.obj"), &LoadOptions::default()).expect("a model")
        };
        let [a, b] = ["a", "b"].map(|letter| letter.repeat(150) + ".mtl");
        write(&a, "newmtl a\nKd 1 0 0\n");
        write(&b, "newmtl b\nKd 0 0 1\n");
        let model = load(&format!("{a} {b}"));
        assert_eq!(model.warnings, []);
        let colours: Vec<_> = model.materials.iter().map(|material| material.to_phong().diffuse).collect();
        assert_eq!(colours, [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0)].map(ColorTexture::Constant));
        let expected = "the material library `m.obj/y.mtl` does not exist; plain grey is used for its materials";
        assert_eq!(load("m.obj/y.mtl").messages(), [expected]);
        for image in ["i".repeat(300), "m.obj/i.png".to_owned()] {
            write("c.mtl", &format!("newmtl a\nmap_Kd {image}\nnewmtl b\n"));
            let expected = format!("the image `{image}` does not exist; the plain colour is used");
            assert_eq!(load("c.mtl").messages(), [expected]);
        }
    }
}
