//! Physics: our images compared with independent references, block by block.
//!
//! A pair is a folder with a scene, `pair.json` and `ref.json`. Pairs lie in `tests/physics/pairs`, further ones in a
//! shared folder outside of the project. The guide is docs/PHYSICS.md; `--write` renews its table.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use super::unit::{Context, Findings, Outcome, Unit};
use crate::{error::TaskError, files, workspace::Workspace};

mod blocks;
mod comparison;
mod pair;
mod score;
pub(super) mod table;

use blocks::Blocks;
use comparison::{Comparison, MEAN_LIMIT};
use pair::{BlockMeans, Effort, Expect, OWN, Pair, Series};
use score::{RelativeTolerance, Score};
use table::PairRow;

/// Pairs outside of the project.
const SHARED: &str = "../shared/reference/physics/pairs";
/// Ratios of the pairs that differ by convention.
const CONVENTIONS: &str = "tests/physics/conventions.json";

/// Work per pair without `--full`.
const REDUCED: Effort = Effort { max_seeds: 8, divisor: 4, min_samples: 16 };
/// Work that a pair outside of the project starts with. If it fails, it is compared again with [`REDUCED`]: means of few
/// samples may be skewed.
const FIRST: Effort = Effort { max_seeds: 8, divisor: 16, min_samples: 4 };

/// One unit per pair, and one that plants faults. Pairs of the project take precedence over others of the same name.
pub(super) fn units(workspace: &Workspace, more: Option<&Path>) -> Result<Vec<Unit>, TaskError> {
    let shared = more.map_or_else(|| workspace.root.join(SHARED), Path::to_path_buf);
    if more.is_some() && !shared.is_dir() {
        return Err(TaskError::Other(format!("{}: the folder of pairs does not exist", shared.display())));
    }
    let mut pairs = BTreeMap::new();
    for (parent, is_own) in [(shared.clone(), false), (workspace.root.join(OWN), true)] {
        for folder in folders(&parent)? {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            pairs.insert(name.clone(), PairFolder { name, folder, is_own });
        }
    }
    let mut units = vec![Unit::new("physics/planted-fault", planted_fault)];
    units.extend(pairs.into_values().map(|pair| {
        Unit::new(format!("physics/{}", pair.name), move |context, folder, findings| {
            pair.run(context, folder, findings)
        })
    }));
    if !shared.is_dir() {
        units.push(Unit::new("physics/beside-the-project", |_, _, findings| {
            findings.note(format!("skipped: {SHARED} is not here"));
            Ok(())
        }));
    }
    Ok(units)
}

/// Writes the table of the pairs among the outcomes into `folder`, and with `write` into the guide.
pub(super) fn finish(
    workspace: &Workspace,
    outcomes: &[Outcome],
    folder: &Path,
    full: bool,
    write: bool,
) -> Result<(), TaskError> {
    let rows = outcomes.iter().filter_map(|outcome| outcome.findings.pair.as_ref()).collect();
    table::finish(workspace, rows, folder, effort(full), write)
}

fn effort(full: bool) -> Effort {
    if full { Effort::FULL } else { REDUCED }
}

/// Folders of pairs in `parent`, which may be missing.
fn folders(parent: &Path) -> Result<Vec<PathBuf>, TaskError> {
    if !parent.is_dir() {
        return Ok(Vec::new());
    }
    let entries = crate::workspace::sorted_entries(parent)?;
    Ok(entries.into_iter().filter(|folder| folder.join("pair.json").is_file()).collect())
}

struct PairFolder {
    name: String,
    folder: PathBuf,
    is_own: bool,
}

impl PairFolder {
    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        let pair = Pair::load(&self.folder)?;
        let efforts: &[Effort] = match (context.full, self.is_own) {
            (true, _) => &[Effort::FULL],
            (false, true) => &[REDUCED],
            (false, false) => &[FIRST, REDUCED],
        };
        for &effort in efforts {
            *findings = Findings::default();
            self.compare(context, folder, &pair, effort, findings)?;
            if findings.problems.is_empty() {
                break;
            }
        }
        Ok(())
    }

    fn compare(
        &self,
        context: &Context,
        folder: &Path,
        pair: &Pair,
        effort: Effort,
        findings: &mut Findings,
    ) -> Result<(), TaskError> {
        let (ours, reference) = both(context, folder, &self.folder, (pair, effort))?;
        let comparison = Comparison::of(&ours, &reference, pair.tolerance());
        let differs = !comparison.problems.is_empty();
        let recorded: BTreeMap<String, Convention> = files::read_json(&context.workspace.root.join(CONVENTIONS))?;
        let recorded = recorded.get(&self.name);
        classify(pair.expect, &comparison.problems, recorded, findings);
        if differs && pair.expect != Expect::Agree {
            findings.problems.extend(recorded.into_iter().flat_map(|it| it.broken_by(&ours, &reference)));
        }
        findings.notes.extend(comparison.notes.iter().cloned());
        let passed = findings.problems.is_empty();
        let verdict = match (pair.expect, differs) {
            _ if !passed => "FAILS",
            (Expect::Convention, _) => "differs by convention",
            (Expect::Known, true) => "differs, known",
            (Expect::Agree | Expect::Known, _) => "agrees",
        };
        let (name, is_own) = (self.name.clone(), self.is_own);
        let (note, kind) = (pair.note.clone(), pair.kind.clone());
        let row = PairRow { name, is_own, kind, note, comparison, verdict };
        findings.note(row.line());
        findings.pair = Some(row);
        Ok(())
    }
}

