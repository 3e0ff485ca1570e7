//! `check`: numerical health of a scene, as text or JSON.

use rt_check::{CameraMeasures, CheckMemory, Finding, Report, Severity, check};
use rt_render::{MemoryPrediction, RenderError};
use rt_scene_io::{MemoryError, Scene};
use serde_json::{Map, Value, json};

use crate::args::{CheckArgs, ReportFormat};
use crate::console::{Console, print, show};
use crate::error::CliError;
use crate::input::{self, Input};

pub(super) fn run(args: &CheckArgs) -> Result<(), CliError> {
    // The report includes the warnings of the loader.
    let Input { scene, options, .. } = input::read(&args.input, None, Console { quiet: true })?;
    check_memory(&scene, options.memory.limit()).map_err(|cause| CliError::plan(&args.input.scene, cause.into()))?;
    let report = check(&scene);
    match args.format {
        ReportFormat::Text => show(format_args!("{report}"))?,
        ReportFormat::Json => print(format_args!("{:#}\n", report_json(&scene.name, &report)))?,
    }
    match report.count(Severity::Error) + report.count(Severity::Warning) {
        count if args.strict && count > 0 => Err(CliError::Warnings {
            file: args.input.scene.clone(),
            count: usize::try_from(count).unwrap_or(usize::MAX),
        }),
        _ => Ok(()),
    }
}

/// Error if the check needs more memory than the budget.
fn check_memory(scene: &Scene, budget: Option<u64>) -> Result<(), MemoryError> {
    let geometry = match MemoryPrediction::of_scene(scene, budget) {
        Ok(prediction) => prediction,
        Err(RenderError::Memory(error)) => return Err(error),
        // The report states why the scene cannot be rendered.
        Err(_) => MemoryPrediction::default(),
    };
    let lists = CheckMemory::of(scene).peak();
    // The lists are made after the accelerators.
    let held = MemoryPrediction { film: lists, ..geometry };
    match budget {
        Some(budget) if held.peak() > budget => {
            let MemoryPrediction { textures, geometry, accelerators, .. } = held;
            let lists = (lists, "the lists of objects, faces and edges of the check");
            let parts = [(textures, "textures"), (geometry, "geometry"), (accelerators, "accelerators"), lists];
            let (most, largest) = parts.into_iter().max().unwrap_or(lists);
            Err(MemoryError { predicted: held.peak(), budget, largest: largest.to_owned(), most })
        }
        _ => Ok(()),
    }
}

/// JSON report; `check --help` documents it.
fn report_json(scene: &str, report: &Report) -> Value {
    let measures = &report.measures;
    let more = report.more.iter();
    json!({
        "program": env!("CARGO_PKG_NAME"),
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene,
        "measures": {
            "objects": measures.objects,
            "infinite_objects": measures.infinite_objects,
            "triangles": measures.triangles,
            "bounds": measures.bounds.map(|bounds| [bounds.min.to_array(), bounds.max.to_array()]),
            "extent": measures.extent,
            "smallest": measures.smallest,
            "dynamic_range": measures.dynamic_range,
            "origin_distance": measures.origin_distance,
            "condition": measures.condition,
            "cameras": measures.cameras.iter().map(camera_json).collect::<Vec<_>>(),
        },
        "findings": report.findings.iter().map(finding_json).collect::<Vec<_>>(),
        "more": more
            .map(|more| json!({ "severity": more.severity.name(), "kind": more.kind.code(), "count": more.count }))
            .collect::<Vec<_>>(),
        "errors": report.count(Severity::Error),
        "warnings": report.count(Severity::Warning),
        "notes": report.count(Severity::Note),
    })
}

fn camera_json(camera: &CameraMeasures) -> Value {
    json!({
        "name": camera.name,
        "rays": camera.rays,
        "hits": camera.hits,
        "nearest": camera.nearest,
        "farthest": camera.farthest,
        "position_error": camera.position_error,
        "position_error_in_pixels": camera.position_error_in_pixels,
        "pixel_angle": camera.pixel_angle,
    })
}

fn finding_json(finding: &Finding) -> Value {
    let values: Map<_, _> =
        finding.values.iter().map(|measured| (measured.name.to_owned(), measured.value.into())).collect();
    json!({
        "severity": finding.severity.name(),
        "kind": finding.kind.code(),
        "object": finding.object,
        "values": values,
        "message": finding.message,
        "advice": finding.advice,
    })
}
