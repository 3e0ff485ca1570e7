//! The scene file: types that mirror the text, with plain numbers and names.
//!
//! `.ron` and `.json` have the same content. All fields except the geometry have defaults, an unknown field is an
//! error, angles are in degrees, +y is up, and cameras look along −z. [`resolve`](crate::resolve) defines what the
//! numbers mean.

mod advice;
mod animation;
mod camera;
mod color;
mod cursor;
mod default_values;
mod deprecated;
mod expected;
mod film;
mod light;
mod material;
mod named_fields;
mod node;
mod parse;
mod parse_error;
mod path_position;
mod reference_page;
mod ron_options;
mod run_time;
mod schema;
mod settings;
mod spelling;
mod synonyms;
mod transform;
mod write;

use indexmap::IndexMap;
use serde::{Deserialize, Deserializer, Serialize, de};

use crate::Warning;
pub use crate::{Accel, Integrator};
pub use animation::{CameraAnimation, CameraKey, Interpolation, NodeAnimation, NodeKey};
pub use camera::{Camera, FovAxis, Lens};
pub use color::{Color, ColorTexture, Wrap};
pub use film::{Encoding, Film, Filter, Tone};
pub use light::{Background, Falloff, Light, LightUnits};
pub use material::{EmissionSides, Highlight, Material, Metal, NodeMaterial};
pub use node::{InsideRule, Node, Shape};
pub use parse::{parse_json, parse_ron};
pub(crate) use path_position::positions_of;
pub use reference_page::reference_page;
pub use schema::json_schema;
pub use settings::{Adaptive, LightSampling, Sampler, Settings};
pub use transform::Step;

/// A scene: objects, materials, lights, cameras and render settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Scene", deny_unknown_fields)]
pub struct SceneFile {
    /// Path or address of the JSON Schema, for editors, in JSON files only. It has no effect here.
    ///
    /// Example: `"$schema": "scene.schema.json"`.
    #[serde(default, rename = "$schema", skip_serializing)]
    pub schema: Option<String>,
    /// Name of the scene.
    ///
    /// Default: stem of the file name. Example: `name: "still life"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The camera. Without a camera, or without its position, the whole scene is shown.
    ///
    /// Default: a camera that shows the whole scene. Example: `camera: (look_from: (0, 1, 5))`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// More cameras to choose from by name. Without `camera`, the first of these is the default.
    ///
    /// Example: `cameras: [(name: "side", look_from: (5, 1, 0))]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<Camera>,
    /// The image: size, filter, exposure.
    ///
    /// Example: `film: (size: (1280, 720))`.
    #[serde(default)]
    pub film: Film,
    /// Method, samples and other settings of the render.
    ///
    /// Example: `settings: (integrator: path, spp: 64)`.
    #[serde(default)]
    pub settings: Settings,
    /// Radiance of rays that leave the scene.
    ///
    /// Default: black. Example: `background: gradient(bottom: 1, top: "#80b0ff")`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<Background>,
    /// The lights. Without this field, a scene without other light gets studio lights: a key light, a fill light, some ambient
    /// light and a background. Other light is an emissive material, an environment image, and under path tracing a background.
    /// Emission by a texture counts if it is brighter than 1 somewhere.
    /// An empty list means no lights.
    ///
    /// Default: studio lights if no other light exists. Example: `lights: [point(position: (-3, 5, 4)), ambient(0.2)]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<Light>>,
    /// Materials by name. One that is named like a material of a model replaces it, except normal map, occlusion and alpha.
    /// `phong` keeps all that it does not give.
    ///
    /// Default: none. Example: `materials: {"red": diffuse(albedo: (0.8, 0.1, 0.1))}`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty", deserialize_with = "unique_names")]
    pub materials: IndexMap<String, Material>,
    /// Subtrees by name, to be placed any number of times with `instance`.
    ///
    /// Default: none. Example: `groups: {"pair": [(shape: sphere()), (shape: box(min: (1, 0, 0), max: (2, 1, 1)))]}`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty", deserialize_with = "unique_names")]
    pub groups: IndexMap<String, Vec<Node>>,
    /// The objects.
    ///
    /// Example: `nodes: [(shape: sphere(), material: "red")]`.
    pub nodes: Vec<Node>,
    /// Exact mean of the image, if it is known.
    ///
    /// Default: unknown. Example: `truth: (mean: 0.5)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<Truth>,
    /// Deprecated spellings in the file.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// Closed form of the image, as a reference for errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Mean radiance over all pixels.
    ///
    /// Unit: radiance. Example: `mean: 0.5`.
    pub mean: Color,
    /// Source of the value.
    ///
    /// Example: `note: "closed form"`.
    #[serde(default)]
    pub note: String,
}

impl SceneFile {
    /// All materials: named ones, and inline ones of nodes.
    pub(crate) fn materials(&self) -> impl Iterator<Item = &Material> {
        let nodes = self.groups.values().flatten().chain(&self.nodes);
        self.materials.values().chain(nodes.flat_map(Node::materials))
    }

    /// A scene of these nodes, with defaults for all other fields.
    pub fn of_nodes(nodes: Vec<Node>) -> Self {
        Self { nodes, ..Self::default() }
    }
}

/// A map that refuses a name that is given twice, where the last would win silently otherwise.
fn unique_names<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<IndexMap<String, T>, D::Error> {
    struct Visitor<T>(std::marker::PhantomData<T>);

    impl<'de, T: Deserialize<'de>> de::Visitor<'de> for Visitor<T> {
        type Value = IndexMap<String, T>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a map from names")
        }

        fn visit_map<A: de::MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut map = IndexMap::new();
            while let Some(name) = entries.next_key::<String>()? {
                if map.contains_key(&name) {
                    return Err(de::Error::custom(format_args!("there are two entries named `{name}`; rename one")));
                }
                map.insert(name, entries.next_value()?);
            }
            Ok(map)
        }
    }

    from.deserialize_map(Visitor(std::marker::PhantomData))
}
