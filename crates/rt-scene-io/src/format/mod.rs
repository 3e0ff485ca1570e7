//! The scene file: types that mirror the text, with plain numbers and names.
//!
//! `.ron` and `.json` hold the same model. Everything has a default but the geometry, an unknown field is an error,
//! angles are in degrees, +y is up, and cameras look along −z. What the numbers mean is settled by
//! [`resolve`](crate::resolve).

mod animation;
mod camera;
mod colour;
mod film;
mod light;
mod material;
mod node;
mod parse;
mod settings;
mod transform;
mod write;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};

pub use animation::{CameraAnimation, CameraKey, Interpolation, NodeAnimation, NodeKey};
pub use camera::{Camera, FovAxis, Lens};
pub use colour::{Coefficient, Color, Wrap};
pub use film::{Encoding, Film, Filter, Tone};
pub use light::{Background, Falloff, Light};
pub use material::{Highlight, Material, Metal, Sides};
pub use node::{InsideRule, Node, Shape};
pub use parse::{parse_json, parse_ron};
pub use settings::{Accel, Adaptive, Integrator, LightSampling, Sampler, Settings};
pub use transform::Step;

/// A scene: what stands where, how it looks, who sees it, and how to render it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "Scene", deny_unknown_fields)]
pub struct SceneFile {
    /// Name of the scene; by default the stem of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The camera. Without one, or without a place, the camera is put where it sees everything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// More cameras to choose from by name. Without `camera`, the first of these is the default.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<Camera>,
    /// The image: size, filter, exposure.
    #[serde(default)]
    pub film: Film,
    /// How to render.
    #[serde(default)]
    pub settings: Settings,
    /// What rays see that hit nothing; black by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<Background>,
    /// The lights. Without this field the scene gets a key light, a fill light and some ambient light; an empty list
    /// means no light at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<Light>>,
    /// Materials by name. One that is named like a material of a model changes that material: fields that are given
    /// replace the model's.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty", deserialize_with = "unique_names")]
    pub materials: IndexMap<String, Material>,
    /// Subtrees by name, to be placed any number of times with `instance`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty", deserialize_with = "unique_names")]
    pub groups: IndexMap<String, Vec<Node>>,
    /// The objects.
    pub nodes: Vec<Node>,
    /// What the picture should be, if it is known exactly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<Truth>,
}

/// The closed form of a scene's picture, to measure errors against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Mean radiance over all pixels.
    pub mean: Color,
    /// Where the value comes from.
    #[serde(default)]
    pub note: String,
}

impl SceneFile {
    /// A scene of these nodes, with everything else left open.
    pub fn of_nodes(nodes: Vec<Node>) -> Self {
        Self {
            name: None,
            camera: None,
            cameras: Vec::new(),
            film: Film::default(),
            settings: Settings::default(),
            background: None,
            lights: None,
            materials: IndexMap::new(),
            groups: IndexMap::new(),
            nodes,
            truth: None,
        }
    }
}

/// The JSON Schema of [`SceneFile`], for editors to complete and check scene files by.
pub fn json_schema() -> String {
    let mut text = serde_json::to_string_pretty(&schemars::schema_for!(SceneFile)).unwrap_or_default();
    text.push('\n');
    text
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
