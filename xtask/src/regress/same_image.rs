//! One image: threads, accelerators and instruction sets change no bit of it.
//!
//! Each scene file is rendered by its own integrator with other thread counts, accelerators, instruction sets and build
//! qualities. It is also rendered as two shards, and with the full plan. Other integrators follow, each with two ways
//! to compute it. Without `--full`, integrators and accelerators take turns. A scene is rendered with two integrators, the
//! default accelerator, brute force and two others, and every third scene as shards. `numerics/S47` renders each scene of the
//! project with all accelerators, without the program.

use std::{
    fs,
    path::{Path, PathBuf},
};

use rt_accel::{
    AcceleratorKind,
    wide::{Quality, SimdLevel},
};

use super::unit::{Context, Findings, Unit};
use crate::{error::TaskError, workspace::Workspace};

/// Integrators and debug views, without the cost view, which depends on the accelerator.
const INTEGRATORS: [&str; 9] =
    ["whitted", "distributed", "path", "path-caustics", "direct", "ambient-occlusion", "normals", "depth", "uv"];
/// Integrators per scene without `--full`.
const INTEGRATORS_AT_A_TIME: usize = 2;
/// Distance of the scenes that are rendered as shards without `--full`.
const SHARDS_EVERY: usize = 3;
/// Accelerators per scene without `--full`, apart from the default and brute force.
const ACCELERATORS_AT_A_TIME: usize = 2;

/// Enough for several tiles, and for every kind of ray that the scene has.
const REDUCED: &[&str] = &["--size", "48x36", "--spp", "4"];
/// Size and samples for brute force, which takes longer than all other variants together.
const REDUCED_BRUTE_FORCE: &[&str] = &["--size", "24x18", "--spp", "2"];
/// Size and samples for the other integrators.
const REDUCED_OTHERS: &[&str] = &["--size", "32x24", "--spp", "2"];

/// Options of a render.
type Variant = Vec<&'static str>;

struct SameImage {
    scene: PathBuf,
    /// Number of the scene: by it, scenes take turns.
    turn: usize,
}

/// One unit per scene file of the project and per golden image.
pub(super) fn units(workspace: &Workspace) -> Result<Vec<Unit>, TaskError> {
    let mut scenes = workspace.files("scenes", ".ron")?;
    scenes.extend(workspace.files("scenes/spd", ".nff")?);
    scenes.extend(workspace.files("scenes/gallery", ".pbrt")?);
    scenes.extend(workspace.files("tests/golden", ".ron")?);
    let unit = |(turn, scene): (usize, PathBuf)| {
        let name = format!("one-picture/{}", workspace.relative(&scene.with_extension("")));
        let same_image = SameImage { scene, turn };
        Unit::new(name, move |context, folder, findings| same_image.run(context, folder, findings))
    };
    Ok(scenes.into_iter().enumerate().map(unit).collect())
}

/// SIMD level for this turn, cycling through those of the processor.
fn level(turn: usize) -> &'static str {
    let levels: Vec<SimdLevel> = SimdLevel::ALL.iter().copied().filter(|level| level.is_available()).collect();
    levels[turn % levels.len()].name()
}

fn quality(turn: usize) -> &'static str {
    Quality::ALL[turn % Quality::ALL.len()].name()
}

/// All variants but brute force. The others are compared with the first. Without `full`, accelerators take turns.
fn variants(turn: usize, full: bool) -> Vec<Variant> {
    let mut variants = vec![vec!["--threads", "1"]];
    // In three turns, each instruction set meets each build quality.
    for turn in turn..if full { turn + 3 } else { turn + 1 } {
        for (index, threads) in ["2", "3", "8"].into_iter().enumerate() {
            variants.push(vec!["--threads", threads, "--simd", level(index), "--quality", quality(turn + index)]);
        }
    }
    // By turns with each instruction set.
    variants[1 + turn % 3].insert(0, "--full-plan");
    let other = |kind: &AcceleratorKind| !matches!(kind, AcceleratorKind::Wide | AcceleratorKind::Linear);
    let others: Vec<_> = AcceleratorKind::ALL.iter().copied().filter(other).collect();
    let count = if full { others.len() } else { ACCELERATORS_AT_A_TIME };
    for index in 0..count {
        variants.push(vec!["--threads", "2", "--accel", others[(turn * count + index) % others.len()].name()]);
    }
    variants
}

/// Brute force apart: at full quality it would take hours.
fn brute_force(turn: usize, full: bool) -> Vec<Variant> {
    let linear = |turn| vec!["--threads", "2", "--accel", "linear", "--simd", level(turn)];
    let turns = turn..if full { turn + 3 } else { turn + 1 };
    [vec!["--threads", "2"]].into_iter().chain(turns.map(linear)).collect()
}

/// Two ways to compute the image of an integrator, which differ in everything and depend on the turn.
fn integrator_variants(integrator: &'static str, turn: usize) -> Vec<Variant> {
    let kinds: Vec<_> = AcceleratorKind::ALL.iter().filter(|kind| **kind != AcceleratorKind::Linear).collect();
    let accel = kinds[turn % kinds.len()].name();
    let own = vec!["--integrator", integrator, "--threads", "1"];
    let other = ["--threads", "3", "--accel", accel, "--simd", level(turn), "--quality", quality(turn), "--full-plan"];
    vec![own, [&["--integrator", integrator], &other[..]].concat()]
}

/// Integrators that a scene takes, by its turn.
fn integrators(turn: usize, full: bool) -> impl Iterator<Item = &'static str> {
    let count = if full { INTEGRATORS.len() } else { INTEGRATORS_AT_A_TIME };
    (0..count).map(move |index| INTEGRATORS[(turn * count + index) % INTEGRATORS.len()])
}

