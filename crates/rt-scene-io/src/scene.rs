//! Resolved scene: plain data without unresolved paths or names.

#[cfg(feature = "format")]
use std::collections::BTreeSet;
use std::{fmt, sync::Arc};

use rt_camera::{CameraSettings, FilmSettings, SamplerKind};
use rt_geometry::{Shape, TriangleMesh};
use rt_math::{AnimatedTransform, AnimatedTransformChain, AnimatedTransformError, Rgb, Transform};
use rt_shading::{Appearance, light::LightSampling};
#[cfg(feature = "format")]
use rt_shading::{ColorTexture, Texture};

use crate::sanitize::SingleLine;

pub use rt_shading::{Background, Material};

/// Index of a material in [`Appearance::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// Index of a mesh in [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(pub u32);

/// Index of a group in [`Scene::groups`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GroupId(pub u32);

/// Lists all variants of an enum and their names.
macro_rules! names {
    ($type:ident, $count:literal: $($variant:ident $name:literal)+) => {
        impl $type {
            /// All variants.
            pub const ALL: [Self; $count] = [$(Self::$variant),+];

            /// Name on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

names! {
    Integrator, 11: Whitted "whitted" Distributed "distributed" Path "path" Caustics "path-caustics"
        PathReference "path-reference" Direct "direct" AmbientOcclusion "ambient-occlusion" Normals "normals" Depth "depth" Uv "uv" Cost "cost"
}
names! {
    Accel, 11: Auto "auto" Linear "linear" Grid "grid" Bvh "bvh" Wide "bvh8" Spheres "sphere-tree" Cylinders "cylinder-tree"
        Kd "kd" Bsp "bsp" Bih "bih" BihLazy "bih-lazy"
}

/// Method by which light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "format", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "format", serde(rename_all = "snake_case"))]
pub enum Integrator {
    /// Recursive ray tracing (Whitted 1980).
    Whitted,
    /// Distribution ray tracing: soft shadows, glossy reflection, rough glass (Cook et al. 1984).
    Distributed,
    /// Path tracing: all light (Kajiya 1986).
    Path,
    /// Path tracing, with light tracing for caustics (Arvo 1986).
    #[cfg_attr(feature = "format", serde(rename = "path_caustics", alias = "caustics"))]
    Caustics,
    /// The image of `path`, computed one path at a time by the code to read first.
    PathReference,
    /// Emission and direct light.
    Direct,
    /// Share of the sky that is visible from each point.
    #[cfg_attr(feature = "format", serde(alias = "ao"))]
    AmbientOcclusion,
    /// Shading normals as colours: (n + 1) / 2.
    Normals,
    /// Distance along the view axis: nearest white, farthest black.
    Depth,
    /// Texture coordinates as red and green.
    Uv,
    /// Work per ray as a heat map.
    Cost,
}

impl Integrator {
    /// True if it samples directions at random: images are noisy everywhere, not only at edges.
    pub const fn is_stochastic(self) -> bool {
        match self {
            Self::Whitted | Self::Normals | Self::Depth | Self::Uv | Self::Cost => false,
            Self::Distributed
            | Self::Path
            | Self::Caustics
            | Self::PathReference
            | Self::Direct
            | Self::AmbientOcclusion => true,
        }
    }

    /// True if it shows light, and not a view of the geometry.
    pub const fn follows_light(self) -> bool {
        matches!(self, Self::Whitted) || self.samples_area_lights()
    }

    /// True if diffuse surfaces take light from the background.
    pub const fn gathers_background(self) -> bool {
        matches!(self, Self::Path | Self::Caustics | Self::PathReference | Self::Direct)
    }

    /// True if it samples area lights.
    pub const fn samples_area_lights(self) -> bool {
        matches!(self, Self::Distributed) || self.gathers_background()
    }
}

/// Acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "format", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "format", serde(rename_all = "snake_case"))]
pub enum Accel {
    /// Chosen by the scene.
    #[default]
    Auto,
    /// None: all objects are tested.
    Linear,
    /// Uniform grid.
    Grid,
    /// Binary bounding volume hierarchy.
    Bvh,
    /// Bounding volume hierarchy with eight children per node.
    #[cfg_attr(feature = "format", serde(rename = "bvh8", alias = "wide"))]
    Wide,
    /// Tree of bounding spheres.
    #[cfg_attr(feature = "format", serde(rename = "sphere_tree", alias = "spheres"))]
    Spheres,
    /// Tree of bounding cylinders.
    #[cfg_attr(feature = "format", serde(rename = "cylinder_tree", alias = "cylinders"))]
    Cylinders,
    /// k-d tree.
    Kd,
    /// Binary space partition: planes of any direction.
    Bsp,
    /// Bounding interval hierarchy.
    Bih,
    /// Bounding interval hierarchy, built during traversal.
    BihLazy,
}

/// Distribution of samples among pixels, if not uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdaptiveSampling {
    /// By the objects in the pyramid of a pixel (Genetti, Gordon and Williams 1998). Pixels without edges of objects or shadows
    /// take fewer samples.
    ObjectSpace {
        /// Samples of a pixel without edges; a quarter of all if `None`. Patterns may round it up.
        min_spp: Option<u32>,
    },
}

impl AdaptiveSampling {
    /// Samples of a pixel without edges, of `spp` in other pixels.
    pub const fn simple_spp(self, spp: u32) -> u32 {
        match self {
            Self::ObjectSpace { min_spp: Some(min_spp) } => min_spp,
            Self::ObjectSpace { min_spp: None } => spp.div_ceil(4),
        }
    }
}

/// Render settings of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Integrator.
    pub integrator: Integrator,
    /// Sample pattern.
    pub pattern: SamplerKind,
    /// Samples per pixel; some patterns round it up.
    pub spp: u32,
    /// Independent passes for the error estimate; chosen by the plan if `None`.
    pub passes: Option<u32>,
    /// Distribution of samples among pixels; uniform if `None`.
    pub adaptive: Option<AdaptiveSampling>,
    /// Bounces after the first hit.
    pub depth: u32,
    /// Rays whose contribution to the pixel falls below this are not followed. 0 follows all.
    pub min_contribution: f64,
    /// Acceleration structure.
    pub accel: Accel,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Selection of one of many area lights.
    pub light_sampling: LightSampling,
    /// Bounces before Russian roulette may end a path.
    pub rr_start_depth: u32,
    /// Largest component of a contribution of indirect light, in units of radiance; unbounded and without bias if `None`.
    pub clamp: Option<f64>,
    /// Maximum distance of occluders for ambient occlusion, in world units; may be infinite.
    pub occlusion_distance: f64,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            integrator: Integrator::Whitted,
            pattern: SamplerKind::Sobol,
            spp: 16,
            passes: None,
            adaptive: None,
            depth: 5,
            min_contribution: 0.0,
            accel: Accel::Auto,
            seed: 0,
            light_sampling: LightSampling::default(),
            rr_start_depth: 3,
            clamp: None,
            occlusion_distance: f64::INFINITY,
        }
    }
}

