//! Kinds of findings, and the report that lists them.

use std::collections::BTreeMap;
use std::fmt;

use crate::measures::Measures;

/// Importance of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Worth knowing; the image is right.
    Info,
    /// The image is probably not the intended one, or loses digits.
    Warning,
    /// The scene cannot be rendered.
    Error,
}

impl Severity {
    /// "error", "warning" or "info".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
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
    /// The renderer rejects the scene.
    CannotRender = "cannot-render", Error, "fix the named object; rendering refuses the scene for the same reason";
    /// The loader fixed or skipped something.
    LoadWarning = "mended", Warning, "fix the file if the image should show it";
    /// Largest and smallest objects are too far apart in size.
    DynamicRange = "dynamic-range", Info, "remove objects too small to be seen, or enlarge them";
    /// The scene lies far from the origin compared to its size.
    FarFromOrigin = "far-from-origin", Info,
        "move the scene to the origin: whole units can be subtracted from all positions without loss";
    /// A mesh lies so far from its own origin that its `f32` vertices are coarse.
    CoarseVertices = "coarse-vertices", Warning,
        "store its vertices relative to a point in its middle, and move it there by a transform";
    /// A transform nearly flattens space.
    IllConditioned = "ill-conditioned-transform", Warning,
        "scale the axes more alike, or model the flat shape itself instead of flattening a round one";
    /// A transform mirrors.
    Mirrored = "mirrored", Info, "nothing: fronts stay fronts; text on textures reads backwards";
    /// Vertex normals under a transform that stretches.
    StretchedNormals = "stretched-normals", Info,
        "nothing: normals go by the inverse transpose and stay perpendicular to the surface";
    /// Two triangles of a mesh with the same corners and the same front.
    DuplicateTriangles = "duplicate-triangles", Warning,
        "remove them: they cost time, and glass is entered twice; the triangle of the lower index is seen";
    /// Two triangles of a mesh with the same corners, back to back.
    OppositeTriangles = "opposite-triangles", Info,
        "remove one of each pair: surfaces are seen from both sides anyway";
    /// Triangles that are far longer than high.
    SliverTriangles = "sliver-triangles", Info,
        "mesh the surface again, or merge its nearest vertices: the normal of a sliver is ill-defined";
    /// Edges of a mesh of very different lengths.
    UnevenTriangles = "uneven-triangles", Info,
        "split it into meshes of one scale if rendering is slow; a grid suffers most, a BVH hardly";
    /// A polygon whose corners do not lie in one plane.
    NonPlanarPolygon = "non-planar-polygon", Info,
        "move them into one plane, or cut it into triangles; more than 1e-6 is refused";
    /// A polygon whose edges cross.
    SelfIntersectingPolygon = "self-intersecting-polygon", Warning,
        "reorder the corners, or cut it into polygons whose edges do not cross";
    /// Neighbouring triangles whose fronts disagree.
    InconsistentWinding = "inconsistent-winding", Info,
        "let all triangles run counter-clockwise seen from outside; glass needs it, other surfaces have two fronts";
    /// Edges with more than two triangles.
    NonManifoldEdges = "non-manifold-edges", Info,
        "separate the parts that meet there if the mesh is to be a solid; as a surface it renders as it is";
    /// Edges with one triangle: the mesh has a border.
    OpenEdges = "open-edges", Info,
        "nothing for a surface; close the mesh if it is to be a solid, and weld corners that should be one";
    /// A closed mesh whose front is inside.
    InsideOut = "inside-out", Info, "reverse all triangles: glass takes the outside for its inside";
    /// A transparent surface that encloses nothing.
    OpenGlass = "open-glass", Warning,
        "close it, or give the sheet a thickness; for a window that does not bend light set `ior: 1`";
    /// A transparent surface that touches another one exactly.
    TouchingGlass = "touching-glass", Info,
        "let the two overlap a little, or leave a gap: light passes each surface then";
    /// Vertex normals that point to the back of their triangle.
    OpposedNormals = "opposed-normals", Warning,
        "reverse these triangles, or compute the normals again: shading jumps where they disagree";
    /// A textured mesh without texture coordinates.
    MissingUvs = "missing-uvs", Warning, "give it texture coordinates, or a material without texture";
    /// Triangles of a textured mesh without area in the texture.
    DegenerateUvs = "degenerate-uvs", Info,
        "unwrap them if they should show more of the texture than a line or a point";
    /// Overlapping surfaces in one plane.
    CoincidentSurfaces = "coincident-surfaces", Info,
        "move one of them, or order them so that the one to be seen comes first";
    /// No ray of the camera hits anything.
    CameraSeesNothing = "camera-sees-nothing", Warning,
        "point the camera at the scene, or leave it out to have one placed where it sees everything";
    /// The scene covers less than two pixels.
    CameraFar = "camera-far", Warning, "go nearer, or narrow the field of view";
    /// The field of view is so small that directions of neighbouring rays lose digits.
    NarrowView = "narrow-view", Warning,
        "widen the field of view and go nearer, or use an orthographic camera";
    /// Rounding moves visible points by a visible part of a pixel.
    CameraPrecision = "camera-precision", Warning, "bring camera and scene nearer to the origin, and to each other";
    /// The camera is inside of a solid.
    CameraInside = "camera-inside", Warning, "move the camera out, or put a light inside if this is a room";
    /// A light is inside of an opaque solid.
    LightEnclosed = "light-enclosed", Warning,
        "move it out, give it a `shadow_near` beyond the wall, or let the object cast no shadow";
    /// A light is so far away that its directions lose digits.
    LightFar = "light-far", Warning, "make it a directional light: from so far away its rays are parallel";
    /// A material reflects more light than arrives.
    EnergyGain = "energy-gain", Info,
        "nothing under classical shading; lower `specular` or raise `exponent` for physical light";
    /// An unused material, mesh or group.
    Unused = "unused", Info, "remove it, or correct the name where it should be used";
    /// A check stopped at a limit that bounds its running time.
    LimitReached = "limit-reached", Info, "check parts of the scene one by one for a complete report";
}

