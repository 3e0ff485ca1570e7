//! `check`: numerical health of a scene, as text or JSON.

use indexmap::IndexMap;
use rt_render::check::{CameraMeasures, Finding, Measures, More, Report, Severity, check};
use rt_render::{MemoryPrediction, RenderError};
use serde::Serialize;

use crate::args::{CheckArgs, ReportFormat};
use crate::console::{Console, print, show};
use crate::error::CliError;
use crate::input::{self, Input};

pub(super) fn run(args: &CheckArgs) -> Result<(), CliError> {
    // The report includes the warnings of the loader.
    let Input { scene, options, .. } = input::read(&args.input, None, Console { quiet: true })?;
    if let Err(shortage @ RenderError::Memory(_)) = MemoryPrediction::of_scene(&scene, options.memory.limit()) {
        return Err(CliError::plan(&args.input.scene, shortage));
    }
    let report = check(&scene);
    match args.format {
        ReportFormat::Text => show(format_args!("{report}"))?,
        ReportFormat::Json => print(json(&ReportFile::new(&scene.name, &report))?)?,
    }
    match report.count(Severity::Error) + report.count(Severity::Warning) {
        count if args.strict && count > 0 => Err(CliError::Warnings {
            file: args.input.scene.clone(),
            count: usize::try_from(count).unwrap_or(usize::MAX),
        }),
        _ => Ok(()),
    }
}

fn json(report: &ReportFile<'_>) -> Result<String, CliError> {
    let text = serde_json::to_string_pretty(report).map_err(|error| CliError::Stdout(error.into()))?;
    Ok(text + "\n")
}

/// JSON report; `check --help` documents it.
#[derive(Debug, Serialize)]
struct ReportFile<'r> {
    program: &'static str,
    version: &'static str,
    scene: &'r str,
    measures: MeasuresEntry<'r>,
    findings: Vec<FindingEntry<'r>>,
    more: Vec<MoreEntry>,
    errors: u64,
    warnings: u64,
    notes: u64,
}

#[derive(Debug, Serialize)]
struct MeasuresEntry<'r> {
    objects: u64,
    infinite_objects: u64,
    triangles: u64,
    /// Minimum and maximum corner; `null` without finite objects.
    bounds: Option<[[f64; 3]; 2]>,
    extent: f64,
    smallest: f64,
    dynamic_range: f64,
    origin_distance: f64,
    condition: f64,
    cameras: Vec<CameraEntry<'r>>,
}

#[derive(Debug, Serialize)]
struct CameraEntry<'r> {
    name: &'r str,
    rays: u64,
    hits: u64,
    nearest: f64,
    farthest: f64,
    position_error: f64,
    position_error_in_pixels: f64,
    pixel_angle: f64,
}

#[derive(Debug, Serialize)]
struct FindingEntry<'r> {
    severity: &'static str,
    kind: &'static str,
    object: &'r str,
    values: IndexMap<&'static str, f64>,
    message: &'r str,
    advice: &'static str,
}

#[derive(Debug, Serialize)]
struct MoreEntry {
    severity: &'static str,
    kind: &'static str,
    count: u64,
}

impl<'r> ReportFile<'r> {
    fn new(scene: &'r str, report: &'r Report) -> Self {
        Self {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            scene,
            measures: MeasuresEntry::from(&report.measures),
            findings: report.findings.iter().map(FindingEntry::from).collect(),
            more: report.more.iter().map(MoreEntry::from).collect(),
            errors: report.count(Severity::Error),
            warnings: report.count(Severity::Warning),
            notes: report.count(Severity::Info),
        }
    }
}

impl<'r> From<&'r Measures> for MeasuresEntry<'r> {
    fn from(measures: &'r Measures) -> Self {
        Self {
            objects: measures.objects,
            infinite_objects: measures.infinite_objects,
            triangles: measures.triangles,
            bounds: measures.bounds.map(|bounds| [bounds.min.into(), bounds.max.into()]),
            extent: measures.extent,
            smallest: measures.smallest,
            dynamic_range: measures.dynamic_range,
            origin_distance: measures.origin_distance,
            condition: measures.condition,
            cameras: measures.cameras.iter().map(CameraEntry::from).collect(),
        }
    }
}

impl<'r> From<&'r CameraMeasures> for CameraEntry<'r> {
    fn from(camera: &'r CameraMeasures) -> Self {
        Self {
            name: &camera.name,
            rays: camera.rays,
            hits: camera.hits,
            nearest: camera.nearest,
            farthest: camera.farthest,
            position_error: camera.position_error,
            position_error_in_pixels: camera.position_error_in_pixels,
            pixel_angle: camera.pixel_angle,
        }
    }
}

impl<'r> From<&'r Finding> for FindingEntry<'r> {
    fn from(finding: &'r Finding) -> Self {
        Self {
            severity: finding.severity.name(),
            kind: finding.kind.code(),
            object: &finding.object,
            values: finding.values.iter().map(|measured| (measured.name, measured.value)).collect(),
            message: &finding.message,
            advice: finding.advice,
        }
    }
}

impl From<&More> for MoreEntry {
    fn from(more: &More) -> Self {
        Self { severity: more.severity.name(), kind: more.kind.code(), count: more.count }
    }
}