/// A camera that `--camera` can choose.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Unique within the scene.
    pub name: String,
    /// The camera.
    pub settings: CameraSettings,
    /// Dielectric around the camera; determined from the closed surfaces around it if `None`.
    pub medium: Option<MaterialId>,
}

/// A mesh that nodes refer to.
#[derive(Clone, Debug)]
pub struct NamedMesh {
    /// Name for messages.
    pub name: String,
    /// The triangles.
    pub mesh: Arc<TriangleMesh>,
}

/// A subtree that is described once and placed many times.
#[derive(Clone, Debug)]
pub struct Group {
    /// Unique within the scene.
    pub name: String,
    /// Nodes, in the space of the group.
    pub nodes: Vec<SceneNode>,
}

/// Content of a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A single shape.
    Shape(Shape),
    /// A triangle mesh.
    Mesh(MeshId),
    /// A group. Groups may contain instances of other groups, never of themselves.
    Instance(GroupId),
}

/// Node of the tree.
#[derive(Debug)]
pub struct SceneNode {
    /// Name for messages; may be empty.
    pub name: String,
    /// Takes this node's space to its parent's; where it moves, at time 0.
    pub parent_from_local: Transform,
    /// Transform at time 1, if the node moves.
    pub moves_to: Option<Transform>,
    /// Shape, mesh or instance at this node.
    pub content: Option<Content>,
    /// Material of a shape or mesh here. Instances keep the materials of their group.
    pub material: MaterialId,
    /// True if it casts shadows. `false` applies to all nodes below.
    pub casts_shadow: bool,
    /// True if the nodes below come from a file with left-handed coordinates, which `parent_from_local` reflects: their
    /// image is no mirror image.
    pub is_left_handed: bool,
    /// Nodes below.
    pub children: Vec<SceneNode>,
}

/// Without recursion: trees are as deep as a file says, and threads have small stacks.
impl Clone for SceneNode {
    fn clone(&self) -> Self {
        let (mut node, mut copy) = (self, self.without_children());
        let mut parents: Vec<(&Self, Self)> = Vec::new();
        loop {
            if let Some(child) = node.children.get(copy.children.len()) {
                parents.push((node, core::mem::replace(&mut copy, child.without_children())));
                node = child;
            } else if let Some((parent, mut parent_copy)) = parents.pop() {
                parent_copy.children.push(copy);
                (node, copy) = (parent, parent_copy);
            } else {
                return copy;
            }
        }
    }
}

impl SceneNode {
    /// Copy without the nodes below.
    fn without_children(&self) -> Self {
        let children = Vec::with_capacity(self.children.len());
        Self { name: self.name.clone(), content: self.content.clone(), children, ..*self }
    }

    /// Node with this content, at its parent's place.
    pub fn new(content: Content, material: MaterialId) -> Self {
        Self { content: Some(content), material, ..Self::empty(String::new(), Transform::IDENTITY) }
    }