/// A measured number with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// In snake case; lengths are in world units, angles in degrees.
    pub name: &'static str,
    /// Possibly infinite.
    pub value: f64,
}

/// One result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Importance.
    pub severity: Severity,
    /// Subject.
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
        Self { severity: if is_warning { Severity::Warning } else { Severity::Info }, ..self }
    }

    /// Replaces the usual advice.
    pub(crate) fn with_advice(self, advice: &'static str) -> Self {
        Self { advice, ..self }
    }
}

/// Number of findings of one kind that a report does not list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct More {
    /// Importance.
    pub severity: Severity,
    /// Subject.
    pub kind: Kind,
    /// Number of findings beyond the listed ones.
    pub count: u64,
}

/// Numerical health of a scene; a function of the scene alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Measurements of the scene as a whole.
    pub measures: Measures,
    /// Findings, the severest first, then by kind, then in the order of the scene.
    pub findings: Vec<Finding>,
    /// Counts of unlisted findings, sorted by severity and kind.
    pub more: Vec<More>,
}

impl Report {
    /// Number of findings of a severity, listed or not.
    pub fn count(&self, severity: Severity) -> u64 {
        let listed = self.findings.iter().filter(|finding| finding.severity == severity).count() as u64;
        listed + self.more.iter().filter(|more| more.severity == severity).map(|more| more.count).sum::<u64>()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.measures)?;
        let mut findings = self.findings.iter().peekable();
        while let Some(finding) = findings.next() {
            let Finding { severity, kind, object, message, advice, .. } = finding;
            writeln!(f, "{}[{}] {object}: {message}", severity.name(), kind.code())?;
            writeln!(f, "    {advice}")?;
            if findings.peek().is_none_or(|next| (next.severity, next.kind) != (*severity, *kind)) {
                let more = self.more.iter().find(|more| (more.severity, more.kind) == (*severity, *kind));
                if let Some(more) = more {
                    writeln!(f, "{}[{}] and {} more", severity.name(), kind.code(), more.count)?;
                }
            }
        }
        if !self.findings.is_empty() {
            writeln!(f)?;
        }
        let count = |severity, one: &str, many: &str| match self.count(severity) {
            1 => format!("1 {one}"),
            n => format!("{n} {many}"),
        };
        let errors = count(Severity::Error, "error", "errors");
        let warnings = count(Severity::Warning, "warning", "warnings");
        writeln!(f, "{errors}, {warnings}, {}", count(Severity::Info, "note", "notes"))
    }
}

/// Listed findings of one kind and severity; the rest is counted.
const MAX_LISTED: u64 = 8;

/// Collects findings; keeps the first few of each kind and severity.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    listed: Vec<Finding>,
    counts: BTreeMap<(Severity, Kind), u64>,
}

impl Findings {
    pub(crate) fn add(&mut self, finding: Finding) {
        let count = self.counts.entry((finding.severity, finding.kind)).or_default();
        *count += 1;
        if *count <= MAX_LISTED {
            self.listed.push(finding);
        }
    }

    pub(crate) fn extend(&mut self, findings: impl IntoIterator<Item = Finding>) {
        findings.into_iter().for_each(|finding| self.add(finding));
    }

    /// Sorts the findings by severity and kind, stably.
    pub(crate) fn report(mut self, measures: Measures) -> Report {
        self.listed.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.kind.cmp(&b.kind)));
        let mut more: Vec<More> = self
            .counts
            .into_iter()
            .filter(|(_, count)| *count > MAX_LISTED)
            .map(|((severity, kind), count)| More { severity, kind, count: count - MAX_LISTED })
            .collect();
        more.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.kind.cmp(&b.kind)));
        Report { measures, findings: self.listed, more }
    }
}
