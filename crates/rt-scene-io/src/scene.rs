//! The resolved scene: plain data, no paths, nothing left to look up.

use std::{collections::BTreeSet, fmt, sync::Arc};

use rt_camera::{CameraSettings, FilmSettings, SamplerKind};
use rt_geometry::{Shape, TriangleMesh};
use rt_math::{AnimatedTransform, AnimatedTransformChain, AnimatedTransformError, Rgb, Transform};
use rt_shading::{Appearance, ColorTexture, emitter::LightSampling};

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

/// Method by which light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "format", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "format", serde(rename_all = "snake_case"))]
pub enum Integrator {
    /// Recursive ray tracing (Whitted 1980).
    Whitted,
    /// Distribution ray tracing: soft shadows, glossy reflection, rough glass (Cook et al. 1984).
    Distributed,
    /// Path tracing: all light (Kajiya 1986).
    Path,
    /// Path tracing, with light tracing for caustics (Arvo 1986).
    Caustics,
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
    /// All integrators.
    pub const ALL: [Self; 10] = [
        Self::Whitted,
        Self::Distributed,
        Self::Path,
        Self::Caustics,
        Self::Direct,
        Self::AmbientOcclusion,
        Self::Normals,
        Self::Depth,
        Self::Uv,
        Self::Cost,
    ];

    /// True if rays go in random directions, so that pictures are noisy everywhere and not at edges alone.
    pub const fn is_stochastic(self) -> bool {
        match self {
            Self::Whitted | Self::Normals | Self::Depth | Self::Uv | Self::Cost => false,
            Self::Distributed | Self::Path | Self::Caustics | Self::Direct | Self::AmbientOcclusion => true,
        }
    }

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Whitted => "whitted",
            Self::Distributed => "distributed",
            Self::Path => "path",
            Self::Caustics => "caustics",
            Self::Direct => "direct",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::Normals => "normals",
            Self::Depth => "depth",
            Self::Uv => "uv",
            Self::Cost => "cost",
        }
    }

    /// True if it shows light, and not a view of the geometry.
    pub const fn follows_light(self) -> bool {
        matches!(self, Self::Whitted | Self::Distributed | Self::Path | Self::Caustics | Self::Direct)
    }

    /// True if diffuse surfaces take light from the background.
    pub const fn gathers_background(self) -> bool {
        matches!(self, Self::Path | Self::Caustics | Self::Direct)
    }

    /// True if it draws from lights with extent.
    pub const fn samples_area_lights(self) -> bool {
        matches!(self, Self::Distributed | Self::Path | Self::Caustics | Self::Direct)
    }
}

/// Acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "format", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
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
    Wide,
    /// Tree of bounding spheres.
    Spheres,
    /// Tree of bounding cylinders.
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

impl Accel {
    /// All choices.
    pub const ALL: [Self; 11] = [
        Self::Auto,
        Self::Linear,
        Self::Grid,
        Self::Bvh,
        Self::Wide,
        Self::Spheres,
        Self::Cylinders,
        Self::Kd,
        Self::Bsp,
        Self::Bih,
        Self::BihLazy,
    ];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Linear => "linear",
            Self::Grid => "grid",
            Self::Bvh => "bvh",
            Self::Wide => "wide",
            Self::Spheres => "spheres",
            Self::Cylinders => "cylinders",
            Self::Kd => "kd",
            Self::Bsp => "bsp",
            Self::Bih => "bih",
            Self::BihLazy => "bih-lazy",
        }
    }
}

/// How samples are shared out among pixels, if not evenly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adaptive {
    /// By what lies in the pyramid of a pixel (Genetti, Gordon and Williams 1998): few samples where no edge of an object or
    /// of a shadow can be in it, and all of them elsewhere.
    ObjectSpace {
        /// Samples of a pixel without edges; a quarter of all if `None`. Patterns may round it up.
        least: Option<u32>,
    },
}

impl Adaptive {
    /// Samples of a pixel without edges, of so many asked for.
    pub const fn least(self, spp: u32) -> u32 {
        match self {
            Self::ObjectSpace { least: Some(least) } => least,
            Self::ObjectSpace { least: None } => spp.div_ceil(4),
        }
    }
}

