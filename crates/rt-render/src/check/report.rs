//! What a check finds, in words and numbers.

use std::collections::BTreeMap;
use std::fmt;

use super::measures::Measures;

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Good to know; the picture is right.
    Info,
    /// The picture is probably not what was meant, or loses digits.
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
    ($($(#[$doc:meta])+ $variant:ident = $code:literal,)+) => {
        /// What a finding is about.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kind {
            $($(#[$doc])+ $variant,)+
        }

        impl Kind {
            /// All kinds, in the order of reports.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// The name of the kind in machine-readable reports; it does not change between versions.
            pub const fn code(self) -> &'static str {
                match self {
                    $(Self::$variant => $code,)+
                }
            }
        }
    };
}

kinds! {
    /// The scene is refused by the plan.
    CannotRender = "cannot-render",
    /// Something was mended or left out when the scene was loaded.
    Mended = "mended",
    /// Largest and smallest things are too far apart in size.
    DynamicRange = "dynamic-range",
    /// The scene lies far from the origin compared to its size.
    FarFromOrigin = "far-from-origin",
    /// A mesh lies so far from its own origin that its `f32` vertices are coarse.
    CoarseVertices = "coarse-vertices",
    /// A transform nearly flattens space.
    IllConditioned = "ill-conditioned-transform",
    /// A transform mirrors.
    Mirrored = "mirrored",
    /// Vertex normals under a transform that stretches.
    StretchedNormals = "stretched-normals",
    /// Triangles that stand twice in a mesh, with the same front.
    DuplicateTriangles = "duplicate-triangles",
    /// Triangles that stand twice in a mesh, back to back.
    OppositeTriangles = "opposite-triangles",
    /// Triangles that are far longer than high.
    SliverTriangles = "sliver-triangles",
    /// Edges of a mesh of very different lengths.
    UnevenTriangles = "uneven-triangles",
    /// A polygon whose corners do not lie in one plane.
    NonPlanarPolygon = "non-planar-polygon",
    /// A polygon whose edges cross.
    SelfIntersectingPolygon = "self-intersecting-polygon",
    /// Neighbouring triangles whose fronts disagree.
    InconsistentWinding = "inconsistent-winding",
    /// Edges with more than two triangles.
    NonManifoldEdges = "non-manifold-edges",
    /// Edges with one triangle: the mesh has a border.
    OpenEdges = "open-edges",
    /// A closed mesh whose front is inside.
    InsideOut = "inside-out",
    /// A transparent surface that encloses nothing.
    OpenGlass = "open-glass",
    /// A transparent surface that touches another one exactly.
    TouchingGlass = "touching-glass",
    /// Vertex normals that point to the back of their triangle.
    OpposedNormals = "opposed-normals",
    /// A textured mesh without texture coordinates.
    MissingUvs = "missing-uvs",
    /// Triangles of a textured mesh without area in the texture.
    DegenerateUvs = "degenerate-uvs",
    /// Surfaces that lie in each other.
    CoincidentSurfaces = "coincident-surfaces",
    /// No ray of the camera hits anything.
    CameraSeesNothing = "camera-sees-nothing",
    /// The scene is smaller than a pixel or two.
    CameraFar = "camera-far",
    /// The field of view is so small that neighbouring rays lose digits.
    NarrowView = "narrow-view",
    /// Rounding moves what the camera sees by a visible part of a pixel.
    CameraPrecision = "camera-precision",
    /// The camera stands within a body.
    CameraInside = "camera-inside",
    /// A light stands within an opaque body.
    LightEnclosed = "light-enclosed",
    /// A light is so far away that its directions lose digits.
    LightFar = "light-far",
    /// A material reflects more light than arrives.
    EnergyGain = "energy-gain",
    /// A material, mesh or group that nothing uses.
    Unused = "unused",
    /// Not all could be looked at within bounded time.
    LimitReached = "limit-reached",
}

/// A measured number and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// In snake case; lengths are in world units, angles in degrees.
    pub name: &'static str,
    /// The number; possibly infinite.
    pub value: f64,
}

/// Something that a check found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What it is about.
    pub kind: Kind,
    /// Path and name of the object, or the name of the mesh, material, light or camera.
    pub object: String,
    /// What was measured.
    pub values: Vec<Measurement>,
    /// What was found.
    pub message: String,
    /// What to do about it.
    pub advice: &'static str,
}

/// Findings of one kind that a report counts but does not list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct More {
    /// Their severity.
    pub severity: Severity,
    /// Their kind.
    pub kind: Kind,
    /// How many there are beside those listed.
    pub count: u64,
}

/// The numerical health of a scene. The same scene gives the same report.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// What was measured of the scene as a whole.
    pub measures: Measures,
    /// What was found: the severest first, then by kind, then in the order of the scene.
    pub findings: Vec<Finding>,
    /// What is counted only, in the same order.
    pub more: Vec<More>,
}

impl Report {
    /// Number of findings of a severity, those included that are not listed.
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

/// Findings of one kind and severity that are listed; the rest is counted.
const MAX_LISTED: u64 = 8;

/// Collects findings, and keeps as many as people read.
#[derive(Debug, Default)]
pub(super) struct Findings {
    listed: Vec<Finding>,
    counts: BTreeMap<(Severity, Kind), u64>,
}

impl Findings {
    pub(super) fn add(&mut self, finding: Finding) {
        let count = self.counts.entry((finding.severity, finding.kind)).or_default();
        *count += 1;
        if *count <= MAX_LISTED {
            self.listed.push(finding);
        }
    }

    pub(super) fn extend(&mut self, findings: impl IntoIterator<Item = Finding>) {
        findings.into_iter().for_each(|finding| self.add(finding));
    }

    /// Sorted by severity and kind; within these, in the order in which they came.
    pub(super) fn report(mut self, measures: Measures) -> Report {
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

/// A measurement.
pub(super) const fn value(name: &'static str, value: f64) -> Measurement {
    Measurement { name, value }
}
