//! Area lights: emissive objects of the world that are sampled.

use rt_geometry::{Polygon, Shape, TriangleMesh};
use rt_math::{Aabb, DVec3, Rgb, Transform};
use rt_scene_io::Scene;
use rt_shading::{
    AlphaMode, ColorTexture,
    light::{CylinderLight, DiskLight, Emission, Light, MeshLight, QuadLight, SphereLight},
};

use crate::instance::{Aggregate, BottomLevel, Instance, InstanceGeometry, uses_material};

/// Tolerance of the parallelogram test, as a fraction of the side.
const SQUARENESS: f64 = 1e-9;

/// Makes area lights of all uniformly emissive instances and stores their indices. Other emissive surfaces are found by rays only:
/// textured, coated and animated ones, tori, and what casts no shadow and hides parts of itself.
pub(crate) fn area_lights(scene: &Scene, top: &mut Aggregate, levels: &mut BottomLevel) -> Vec<Light> {
    // Instances in a group store the index within the group; a group instance stores the index of its first light.
    let of_groups: Vec<AreaLights> = levels
        .groups
        .iter()
        .map(|group| AreaLights::of(scene, &group.instances, (&Transform::IDENTITY, true), levels))
        .collect();
    let AreaLights { lights: mut collected, numbers } =
        AreaLights::of(scene, &top.instances, (&Transform::IDENTITY, true), levels);
    for (instance, number) in top.instances.iter_mut().zip(numbers) {
        instance.light = number;
        if let InstanceGeometry::Group(level, transform) = &instance.geometry {
            let transform = transform.as_deref().copied().unwrap_or(Transform::IDENTITY);
            let placed = (&transform, instance.casts_shadow);
            let placed = AreaLights::of(scene, &levels.groups[*level as usize].instances, placed, levels);
            // A transform, or shadows that are left out, may turn an area light into a surface that is not sampled.
            if !placed.lights.is_empty() && placed.numbers == of_groups[*level as usize].numbers {
                instance.light = Some(collected.len() as u32);
                collected.extend(placed.lights);
            }
        }
    }
    for (group, lights) in levels.groups.iter_mut().zip(of_groups) {
        for (instance, number) in group.instances.iter_mut().zip(lights.numbers) {
            instance.light = number;
        }
    }
    collected
}

/// Name of an animated emissive object, if there is one.
pub(crate) fn find_animated_light(scene: &Scene, top: &Aggregate, levels: &BottomLevel) -> Option<String> {
    let emits = |material: u32| {
        let material = scene.appearance.materials.get(material as usize);
        material.is_some_and(|material| !material.emission.is_zero())
    };
    let mut animated = top.all_instances(levels).filter(|instance| instance.has_motion());
    animated.find(|instance| uses_material(instance, levels, &emits)).map(|instance| instance.name.to_string())
}

/// True if a surface emits light and is not sampled: only rays find it.
pub(crate) fn has_unsampled_emitters(scene: &Scene, top: &Aggregate, levels: &BottomLevel) -> bool {
    let emits = |instance: &Instance| {
        let material = scene.appearance.materials.get(instance.material as usize);
        material.is_some_and(|material| !material.emission.is_zero())
    };
    top.instances.iter().any(|instance| match (instance.geometry.group(), instance.light) {
        (None, light) => light.is_none() && emits(instance),
        // A group that has an index stores sampled lights by their own.
        (Some(group), light) => {
            let mut inner = levels.groups[group as usize].instances.iter();
            inner.any(|inner| emits(inner) && (light.is_none() || inner.light.is_none()))
        }
    })
}

/// Object by its name, which may be empty, for messages.
pub(crate) fn named_object(name: &str) -> String {
    if name.is_empty() { "an object without a name".to_owned() } else { format!("object '{name}'") }
}

/// Area lights among some instances.
struct AreaLights {
    lights: Vec<Light>,
    /// Light index by instance.
    numbers: Vec<Option<u32>>,
}

