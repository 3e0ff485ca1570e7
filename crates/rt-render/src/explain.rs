//! Description of a plan: used and omitted features, with reasons.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use rt_accel::{Accelerator as _, AnyAccelerator};
use rt_geometry::Shape;
use rt_scene_io::{Integrator, LightSampling};
use rt_shading::{DeltaLight, PathSettings, Transport};

use crate::{
    MemoryPrediction, RenderPlan, RenderSpace,
    accel_choice::{MAX_LINEAR, MAX_LINEAR_SPHERES, reason},
    area_lights::{find_animated_light, named_object},
    camera_medium::CameraMedium,
    frustum_cull::VisibleSet,
    instance::{Aggregate, BottomLevel, Instance, InstanceGeometry},
    integrator::IntegratorState,
    world::World,
};

/// Feature that a plan leaves out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the feature.
    pub what: &'static str,
    /// Reason that the image does not depend on it.
    pub reason: String,
}

/// Description of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// One line: scene, integrator, camera, image, samples.
    pub title: String,
    /// Objects and features in use.
    pub used: Vec<String>,
    /// Features left out.
    pub left_out: Vec<LeftOut>,
    /// Predicted bytes of memory.
    pub memory: MemoryPrediction,
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        writeln!(f, "\nused")?;
        for line in &self.used {
            writeln!(f, "  {line}")?;
        }
        if !self.left_out.is_empty() {
            writeln!(f, "\nleft out")?;
            for LeftOut { what, reason } in &self.left_out {
                writeln!(f, "  {what}: {reason}")?;
            }
        }
        writeln!(f, "\npredicted memory\n  {}", self.memory)
    }
}

/// Position of a kind of shape in the list, with its name and plural.
type ShapeKind = (u8, &'static str, &'static str);

const TRIANGLE: ShapeKind = (3, "single triangle", "single triangles");
const TRANSFORMED: ShapeKind = (13, "transformed shape", "transformed shapes");

/// Numbers of objects in the flattened world, by kind.
#[derive(Debug, Default)]
struct SceneCounts {
    shapes: BTreeMap<ShapeKind, usize>,
    mesh_instances: usize,
    mesh_triangles: usize,
    meshes: usize,
    group_instances: usize,
    groups: usize,
    animated: usize,
    shadowless: usize,
    unbounded: usize,
    /// Objects with unused texture coordinates.
    plain: usize,
}

impl SceneCounts {
    fn of(world: &World) -> Self {
        let World { top, levels } = world;
        let mut counts = Self { meshes: levels.meshes.len(), groups: levels.groups.len(), ..Self::default() };
        counts.mesh_triangles = levels.meshes.iter().map(|m| m.mesh.data().triangles.len()).sum();
        top.all_instances(levels).for_each(|instance| counts.add(instance));
        counts
    }

    fn add(&mut self, instance: &Instance) {
        self.shadowless += usize::from(!instance.casts_shadow);
        self.plain += usize::from(!instance.textured);
        self.unbounded += usize::from(instance.bounds.is_none());
        self.animated += usize::from(matches!(instance.geometry, InstanceGeometry::Animated(_)));
        let kind = match instance.geometry.static_geometry() {
            InstanceGeometry::Shape(Shape::Sphere(_)) => (0, "sphere", "spheres"),
            InstanceGeometry::Shape(Shape::Cuboid(_)) => (1, "box", "boxes"),
            InstanceGeometry::Shape(Shape::Plane(_)) => (2, "plane", "planes"),
            InstanceGeometry::Shape(Shape::Triangle(_)) | InstanceGeometry::Triangle(_) => TRIANGLE,
            InstanceGeometry::Shape(Shape::Polygon(_)) => (4, "polygon", "polygons"),
            InstanceGeometry::Shape(Shape::Cylinder(_)) => (5, "cylinder", "cylinders"),
            InstanceGeometry::Shape(Shape::InfiniteCylinder(_)) => (6, "infinite cylinder", "infinite cylinders"),
            InstanceGeometry::Shape(Shape::DoubleCone(_)) => (7, "double cone", "double cones"),
            InstanceGeometry::Shape(Shape::Cone(_)) => (8, "cone", "cones"),
            InstanceGeometry::Shape(Shape::Frustum(_)) => (9, "frustum", "frusta"),
            InstanceGeometry::Shape(Shape::Disk(_)) => (10, "disk", "disks"),
            InstanceGeometry::Shape(Shape::Rectangle(_)) => (11, "rectangle", "rectangles"),
            InstanceGeometry::Shape(Shape::Torus(_)) => (12, "torus", "tori"),
            InstanceGeometry::TransformedShape(_) => TRANSFORMED,
            InstanceGeometry::Mesh(..) => return self.mesh_instances += 1,
            InstanceGeometry::Group(..) => return self.group_instances += 1,
            InstanceGeometry::Animated(_) => return,
        };
        *self.shapes.entry(kind).or_default() += 1;
    }

