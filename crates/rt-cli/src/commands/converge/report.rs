//! Report of an experiment: text, CSV, JSON, plot and HTML page.

use std::fs;
use std::path::{Path, PathBuf};

use rt_image::{Development, ImageFormat, write_image};
use rt_scene_io::Scene;
use serde::Serialize;

use super::plot::Plot;
use super::reference::Reference;
use super::run_info::{RunInfo, machine};
use super::runner::Experiment;
use super::summary::{Precision, Summary, TRUSTED};
use super::table;
use crate::args::{ConvergeArgs, ReferenceKind, name_of};
use crate::error::CliError;
use crate::output_error::OutputError;
use crate::output_file::OutputFile;

/// Output directory and files.
#[derive(Debug)]
pub(super) struct Outputs {
    pub(super) folder: PathBuf,
    pub(super) csv: OutputFile,
    pub(super) json: OutputFile,
    pub(super) svg: OutputFile,
    pub(super) png: OutputFile,
    pub(super) html: OutputFile,
    _created: Option<CreatedFolder>,
}

/// Directory that this program has created. It is removed at the end if it is still empty.
#[derive(Debug)]
struct CreatedFolder(PathBuf);

impl Drop for CreatedFolder {
    fn drop(&mut self) {
        // Fails for a directory with files.
        let _ = fs::remove_dir(&self.0);
    }
}

impl Outputs {
    /// Creates the directory if it is missing, and checks that the files are writable.
    pub(super) fn prepare(folder: &Path, inputs: &[PathBuf]) -> Result<Self, CliError> {
        let mut created = None;
        if !folder.is_dir() {
            if folder.exists() {
                let reason = "it is not a directory; choose another --output".to_owned();
                return Err(OutputError::Write { path: folder.to_owned(), reason }.into());
            }
            fs::create_dir(folder).map_err(|error| OutputError::Write {
                path: folder.to_owned(),
                reason: format!("the directory cannot be created: {error}"),
            })?;
            created = Some(CreatedFolder(folder.to_owned()));
        }
        let file = |extension: &str| OutputFile::prepare(&folder.join(format!("converge.{extension}")), inputs);
        let [csv, json, svg, png, html] = ["csv", "json", "svg", "png", "html"].map(file);
        let folder = folder.to_owned();
        Ok(Self { folder, csv: csv?, json: json?, svg: svg?, png: png?, html: html?, _created: created })
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Setting<'a> {
    pub(super) args: &'a ConvergeArgs,
    pub(super) scene: &'a Scene,
    pub(super) kind: ReferenceKind,
    pub(super) reference: &'a Reference,
    /// Tone mapping of the images.
    pub(super) development: Development,
}

#[derive(Debug)]
pub(super) struct Report<'a> {
    pub(super) info: RunInfo,
    pub(super) experiment: &'a Experiment,
    pub(super) summary: Summary,
    pub(super) reference: &'a Reference,
    /// Tone mapping of the images.
    pub(super) development: Development,
}

impl<'a> Report<'a> {
    pub(super) fn new(setting: Setting<'a>, experiment: &'a Experiment) -> Self {
        let Setting { args, scene, kind, reference, development } = setting;
        let measured_against = match reference {
            Reference::KnownMean(truth) => {
                let [r, g, b] = truth.mean.to_array();
                format!("the mean radiance {r} {g} {b} that the scene declares: {}", truth.note)
            }
            Reference::Image(image) => image.note.clone(),
        };
        let image = experiment.methods.iter().find_map(|method| method.last_image());
        let [width, height] = image.map_or([0; 2], |image| [image.film.width(), image.film.height()]);
        let info = RunInfo {
            scene: scene.name.clone(),
            width,
            height,
            against: name_of(kind),
            measured_against,
            floor: reference.floor(),
            seeds: args.seeds,
            threads: experiment.threads,
            machine: machine(),
            left_out: experiment.left_out.clone(),
            bad_samples: experiment.bad_samples,
        };
        let summary = Summary::new(experiment, Precision::of(reference), args.target_rmse);
        Self { info, experiment, summary, reference, development }
    }

    pub(super) fn text(&self) -> String {
        let tables = [table::points(&self.summary, self.reference.image().is_some()), table::methods(&self.summary)];
        let mut lines = vec![tables[0].text(), String::new(), tables[1].text(), String::new()];
        lines.extend(self.notes());
        lines.push(self.info.machine.line());
        lines.join("\n")
    }

