//! Tests of textures and alpha.

use std::path::Path;

use rt_geometry::MeshData;
use rt_math::{Rgb, Vec3};
use rt_shading::{Alpha, AlphaMode, ColorTexture, MaterialModel, Texture, TextureId, TexturePoint};

use super::load_text;
use crate::{LoadOptions, Model};

/// The world with a checkered mask, a normal map and a square to lay them on.
fn square(before: &str, parameters: &str) -> Model {
    let folder = tempfile::tempdir().expect("a folder");
    let save = |name: &str, pixel: fn(u32, u32) -> [u8; 3]| {
        let image = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(pixel(x, y)));
        image.save(folder.path().join(name)).expect("saved");
    };
    save("mask.png", |x, _| [255 * x as u8; 3]);
    save("normals.png", |_, _| [128, 51, 255]);
    save("gray.png", |_, _| [128; 3]);
    let save_rgba = |name: &str, alpha: [u8; 2]| {
        let image = image::RgbaImage::from_fn(2, 2, |x, _| image::Rgba([255, 0, 0, alpha[x as usize]]));
        image.save(folder.path().join(name)).expect("saved");
    };
    save_rgba("cut.png", [0, 255]);
    save_rgba("red.png", [255, 255]);
    save_rgba("veil.png", [128, 128]);
    std::fs::write(folder.path().join("two.exr"), gray_exr(2.0)).expect("written");
    let faces = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                 0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n4 0 1 2 3\n3 1 4 2\n";
    std::fs::write(folder.path().join("faces.ply"), faces).expect("written");
    let text = format!(
        "WorldBegin\nTexture \"mask\" \"float\" \"imagemap\" \"string filename\" \"mask.png\" \"float uscale\" 2\n\
         Texture \"squares\" \"float\" \"checkerboard\"\n\
         Texture \"colors\" \"spectrum\" \"imagemap\" \"string filename\" \"mask.png\"\n{before}\n\
         Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] {parameters}\n"
    );
    let path: &Path = &folder.path().join("m.pbrt");
    load_text(&text, path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// OpenEXR file of one pixel and the channel `Y`, as pbrt-v4 writes float textures.
fn gray_exr(value: f32) -> Vec<u8> {
    let mut bytes = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        let size = (value.len() as u32).to_le_bytes();
        bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &size, value].concat());
    };
    // Name, 32-bit float, not linear, and one sample for each pixel.
    attribute("channels", "chlist", b"Y\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\0");
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &[0; 16]);
    attribute("displayWindow", "box2i", &[0; 16]);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    bytes.push(0);
    // The place of the only row, its number, its size, and the pixel.
    bytes.extend((bytes.len() as u64 + 8).to_le_bytes());
    bytes.extend([0u32.to_le_bytes(), 4u32.to_le_bytes(), value.to_le_bytes()].concat());
    bytes
}

/// Factors above 1 and texels above 1 were clamped before they were multiplied.
#[test]
fn scale_of_an_alpha_texture_is_applied_before_clamping() {
    let constant = |value: f64| {
        let textures = format!(
            "Texture \"c\" \"float\" \"constant\" \"float value\" {value}\n\
             Texture \"a\" \"float\" \"scale\" \"texture tex\" \"c\" \"float scale\" 2"
        );
        square(&textures, "\"texture alpha\" \"a\"").materials[0].alpha.clone()
    };
    assert_eq!((constant(0.3).factor, constant(0.8)), (0.6, Alpha::OPAQUE));

    let of = |file: &str, scale: f64, above: f64| {
        let textures = format!(
            "Texture \"i\" \"float\" \"imagemap\" \"string filename\" \"{file}\" \"float scale\" {scale}\n\
             Texture \"a\" \"float\" \"scale\" \"texture tex\" \"i\" \"float scale\" {above}"
        );
        let model = square(&textures, "\"texture alpha\" \"a\"");
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        let alpha = model.materials[0].alpha.clone();
        // The largest threshold that is hit, in steps of 1/1000.
        let hits = |step: &u32| {
            let threshold = f64::from(*step) / 1000.0;
            alpha.hits(&model.textures, &TexturePoint::default(), 1.0, || threshold)
        };
        (0..1000).rev().find(hits)
    };
    // 128 of 255 is 0.2159 in sRGB, and 0.502 as alpha.
    assert_eq!((of("gray.png", 1.0, 1.0), of("gray.png", 2.0, 1.0)), (Some(215), Some(431)));
    assert_eq!((of("gray.png", 1.0, 2.0), of("gray.png", 2.0, 2.0)), (Some(431), Some(863)));
    assert_eq!((of("gray.png", 8.0, 1.0), of("gray.png", 0.0, 1.0)), (Some(999), None));
    assert_eq!((of("veil.png", 0.5, 1.0), of("veil.png", 1.5, 1.0)), (Some(250), Some(752)));
    assert_eq!((of("two.exr", 0.25, 1.0), of("two.exr", 1.0, 1.0)), (Some(499), Some(999)));
}

