//! Kinds of findings, and the findings of all checks.

use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Importance of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Worth knowing; the image is right.
    Note,
    /// The image is probably not the intended one, or loses digits.
    Warning,
    /// The scene cannot be rendered.
    Error,
}

impl Severity {
    /// "error", "warning" or "note".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

macro_rules! kinds {
    ($($(#[$doc:meta])+ $variant:ident = $code:literal, $severity:ident, $advice:literal;)+) => {
        /// Subject of a finding.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind {
            $($(#[$doc])+ $variant,)+
        }

        impl Kind {
            /// All kinds, in the order of reports.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// Name in machine-readable reports; stable between versions.
            pub const fn code(self) -> &'static str {
                match self {
                    $(Self::$variant => $code,)+
                }
            }

            /// Severity, unless the finding sets its own.
            const fn severity(self) -> Severity {
                match self {
                    $(Self::$variant => Severity::$severity,)+
                }
            }

            /// Advice, unless the finding sets its own.
            const fn advice(self) -> &'static str {
                match self {
                    $(Self::$variant => $advice,)+
                }
            }
        }
    };
}

// One row per lint: name in code, name in reports, usual severity, usual advice.
kinds! {
    /// The renderer refuses the scene.
    CannotRender = "cannot-render", Error, "fix the named object; rendering refuses the scene for the same reason";
    /// The loader fixed or skipped something.
    LoadWarning = "load-warning", Warning, "fix the file if the image should show the object";
    /// Largest and smallest objects are too far apart in size.
    DynamicRange = "dynamic-range", Note, "remove invisibly small objects, or enlarge them";
    /// The scene lies far from the origin compared to its size.
    FarFromOrigin = "far-from-origin", Note,
        "move the scene to the origin; subtract an integer from all positions, which is exact";
    /// A mesh lies so far from its own origin that its `f32` vertices are coarse.
    CoarseVertices = "coarse-vertices", Warning,
        "store its vertices relative to the centre of the mesh, and place it by a transform";
    /// A transform is nearly singular.
    IllConditioned = "ill-conditioned-transform", Warning,
        "use more similar scale factors, or a flat shape instead of a flattened one";
    /// A transform mirrors.
    Mirrored = "mirrored", Note, "no action: the front stays the front; text in textures is mirrored";
    /// Vertex normals under a transform that stretches.
    StretchedNormals = "stretched-normals", Note,
        "no action: normals are transformed by the inverse transpose and stay perpendicular to the surface";
    /// Two triangles of a mesh with the same corners and the same front.
    DuplicateTriangles = "duplicate-triangles", Warning,
        "remove them: they cost time, and rays enter dielectrics twice; the triangle of the lower index is visible";
    /// Two triangles of a mesh with the same corners, back to back.
    OppositeTriangles = "opposite-triangles", Note,
        "remove one of each pair: surfaces are two-sided";
    /// Triangles that are far longer than high.
    SliverTriangles = "sliver-triangles", Note,
        "remesh the surface, or merge close vertices: the normal of a sliver is inaccurate";
    /// Edges of a mesh of very different lengths.
    UnevenTriangles = "uneven-triangles", Note,
        "split it into meshes of similar triangles if rendering is slow, above all with a grid";
    /// A polygon whose corners do not lie in one plane.
    NonPlanarPolygon = "non-planar-polygon", Note,
        "move the corners into one plane, or split the polygon into triangles; the limit is 1e-6";
    /// A polygon whose edges cross.
    SelfIntersectingPolygon = "self-intersecting-polygon", Warning,
        "reorder the corners, or split it into simple polygons";
    /// Neighbouring triangles whose fronts disagree.
    InconsistentWinding = "inconsistent-winding", Note,
        "orient all triangles counter-clockwise as seen from outside; dielectrics need it, other surfaces are two-sided";
    /// Edges with more than two triangles.
    NonManifoldEdges = "non-manifold-edges", Note,
        "split the mesh at these edges if it is a solid; a surface needs no action";
    /// Edges with one triangle: the mesh has a border.
    OpenEdges = "open-edges", Note,
        "close the mesh and weld its vertices if it is a solid; a surface needs no action";
    /// A closed mesh whose front is inside.
    InsideOut = "inside-out", Note, "reverse all triangles: a dielectric would have its inside outside";
    /// A transmissive surface that encloses no volume.
    OpenGlass = "open-glass", Warning,
        "close it, or give it a thickness; set `ior: 1` for a window that does not refract";
    /// A transparent surface that touches another one exactly.
    TouchingGlass = "touching-glass", Note,
        "let the two overlap slightly, or leave a gap: rays then hit each surface";
    /// Vertex normals that point to the back of their triangle.
    OpposedNormals = "opposed-normals", Warning,
        "reverse these triangles, or recompute the normals: shading is discontinuous there";
    /// A textured mesh without texture coordinates.
    MissingUvs = "missing-uvs", Warning, "give it texture coordinates, or a material without texture";
    /// Triangles of a textured mesh without area in the texture.
    DegenerateUvs = "degenerate-uvs", Note,
        "unwrap them if they should show more than a line or a point of the texture";
    /// Overlapping surfaces in one plane.
    CoincidentSurfaces = "coincident-surfaces", Note,
        "move one of them, or list the visible one first";
    /// No ray of the camera hits an object.
    CameraSeesNothing = "camera-sees-nothing", Warning,
        "point the camera at the scene, or omit it for a camera that shows the whole scene";
    /// The scene covers less than two pixels.
    CameraFar = "camera-far", Warning, "move the camera closer, or reduce the field of view";
    /// The field of view is so small that neighbouring rays lose digits.
    NarrowView = "narrow-view", Warning,
        "increase the field of view and move closer, or use an orthographic camera";
    /// Rounding moves visible points by a visible part of a pixel.
    CameraPrecision = "camera-precision", Warning, "move camera and scene closer to the origin, and to each other";
    /// The camera is inside of a solid.
    CameraInside = "camera-inside", Warning, "move the camera out, or put a light inside if this is a room";
    /// The scene has no source of light.
    Unlit = "unlit", Warning, "add a light, an emissive material, or an environment image with `--env`";
    /// A light or an emissive object is inside of an opaque solid.
    LightEnclosed = "light-enclosed", Warning,
        "move it out, set its `shadow_near` beyond the wall, or set `casts_shadow: false` for the object";
    /// A light is so far away that its directions lose digits.
    LightFar = "light-far", Warning, "use a directional light: at this distance its rays are parallel";
    /// A material reflects more light than arrives.
    EnergyGain = "energy-gain", Note,
        "reduce `specular` or increase `exponent` for physical light; `whitted` needs no action";
    /// An unused material, mesh or group.
    Unused = "unused", Note, "remove it, or correct the name that should refer to it";
    /// A check stopped at its limit of time.
    LimitReached = "limit-reached", Note, "check parts of the scene one by one for a complete report";
}

/// A measured number with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Name in snake case.
    pub name: &'static str,
    /// Value, possibly infinite: lengths in world units, angles in degrees.
    pub value: f64,
}

/// One result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Severity, which sets the exit code under `--strict`.
    pub severity: Severity,
    /// Kind of the finding.
    pub kind: Kind,
    /// Path and name of the object, or the name of the mesh, material, light or camera.
    pub object: String,
    /// Measured numbers.
    pub values: Vec<Measurement>,
    /// Description of the finding.
    pub message: String,
    /// Suggested remedy.
    pub advice: &'static str,
}

