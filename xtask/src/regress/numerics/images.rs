//! Whole images.

use std::{f64::consts::PI, path::Path, sync::Arc};

use rt_camera::{CameraSettings, FilmSettings, Filter, Projection, SamplerKind};
use rt_geometry::{MeshData, Rectangle, Shape, Sphere, TriangleMesh};
use rt_math::{DVec3, Rgb, Transform, Vec3, transcendental::sincos};
use rt_render::{Crop, PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::{
    Accel, Content, LoadOptions, MaterialId, MeshId, NamedCamera, NamedMesh, RenderSettings, Scene, SceneNode, load,
};
use rt_shading::{
    Appearance, Background, Bitmap, ColorTexture, DeltaLight, DeltaLightKind, Material, Phong, Texture, TextureId, Wrap,
};

use super::{Case, Checks, Conditions, Fallible, cases};

cases! {
    "S36", "a smooth ball of 8×8 facets, lit from 80° aside",
        "Lambert's phase function, no dark facet", "2 %", terminator;
    "S47", "all accelerators × all scene files (one-picture does it with the program)",
        "one checksum", "bits", one_checksum;
    "S70", "texels that are NaN", "each sample of them counted and black, no other", "exact", nan_texels;
    "S71", "images of 1×1, 1×65536 and 65536×1 pixels",
        "each pixel the same, alone or together, on any threads", "bits", extreme_sizes;
}

/// An orthographic view along −z of a square 2 units high, one sample in the middle of each pixel.
fn facing(width: u32, height: u32, node: SceneNode, phong: Phong) -> Scene {
    let place = Transform::translate(DVec3::Z * 5.0);
    let camera = CameraSettings::new(place, Projection::Orthographic { height: 2.0 });
    Scene {
        cameras: vec![NamedCamera { name: "front".into(), settings: camera, medium: None }],
        film: FilmSettings { width, height, filter: Filter::Box, ..FilmSettings::default() },
        settings: RenderSettings { spp: 1, pattern: SamplerKind::Centre, ..RenderSettings::default() },
        appearance: Appearance {
            materials: vec![Material::new("front".into(), phong)],
            background: Background::Constant(Rgb::gray(0.125)),
            ..Appearance::default()
        },
        nodes: vec![node],
        ..Scene::empty("front")
    }
}

/// A sphere of facets around the origin, with the normals of the sphere.
fn faceted_sphere(around: u32, up: u32) -> Fallible<TriangleMesh> {
    let vertex = |i: u32| {
        let (sin, cos) = sincos(2.0 * PI * f64::from(i % around) / f64::from(around));
        let (ring, height) = sincos(PI * f64::from(i / around) / f64::from(up));
        DVec3::new(ring * cos, ring * sin, height).as_vec3()
    };
    let positions: Vec<Vec3> = (0..around * (up + 1)).map(vertex).collect();
    let quad = |cell: u32| {
        let (row, column) = (cell / around, cell % around);
        let [a, b] = [row * around + column, row * around + (column + 1) % around];
        [[a, a + around, b + around], [a, b + around, b]]
    };
    let triangles = (0..around * up).flat_map(quad).collect();
    Ok(TriangleMesh::build(MeshData { normals: positions.clone(), positions, triangles, ..MeshData::default() })?.0)
}

fn terminator(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let side = conditions.count(100, 400) as u32;
    let white = ColorTexture::Constant(Rgb::WHITE);
    let phong = Phong { ambient: ColorTexture::ZERO, diffuse: white, ..Phong::default() };
    let mut scene = facing(side, side, SceneNode::new(Content::Mesh(MeshId(0)), MaterialId(0)), phong);
    scene.meshes = vec![NamedMesh { name: "ball".into(), mesh: Arc::new(faceted_sphere(8, 8)?) }];
    let angle = 80f64.to_radians();
    let (sin, cos) = sincos(angle);
    scene.appearance.lights =
        vec![DeltaLight::new(DeltaLightKind::Directional { direction: DVec3::new(-sin, 0.0, -cos) }, Rgb::WHITE)];
    let mut unshadowed = scene.clone();
    unshadowed.appearance.lights[0].casts_shadows = false;
    let options = PlanOptions { transparent: true, ..PlanOptions::default() };
    let [lit, bare] = [&scene, &unshadowed].map(|scene| -> Fallible<_> {
        Ok(RenderPlan::compile(scene, &options)?.render(&RunOptions::default(), |_| {})?.film)
    });
    let (lit, bare) = (lit?, bare?);
    let covered = lit.alpha().map_or(0.0, |alpha| alpha.iter().map(|a| f64::from(*a)).sum());
    let mean = lit.pixels().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / covered;
    let truth = 2.0 / 3.0 * (sin + (PI - angle) * cos) / PI;
    checks.limit(mean / truth - 1.0, 0.02, format_args!("mean {mean} instead of {truth}"));
    for (lit, bare) in lit.pixels().iter().zip(bare.pixels()) {
        checks.check(lit == bare, || format!("{lit:?} in shadow instead of {bare:?}"));
    }
    Ok(())
}

/// A scene file, smaller than it is.
pub(super) fn small(file: &Path, width: u32, spp: u32) -> Fallible<Scene> {
    let mut scene = load(file, &LoadOptions::default())?;
    let FilmSettings { width: full_width, height, .. } = scene.film;
    scene.film.height = (u64::from(width) * u64::from(height) / u64::from(full_width)).max(1) as u32;
    scene.film.width = width;
    scene.settings.spp = spp;
    Ok(scene)
}

fn one_checksum(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for file in conditions.workspace.files("scenes", ".ron")? {
        let (width, spp) = if conditions.full { (96, 4) } else { (24, 1) };
        let mut scene = small(&file, width, spp)?;
        let mut checksums = Vec::new();
        for accel in Accel::ALL {
            scene.settings.accel = accel;
            let film =
                RenderPlan::compile(&scene, &PlanOptions::default())?.render(&RunOptions::default(), |_| {})?.film;
            checksums.push(film.checksum());
            checks.same(film.checksum(), checksums[0], format_args!("{}, {}", scene.name, accel.name()));
        }
    }
    Ok(())
}

fn nan_texels(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const SIDE: u32 = 16;
    let spp = conditions.count(4, 64) as u32;
    let mut pixels = vec![[0.5f32; 3]; (SIDE * SIDE) as usize];
    let bad = [(0, f32::NAN), (17, f32::INFINITY), (100, f32::NAN), (255, f32::NEG_INFINITY)];
    for (texel, value) in bad {
        pixels[texel][texel % 3] = value;
    }
    let upright = Transform::rotate(DVec3::X, PI / 2.0)?;
    let board = Content::Shape(Shape::Rectangle(Rectangle::new(2.0, 2.0)?));
    let mut scene = facing(
        SIDE,
        SIDE,
        SceneNode { parent_from_local: upright, ..SceneNode::new(board, MaterialId(0)) },
        Phong::BLACK,
    );
    scene.appearance.materials[0].emission = ColorTexture::Textured(TextureId(0), Rgb::WHITE);
    let bitmap = Arc::new(Bitmap::opaque(SIDE, SIDE, pixels));
    scene.appearance.textures = vec![Texture::Image { bitmap, wrap: [Wrap::Clamp; 2], smooth: false }];
    scene.settings.spp = spp;
    scene.settings.pattern = SamplerKind::Grid;
    let rendering = RenderPlan::compile(&scene, &PlanOptions::default())?.render(&RunOptions::default(), |_| {})?;
    checks.same(rendering.statistics.bad_samples, bad.len() as u64 * u64::from(spp), "bad samples");
    for (index, pixel) in rendering.film.pixels().iter().enumerate() {
        let is_bad = bad.iter().any(|(texel, _)| *texel == index);
        let expected = if is_bad { [0.0; 3] } else { [0.5; 3] };
        checks.same(*pixel, expected, format_args!("pixel {index}"));
    }
    Ok(())
}

fn extreme_sizes(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const LONG: u32 = 65_536;
    for (width, height) in [(1, 1), (1, LONG), (LONG, 1)] {
        let sphere = Content::Shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.9)?));
        let mut scene = facing(width, height, SceneNode::new(sphere, MaterialId(0)), Phong::default());
        scene.appearance.materials[0].emission = ColorTexture::Constant(Rgb::gray(0.25));
        if width > height {
            // As wide as it would be high.
            scene.cameras[0].settings.projection = Projection::Orthographic { height: 2.0 / f64::from(LONG) };
        }
        let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
        let film = plan.render(&RunOptions::default(), |_| {})?.film;
        let alone = plan.render(&RunOptions { threads: 1, ..RunOptions::default() }, |_| {})?.film;
        checks.same(alone.checksum(), film.checksum(), format_args!("{width}×{height} on one thread"));
        checks.same((film.width(), film.height()), (width, height), "size");
        let at = |index: u32| if width > height { (index, 0) } else { (0, index) };
        let count = width.max(height);
        let hits = film.pixels().iter().filter(|pixel| **pixel == [0.25; 3]).count();
        let expected = if count == 1 { 1.0 } else { 0.9 * f64::from(LONG) };
        checks
            .check((hits as f64 - expected).abs() <= 1.0, || format!("{hits} pixels of {width}×{height} see the ball"));
        for index in (0..count).step_by(97) {
            let (x, y) = at(index);
            let together = film.pixels()[index as usize];
            let single = plan.pixel(x, y).map(|rgb| rgb.to_array().map(|c| c as f32));
            checks.same(single, Some(together), format_args!("pixel {x}, {y}"));
        }
        let (x, y) = at(count - 1);
        let crop = Some(Crop { x, y, width: 1, height: 1 });
        let corner = RenderPlan::compile(&scene, &PlanOptions { crop, ..PlanOptions::default() })?;
        checks.same(corner.pixel(x, y), plan.pixel(x, y), "the last pixel");
    }
    Ok(())
}