/// How to render, as far as the scene has an opinion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Integrator.
    pub integrator: Integrator,
    /// Sample pattern.
    pub pattern: SamplerKind,
    /// Samples per pixel asked for; patterns may round it up.
    pub spp: u32,
    /// Independent passes that the samples are split into, by which the error is estimated; the plan chooses if `None`.
    pub passes: Option<u32>,
    /// How samples are shared out among pixels; evenly if `None`.
    pub adaptive: Option<Adaptive>,
    /// Bounces after the first hit.
    pub depth: u32,
    /// Rays whose contribution to the pixel falls below this are not followed. 0 follows all.
    pub min_contribution: f64,
    /// Acceleration structure.
    pub accel: Accel,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How one of many lights with extent is chosen.
    pub light_sampling: LightSampling,
    /// Bounces before Russian roulette may end a path.
    pub roulette_from: u32,
    /// Largest component of a contribution of indirect light, in units of radiance; unbounded and without bias if `None`.
    pub clamp: Option<f64>,
    /// How far away surfaces still take light from a point, in world units, for ambient occlusion; infinite for all.
    pub occlusion_distance: f64,
}

impl Default for Settings {
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
            roulette_from: 3,
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
    /// The transparent material that it stands inside of; without one, the plan looks at the bodies around it.
    pub medium: Option<MaterialId>,
}

/// A mesh that nodes refer to.
#[derive(Clone, Debug)]
pub struct NamedMesh {
    /// For messages.
    pub name: String,
    /// The triangles.
    pub mesh: Arc<TriangleMesh>,
}

/// A subtree that is described once and placed many times.
#[derive(Clone, Debug)]
pub struct Group {
    /// Unique within the scene.
    pub name: String,
    /// Its nodes, in the group's own space.
    pub nodes: Vec<Node>,
}

/// What stands at a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A single shape.
    Shape(Shape),
    /// A triangle mesh.
    Mesh(MeshId),
    /// All of a group. Groups may contain instances of other groups, never of themselves.
    Instance(GroupId),
}

/// A place in the tree.
#[derive(Clone, Debug)]
pub struct Node {
    /// For messages; may be empty.
    pub name: String,
    /// Takes this node's space to its parent's; where it moves, at time 0.
    pub parent_from_local: Transform,
    /// The same at time 1, if the node moves.
    pub moves_to: Option<Transform>,
    /// What stands here, if anything.
    pub content: Option<Content>,
    /// Material of a shape or mesh here. Instances keep the materials of their group.
    pub material: MaterialId,
    /// Whether it casts shadows. For an instance or a node with children, off switches off all below.
    pub casts_shadow: bool,
    /// Nodes below.
    pub children: Vec<Node>,
}

impl Node {
    /// A node with this content, at its parent's place.
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
            children: Vec::new(),
        }
    }

    /// The motion from [`parent_from_local`](Self::parent_from_local) to [`moves_to`](Self::moves_to); `None` for a node that is
    /// at the same place all the time.
    ///
    /// # Errors
    /// [`AnimatedTransformError`] if there is no way from one to the other.
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
pub(crate) fn used_materials<'a>(trees: impl IntoIterator<Item = &'a [Node]>) -> BTreeSet<u32> {
    let mut used = BTreeSet::new();
    let mut open: Vec<&Node> = trees.into_iter().flatten().collect();
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
pub(crate) fn is_emissive(material: &Material) -> bool {
    match material.phong.emission {
        ColorTexture::Constant(radiance) => !radiance.is_black(),
        ColorTexture::Textured(_, radiance) => radiance.max_component() > 1.0,
    }
}

/// Something that was mended, and where. Printed on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// File and line, path in the document, or name of the object.
    pub place: String,
    /// What was found and what was done about it.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", SingleLine(format_args!("{}: {}", self.place, self.message)))
    }
}

/// The closed form of a scene's picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Mean radiance over all pixels.
    pub mean: Rgb,
    /// Where the value comes from.
    pub note: String,
}

/// A scene ready to be compiled to a plan.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name, usually the stem of the file.
    pub name: String,
    /// At least one camera; the first is the default.
    pub cameras: Vec<NamedCamera>,
    /// The image.
    pub film: FilmSettings,
    /// How to render.
    pub settings: Settings,
    /// Materials, textures, lights, background.
    pub appearance: Appearance,
    /// Meshes that nodes refer to.
    pub meshes: Vec<NamedMesh>,
    /// Groups that instances refer to. A group only contains instances of groups before it.
    pub groups: Vec<Group>,
    /// The tree.
    pub nodes: Vec<Node>,
    /// What the picture should be, if it is known exactly.
    pub truth: Option<Truth>,
    /// What was mended on the way.
    pub warnings: Vec<Warning>,
    /// What was chosen because the file leaves it open: camera, lights, exposure. One sentence each.
    pub notes: Vec<String>,
}

impl Scene {
    /// A scene with nothing in it, not even a camera.
    pub fn empty(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            cameras: Vec::new(),
            film: FilmSettings::default(),
            settings: Settings::default(),
            appearance: Appearance::default(),
            meshes: Vec::new(),
            groups: Vec::new(),
            nodes: Vec::new(),
            truth: None,
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }
}