impl AreaLights {
    /// Lights of instances that are placed by a transform, and cast shadows if `casts_shadows` is true.
    fn of(
        scene: &Scene,
        instances: &[Instance],
        (world_from_parts, casts_shadows): (&Transform, bool),
        levels: &BottomLevel,
    ) -> Self {
        let mut found = Self { lights: Vec::new(), numbers: Vec::with_capacity(instances.len()) };
        let mut before = None;
        for instance in instances {
            // The inlined triangles of a mesh follow each other, and are one light.
            let number = match (&instance.geometry, before) {
                (InstanceGeometry::Triangle(_), Some((object, number))) if object == instance.object => number,
                _ => {
                    let light = light_of(scene, instance, world_from_parts, levels);
                    let is_opaque = casts_shadows && instance.casts_shadow;
                    light.filter(|light| is_opaque || !may_hide_itself(light)).map(|light| {
                        found.lights.push(light);
                        found.lights.len() as u32 - 1
                    })
                }
            };
            found.numbers.push(number);
            before = Some((instance.object, number));
        }
        found
    }
}

/// Emission of an instance, if it is uniform.
fn emission_of(scene: &Scene, instance: &Instance) -> Option<Emission> {
    if matches!(instance.geometry, InstanceGeometry::Group(..)) {
        return None;
    }
    let material = scene.appearance.materials.get(instance.material as usize)?;
    let ColorTexture::Constant(radiance) = material.emission else { return None };
    // The whole surface is sampled, with the same radiance in all directions. Others are found by rays only.
    if material.alpha.mode != AlphaMode::Opaque || material.has_coated_emission() {
        return None;
    }
    (radiance != Rgb::BLACK).then(|| Emission::new(radiance, material.emission_sides).ok())?
}

/// True if parts of a light may lie behind others. Light samples of an object that casts no shadow would pass it, and rays that find
/// the light would not.
fn may_hide_itself(light: &Light) -> bool {
    match light {
        Light::Mesh(mesh) => mesh.may_hide_itself(),
        Light::Cylinder(cylinder) => cylinder.may_hide_itself(),
        _ => false,
    }
}

/// Light of an instance in a transformed aggregate.
fn light_of(scene: &Scene, instance: &Instance, outer: &Transform, levels: &BottomLevel) -> Option<Light> {
    let emission = emission_of(scene, instance)?;
    match &instance.geometry {
        InstanceGeometry::Shape(shape) => light_of_shape(shape, outer, emission),
        InstanceGeometry::TransformedShape(placed) => {
            light_of_shape(placed.shape(), &outer.compose(placed.world_from_local()), emission)
        }
        InstanceGeometry::Mesh(level, transform) => {
            let inner = transform.as_deref().copied().unwrap_or(Transform::IDENTITY);
            light_of_mesh(&levels.meshes[*level as usize].mesh, &outer.compose(&inner), emission)
        }
        InstanceGeometry::Triangle(triangle) => light_of_mesh(&triangle.mesh, outer, emission),
        InstanceGeometry::Group(..) | InstanceGeometry::Animated(_) => None,
    }
}

fn light_of_shape(shape: &Shape, world_from_local: &Transform, emission: Emission) -> Option<Light> {
    let at = |point: DVec3| world_from_local.point(point);
    match shape {
        Shape::Sphere(sphere) => {
            let radius = sphere.radius() * world_from_local.uniform_scale()?;
            SphereLight::new(at(sphere.centre()), radius, emission).ok().map(Light::Sphere)
        }
        Shape::Disk(disk) => {
            let scale = world_from_local.uniform_scale()?;
            let normal = world_from_local.normal(DVec3::Y).normalize();
            let (radius, inner) = (disk.radius() * scale, disk.inner_radius() * scale);
            DiskLight::new(at(DVec3::ZERO), normal, radius, inner, emission).ok().map(Light::Disk)
        }
        Shape::Cylinder(cylinder) => {
            let radius = cylinder.radius() * world_from_local.uniform_scale()?;
            let [base, top] = cylinder.heights().map(|y| at(DVec3::Y * y));
            CylinderLight::new(base, top, radius, cylinder.has_caps(), emission).ok().map(Light::Cylinder)
        }
        Shape::Rectangle(rectangle) => {
            let (x, z) = (0.5 * rectangle.width(), 0.5 * rectangle.depth());
            let corners = [[-x, z], [x, z], [x, -z], [-x, -z]].map(|[x, z]| at(DVec3::new(x, 0.0, z)));
            quad(corners, world_from_local.normal(DVec3::Y), emission)
        }
        Shape::Polygon(polygon) => light_of_polygon(polygon, world_from_local, emission),
        Shape::Triangle(triangle) => mesh([triangle.vertices()], world_from_local, emission),
        // The faces of a flat box would coincide.
        Shape::Cuboid(axis_box) if axis_box.bounds().extent().min_element() > 0.0 => {
            mesh(faces_of(&axis_box.bounds()), world_from_local, emission)
        }
        _ => None,
    }
}

