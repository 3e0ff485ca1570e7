//! What is told of a study: text, files, and a page.

use std::io::Write;

use rt_image::{Development, ImageFormat, write_image};
use rt_scene_io::Scene;

use super::files::{self, Circumstances, JsonFile};
use super::machine::Machine;
use super::measure::Study;
use super::outputs::Outputs;
use super::page::Page;
use super::plot::Plot;
use super::summary::{Precision, Summary, TRUSTED};
use super::table;
use super::yardstick::Yardstick;
use crate::args::{Against, ConvergeArgs};
use crate::error::Failure;
use crate::output::OutputError;

/// What holds for all of a study, whatever is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting<'a> {
    pub(super) args: &'a ConvergeArgs,
    pub(super) scene: &'a Scene,
    pub(super) against: Against,
    pub(super) yardstick: &'a Yardstick,
    /// What shows the pictures.
    pub(super) development: Development,
}

/// All that is told of a study.
#[derive(Debug)]
pub(super) struct Report<'a> {
    circumstances: Circumstances,
    study: &'a Study,
    summary: Summary,
    yardstick: &'a Yardstick,
    development: Development,
}

impl<'a> Report<'a> {
    pub(super) fn new(setting: Setting<'a>, study: &'a Study) -> Self {
        let Setting { args, scene, against, yardstick, development } = setting;
        let measured_against = match yardstick {
            Yardstick::Truth(truth) => {
                let [r, g, b] = truth.mean.to_array();
                format!("the mean radiance {r} {g} {b} that the scene declares: {}", truth.note)
            }
            Yardstick::Image(reference) => reference.note.clone(),
        };
        let picture = study.methods.iter().find_map(|method| method.last_picture());
        let [width, height] = picture.map_or([0; 2], |picture| [picture.film.width(), picture.film.height()]);
        let circumstances = Circumstances {
            scene: scene.name.clone(),
            width,
            height,
            against: against.name(),
            measured_against,
            floor: yardstick.floor(),
            seeds: args.seeds,
            threads: study.threads,
            machine: Machine::here(),
            left_out: study.left_out.clone(),
            bad_samples: study.bad_samples,
        };
        let summary = Summary::new(study, Precision::of(yardstick), args.error_goal);
        Self { circumstances, study, summary, yardstick, development }
    }

    /// The report for people.
    pub(super) fn text(&self) -> String {
        let tables =
            [table::points(&self.summary, self.yardstick.reference().is_some()), table::methods(&self.summary)];
        let mut lines = vec![tables[0].text(), String::new(), tables[1].text(), String::new()];
        lines.extend(self.notes());
        lines.push(self.circumstances.machine.line());
        lines.join("\n")
    }

    /// Sentences about the numbers.
    fn notes(&self) -> Vec<String> {
        let Circumstances { against, measured_against, floor, seeds, threads, width, height, left_out, .. } =
            &self.circumstances;
        let mut notes = vec![format!("measured against ({against}) {measured_against}")];
        if let Some(floor) = floor {
            let [rmse, relative] = [floor.mse.sqrt(), floor.relative_mse].map(table::number);
            notes.push(format!("its own RMSE is {rmse} (relMSE {relative}), which is subtracted"));
        }
        let mut points = self.summary.methods.iter().flat_map(|method| &method.points);
        if points.any(|point| !point.is_trusted) {
            notes.push(format!(
                "errors marked * are neither drawn nor fitted: they are below {:.2} times that of {}",
                TRUSTED.sqrt(),
                if floor.is_some() { "the reference" } else { "rounding" },
            ));
        }
        notes.push(format!("{width}x{height} pixels, {seeds} seeds, {threads} threads"));
        if self.summary.error_goal > 0.0 {
            notes.push(format!("the goal is an RMSE of {}", table::number(self.summary.error_goal)));
        }
        if !left_out.is_empty() {
            let list = left_out.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
            notes.push(format!("the time did not suffice for {list} samples per pixel, which are left out"));
        }
        notes
    }

    /// Writes all files, each of them whole.
    pub(super) fn write(&self, outputs: &Outputs) -> Result<(), Failure> {
        let title = format!("{}: error against run time", self.circumstances.scene);
        let plot = Plot::new(title, &self.summary, self.circumstances.floor);
        let failed = |reason| OutputError::Write { path: outputs.folder.clone(), reason };
        let svg = plot.as_ref().map(Plot::svg).transpose().map_err(failed)?;
        let film = plot.as_ref().map(Plot::film).transpose().map_err(failed)?;
        let notes = self.notes();
        let page = Page {
            circumstances: &self.circumstances,
            study: self.study,
            summary: &self.summary,
            yardstick: self.yardstick,
            development: self.development,
            plot: svg.as_deref(),
            notes: &notes,
        };
        let html = page.html().map_err(failed)?;
        let csv = files::csv(&self.circumstances, &self.summary).map_err(failed)?;
        let json = JsonFile { circumstances: &self.circumstances, summary: &self.summary };
        outputs.csv.write(|file| file.write_all(&csv))?;
        outputs.json.write(|file| serde_json::to_writer_pretty(file, &json))?;
        if let (Some(svg), Some(film)) = (&svg, &film) {
            outputs.svg.write(|file| file.write_all(svg.as_bytes()))?;
            outputs.png.write(|file| write_image(film, &Development::default(), ImageFormat::Png, file))?;
        }
        Ok(outputs.html.write(|file| file.write_all(html.as_bytes()))?)
    }
}
