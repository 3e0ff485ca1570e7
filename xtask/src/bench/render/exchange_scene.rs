//! Scene descriptions that belong to no renderer: one right-handed world in plain numbers. Each renderer's own file is
//! made from them.

use std::{collections::BTreeMap, fs::File, io::BufReader, path::Path};

use serde::{Deserialize, de::DeserializeOwned};

use crate::error::TaskError;

/// A scene without its objects.
#[derive(Debug, Deserialize)]
pub(super) struct Outline {
    pub name: String,
    pub w: u64,
    pub h: u64,
    /// Samples per pixel.
    pub spp: u64,
}

#[derive(Debug, Deserialize)]
pub(super) struct ExchangeScene {
    pub name: String,
    pub w: u64,
    pub h: u64,
    /// Samples per pixel.
    pub spp: u64,
    /// Levels of rays: 1 traces camera rays alone.
    pub depth: u64,
    /// Global illumination.
    pub gi: bool,
    pub camera: Camera,
    pub background: [f64; 3],
    pub ambient: [f64; 3],
    pub lights: Vec<Light>,
    pub materials: BTreeMap<String, Material>,
    pub objects: Vec<Object>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Camera {
    pub eye: [f64; 3],
    pub at: [f64; 3],
    pub up: [f64; 3],
    /// Degrees over the height of the image.
    pub vfov: f64,
}

/// A light, as classical renderers need it.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Light {
    /// Point light without falloff.
    Point { p: [f64; 3], color: [f64; 3] },
    /// Point light in the centre of a sphere of the scene, which does not shadow it.
    #[serde(rename = "sphere_light")]
    Sphere { p: [f64; 3], r: f64, color: [f64; 3] },
    /// A parallelogram.
    Rect {},
}

#[derive(Debug, Deserialize)]
pub(super) struct Material {
    pub color: [f64; 3],
    /// Coefficients: ambient, diffuse, highlight and its exponent, mirrored and transmitted light.
    pub ka: f64,
    pub kd: f64,
    pub ks: f64,
    pub shin: f64,
    pub kr: f64,
    pub kt: f64,
    pub ior: f64,
    /// Emission, in its colour.
    pub emit: f64,
    pub checker: Option<Checker>,
    /// True if the colour tints `kr`.
    pub kr_tint: bool,
    /// Emitted radiance; the surface also reflects by its colour.
    pub radiance: Option<[f64; 3]>,
}

/// Squares of another colour; the one at the origin has it.
#[derive(Debug, Deserialize)]
pub(super) struct Checker {
    pub c2: [f64; 3],
    pub size: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Object {
    #[serde(flatten)]
    pub shape: Shape,
    pub mat: String,
    #[serde(default)]
    pub no_shadow: bool,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Shape {
    Sphere {
        c: [f64; 3],
        r: f64,
    },
    /// Flat and convex.
    Poly {
        pts: Vec<[f32; 3]>,
    },
    Mesh {
        #[serde(rename = "V")]
        positions: Vec<[f32; 3]>,
        #[serde(rename = "N")]
        normals: Vec<[f32; 3]>,
        #[serde(rename = "F")]
        triangles: Vec<[u32; 3]>,
    },
}

/// Reads a description, or its outline.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, TaskError> {
    let file = File::open(path).map_err(TaskError::file(path))?;
    serde_json::from_reader(BufReader::new(file)).map_err(TaskError::file(path))
}
