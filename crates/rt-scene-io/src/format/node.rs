//! The tree of objects in the file.

use serde::{Deserialize, Serialize};

use super::default_values::{half, is_yes, one, up, yes};
use super::{Material, NodeAnimation, NodeMaterial, Step};

/// A node of the tree, with at most one of `shape`, `model` and `instance`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Node {
    /// Name for messages.
    ///
    /// Example: `name: "table"`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Steps that place the node, applied to the object in the order in which they are written.
    /// `[scale(2), translate(1, 0, 0)]` makes it larger first and then moves it by 1.
    ///
    /// Example: `transform: [scale(2), translate(1, 0, 0)]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
    /// Transform of the node at time 1, as steps like those of `transform`, which is its transform at time 0. It
    /// rotates by the shortest arc, at most half a turn. It is blurred by its motion while the shutter is open.
    ///
    /// Example: `motion: [translate(0.5, 0, 0)]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Step>,
    /// Instead of `motion`: transforms of the node at times of an animation. It is blurred by its motion while a camera's `shutter`
    /// is open.
    ///
    /// Default: at rest. Example: `animation: (keys: [(time: 0), (time: 1, transform: [translate(0, 2, 0)])])`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<NodeAnimation>,
    /// Shape of this node.
    ///
    /// Default: none. Example: `shape: sphere(radius: 0.5)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Model file (glTF, OBJ, PLY, STL, NFF or pbrt) of this node, with its tree and materials, without its cameras and lights.
    /// The path is relative to the directory of the scene file.
    ///
    /// Default: none. Example: `model: "chair.gltf"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Name of a group; this node is an instance of it.
    ///
    /// Default: none. Example: `instance: "pair"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instance: Option<String>,
    /// Material of this shape, and of the shapes below that have none. It is the name of one of the
    /// scene's `materials`, or a material written here. On a `model` it replaces the materials of the model. Instances and models
    /// below do not inherit it: they have the materials of their own nodes.
    ///
    /// Default: that of the parent, or grey. Example: `material: diffuse(albedo: 0.8)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<NodeMaterial>,
    /// True if this node and all below it cast shadows.
    ///
    /// Default: `true`. Example: `casts_shadow: false`.
    #[serde(skip_serializing_if = "is_yes")]
    pub casts_shadow: bool,
    /// Nodes that move with this one.
    ///
    /// Example: `children: [(shape: sphere())]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<Node>,
}

impl Default for Node {
    fn default() -> Self {
        Self {
            name: String::new(),
            transform: Vec::new(),
            motion: Vec::new(),
            animation: None,
            shape: None,
            model: None,
            instance: None,
            material: None,
            casts_shadow: true,
            children: Vec::new(),
        }
    }
}

impl Node {
    /// The inline materials of this node and of all nodes below.
    pub(crate) fn materials(&self) -> Vec<&Material> {
        let (mut found, mut waiting) = (Vec::new(), vec![self]);
        while let Some(node) = waiting.pop() {
            if let Some(NodeMaterial::Inline(material)) = &node.material {
                found.push(material.as_ref());
            }
            waiting.extend(&node.children);
        }
        found
    }
}