impl SameImage {
    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        let [quality, brute_force_quality, others_quality]: [&[&str]; 3] = if context.full {
            [&[], &["--spp", "1"], &["--spp", "4"]]
        } else {
            [REDUCED, REDUCED_BRUTE_FORCE, REDUCED_OTHERS]
        };
        let first = self.compare(context, folder, quality, &variants(self.turn, context.full), findings)?;
        if let Some(first) = first.filter(|_| context.full || self.turn.is_multiple_of(SHARDS_EVERY)) {
            self.compare_shards(context, folder, quality, &first, findings)?;
        }
        self.compare(context, folder, brute_force_quality, &brute_force(self.turn, context.full), findings)?;
        for (index, integrator) in integrators(self.turn, context.full).enumerate() {
            // Neighbours in the list of scenes, which are alike, get other accelerators.
            let variants = integrator_variants(integrator, self.turn * INTEGRATORS_AT_A_TIME + index);
            self.compare(context, folder, others_quality, &variants, findings)?;
        }
        Ok(())
    }

    /// Renders all variants and compares the bytes with those of the first, which are returned.
    fn compare(
        &self,
        context: &Context,
        folder: &Path,
        quality: &[&str],
        variants: &[Variant],
        findings: &mut Findings,
    ) -> Result<Option<Vec<u8>>, TaskError> {
        let mut first: Option<Vec<u8>> = None;
        for variant in variants {
            let args = quality.iter().chain(variant).copied();
            let run = context.renderer.render(folder, &self.scene, "linear.pfm", args);
            let variant = variant.join(" ");
            if let Err(error) = run {
                findings.problem(format!("{variant}: {error}"));
                continue;
            }
            let bytes = read(&folder.join("linear.pfm"))?;
            match &first {
                None => first = Some(bytes),
                Some(first) => check_run(first, &bytes, &variant, findings),
            }
        }
        Ok(first)
    }

    /// Renders two shards, each with every other tile, joins them, and compares the bytes.
    fn compare_shards(
        &self,
        context: &Context,
        folder: &Path,
        quality: &[&str],
        first: &[u8],
        findings: &mut Findings,
    ) -> Result<(), TaskError> {
        for (shard, part) in [("2/2", "2.part"), ("1/2", "1.part")] {
            let args = quality.iter().copied().chain(["--shard", shard, "--threads", "2"]);
            context.renderer.render(folder, &self.scene, part, args)?;
        }
        context.renderer.run(folder, ["merge", "1.part", "2.part", "-o", "linear.pfm"])?.succeeded()?;
        check_run(first, &read(&folder.join("linear.pfm"))?, "two shards", findings);
        Ok(())
    }
}

fn read(path: &Path) -> Result<Vec<u8>, TaskError> {
    fs::read(path).map_err(TaskError::file(path))
}

fn check_run(expected: &[u8], actual: &[u8], variant: &str, findings: &mut Findings) {
    if expected != actual {
        findings.problem(format!("{variant}: {}", difference(expected, actual)));
    }
}

/// Difference of two files of linear 32-bit values, in words.
fn difference(expected: &[u8], actual: &[u8]) -> String {
    if expected.len() != actual.len() {
        return format!("{} bytes instead of {}", actual.len(), expected.len());
    }
    let differing = expected.iter().zip(actual).filter(|(a, b)| a != b).count();
    format!("{differing} of {} bytes differ from the first variant", expected.len())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn differing_bytes_are_counted() {
        assert_eq!(difference(&[1, 2, 3, 4], &[1, 9, 3, 9]), "2 of 4 bytes differ from the first variant");
        assert_eq!(difference(&[1, 2], &[1]), "1 bytes instead of 2");
        let mut findings = Findings::default();
        check_run(&[1, 2], &[1, 2], "same", &mut findings);
        check_run(&[1, 2], &[1, 3], "other", &mut findings);
        assert_eq!(findings.problems, ["other: 1 of 2 bytes differ from the first variant"]);
    }

    /// Regression: instruction sets, build qualities and integrators were not varied.
    #[test]
    fn everything_that_must_not_matter_is_varied() {
        let all = |turns: usize, full| -> Vec<Variant> {
            (0..turns).flat_map(|turn| [variants(turn, full), brute_force(turn, full)].concat()).collect()
        };
        // A full run varies everything on each scene, and a short one on five consecutive scenes.
        for variants in [all(1, true), all(5, false)] {
            let has = |expected: &[&str]| {
                variants.iter().any(|variant| variant.windows(expected.len()).any(|w| w == expected))
            };
            for kind in AcceleratorKind::ALL.iter().filter(|kind| **kind != AcceleratorKind::Wide) {
                assert!(has(&["--accel", kind.name()]), "{}", kind.name());
            }
            for quality in Quality::ALL {
                assert!(has(&["--quality", quality.name()]), "{}", quality.name());
            }
            for level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
                assert!(has(&["--simd", level.name()]), "{}", level.name());
            }
        }
        for (level, quality) in (0..3).flat_map(|index| (0..3).map(move |other| (level(index), quality(other)))) {
            let pair = ["--simd", level, "--quality", quality];
            for variants in [all(1, true), all(3, false)] {
                assert!(variants.iter().any(|variant| variant.ends_with(&pair)), "{level} {quality}");
            }
        }
        let taken = |turns: usize, full| (0..turns).flat_map(|turn| integrators(turn, full)).collect::<BTreeSet<_>>();
        assert_eq!((taken(5, false), taken(1, true)), (INTEGRATORS.into(), INTEGRATORS.into()));
        let accelerators: BTreeSet<&str> = (0..9).map(|turn| integrator_variants("path", turn)[1][5]).collect();
        assert_eq!(accelerators.len(), AcceleratorKind::ALL.len() - 1, "{accelerators:?}");
    }
}
