//! Scenes built in code, for the tests of this crate.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use rt_camera::{CameraSettings, FilmSettings, FovAxis, Projection};
use rt_geometry::{Cuboid, InsideRule, MeshData, Plane, Polygon, Shape, Sphere, Triangle, TriangleMesh};
use rt_image::Image;
use rt_math::{DVec3, Rgb, Transform, Vec3};
use rt_render::{Checkpoint, Observer, PlanOptions, RenderPlan, RenderSnapshot, Rendering, RunOptions, StopRule};
use rt_scene_io::{
    Content, Group, GroupId, Integrator, MaterialId, MeshId, NamedCamera, NamedMesh, RenderSettings, Scene, SceneNode,
};
use rt_shading::{
    Appearance, Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, Material, Phong,
    Texture, TextureId, Transmission,
};

pub(crate) fn compile(scene: &Scene) -> RenderPlan<'_> {
    compile_with(scene, PlanOptions::default())
}

pub(crate) fn compile_with(scene: &Scene, options: PlanOptions) -> RenderPlan<'_> {
    RenderPlan::compile(scene, &options).expect("the scene compiles")
}

/// Options of a plan that leaves nothing out.
pub(crate) fn full() -> PlanOptions {
    PlanOptions { full: true, ..PlanOptions::default() }
}

pub(crate) fn render(scene: &Scene, options: PlanOptions, run: RunOptions<'_>) -> Rendering {
    compile_with(scene, options).render(&run, |_| {}).expect("threads start")
}

/// Image on this number of threads; 0 for one for each processor.
pub(crate) fn film_with(scene: &Scene, options: PlanOptions, threads: usize) -> Image {
    render(scene, options, RunOptions { threads, ..RunOptions::default() }).film
}

pub(crate) fn film(scene: &Scene) -> Image {
    film_with(scene, PlanOptions::default(), 0)
}

/// Observer that calls a function after each tile.
pub(crate) struct OnTile<F>(pub(crate) F);

impl<F: FnMut(&RenderSnapshot<'_>)> Observer for OnTile<F> {
    fn tile_done(&mut self, snapshot: &RenderSnapshot<'_>) {
        self.0(snapshot);
    }
}

/// Checkpoint after `kept_after` tiles of a render that is interrupted `killed_after` tiles after its start, and its result.
pub(crate) fn interrupted(
    plan: &RenderPlan<'_>,
    rule: Option<&StopRule>,
    from: Option<Checkpoint>,
    run: RunOptions<'_>,
    [kept_after, killed_after]: [u64; 2],
) -> (Vec<u8>, Rendering) {
    let interrupt = AtomicBool::new(false);
    let (mut tiles, mut checkpoint) = (0, Vec::new());
    let observer = OnTile(|snapshot: &RenderSnapshot<'_>| {
        tiles += 1;
        if tiles == kept_after {
            checkpoint = postcard::to_stdvec(&snapshot.checkpoint()).expect("written");
        }
        if tiles >= killed_after {
            interrupt.store(true, Ordering::Relaxed);
        }
    });
    let run = RunOptions { interrupt: Some(&interrupt), ..run };
    let shard = plan.render_shard(&run, rule, from, observer).expect("renders");
    (checkpoint, shard.into_rendering())
}

/// Camera with a vertical field of view in radians.
pub(crate) fn camera(eye: impl Into<DVec3>, target: impl Into<DVec3>, up: DVec3, fov: f64) -> CameraSettings {
    let world_from_camera = Transform::look_at(eye.into(), target.into(), up).expect("a view");
    CameraSettings::new(world_from_camera, Projection::Perspective { fov, axis: FovAxis::Vertical })
}

/// Scene before a black background, without lights.
pub(crate) fn scene(camera: CameraSettings, size: [u32; 2], materials: Vec<Material>, nodes: Vec<SceneNode>) -> Scene {
    let [width, height] = size;
    Scene {
        cameras: vec![NamedCamera { name: "main".into(), settings: camera, medium: None }],
        film: FilmSettings { width, height, ..FilmSettings::default() },
        appearance: Appearance { materials, ..Appearance::default() },
        nodes,
        ..Scene::empty("test")
    }
}

pub(crate) fn node(content: Content, material: u32) -> SceneNode {
    SceneNode::new(content, MaterialId(material))
}

pub(crate) fn node_at(content: Content, material: u32, parent_from_local: Transform) -> SceneNode {
    SceneNode { parent_from_local, ..node(content, material) }
}

pub(crate) fn mesh(name: &str, data: MeshData) -> NamedMesh {
    NamedMesh { name: name.into(), mesh: Arc::new(TriangleMesh::build(data).expect("a mesh").0) }
}

pub(crate) fn sphere(x: f64, y: f64, z: f64, radius: f64) -> Content {
    Content::Shape(Shape::Sphere(Sphere::new(DVec3::new(x, y, z), radius).expect("a sphere")))
}

pub(crate) fn plane(point: DVec3, normal: DVec3) -> Content {
    Content::Shape(Shape::Plane(Plane::new(point, normal).expect("a plane")))
}