/// pbrt-v4 stores float textures so; the files were refused.
#[test]
fn exr_textures_of_one_channel_are_read() {
    let text = "Texture \"y\" \"spectrum\" \"imagemap\" \"string filename\" \"two.exr\"\n\
                Material \"diffuse\" \"texture reflectance\" \"y\"";
    let model = square(text, "");
    assert_eq!(model.textures.last().expect("the image").bitmap().expect("an image").pixels, [[2.0; 3]]);
}

#[test]
fn shapes_are_cut_by_numbers_and_images() {
    let model = square("", "\"texture alpha\" \"mask\"");
    let Alpha { mode: AlphaMode::Blend, factor: 1.0, texture: Some(TextureId(id)), .. } = model.materials[0].alpha
    else {
        panic!("not cut: {:?}", model.materials[0].alpha)
    };
    let Texture::Mapped { texture, .. } = &model.textures[id as usize] else { panic!("not scaled") };
    assert_eq!(texture.bitmap().expect("an image").alpha, [0.0, 1.0, 0.0, 1.0]);
    let half = square("", "\"float alpha\" 0.5");
    assert_eq!((half.materials[0].alpha.mode, half.materials[0].alpha.factor), (AlphaMode::Blend, 0.5));
    assert_eq!(square("", "\"float alpha\" 1").materials[0].alpha, Alpha::OPAQUE);
    let other = square("", "\"texture alpha\" \"squares\"");
    assert_eq!(other.materials[0].alpha, Alpha::OPAQUE);
    assert!(other.warnings[0].message.contains("\"alpha\" must be an image"), "{:?}", other.warnings);
}

/// Alpha was the mean of the colours, even where the image has an alpha channel.
#[test]
fn alpha_of_an_rgba_image_is_its_alpha_channel() {
    let alpha_of = |file: &str| {
        let image = format!("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"{file}\"");
        let model = square(&image, "\"texture alpha\" \"a\"");
        let Some(TextureId(id)) = model.materials[0].alpha.texture else { panic!("not cut by {file}") };
        model.textures[id as usize].bitmap().expect("an image").alpha.clone()
    };
    assert_eq!(alpha_of("cut.png"), [0.0, 1.0, 0.0, 1.0]);
    // Images that are opaque throughout count as images of three channels.
    assert_eq!(alpha_of("red.png"), [1.0 / 3.0; 4]);
}

/// Float and spectrum textures shared one namespace, so that the last definition replaced both.
#[test]
fn float_and_spectrum_textures_have_names_of_their_own() {
    let textures = "Texture \"n\" \"spectrum\" \"constant\" \"rgb value\" [1 0 0]\n\
                    Texture \"n\" \"float\" \"constant\" \"float value\" 0.25\n\
                    Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"n\" \"texture scale\" \"n\"\n";
    let of = |name: &str| {
        let material = format!("{textures}Material \"diffuse\" \"texture reflectance\" \"{name}\"");
        let model = square(&material, "\"texture alpha\" \"n\"");
        assert_eq!(model.materials[0].alpha.factor, 0.25);
        model.materials[0].model.clone()
    };
    let diffuse = |r| MaterialModel::Diffuse { albedo: ColorTexture::Constant(Rgb::new(r, 0.0, 0.0)), roughness: 0.0 };
    assert_eq!((of("n"), of("s")), (diffuse(1.0), diffuse(0.25)));
}

#[test]
fn a_shape_that_is_cut_has_a_material_of_its_own() {
    let model = square("Shape \"sphere\"", "\"float alpha\" 0.5");
    assert_eq!(model.materials.len(), 2);
    assert_eq!((&model.materials[0].alpha, model.materials[1].alpha.factor), (&Alpha::OPAQUE, 0.5));
}