    pub(super) fn title(&self) -> String {
        format!("{}: error against run time", self.info.scene)
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let RunInfo { against, measured_against, floor, seeds, threads, width, height, left_out, .. } = &self.info;
        let mut notes = vec![format!("measured against ({against}) {measured_against}")];
        if let Some(floor) = floor {
            let [rmse, relative] = [floor.mse.sqrt(), floor.relative_mse].map(table::number);
            notes.push(format!("the RMSE of the reference is {rmse} (relMSE {relative}) and is subtracted"));
        }
        let mut points = self.summary.methods.iter().flat_map(|method| &method.points);
        if points.any(|point| !point.is_trusted) {
            notes.push(format!(
                "errors marked * are excluded from plot and fits: they are below {:.2} times the RMSE of {}",
                TRUSTED.sqrt(),
                if floor.is_some() { "the reference" } else { "rounding" },
            ));
        }
        let unit = if *threads == 1 { "thread" } else { "threads" };
        notes.push(format!("{width}x{height} pixels, {seeds} seeds, {threads} {unit}"));
        if self.summary.target_rmse > 0.0 {
            notes.push(format!("the target RMSE is {}", table::number(self.summary.target_rmse)));
        }
        if !left_out.is_empty() {
            let list = left_out.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
            let reason = if self.experiment.is_interrupted { "an interrupt" } else { "the time limit" };
            notes.push(format!("{reason} skipped {list} samples per pixel"));
        }
        notes
    }

    pub(super) fn write(&self, outputs: &Outputs) -> Result<(), CliError> {
        let plot = Plot::new(self.title(), &self.summary, self.info.floor);
        let failed = |reason| OutputError::Write { path: outputs.folder.clone(), reason };
        let svg = plot.as_ref().map(Plot::svg).transpose().map_err(failed)?;
        let film = plot.as_ref().map(Plot::film).transpose().map_err(failed)?;
        let html = self.html(svg.as_deref()).map_err(failed)?;
        let csv = csv(&self.info, &self.summary).map_err(failed)?;
        let json = JsonFile { info: &self.info, summary: &self.summary };
        outputs.csv.write(|file| file.write_all(&csv))?;
        outputs.json.write(|file| serde_json::to_writer_pretty(file, &json))?;
        if let (Some(svg), Some(film)) = (&svg, &film) {
            outputs.svg.write(|file| file.write_all(svg.as_bytes()))?;
            outputs.png.write(|file| write_image(film, &Development::default(), ImageFormat::Png, file))?;
        }
        Ok(outputs.html.write(|file| file.write_all(html.as_bytes()))?)
    }
}

#[derive(Debug, Serialize)]
struct JsonFile<'a> {
    #[serde(flatten)]
    pub(super) info: &'a RunInfo,
    #[serde(flatten)]
    pub(super) summary: &'a Summary,
}

/// Line of the CSV file.
#[derive(Debug, Serialize)]
struct Row<'a> {
    method: &'a str,
    integrator: &'a str,
    sampler: &'a str,
    accel: &'a str,
    depth: u32,
    spp: u32,
    seeds: usize,
    threads: usize,
    cpu_seconds: f64,
    wall_seconds: f64,
    build_seconds: f64,
    rmse: Option<f64>,
    rmse_median: Option<f64>,
    rmse_low: Option<f64>,
    rmse_high: Option<f64>,
    relative_mse: f64,
    bias: f64,
    bias_standard_error: f64,
    flip: Option<f64>,
    efficiency: Option<f64>,
    floor_rmse: Option<f64>,
    is_trusted: bool,
}

fn csv(info: &RunInfo, summary: &Summary) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for method in &summary.methods {
        for point in &method.points {
            let row = Row {
                method: &method.name.label,
                integrator: method.name.integrator,
                sampler: method.name.sampler,
                accel: method.name.accel,
                depth: method.name.depth,
                spp: point.spp,
                seeds: point.runs.len(),
                threads: info.threads,
                cpu_seconds: point.seconds,
                wall_seconds: point.wall_seconds,
                build_seconds: point.build_seconds,
                rmse: point.rmse,
                rmse_median: point.rmse_median,
                rmse_low: point.rmse_interval.map(|interval| interval.low),
                rmse_high: point.rmse_interval.map(|interval| interval.high),
                relative_mse: point.relative_mse,
                bias: point.bias,
                bias_standard_error: point.bias_standard_error,
                flip: point.flip,
                efficiency: point.efficiency,
                floor_rmse: info.floor.map(|floor| floor.mse.sqrt()),
                is_trusted: point.is_trusted,
            };
            writer.serialize(row).map_err(|error| error.to_string())?;
        }
    }
    writer.into_inner().map_err(|error| error.to_string())
}