pub(crate) fn cuboid(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Content {
    Content::Shape(Shape::Cuboid(Cuboid::new(min.into(), max.into()).expect("a box")))
}

pub(crate) fn point_light(position: [f64; 3], strength: f64) -> DeltaLight {
    let kind = DeltaLightKind::Point { position: position.into(), falloff: Falloff::None, shadow_near: 0.0 };
    DeltaLight::new(kind, Rgb::gray(strength))
}

fn material(name: &str, phong: Phong) -> Material {
    Material::new(name.into(), phong)
}

/// Emissive material that reflects nothing.
pub(crate) fn glowing(radiance: Rgb) -> Material {
    Material { emission: ColorTexture::Constant(radiance), ..material("glow", Phong::BLACK) }
}

fn gray(value: f64) -> ColorTexture {
    ColorTexture::Constant(Rgb::gray(value))
}

/// Diffuse spheres on a grid, two lights, a small image, and a camera at z = 9.
pub(crate) fn spheres() -> Scene {
    let grid = |i| [i % 3, i / 3 % 3, i / 9].map(|at| f64::from(at) - 1.0);
    let nodes = (0..27).map(grid).map(|[x, y, z]| node(sphere(x, y, z, 0.45), 0)).collect();
    let gray = material("grey", Phong { ambient: ColorTexture::ZERO, ..Phong::default() });
    let mut scene = scene(camera([1.0, 3.0, 9.0], [0.0; 3], DVec3::Y, 0.7), [61, 43], vec![gray], nodes);
    scene.name = "spheres".into();
    scene.settings.spp = 4;
    scene.appearance.lights = vec![point_light([5.0, 8.0, 6.0], 0.8), point_light([-5.0, 3.0, 6.0], 0.3)];
    scene.appearance.background = Background::Constant(Rgb::new(0.1, 0.2, 0.3));
    scene
}

/// Diffuse scene that path tracing shades in streams: small meshes, spheres, a plane, an emissive polygon and a point light. One mesh
/// has its triangles twice.
pub(crate) fn diffuse_shapes() -> Scene {
    let mut scene = spheres();
    let diffuse = |name: &str, [r, g, b]: [f64; 3]| {
        let diffuse = ColorTexture::Constant(Rgb::new(r, g, b));
        material(name, Phong { diffuse, ambient: ColorTexture::ZERO, ..Phong::default() })
    };
    let bright = Material { emission: gray(6.0), ..diffuse("bright", [0.5; 3]) };
    scene.appearance.materials = vec![diffuse("white", [0.7; 3]), diffuse("red", [0.8, 0.2, 0.1]), bright];
    scene.appearance.lights.truncate(1);
    let tent = [[-2.0, -1.5, -2.0], [2.0, -1.5, -2.0], [2.0, 1.5, -2.5], [-2.0, 1.5, -2.5], [0.0, 2.0, 0.5]];
    let positions: Vec<Vec3> = tent.map(Vec3::from_array).to_vec();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [2, 4, 3]];
    let mut smooth = MeshData { positions: positions.clone(), triangles: triangles.clone(), ..MeshData::default() };
    smooth.smooth_normals();
    let twice = MeshData { positions, triangles: triangles.repeat(2), ..MeshData::default() };
    scene.meshes = vec![mesh("twice", twice), mesh("smooth", smooth)];
    let corners = [[-1.0, 3.0, 0.0], [1.0, 3.0, 0.0], [1.0, 3.0, 1.5], [-1.0, 3.0, 1.5]].map(DVec3::from_array);
    let outline = Polygon::new(corners.to_vec(), Vec::new(), InsideRule::Convex).expect("a polygon");
    let mut smooth = node(Content::Mesh(MeshId(1)), 1);
    smooth.casts_shadow = false;
    scene.nodes = vec![
        node(Content::Mesh(MeshId(0)), 0),
        smooth,
        node(Content::Shape(Shape::Polygon(Arc::new(outline))), 2),
        node(plane(DVec3::NEG_Y * 1.5, DVec3::Y), 0),
        node(sphere(-0.8, -0.6, 1.0, 0.8), 1),
        node(sphere(1.2, -0.9, 1.5, 0.5), 0),
    ];
    scene.settings = RenderSettings { integrator: Integrator::Path, depth: 6, ..scene.settings };
    Scene { name: "diffuse shapes".into(), ..scene }
}

/// A bumpy sheet of 2·8² triangles over [−1, 1]², smooth and textured: too many to be inlined, and few for brute force.
fn sheet() -> MeshData {
    const N: u32 = 8;
    let mut data = MeshData::default();
    for j in 0..=N {
        for i in 0..=N {
            let (u, v) = (i as f32 / N as f32, j as f32 / N as f32);
            let height = 0.2 * ((i * 7 + j * 3) % 5) as f32 / 5.0;
            data.positions.push(Vec3::new(2.0 * u - 1.0, height, 1.0 - 2.0 * v));
            data.uvs.push([u, v]);
        }
    }
    for j in 0..N {
        for i in 0..N {
            let a = j * (N + 1) + i;
            data.triangles.push([a, a + 1, a + N + 2]);
            data.triangles.push([a, a + N + 2, a + N + 1]);
        }
    }
    data.smooth_normals();
    data
}

