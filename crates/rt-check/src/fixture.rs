//! Small scenes for tests.

use std::sync::Arc;

use rt_camera::{CameraSettings, FilmSettings, FovAxis, Projection};
use rt_geometry::{MeshData, Plane, Shape, Sphere, TriangleMesh};
use rt_math::{DVec3, Rgb, Transform, Vec3};
use rt_scene_io::{Content, MaterialId, MeshId, NamedCamera, NamedMesh, Scene, SceneNode};
use rt_shading::{
    Appearance, ColorTexture, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, Material, Phong, Texture, TextureId,
    Transmission,
};

pub(crate) use crate::Severity;
use crate::{Finding, Kind, Measurement, check};

pub(crate) const GREY: MaterialId = MaterialId(0);
pub(crate) const GLASS: MaterialId = MaterialId(1);
pub(crate) const CHECKER: MaterialId = MaterialId(2);

/// Three materials, ambient light, a small square image, and no objects.
pub(crate) fn empty() -> Scene {
    let material = |name: &str, phong| Material::new(name.into(), phong);
    let white = ColorTexture::Constant(Rgb::WHITE);
    let transmission = Some(Transmission { coefficient: white, fresnel: true });
    let glass = Phong { diffuse: ColorTexture::ZERO, mirror: white, transmission, ..Phong::default() };
    let glass = Material { interior: Some(InteriorMedium::clear(1.5)), ..material("glass", glass) };
    let checker = Phong { diffuse: ColorTexture::Textured(TextureId(0), Rgb::WHITE), ..Phong::default() };
    Scene {
        film: FilmSettings { width: 48, height: 48, ..FilmSettings::default() },
        appearance: Appearance {
            materials: vec![material("grey", Phong::default()), glass, material("checker", checker)],
            textures: vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 1.0 }],
            ambient: Rgb::WHITE,
            ..Appearance::default()
        },
        ..Scene::empty("test")
    }
}

/// [`empty`] with these nodes.
pub(crate) fn scene_with(nodes: Vec<SceneNode>) -> Scene {
    Scene { nodes, ..empty() }
}

/// [`scene_with`] a camera that looks at the origin.
pub(crate) fn seen_from(eye: DVec3, nodes: Vec<SceneNode>) -> Scene {
    Scene { cameras: vec![camera(eye, DVec3::ZERO)], ..scene_with(nodes) }
}

/// [`empty`] with a node that shows a mesh, as of [`add_mesh`].
pub(crate) fn scene_of_mesh(data: MeshData) -> Scene {
    let mut scene = empty();
    scene.nodes = vec![add_mesh(&mut scene, data)];
    scene
}

pub(crate) const fn value(name: &'static str, value: f64) -> Measurement {
    Measurement { name, value }
}

pub(crate) fn sphere(centre: DVec3, radius: f64) -> SceneNode {
    SceneNode::new(Content::Shape(Shape::Sphere(Sphere::new(centre, radius).unwrap())), GREY)
}

/// A plane that faces upwards.
pub(crate) fn floor(height: f64) -> SceneNode {
    SceneNode::new(Content::Shape(Shape::Plane(Plane::new(DVec3::Y * height, DVec3::Y).unwrap())), GREY)
}

pub(crate) fn camera(from: DVec3, at: DVec3) -> NamedCamera {
    let settings = CameraSettings::new(
        Transform::look_at(from, at, DVec3::Y).unwrap(),
        Projection::Perspective { fov: 40f64.to_radians(), axis: FovAxis::Vertical },
    );
    NamedCamera { name: "main".into(), settings, medium: None }
}

pub(crate) fn point_light(position: DVec3, shadow_near: f64) -> DeltaLight {
    let kind = DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near };
    DeltaLight { name: "lamp".into(), ..DeltaLight::new(kind, Rgb::WHITE) }
}

/// The unit cube from the origin to (1, 1, 1), its front outside.
pub(crate) fn cube_data() -> MeshData {
    let positions = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

/// Adds a mesh to the scene and returns a node that shows it; mesh and node are named "cube".
pub(crate) fn add_mesh(scene: &mut Scene, data: MeshData) -> SceneNode {
    let id = MeshId(scene.meshes.len() as u32);
    scene.meshes.push(NamedMesh { name: "cube".into(), mesh: Arc::new(TriangleMesh::build(data).unwrap().0) });
    SceneNode { name: "cube".into(), ..SceneNode::new(Content::Mesh(id), GREY) }
}

pub(crate) fn of_kind(scene: &Scene, kind: Kind) -> Vec<Finding> {
    check(scene).findings.into_iter().filter(|finding| finding.kind == kind).collect()
}

/// The only finding of a kind in a scene without other warnings.
#[track_caller]
pub(crate) fn only(scene: &Scene, kind: Kind) -> Finding {
    let report = check(scene);
    let others: Vec<_> = report.findings.iter().filter(|f| f.kind != kind && f.severity > Severity::Note).collect();
    assert!(others.is_empty(), "{others:#?}");
    let mut found: Vec<_> = report.findings.into_iter().filter(|finding| finding.kind == kind).collect();
    assert_eq!(found.len(), 1, "{found:#?}");
    found.remove(0)
}