impl Finding {
    /// A finding with the usual severity and advice of its kind.
    pub(crate) fn new(
        kind: Kind,
        object: impl Into<String>,
        values: &[(&'static str, f64)],
        message: impl Into<String>,
    ) -> Self {
        Self {
            severity: kind.severity(),
            kind,
            object: object.into(),
            values: values.iter().map(|&(name, value)| Measurement { name, value }).collect(),
            message: message.into(),
            advice: kind.advice(),
        }
    }

    /// Makes this a warning if a condition holds, and a note otherwise.
    pub(crate) fn warn_if(self, is_warning: bool) -> Self {
        Self { severity: if is_warning { Severity::Warning } else { Severity::Note }, ..self }
    }

    /// Replaces the usual advice.
    pub(crate) fn with_advice(self, advice: &'static str) -> Self {
        Self { advice, ..self }
    }
}

/// Listed findings of one kind and severity; the rest is counted.
pub(crate) const MAX_LISTED: u64 = 8;

/// Collects findings; keeps the first few of each kind and severity.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    pub(crate) listed: Vec<Finding>,
    /// Numbers of findings, in the order of a report.
    pub(crate) counts: BTreeMap<(Reverse<Severity>, Kind), u64>,
}

impl Findings {
    pub(crate) fn add(&mut self, finding: Finding) {
        let count = self.counts.entry((Reverse(finding.severity), finding.kind)).or_default();
        *count += 1;
        if *count <= MAX_LISTED {
            self.listed.push(finding);
        }
    }

    pub(crate) fn extend(&mut self, findings: impl IntoIterator<Item = Finding>) {
        findings.into_iter().for_each(|finding| self.add(finding));
    }
}