/// Scene with all features of the renderer.
///
/// It has all shapes with and without transforms, two instances of a mesh, nested groups, and all kinds of lights. Materials
/// include a mirror, glass and a texture; one object casts no shadow.
pub(crate) fn everything() -> Scene {
    let mut scene = spheres();
    scene.name = "everything".into();
    let glass = Transmission { coefficient: gray(1.0), fresnel: true };
    let whitted_glass = Transmission { coefficient: gray(0.8), fresnel: false };
    let clear = InteriorMedium::clear(1.5);
    let filled = |interior, material| Material { interior: Some(interior), ..material };
    let checker = ColorTexture::Textured(TextureId(0), Rgb::WHITE);
    scene.appearance.textures = vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::new(0.7, 0.1, 0.1), size: 0.25 }];
    scene.appearance.ambient = Rgb::gray(0.5);
    scene.appearance.materials = vec![
        material("plain", Phong { specular: gray(0.4), ..Phong::default() }),
        material("checker", Phong { diffuse: checker, ..Phong::default() }),
        material("mirror", Phong { mirror: gray(0.8), diffuse: gray(0.1), ..Phong::default() }),
        filled(
            InteriorMedium { absorption: Rgb::new(0.5, 0.1, 0.4), ..clear },
            material(
                "glass",
                Phong { mirror: gray(1.0), diffuse: ColorTexture::ZERO, transmission: Some(glass), ..Phong::default() },
            ),
        ),
        filled(
            clear,
            material("bubble", Phong { mirror: gray(0.1), transmission: Some(whitted_glass), ..Phong::default() }),
        ),
        Material { emission: gray(0.3), ..material("glow", Phong::default()) },
    ];
    scene.appearance.lights.push(DeltaLight::new(
        DeltaLightKind::Directional { direction: DVec3::new(0.3, -0.9, -0.3).normalize() },
        Rgb::gray(0.3),
    ));
    scene.appearance.lights.push(DeltaLight {
        casts_shadows: false,
        ..DeltaLight::new(
            DeltaLightKind::Spot {
                position: DVec3::new(0.0, 4.0, 2.0),
                direction: DVec3::NEG_Y,
                cos_inner: 0.95,
                cos_outer: 0.8,
                falloff: Falloff::InverseSquare,
            },
            Rgb::gray(4.0),
        )
    });
    scene.meshes = vec![mesh("sheet", sheet())];

    let moved = |x: f64, y: f64, z: f64| Transform::translate(DVec3::new(x, y, z));
    let turn = Transform::rotate(DVec3::new(1.0, 2.0, 0.5), 0.8).expect("an axis");
    let stretch = Transform::scale(DVec3::new(1.5, 0.6, -0.8)).expect("regular");
    let unit_box = || cuboid([-0.5; 3], [0.5; 3]);
    let triangle = Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]).expect("a triangle");
    let small = Transform::scale(DVec3::splat(0.3)).expect("regular");
    scene.groups = vec![
        Group {
            name: "pair".into(),
            nodes: vec![
                node(sphere(0.0, 0.0, 0.0, 1.0), 2),
                node_at(Content::Mesh(MeshId(0)), 1, moved(0.0, 1.0, 0.0)),
            ],
        },
        Group {
            name: "pairs".into(),
            nodes: vec![
                node_at(Content::Instance(GroupId(0)), 0, moved(0.0, 0.0, -1.5)),
                node_at(Content::Instance(GroupId(0)), 0, moved(2.0, 0.0, 0.0).compose(&turn)),
                node_at(unit_box(), 5, turn),
            ],
        },
    ];
    let mut shadowless = node(sphere(1.2, 0.2, 2.0, 0.4), 0);
    shadowless.casts_shadow = false;
    scene.nodes = vec![
        node(plane(DVec3::NEG_Y, DVec3::Y), 1),
        node_at(sphere(0.0, 0.0, 0.0, 0.8), 3, moved(-1.0, 0.0, 1.0)),
        node_at(sphere(0.0, 0.0, 0.0, 0.5), 4, moved(0.6, -0.4, 3.0)),
        node_at(sphere(0.0, 0.0, 0.0, 0.7), 0, moved(2.5, 0.0, -1.0).compose(&turn).compose(&stretch)),
        node_at(unit_box(), 2, moved(-2.5, 0.0, -1.0).compose(&turn)),
        node_at(Content::Shape(Shape::Triangle(triangle)), 5, moved(0.0, 1.0, -2.0).compose(&stretch)),
        node_at(Content::Mesh(MeshId(0)), 1, moved(0.0, 1.2, -1.0).compose(&turn)),
        node_at(Content::Instance(GroupId(1)), 0, moved(-2.5, -0.6, 2.0).compose(&small)),
        node_at(Content::Instance(GroupId(1)), 0, moved(2.0, -0.6, 2.0).compose(&turn).compose(&small)),
        shadowless,
    ];
    scene
}