/// The parallelogram of four corners in order; `None` if they are none.
fn quad([a, b, c, d]: [DVec3; 4], normal: DVec3, emission: Emission) -> Option<Light> {
    let size = (b - a).length().max((d - a).length());
    if !((a + c - b - d).length() <= SQUARENESS * size) {
        return None;
    }
    let edges = if (b - a).cross(d - a).dot(normal) > 0.0 { [b - a, d - a] } else { [d - a, b - a] };
    QuadLight::new(a, edges, emission).ok().map(Light::Quad)
}

/// A polygon without dents and holes.
fn light_of_polygon(polygon: &Polygon, world_from_local: &Transform, emission: Emission) -> Option<Light> {
    let mut rings = polygon.rings();
    let (Some(form), None) = (rings.next(), rings.next()) else { return None };
    if let [a, b, c, d] = form {
        let corners = [a, b, c, d].map(|corner| world_from_local.point(*corner));
        if let Some(light) = quad(corners, world_from_local.normal(polygon.normal()), emission) {
            return Some(light);
        }
    }
    let next = |i: usize| form[i % form.len()];
    let turns_left = |i: usize| (next(i + 1) - next(i)).cross(next(i + 2) - next(i + 1)).dot(polygon.normal()) >= 0.0;
    let fan = (1..form.len() - 1).map(|i| [form[0], form[i], form[i + 1]]);
    // An outline that winds more than once turns left everywhere, but its fan has reversed triangles.
    let is_fan = (0..form.len()).all(turns_left)
        && fan.clone().all(|[a, b, c]| (b - a).cross(c - a).dot(polygon.normal()) >= 0.0);
    if is_fan { mesh(fan, world_from_local, emission) } else { None }
}

fn light_of_mesh(source: &TriangleMesh, world_from_local: &Transform, emission: Emission) -> Option<Light> {
    let data = source.data();
    if let ([a, b, c, d], [[0, 1, 2], [0, 2, 3]]) = (&data.positions[..], &data.triangles[..]) {
        let corners = [a, b, c, d].map(|corner| world_from_local.point(corner.as_dvec3()));
        let front = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let front = if world_from_local.flips_handedness() { -front } else { front };
        if let Some(light) = quad(corners, front, emission) {
            return Some(light);
        }
    }
    let vertex = |index: u32| data.positions[index as usize].as_dvec3();
    mesh(data.triangles.iter().map(|triangle| triangle.map(vertex)), world_from_local, emission)
}

/// Mesh light of triangles whose vertices are counter-clockwise in local space, seen from the front.
fn mesh(
    triangles: impl IntoIterator<Item = [DVec3; 3]>,
    world_from_local: &Transform,
    emission: Emission,
) -> Option<Light> {
    let flips = world_from_local.flips_handedness();
    let placed = triangles.into_iter().map(|triangle| {
        let [a, b, c] = triangle.map(|vertex| world_from_local.point(vertex));
        if flips { [a, c, b] } else { [a, b, c] }
    });
    MeshLight::new(placed, emission).ok().map(Light::Mesh)
}

/// The twelve triangles of a box.
fn faces_of(bounds: &Aabb) -> impl Iterator<Item = [DVec3; 3]> {
    let corners = bounds.corners();
    let corner = |x: usize, y: usize, z: usize| corners[x | y << 1 | z << 2];
    let quads = [
        [corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)],
        [corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)],
        [corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)],
        [corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)],
        [corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)],
        [corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)],
    ];
    quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
}