/// A shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Its centre.
        ///
        /// Unit: units of the scene.
        #[serde(default, alias = "centre")]
        center: [f64; 3],
        /// Its radius.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
    },
    /// A box with faces along the axes.
    Box {
        /// Minimum corner.
        ///
        /// Unit: units of the scene. Example: `min: (-1, 0, -1)`.
        min: [f64; 3],
        /// Maximum corner.
        ///
        /// Unit: units of the scene. Example: `max: (1, 2, 1)`.
        max: [f64; 3],
    },
    /// An infinite plane.
    Plane {
        /// A point on it.
        ///
        /// Unit: units of the scene.
        #[serde(default)]
        point: [f64; 3],
        /// The direction that it faces.
        ///
        /// Unit: none.
        #[serde(default = "up")]
        normal: [f64; 3],
    },
    /// A cylinder around the y axis.
    Cylinder {
        /// Its radius.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
        /// Height of its bottom.
        ///
        /// Unit: units of the scene.
        #[serde(default)]
        bottom: f64,
        /// Height of its top.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        top: f64,
        /// True for a closed solid, false for an open tube.
        #[serde(default = "yes")]
        caps: bool,
    },
    /// A cylinder around the y axis without ends.
    InfiniteCylinder {
        /// Its radius.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
    },
    /// Two infinite cones around the y axis with their apexes in the origin.
    DoubleCone {
        /// Their radius at a distance of 1 from the origin.
        ///
        /// Unit: none.
        #[serde(default = "one")]
        slope: f64,
    },
    /// A cone around the y axis with its base in the plane y = 0.
    Cone {
        /// Radius of its base.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
        /// Height of its apex.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        height: f64,
        /// True for a closed solid with a base, false for an open surface.
        #[serde(default = "yes")]
        caps: bool,
    },
    /// A truncated cone around the y axis with its base in the plane y = 0.
    Frustum {
        /// Radius of its lower end.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        bottom_radius: f64,
        /// Radius of its upper end.
        ///
        /// Unit: units of the scene.
        #[serde(default = "half")]
        top_radius: f64,
        /// Its height.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        height: f64,
        /// True for a closed solid, false for an open surface.
        #[serde(default = "yes")]
        caps: bool,
    },
    /// A disk or ring around the origin that faces +y.
    Disk {
        /// Its radius.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
        /// Radius of the hole; 0 for a full disk.
        ///
        /// Unit: units of the scene.
        #[serde(default)]
        inner_radius: f64,
    },
    /// A rectangle around the origin that faces +y.
    Rectangle {
        /// Its extent along x.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        width: f64,
        /// Its extent along z.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        depth: f64,
    },
    /// A ring around the y axis, round in section.
    Torus {
        /// Radius of the circle in the middle of its tube.
        ///
        /// Unit: units of the scene.
        #[serde(default = "one")]
        radius: f64,
        /// Radius of its tube, less than `radius`.
        ///
        /// Unit: units of the scene.
        #[serde(default = "quarter")]
        tube_radius: f64,
    },
    /// A triangle by its corners, counter-clockwise seen from the front.
    ///
    /// Example: `triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))`.
    Triangle([f64; 3], [f64; 3], [f64; 3]),
    /// A four-cornered face by its corners, counter-clockwise seen from the front. It is two triangles with the diagonal
    /// from the first to the third corner. Its texture coordinates are (0, 0), (1, 0), (1, 1) and (0, 1) at the corners.
    ///
    /// Example: `quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))`.
    Quad([f32; 3], [f32; 3], [f32; 3], [f32; 3]),
    /// A flat polygon by its corners, counter-clockwise seen from the front. It may be concave and have holes. Corners
    /// may lie off its plane by a millionth of its size. Its texture coordinates run from 0 to 1 over its box within
    /// the plane.
    Polygon {
        /// The corners of the outline, at least three; the last is joined to the first.
        ///
        /// Unit: units of the scene. Example: `points: [(0, 0, 0), (4, 0, 0), (0, 4, 0)]`.
        points: Vec<[f64; 3]>,
        /// The corners of each hole, in either direction.
        ///
        /// Unit: units of the scene. Example: `holes: [[(1, 1, 0), (2, 1, 0), (1, 2, 0)]]`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        holes: Vec<Vec<[f64; 3]>>,
        /// Inside of the polygon.
        #[serde(default)]
        rule: InsideRule,
    },
    /// A strip of triangles: each point after the second makes one with the two before it. The first triangle is
    /// counter-clockwise seen from the front, and the others face the same side. Points are repeated to join strips.
    ///
    /// Example: `strip([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])`.
    Strip(Vec<[f32; 3]>),
    /// A fan of triangles: each point after the second makes one with the point before it and the first,
    /// counter-clockwise seen from the front.
    ///
    /// Example: `fan([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])`.
    Fan(Vec<[f32; 3]>),
    /// A triangle mesh. Like those of `quad`, `strip`, `fan` and model files, its vertices are stored in single precision: numbers up
    /// to 3.4e38 with 24 bits. Far from the origin it loses detail: place it by the `transform` of its node, which has double
    /// precision.
    Mesh {
        /// Vertices.
        ///
        /// Unit: units of the scene. Example: `positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)]`.
        positions: Vec<[f32; 3]>,
        /// Three vertices for each triangle, numbered from 0, counter-clockwise seen from the front.
        ///
        /// Unit: indices of vertices. Example: `triangles: [(0, 1, 2)]`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        triangles: Vec<[u32; 3]>,
        /// Three or more vertices for each flat face, numbered as for `triangles`. Faces may be concave; they are cut
        /// into triangles, which follow those of `triangles`.
        ///
        /// Unit: indices of vertices. Example: `faces: [[0, 1, 2]]`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        faces: Vec<Vec<u32>>,
        /// A normal for each vertex, for smooth shading.
        ///
        /// Unit: none. Example: `normals: [(0, 0, 1), (0, 0, 1), (0, 0, 1)]`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        normals: Vec<[f32; 3]>,
        /// Texture coordinates for each vertex.
        ///
        /// Unit: none. Example: `uvs: [(0, 0), (1, 0), (0, 1)]`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        uvs: Vec<[f32; 2]>,
    },
}

/// Inside of a polygon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum InsideRule {
    /// The common part of the half-planes along the edges. A polygon that is concave or has holes is refused.
    Convex,
    /// The outline winds around the point. All of a pentagram is inside.
    Winding,
    /// A line from the point to infinity crosses the outline an odd number of times. The middle of a pentagram is
    /// outside.
    #[default]
    EvenOdd,
}

fn quarter() -> f64 {
    0.25
}