#[test]
fn normal_maps_are_numbers_along_tangents() {
    let bumpy = "Material \"diffuse\" \"string normalmap\" \"normals.png\"";
    let model = square(bumpy, "");
    let normal_map = model.materials[0].normal_map.expect("a normal map");
    let bitmap = model.textures[normal_map.texture.0 as usize].bitmap().expect("an image");
    assert_eq!((bitmap.pixels[0][1], normal_map.scale), (0.2, 1.0), "not sRGB");
    assert_eq!(model.mesh_data(0).tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let sphere = square(&format!("{bumpy}\nShape \"sphere\""), "");
    assert!(sphere.warnings[0].message.contains("its normal map needs texture coordinates"), "{:?}", sphere.warnings);
}

/// A material with an image.
const IMAGE: &str = "Material \"diffuse\" \"texture reflectance\" \"colors\"";

/// The first mesh of the world with this before the square.
fn mesh(before: &str) -> MeshData {
    square(before, "").mesh_data(0).clone()
}

/// Meshes without `uv` had no texture coordinates, so that images showed one colour.
#[test]
fn triangles_without_uv_have_the_texture_coordinates_of_pbrt() {
    let shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 2 3 0]";
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    for textured in [shape.to_owned() + " \"texture alpha\" \"mask\"", format!("{IMAGE}\n{shape}")] {
        let data = mesh(&textured);
        assert_eq!((&data.triangles[..], data.uvs), (&[[0, 1, 2], [3, 4, 5]][..], [uvs, uvs].concat()));
        assert_eq!(data.positions[3..], [Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::ZERO]);
    }
    let reversed = mesh(&format!("{IMAGE}\nReverseOrientation\n{shape}"));
    assert_eq!((&reversed.triangles[..], reversed.uvs), (&[[0, 2, 1], [3, 5, 4]][..], [uvs, uvs].concat()));
    // Without textures, vertices stay shared.
    let plain = mesh(shape);
    assert_eq!((plain.positions.len(), plain.uvs), (4, Vec::new()));
}

#[test]
fn every_patch_without_uv_spans_the_unit_square() {
    let shape = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0] \
                 \"integer indices\" [0 1 2 3 1 4 3 5]";
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let data = mesh(&format!("{IMAGE}\n{shape}"));
    assert_eq!(data.triangles, [[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6]]);
    assert_eq!((data.uvs, data.positions[5]), ([uvs, uvs].concat(), Vec3::X * 2.0));
    let plain = mesh(shape);
    assert_eq!((plain.positions.len(), plain.uvs), (6, Vec::new()));
    // The coordinates of a single patch follow its indices, not its vertices.
    let turned = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 3 2]";
    let turned = mesh(turned);
    assert_eq!((turned.uvs, turned.positions[3]), (uvs.to_vec(), Vec3::new(1.0, 1.0, 0.0)));
}

#[test]
fn every_face_of_a_ply_file_without_uv_has_the_texture_coordinates_of_pbrt() {
    let shape = "Shape \"plymesh\" \"string filename\" \"faces.ply\"";
    let data = mesh(&format!("{IMAGE}\n{shape}"));
    assert_eq!(data.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    let (square, triangle) = ([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!((data.uvs, data.positions[5]), ([&square[..], &triangle[..]].concat(), Vec3::X * 2.0));
    let plain = mesh(shape);
    assert_eq!((plain.positions.len(), plain.uvs), (5, Vec::new()));
}

/// The second axis was that along which `v` rises, in charts that mirror the image as well.
#[test]
fn the_second_axis_of_normal_maps_is_the_cross_product_of_pbrt() {
    let sides = |before: &str, uv: &str| -> Vec<f32> {
        let bumpy = format!("Material \"diffuse\" \"string normalmap\" \"normals.png\"\n{before}");
        let model = square(&bumpy, &format!("\"point2 uv\" [{uv}]"));
        model.mesh_data(0).tangents.iter().map(|tangent| tangent[3]).collect()
    };
    let (straight, mirrored) = ("0 0 1 0 0 1 1 1", "1 0 0 0 1 1 0 1");
    assert_eq!((sides("", straight), sides("", mirrored)), (vec![1.0; 4], vec![1.0; 4]));
    // The product is taken in the world.
    let reflection = "Scale -1 1 1";
    assert_eq!((sides(reflection, straight), sides(reflection, mirrored)), (vec![-1.0; 4], vec![-1.0; 4]));
}

#[test]
fn normal_maps_need_no_uv() {
    let shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0]";
    let model = square(&format!("Material \"diffuse\" \"string normalmap\" \"normals.png\"\n{shape}"), "");
    assert_eq!(model.mesh_data(0).tangents, [[1.0, 0.0, 0.0, 1.0]; 3]);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
}