    /// A node without content.
    pub const fn empty(name: String, parent_from_local: Transform) -> Self {
        Self {
            name,
            parent_from_local,
            moves_to: None,
            content: None,
            material: MaterialId(0),
            casts_shadow: true,
            is_left_handed: false,
            children: Vec::new(),
        }
    }

    /// Motion from [`parent_from_local`](Self::parent_from_local) to [`moves_to`](Self::moves_to); `None` for a static node.
    ///
    /// # Errors
    /// [`AnimatedTransformError`] if the two transforms cannot be interpolated.
    pub fn motion(&self) -> Result<Option<AnimatedTransform>, AnimatedTransformError> {
        let end = self.moves_to.as_ref().filter(|end| **end != self.parent_from_local);
        end.map(|end| AnimatedTransform::new(&self.parent_from_local, end)).transpose()
    }

    /// Takes this node's space to that which `outer` takes its parent's to.
    ///
    /// # Errors
    /// [`AnimatedTransformError`] as of [`motion`](Self::motion).
    pub fn place_below(
        &self,
        outer: &AnimatedTransformChain,
    ) -> Result<AnimatedTransformChain, AnimatedTransformError> {
        Ok(match self.motion()? {
            Some(motion) => outer.clone().compose_animated(&motion),
            None => outer.clone().compose(&self.parent_from_local),
        })
    }
}

/// Indices of the materials of all shapes and meshes in these trees.
#[cfg(feature = "format")]
pub(crate) fn used_materials<'a>(trees: impl IntoIterator<Item = &'a [SceneNode]>) -> BTreeSet<u32> {
    let mut used = BTreeSet::new();
    let mut open: Vec<&SceneNode> = trees.into_iter().flatten().collect();
    while let Some(node) = open.pop() {
        if let Some(Content::Shape(_) | Content::Mesh(_)) = node.content {
            used.insert(node.material.0);
        }
        open.extend(&node.children);
    }
    used
}

/// True if a material makes its objects lights: it emits everywhere, or through a texture brighter than white. Textures of
/// less are screens, signs and glowing details, which do not light a scene.
#[cfg(feature = "format")]
pub(crate) fn is_emissive(material: &Material, textures: &[Texture]) -> bool {
    match material.emission {
        ColorTexture::Constant(radiance) => !radiance.is_black(),
        ColorTexture::Textured(texture, factor) => {
            let texture = textures.get(texture.0 as usize).map_or(Rgb::WHITE, Texture::max);
            (texture * factor).max_component() > 1.0
        }
    }
}

/// Repair or omission, with its location. Printed on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// File and line, path in the document, or name of the object.
    pub place: String,
    /// Finding, and the action taken.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", SingleLine(format_args!("{}: {}", self.place, self.message)))
    }
}

/// Closed form of the image of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownMean {
    /// Mean radiance over all pixels.
    pub mean: Rgb,
    /// Source of the value.
    pub note: String,
    /// Width and height of the image that the file describes. An image of another aspect ratio has another mean.
    pub size: [u64; 2],
}

/// A scene ready to be compiled to a plan.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name, usually the stem of the file.
    pub name: String,
    /// At least one camera; the first is the default.
    pub cameras: Vec<NamedCamera>,
    /// Fields of a scene file for each of the cameras, with options and defaults applied. Empty for a scene made in code.
    #[cfg(feature = "format")]
    pub camera_fields: Vec<crate::format::Camera>,
    /// The image.
    pub film: FilmSettings,
    /// Render settings.
    pub settings: RenderSettings,
    /// Materials, textures, lights, background.
    pub appearance: Appearance,
    /// Meshes that nodes refer to.
    pub meshes: Vec<NamedMesh>,
    /// Groups that instances refer to. A group only contains instances of groups before it.
    pub groups: Vec<Group>,
    /// The tree.
    pub nodes: Vec<SceneNode>,
    /// Exact mean of the image, if known.
    pub truth: Option<KnownMean>,
    /// Part of a frame that the times 0 to 1 of cameras and motions span; `None` if they span all of it.
    pub shutter_interval: Option<[f64; 2]>,
    /// Repairs and omissions.
    pub warnings: Vec<Warning>,
    /// Choices that the file leaves open: camera, lights, exposure. One sentence each.
    pub notes: Vec<String>,
}

impl Scene {
    /// Scene without content or cameras.
    pub fn empty(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_of_trees_have_the_same_nodes_in_the_same_order() {
        let node = |name: &str, children| SceneNode {
            children,
            moves_to: Some(Transform::IDENTITY),
            material: MaterialId(name.len() as u32),
            casts_shadow: name != "b",
            ..SceneNode::empty(name.into(), Transform::IDENTITY)
        };
        let tree = node("a", vec![node("b", vec![node("cc", vec![])]), node("d", vec![]), node("e", vec![])]);
        assert_eq!(format!("{:?}", tree.clone()), format!("{tree:?}"));
    }
}
