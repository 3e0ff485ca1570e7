//! Builds a scene in Rust, renders it and saves the image:
//! `cargo run -p rt-render --example scene_in_code -- picture.png`

#![allow(clippy::print_stdout, reason = "an example shows its results")]

use std::{error::Error, fs::File, io::BufWriter};

use rt_camera::{CameraSettings, FilmSettings, FovAxis, Projection};
use rt_geometry::{Plane, Shape, Sphere};
use rt_image::{ImageFormat, write_image};
use rt_math::{DVec3, Rgb, Transform};
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::{Content, MaterialId, NamedCamera, Scene, SceneNode};
use rt_shading::{
    Appearance, Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, LightUnits, Material, Phong,
};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "scene_in_code.png".to_owned());

    let camera = CameraSettings::new(
        Transform::look_at(DVec3::new(0.0, 2.0, 7.0), DVec3::new(0.0, 0.8, 0.0), DVec3::Y)?,
        Projection::Perspective { fov: 40f64.to_radians(), axis: FovAxis::Vertical },
    );
    let point_light =
        DeltaLightKind::Point { position: DVec3::new(-4.0, 6.0, 5.0), falloff: Falloff::None, shadow_near: 0.0 };
    let gray = |value| ColorTexture::Constant(Rgb::gray(value));
    let clay = Phong { diffuse: ColorTexture::Constant(Rgb::new(0.8, 0.4, 0.3)), ..Phong::default() };
    let chrome = Phong { diffuse: gray(0.1), specular: gray(0.8), mirror: gray(0.7), ..Phong::default() };

    let sphere =
        |x, radius| Ok::<_, rt_geometry::ShapeError>(Shape::Sphere(Sphere::new(DVec3::new(x, radius, 0.0), radius)?));
    let scene = Scene {
        cameras: vec![NamedCamera { name: "main".into(), settings: camera, medium: None }],
        film: FilmSettings { width: 480, height: 320, ..FilmSettings::default() },
        appearance: Appearance {
            materials: vec![Material::new("clay".into(), clay), Material::new("chrome".into(), chrome)],
            lights: vec![DeltaLight {
                name: "lamp".into(),
                kind: point_light,
                intensity: Rgb::WHITE,
                units: LightUnits::Classical,
                casts_shadows: true,
            }],
            ambient: Rgb::WHITE,
            background: Background::Gradient { bottom: Rgb::gray(0.9), top: Rgb::new(0.3, 0.5, 0.9) },
            ..Appearance::default()
        },
        nodes: vec![
            SceneNode::new(Content::Shape(Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y)?)), MaterialId(0)),
            SceneNode::new(Content::Shape(sphere(-1.2, 1.0)?), MaterialId(0)),
            SceneNode::new(Content::Shape(sphere(1.3, 1.2)?), MaterialId(1)),
        ],
        ..Scene::empty("scene in code")
    };

    let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
    println!("{}", plan.explain());
    let rendering = plan.render(&RunOptions::default(), |_| {})?;
    println!("{:.1} million rays per second", rendering.statistics.mega_rays_per_second());

    let format = ImageFormat::from_path(path.as_ref())?;
    write_image(&rendering.film, &scene.film.development, format, BufWriter::new(File::create(&path)?))?;
    println!("saved {path}");
    Ok(())
}