/// Reports the differences of a pair against what is expected of it. Expected differences need a recorded ratio.
fn classify(expect: Expect, differences: &[String], recorded: Option<&Convention>, findings: &mut Findings) {
    match (expect, !differences.is_empty()) {
        (Expect::Agree, _) => findings.problems = differences.to_vec(),
        (Expect::Convention, false) => findings.problem("agrees, although a convention makes it differ"),
        (Expect::Convention | Expect::Known, true) if recorded.is_none() => {
            findings.problem(format!("differs as expected, but {CONVENTIONS} does not say by how much"));
        }
        (Expect::Known, false) => findings.note("agrees by now, although it was known to differ"),
        (Expect::Known, true) => findings.note("differs, as is known"),
        (Expect::Convention, true) => {}
    }
}

/// One pair of each kind.
const SOUND: [&str; 3] = ["sky-gold-r0.3", "depth-1", "drawn-or-found-glossy"];
const FAULT: f64 = 1.01;

/// Compares with references that are off by a hundredth.
fn planted_fault(context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
    for name in SOUND {
        let pair_folder = context.workspace.root.join(OWN).join(name);
        let pair = Pair::load(&pair_folder)?;
        let effort = effort(context.full);
        let (ours, reference) = both(context, folder, &pair_folder, (&pair, effort))?;
        for (factor, is_sound) in [(1.0, true), (FAULT, false), (1.0 / FAULT, false)] {
            let problems = Comparison::of(&ours, &reference.scaled([factor; 3]), pair.tolerance()).problems;
            if problems.is_empty() != is_sound {
                let verdict = if is_sound { "refused" } else { "accepted" };
                findings.problem(format!("{name}: a reference times {factor:.4} is {verdict}"));
            }
        }
    }
    Ok(())
}

/// Recorded difference of a pair that differs by convention.
#[derive(Debug, Deserialize)]
struct Convention {
    /// Our image mean divided by that of the reference, by channel.
    ratio: [f64; 3],
    /// Relative tolerance of the ratio, as a standard deviation.
    within: f64,
}

impl Convention {
    /// Channels whose ratio is no longer the recorded one.
    fn broken_by(&self, ours: &BlockMeans, reference: &BlockMeans) -> Vec<String> {
        let expected = reference.scaled(self.ratio);
        let tolerance = RelativeTolerance { relative: self.within, absolute: 0.0 };
        let mut broken = Vec::new();
        for channel in 0..3 {
            let z = Score::of(ours.image[channel], expected.image[channel], tolerance).z;
            // NaN is a failure, too.
            if !(z.abs() <= MEAN_LIMIT) {
                let ratio = ours.image[channel].mean / reference.image[channel].mean;
                broken.push(format!(
                    "channel {channel}: differs by a factor of {ratio:.5} instead of {:.5}, score {z:+.1}; {CONVENTIONS}",
                    self.ratio[channel]
                ));
            }
        }
        broken
    }
}

/// Our means and those of the reference.
fn both(
    context: &Context,
    folder: &Path,
    pair_folder: &Path,
    (pair, effort): (&Pair, Effort),
) -> Result<(BlockMeans, BlockMeans), TaskError> {
    let series = pair.series(pair_folder, effort);
    let ours = render(context, folder, &series, pair.block)?;
    let shape = |renders: &[Blocks]| renders.first().map_or([0; 2], |render| [render.rows, render.columns]);
    let (reference, expected) = if pair.is_of_ours_alone() {
        let renders = render(context, folder, &pair.reference_series(pair_folder, effort), pair.block)?;
        (BlockMeans::of_seeds(&renders), shape(&renders))
    } else {
        BlockMeans::load(pair_folder)?
    };
    let [rows, columns] = shape(&ours);
    if [rows, columns] != expected {
        let [expected_rows, expected_columns] = expected;
        let problem = format!("{columns}×{rows} blocks instead of {expected_columns}×{expected_rows}");
        return Err(TaskError::Other(problem));
    }
    // The mean of a block that one sample has lit as brightly as the brightest pixel.
    let samples = f64::from(series.spp.unwrap_or(1)) * f64::from(series.seeds) * (pair.block * pair.block) as f64;
    let event = ours.iter().fold(0.0, |most: f64, render| most.max(render.brightest)) / samples;
    Ok((BlockMeans::of_seeds(&ours).with_rare_events(&reference, event), reference))
}