    fn of_kind(&self, kind: ShapeKind) -> usize {
        self.shapes.get(&kind).copied().unwrap_or(0)
    }
}

/// "1 sphere", "2 spheres".
fn count(n: usize, singular: &str, plural: &str) -> String {
    format!("{n} {}", if n == 1 { singular } else { plural })
}

/// Reason for what a scene without a light that `whitted` samples leaves out.
const NO_DELTA_LIGHT: &str = "the scene has no point, spot or directional light";

impl RenderPlan<'_> {
    /// Describes the plan. The text is deterministic.
    pub fn explain(&self) -> Explanation {
        let counts = SceneCounts::of(&self.scene.world);
        Explanation {
            title: self.title(),
            used: self.used(&counts),
            left_out: if self.options.full { Vec::new() } else { self.left_out(&counts) },
            memory: self.memory(),
        }
    }

    fn title(&self) -> String {
        let samples = count(self.samples_per_pixel() as usize, "sample", "samples");
        let samples = self.min_samples_per_pixel().map_or(samples.clone(), |min| format!("{min} to {samples}"));
        let passes = if self.frame.passes > 1 { format!(" in {} passes", self.frame.passes) } else { String::new() };
        let biased = if self.frame.sampler.is_biased() { " (biased)" } else { "" };
        format!(
            "plan for '{}': integrator {}, camera '{}', {}x{} pixels, {samples} per pixel{passes}, sampler {}{biased}",
            self.scene.source.name,
            self.integrator_kind().name(),
            self.camera_name,
            self.frame.crop.width,
            self.frame.crop.height,
            self.frame.sampler.name(),
        )
    }

    fn used(&self, counts: &SceneCounts) -> Vec<String> {
        let mut used: Vec<String> =
            counts.shapes.iter().map(|(&(_, singular, plural), n)| count(*n, singular, plural)).collect();
        if counts.mesh_instances > 0 {
            used.push(format!(
                "{} of {} with {}",
                count(counts.mesh_instances, "instance", "instances"),
                count(counts.meshes, "mesh", "meshes"),
                count(counts.mesh_triangles, "triangle", "triangles"),
            ));
        }
        if counts.group_instances > 0 {
            let instances = count(counts.group_instances, "instance", "instances");
            used.push(format!("{instances} of {}", count(counts.groups, "group", "groups")));
        }
        if used.is_empty() {
            used.push("no objects".to_owned());
        }
        used.extend(self.accelerators());
        if self.frame.has_motion {
            used.extend(self.motion(counts));
        }
        if self.frame.backdrop.is_some() {
            used.push("backdrop: shown instead of the background by camera rays that hit nothing".to_owned());
        }
        if self.frame.camera.has_lens() {
            used.push("lens: camera rays start at points sampled on the aperture".to_owned());
        }
        if self.integrator_kind().follows_light() {
            used.extend(self.light());
        }
        used.extend(self.light_paths());
        if let Some(min) = self.min_samples_per_pixel() {
            used.push(format!(
                "adaptive sampling in object space: {} in pixels without edges of objects or shadows, all samples in others",
                count(min as usize, "sample", "samples")
            ));
        }
        used
    }

    fn motion(&self, counts: &SceneCounts) -> Vec<String> {
        let [first, last] = self.scene.source.shutter_interval.unwrap_or([0.0, 1.0]);
        let [opens, closes] = self.frame.camera.shutter().map(|time| first * (1.0 - time) + last * time);
        let mut lines = vec![format!(
            "motion blur: each sample has its own time, from {opens} to {closes} in fractions of a frame"
        )];
        if counts.animated > 0 {
            let what = count(counts.animated, "animated object", "animated objects");
            lines.push(format!("{what}: bounding boxes enclose the whole motion"));
        }
        if self.frame.camera.moves() {
            lines.push("animated camera: camera rays are tested against all objects".to_owned());
        }
        if let IntegratorState::Path(_) = &self.integrator {
            let World { top, levels } = &self.scene.world;
            let light = find_animated_light(self.scene.source, top, levels);
            lines.extend(light.map(|name| {
                let object = named_object(&name);
                format!("moving emitters, such as {object}: found by BSDF samples, not sampled explicitly")
            }));
        }
        lines
    }

    /// Line on light tracing.
    fn light_paths(&self) -> Option<String> {
        let sources = self.scene.light_sources.as_ref()?;
        let [width, height] = self.frame.size.map(u64::from);
        let paths = width * height * u64::from(self.frame.pass_spp);
        let directions = if sources.projection_map().is_everywhere() {
            "in all directions, because a specular surface is unbounded".to_owned()
        } else {
            let spheres = count(sources.projection_map().len(), "bounding sphere", "bounding spheres");
            format!("towards {spheres} of specular surfaces")
        };
        Some(format!("light tracing: {paths} light paths per pass, emitted {directions}"))
    }

    fn accelerators(&self) -> Vec<String> {
        let accel_options = self.scene.accel;
        let line = |level: &str, accelerator: &AnyAccelerator, primitives: usize, reason: String| {
            let primitives = count(primitives, "primitive", "primitives");
            let nodes = match accelerator.build_stats().nodes {
                0 => String::new(),
                nodes => format!(", {}", count(nodes, "node", "nodes")),
            };
            format!("{level}: {} over {primitives}{nodes} ({reason})", accelerator.kind().name())
        };
        // Apply the selection rule again to the primitives of each accelerator.
        let aggregate = |level: &str, aggregate: &Aggregate, levels: &BottomLevel| {
            let reason = reason(accel_options, &aggregate.set(levels));
            line(level, &aggregate.accelerator, aggregate.instances.len(), reason)
        };
        let visible = |reason: &dyn Fn(&VisibleSet) -> String| {
            let visible = self.frame.visible.as_ref()?;
            Some(line(
                "  objects in view, for camera rays",
                visible.accelerator(),
                visible.of() - visible.left_out(),
                reason(visible),
            ))
        };
        let World { top, levels } = &self.scene.world;
        let mut lines = vec![aggregate("accelerator", top, levels)];
        lines.extend(visible(&|visible| visible.reason(accel_options, &top.set(levels))));
        lines.extend(levels.groups.iter().map(|group| aggregate("  group", group, levels)));
        lines.extend(levels.meshes.iter().map(|level| {
            let reason = reason(accel_options, &*level.mesh);
            let kind = if level.alpha_test.is_some() { "  mesh with alpha test" } else { "  mesh" };
            line(kind, &level.accelerator, level.mesh.data().triangles.len(), reason)
        }));
        if self.frame.culls_tiles {
            lines.push(format!(
                "  tiles with at most {MAX_LINEAR} objects, or {MAX_LINEAR_SPHERES} spheres, in view: brute force for camera rays"
            ));
        }
        if (self.scene.features.shadows || !self.scene.lights.sampled_lights().is_empty()) && self.has_wide_tree() {
            lines.push("  shadow rays: the last occluder is tested first".to_owned());
        }
        if self.scene.space != RenderSpace::WORLD {
            lines.push(format!(
                "rendering space: relative to {}, because the scene is small and far from the origin",
                self.scene.space.origin()
            ));
        }
        lines
    }

    fn has_wide_tree(&self) -> bool {
        let is_wide = |accelerator: &AnyAccelerator| matches!(accelerator, AnyAccelerator::Wide(_));
        let World { top, levels } = &self.scene.world;
        is_wide(&top.accelerator)
            || levels.groups.iter().any(|group| is_wide(&group.accelerator))
            || levels.meshes.iter().any(|mesh| is_wide(&mesh.accelerator))
    }

    fn light(&self) -> Vec<String> {
        let lights = &self.scene.appearance.lights;
        let shadowing = lights.iter().filter(|light| light.casts_shadows).count();
        let mut lines = vec![match (lights.len(), shadowing) {
            (0, _) => "no delta lights".to_owned(),
            (n, shadowing) => format!("{}, {shadowing} with shadows", count(n, "delta light", "delta lights")),
        }];
        if let IntegratorState::Path(settings) = &self.integrator {
            lines.extend(self.extended_lights());
            lines.push(self.paths(settings));
        } else if self.scene.features.reflection || self.scene.features.refraction {
            lines.push(format!(
                "ray tree of up to {} after the first hit",
                count(self.scene.source.settings.depth as usize, "bounce", "bounces")
            ));
        }
        if self.scene.features.refraction {
            lines.extend(self.nesting());
        }
        lines
    }

    /// Line on area and environment lights.
    fn extended_lights(&self) -> Option<String> {
        let lights = self.scene.lights.sampled_lights().len();
        (lights > 0).then(|| {
            let choice = match (lights, self.scene.source.settings.light_sampling) {
                (1, _) => "sampled at each hit",
                (_, LightSampling::Uniform) => "one is sampled at each hit, with equal probability",
                (_, LightSampling::Power) => "one is sampled at each hit, with probability proportional to its power",
                (_, LightSampling::Tree) => "one is sampled at each hit, by a light tree",
            };
            let environment = usize::from(self.scene.lights.environment().is_some());
            let areas = count(lights - environment, "area light", "area lights");
            let kinds = match (lights - environment, environment) {
                (_, 0) => areas,
                (0, _) => "environment light".to_owned(),
                _ => format!("{areas} and the environment light"),
            };
            format!("{kinds}: {choice}")
        })
    }

    fn paths(&self, settings: &PathSettings) -> String {
        let bounces = count(settings.max_depth as usize, "bounce", "bounces");
        let what = match settings.transport {
            Transport::Full | Transport::NonCaustic => "paths",
            Transport::Specular | Transport::SpecularWithEmitters => "specular and glossy paths",
        };
        let roulette = if settings.max_depth > settings.rr_start_depth {
            format!(", Russian roulette after {}", count(settings.rr_start_depth as usize, "bounce", "bounces"))
        } else {
            String::new()
        };
        let clamp = match self.clamp() {
            Some(clamp) => format!(", indirect light clamped to {clamp} (biased)"),
            None => String::new(),
        };
        format!("{what} of up to {bounces} after the first hit{roulette}{clamp}")
    }

    /// Line on overlapping dielectrics and the medium of the camera; `None` for thin dielectrics only.
    fn nesting(&self) -> Option<String> {
        let transparent = self.scene.appearance.materials.iter().filter_map(|material| material.interior);
        let priorities: BTreeSet<i32> = transparent.map(|inside| inside.priority).collect();
        let (min, max) = (priorities.first()?, priorities.last()?);
        let order = if min < max { format!("priorities {min} to {max}") } else { "all of equal priority".to_owned() };
        let camera = match &self.frame.medium {
            CameraMedium::Constant(interior) if interior.is_empty() => "the camera is outside of all",
            CameraMedium::Constant(_) => "the camera is inside of a dielectric",
            CameraMedium::PerRay(_) => "the medium of each camera ray is determined at its origin",
        };
        Some(format!("nested dielectrics: {order}; {camera}"))
    }

    fn left_out(&self, counts: &SceneCounts) -> Vec<LeftOut> {
        let triangles = counts.of_kind(TRIANGLE) + counts.mesh_triangles;
        let whitted = self.integrator_kind() == Integrator::Whitted;
        let lit = !self.scene.appearance.lights.is_empty();
        let n = &self.scene.features;
        let linear = matches!(self.scene.world.top.accelerator, AnyAccelerator::Linear(_));
        let geometry = [
            (triangles == 0, "triangles", "the scene has none"),
            (
                counts.of_kind(TRANSFORMED) + counts.mesh_instances + counts.group_instances == 0,
                "transforms",
                "all shapes are given in world space",
            ),
            (counts.group_instances == 0, "instances of groups", "no group has more than one instance"),
            (counts.unbounded == 0, "list of unbounded objects", "all objects are bounded"),
            (linear, "tree over the objects", "brute force tests all of them"),
            (counts.shadowless == 0, "shadow flags of objects", "every object casts shadows"),
            (!self.frame.transparent, "alpha channel", "the background is part of the image"),
            (!self.frame.has_motion, "motion blur", "nothing moves while the shutter is open"),
            (!self.frame.camera.has_lens(), "lens", "the camera is a pinhole camera or orthographic"),
        ];
        let surface = [
            (
                !n.textures && self.integrator_kind() != Integrator::Uv,
                "texture coordinates",
                "no material uses textures",
            ),
            (
                n.textures && counts.plain > 0,
                "texture coordinates of some surfaces",
                "their materials have no textures",
            ),
            (!n.shading_normals, "interpolated normals", "no mesh has vertex normals"),
        ];
        let shading = [
            (!n.textures, "textures", "no material has one"),
            (!n.ambient, "ambient light", "the scene has none, or no material reflects it"),
            (!n.emission, "emission", "no surface is emissive"),
            (!n.highlights, "highlights", if lit { "no material has one" } else { NO_DELTA_LIGHT }),
            (!n.shadows, "shadow rays", if lit { "no light, or no object, casts shadows" } else { NO_DELTA_LIGHT }),
            (!n.reflection, "reflection", "no material is reflective"),
            (!n.refraction, "refraction", "no material is transmissive"),
            (!n.refraction, "nested dielectrics", "no object is a dielectric"),
            (n.refraction && !n.fresnel, "Fresnel equations", "the reflectance of transmissive materials is constant"),
            (n.refraction && !n.absorption, "absorption", "all dielectrics are clear"),
            (!n.reflection && !n.refraction, "ray tree", "no material spawns secondary rays"),
        ];
        let is_path = matches!(self.integrator, IntegratorState::Path(_));
        let of_paths = [
            (!n.textures, "textures", "no material has one"),
            (!n.emission, "emission", "no surface is emissive"),
            (self.scene.lights.sampled_lights().is_empty(), "area and environment lights", "none can be sampled"),
            (!n.refraction, "nested dielectrics", "no object is a dielectric"),
            (n.refraction && !n.absorption, "absorption", "all dielectrics are clear"),
        ];
        let listed = geometry.into_iter().chain(surface).chain(shading.into_iter().filter(|_| whitted));
        let listed = listed.chain(of_paths.into_iter().filter(|_| is_path));
        let mut left_out: Vec<LeftOut> = listed
            .filter(|(left, ..)| *left)
            .map(|(_, what, reason)| LeftOut { what, reason: reason.to_owned() })
            .collect();
        if let Some(visible) = &self.frame.visible {
            let reason = format!("{} of {} lie outside the view", visible.left_out(), visible.of());
            left_out.push(LeftOut { what: "objects, for camera rays", reason });
        }
        let (alike, used) = self.scene.bsdfs.count();
        if alike > 0 {
            let materials = count(used, "material", "materials");
            let reason = format!("{alike} of {materials} are uniform: their BSDFs are cached");
            let what = if alike == used { "BSDF construction at hits" } else { "BSDF construction at some hits" };
            left_out.push(LeftOut { what, reason });
        }
        left_out.extend(self.light_paths_left_out());
        if !self.integrator_kind().follows_light() {
            left_out.push(LeftOut {
                what: "light and materials",
                reason: format!("'{}' shows geometry only", self.integrator_kind().name()),
            });
        }
        left_out
    }

    fn light_paths_left_out(&self) -> Option<LeftOut> {
        if self.integrator_kind() != Integrator::Caustics {
            return None;
        }
        let of = |what, reason: &str| Some(LeftOut { what, reason: reason.to_owned() });
        let Some(sources) = &self.scene.light_sources else {
            return of("light paths", "no light that can be sampled illuminates a specular surface");
        };
        let is_sun = |light: &DeltaLight| light.kind.position().is_none() && light.casts_shadows;
        if sources.projection_map().is_everywhere() && self.scene.appearance.lights.iter().any(is_sun) {
            return of("light paths of directional lights", "a specular surface is unbounded");
        }
        match self.scene.lights.environment() {
            Some(_) => of("light paths of the environment", "paths from the camera find its light"),
            None => None,
        }
    }
}