fn render(context: &Context, folder: &Path, series: &Series, block: usize) -> Result<Vec<Blocks>, TaskError> {
    const OUTPUT: &str = "image.pfm";
    if series.seeds == 0 || block == 0 {
        return Err(TaskError::Other("seeds and block must be 1 or more".to_owned()));
    }
    let output = folder.join(OUTPUT);
    let mut renders: Vec<Blocks> = Vec::new();
    for seed in (series.first_seed..).take(series.seeds as usize) {
        // Pairs run side by side, so that each has one thread.
        let mut args = vec!["--threads".to_owned(), "1".to_owned(), "--seed".to_owned(), seed.to_string()];
        if let Some(spp) = series.spp {
            args.extend(["--spp".to_owned(), spp.to_string()]);
        }
        args.extend(series.args.iter().cloned());
        context.renderer.render(folder, &series.scene, OUTPUT, args.iter().map(String::as_str))?;
        let film = rt_image::read_image(&output).map_err(TaskError::other)?;
        renders.push(Blocks::of_film(&film, block));
    }
    fs::remove_file(&output).map_err(TaskError::file(&output))?;
    Ok(renders)
}

#[cfg(test)]
mod tests {
    use super::{score::BlockEstimate, *};

    #[test]
    fn a_convention_that_changes_is_found() {
        let with_mean = |mean: f64| {
            let estimate = BlockEstimate { mean, variance: 1e-8, freedom: 15.0 };
            BlockMeans { blocks: vec![estimate; 3], image: [estimate; 3] }
        };
        let convention = Convention { ratio: [1.02; 3], within: 0.001 };
        assert_eq!(convention.broken_by(&with_mean(1.02), &with_mean(1.0)), Vec::<String>::new());
        assert_eq!(convention.broken_by(&with_mean(1.03), &with_mean(1.0)).len(), 3);
        assert_eq!(convention.broken_by(&with_mean(1.0), &with_mean(1.0)).len(), 3);
        assert_eq!(convention.broken_by(&with_mean(f64::NAN), &with_mean(1.0)).len(), 3);
    }

    /// A pair that was known to differ passed without a recorded ratio.
    #[test]
    fn expected_differences_without_a_recorded_ratio_fail() {
        let convention = Convention { ratio: [1.02; 3], within: 0.001 };
        let differences = ["darker".to_owned()];
        let passes = |expect, differences: &[String], recorded| {
            let mut findings = Findings::default();
            classify(expect, differences, recorded, &mut findings);
            findings.problems.is_empty()
        };
        for expect in [Expect::Known, Expect::Convention] {
            assert!(passes(expect, &differences, Some(&convention)), "{expect:?}");
            assert!(!passes(expect, &differences, None), "{expect:?}");
        }
        for recorded in [None, Some(&convention)] {
            assert!(passes(Expect::Agree, &[], recorded) && !passes(Expect::Agree, &differences, recorded));
            assert!(passes(Expect::Known, &[], recorded) && !passes(Expect::Convention, &[], recorded));
        }
    }

    #[test]
    fn all_pairs_of_the_project_can_be_read() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let conventions: BTreeMap<String, Convention> = files::read_json(&root.join(CONVENTIONS)).unwrap();
        let folders = folders(&root.join(OWN)).unwrap();
        assert!(folders.len() >= 40, "{}", folders.len());
        for folder in folders {
            let pair = Pair::load(&folder).unwrap_or_else(|error| panic!("{error}"));
            let name = folder.file_name().unwrap().to_string_lossy().into_owned();
            assert!(pair.series(&folder, Effort::FULL).scene.is_file(), "{name}: no scene");
            if !pair.is_of_ours_alone() {
                let (reference, _) = BlockMeans::load(&folder).unwrap_or_else(|error| panic!("{error}"));
                assert!(reference.image.iter().all(|channel| channel.mean.is_finite()), "{name}");
            }
            assert!(pair.expect != Expect::Convention || conventions.contains_key(&name), "{name}: no ratio");
        }
    }
}
