//! Files of a pair: `pair.json` and, unless our own renderer gives the reference, `ref.json`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{blocks::Blocks, score::BlockEstimate, score::RelativeTolerance};
use crate::{error::TaskError, files};

/// Pairs of the project.
pub(super) const OWN: &str = "tests/physics/pairs";

/// First seed of the reference where our own renderer makes it.
const FIRST_REFERENCE_SEED: u64 = 5001;
/// Degrees of freedom of a variance that is not estimated.
const MANY: f64 = 1e6;
/// Default number of seeds of a stored reference.
const USUAL_SEEDS: f64 = 16.0;

/// Contents of `pair.json`.
#[derive(Debug, Deserialize)]
pub(super) struct Pair {
    /// Scene file, relative to the folder of the pair.
    scene: String,
    /// Arguments for `render`.
    #[serde(default)]
    args: Vec<String>,
    /// Samples per pixel; those of the scene if missing.
    spp: Option<u32>,
    /// Samples per pixel for reduced [`Effort`], for pairs that notice a fault of 1 % with few.
    reduced_spp: Option<u32>,
    /// Independent renders.
    seeds: u32,
    /// Pixels along the side of a block.
    pub block: usize,
    /// Relative tolerance, as a standard deviation.
    #[serde(default = "usual_tolerance")]
    tol: f64,
    /// Absolute tolerance, as a standard deviation.
    #[serde(default)]
    atol: f64,
    #[serde(default)]
    pub note: String,
    #[serde(default)]
    pub expect: Expect,
    /// Origin of the reference: `self` is our own renderer, anything else `ref.json`.
    pub kind: String,
    #[serde(default = "usual_first_seed")]
    first_seed: u64,
    /// Arguments, scene, seeds and samples of a reference of kind `self`, where they differ from those of the pair.
    ref_args: Option<Vec<String>>,
    ref_scene: Option<String>,
    ref_seeds: Option<u32>,
    ref_spp: Option<u32>,
}

/// Expected outcome of the comparison.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub(super) enum Expect {
    /// Both show the same light.
    #[default]
    Agree,
    /// Both differ by a documented convention, by a recorded factor.
    Convention,
    /// A difference that is known and not explained; it may vanish.
    Known,
}

impl TryFrom<String> for Expect {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.as_str() {
            "agree" => Ok(Self::Agree),
            "convention" => Ok(Self::Convention),
            known if known.starts_with("known") || known == "suspect" => Ok(Self::Known),
            other => Err(format!("expect: {other:?} is none of agree, convention, known, suspect")),
        }
    }
}

fn usual_tolerance() -> f64 {
    2e-5
}

fn usual_first_seed() -> u64 {
    1
}

/// Renders of one scene that differ in their seeds alone.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Series {
    pub scene: PathBuf,
    pub args: Vec<String>,
    pub spp: Option<u32>,
    pub first_seed: u64,
    pub seeds: u32,
}

/// Amount of work per pair: at most so many seeds, and samples per pixel divided by this number. At least `min_samples` are left,
/// unless the pair has fewer itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Effort {
    pub max_seeds: u32,
    pub divisor: u32,
    pub min_samples: u32,
}

impl std::fmt::Display for Effort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { max_seeds, divisor, .. } = self;
        if *self == Self::FULL {
            write!(f, "all seeds and samples")
        } else {
            write!(f, "{max_seeds} seeds and 1/{divisor} of the samples per pixel or fewer")
        }
    }
}

impl Pair {
    /// Reads `pair.json` in `folder`.
    pub(super) fn load(folder: &Path) -> Result<Self, TaskError> {
        files::read_json(&folder.join("pair.json"))
    }

    pub(super) fn tolerance(&self) -> RelativeTolerance {
        RelativeTolerance { relative: self.tol, absolute: self.atol }
    }

    /// True if the reference is rendered by our own program in another way.
    pub(super) fn is_of_ours_alone(&self) -> bool {
        self.kind == "self"
    }

    /// Renders under test.
    pub(super) fn series(&self, folder: &Path, effort: Effort) -> Series {
        Series {
            scene: folder.join(&self.scene),
            args: resolved(&self.args, folder),
            spp: effort.samples(self.spp, self.reduced_spp),
            first_seed: self.first_seed,
            seeds: effort.seeds(self.seeds),
        }
    }

    /// Renders that they are compared with, for a pair of kind `self`.
    pub(super) fn reference_series(&self, folder: &Path, effort: Effort) -> Series {
        Series {
            scene: folder.join(self.ref_scene.as_ref().unwrap_or(&self.scene)),
            args: resolved(self.ref_args.as_ref().unwrap_or(&self.args), folder),
            spp: effort.samples(self.ref_spp.or(self.spp), self.reduced_spp),
            first_seed: FIRST_REFERENCE_SEED,
            seeds: effort.seeds(self.ref_seeds.unwrap_or(self.seeds)),
        }
    }
}

impl Effort {
    /// Seeds and samples of `pair.json`.
    pub(super) const FULL: Self = Self { max_seeds: u32::MAX, divisor: 1, min_samples: 0 };

    fn seeds(self, seeds: u32) -> u32 {
        seeds.min(self.max_seeds)
    }

    fn samples(self, spp: Option<u32>, reduced: Option<u32>) -> Option<u32> {
        let reduced = reduced.filter(|_| self != Self::FULL);
        reduced.or_else(|| spp.map(|spp| (spp / self.divisor).max(spp.min(self.min_samples))))
    }
}

/// Arguments with absolute paths for names of files of the folder.
fn resolved(args: &[String], folder: &Path) -> Vec<String> {
    let resolve = |arg: &String| {
        let path = folder.join(arg);
        if path.is_file() { path.to_string_lossy().into_owned() } else { arg.clone() }
    };
    args.iter().map(resolve).collect()
}

/// Contents of `ref.json`.
#[derive(Debug, Deserialize)]
struct Stored {
    /// Rows, columns, channels.
    shape: [usize; 3],
    mean: Vec<f64>,
    /// Standard errors; 0 for an integral.
    stderr: Vec<f64>,
    /// Renders that the standard errors are of.
    seeds: Option<f64>,
    /// Standard errors of the image means, where they do not follow from those of the blocks: all blocks may share the
    /// time of a sample.
    image_stderr: Option<[f64; 3]>,
}

/// Means of a reference, with their errors.
#[derive(Clone, Debug)]
pub(super) struct BlockMeans {
    /// By block, then channel.
    pub blocks: Vec<BlockEstimate>,
    /// By channel.
    pub image: [BlockEstimate; 3],
}

impl BlockMeans {
    /// Reads `ref.json` in `folder`; the text says what is wrong with it.
    pub(super) fn load(folder: &Path) -> Result<(Self, [usize; 2]), TaskError> {
        let path = folder.join("ref.json");
        let stored: Stored = files::read_json(&path)?;
        Self::of_stored(&stored).map_err(|problem| TaskError::Other(format!("{}: {problem}", path.display())))
    }

    fn of_stored(stored: &Stored) -> Result<(Self, [usize; 2]), String> {
        let [rows, columns, channels] = stored.shape;
        let numbers = rows.checked_mul(columns).and_then(|blocks| blocks.checked_mul(channels)).unwrap_or(0);
        if channels != 3 || numbers == 0 || stored.mean.len() != numbers || stored.stderr.len() != numbers {
            return Err(format!(
                "{} means and {} errors for shape {:?}",
                stored.mean.len(),
                stored.stderr.len(),
                stored.shape
            ));
        }
        if stored.stderr.iter().any(|error| !(*error >= 0.0)) {
            return Err("stderr: a standard error is not 0 or more".to_owned());
        }
        let freedom = (stored.seeds.unwrap_or(USUAL_SEEDS) - 1.0).max(1.0);
        let estimate = |mean: f64, error: f64| BlockEstimate { mean, variance: error * error, freedom };
        let blocks: Vec<BlockEstimate> =
            stored.mean.iter().zip(&stored.stderr).map(|(m, e)| estimate(*m, *e)).collect();
        let mut image = image_means(&blocks);
        if let Some(errors) = stored.image_stderr {
            image = std::array::from_fn(|channel| estimate(image[channel].mean, errors[channel]));
        }
        Ok((Self { blocks, image }, [rows, columns]))
    }

    /// Gives blocks in which no render found any light the spread that they would have if `expected` were true. It is
    /// that of a count of rare events (Poisson); each event adds `event` to the mean of its block.
    pub(super) fn with_rare_events(mut self, expected: &Self, event: f64) -> Self {
        for (block, expected) in self.blocks.iter_mut().zip(&expected.blocks) {
            if block.mean == 0.0 && block.variance == 0.0 && expected.mean > 0.0 {
                *block = BlockEstimate { variance: expected.mean * event, freedom: MANY, ..*block };
            }
        }
        self
    }

    /// Means over renders that differ in their seeds.
    pub(super) fn of_seeds(renders: &[Blocks]) -> Self {
        let over_seeds =
            |value: &dyn Fn(&Blocks) -> f64| BlockEstimate::of_seeds(&renders.iter().map(value).collect::<Vec<_>>());
        let numbers = renders.first().map_or(0, |render| render.means.len());
        Self {
            blocks: (0..numbers).map(|i| over_seeds(&|render| render.means[i])).collect(),
            image: std::array::from_fn(|channel| over_seeds(&|render| render.image_mean(channel))),
        }
    }

    /// The reference of a scene that is `factor` times as bright.
    pub(super) fn scaled(&self, factor: [f64; 3]) -> Self {
        Self {
            blocks: self.blocks.iter().enumerate().map(|(i, block)| block.scaled(factor[i % 3])).collect(),
            image: std::array::from_fn(|channel| self.image[channel].scaled(factor[channel])),
        }
    }
}

/// Image means of blocks whose noise is independent.
fn image_means(blocks: &[BlockEstimate]) -> [BlockEstimate; 3] {
    let of_channel = |channel: usize| blocks.iter().skip(channel).step_by(3).copied().collect::<Vec<_>>();
    std::array::from_fn(|channel| BlockEstimate::mean_of(&of_channel(channel)))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{super::score::Score, *};

    fn pair(json: &str) -> Pair {
        serde_json::from_str(json).unwrap()
    }

    #[test]
    fn missing_keys_have_the_usual_values() {
        let pair = pair(r#"{"scene": "a.gltf", "spp": 64, "seeds": 16, "block": 8, "kind": "numeric"}"#);
        assert_eq!((pair.tol, pair.atol, pair.expect), (2e-5, 0.0, Expect::Agree));
        let series = pair.series(Path::new("folder"), Effort::FULL);
        let scene = Path::new("folder").join("a.gltf");
        assert_eq!(series, Series { scene, args: Vec::new(), spp: Some(64), first_seed: 1, seeds: 16 });
    }

    #[test]
    fn a_pair_of_ours_alone_has_two_series() {
        let pair = pair(
            r#"{"name": "p", "scene": "ours.ron", "args": ["--crop", "0,0,8,8"], "spp": 64, "seeds": 16, "block": 8,
                "kind": "self", "first_seed": 77, "expect": "known (1)", "ref_args": ["--integrator", "path"],
                "ref_scene": "other.ron", "ref_seeds": 4, "ref_spp": 256}"#,
        );
        assert!(pair.is_of_ours_alone());
        assert_eq!(pair.expect, Expect::Known);
        let reference = pair.reference_series(Path::new("f"), Effort::FULL);
        assert_eq!((reference.spp, reference.seeds, reference.first_seed), (Some(256), 4, 5001));
        assert_eq!((reference.args.join(" "), reference.scene), ("--integrator path".into(), "f/other.ron".into()));
        let unstated = Pair { ref_args: None, ref_scene: None, ref_seeds: None, ref_spp: None, ..pair };
        let reference = unstated.reference_series(Path::new("f"), Effort::FULL);
        assert_eq!((reference.spp, reference.seeds, reference.args.join(" ")), (Some(64), 16, "--crop 0,0,8,8".into()));
    }

    #[test]
    fn an_unknown_expectation_is_refused() {
        let text = r#"{"scene": "a", "seeds": 1, "block": 8, "kind": "self", "expect": "agrees"}"#;
        assert!(serde_json::from_str::<Pair>(text).unwrap_err().to_string().contains("agrees"));
    }

    #[test]
    fn reduced_effort_keeps_some_samples() {
        let effort = Effort { max_seeds: 8, divisor: 4, min_samples: 16 };
        assert_eq!([16, 8, 4].map(|seeds| effort.seeds(seeds)), [8, 8, 4]);
        let samples = [256, 64, 32, 4].map(|spp| effort.samples(Some(spp), None));
        assert_eq!(samples, [Some(64), Some(16), Some(16), Some(4)]);
        assert_eq!((effort.samples(Some(64), Some(4)), Effort::FULL.samples(Some(64), Some(4))), (Some(4), Some(64)));
    }

    #[test]
    fn arguments_that_name_files_of_the_folder_become_paths() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("env.exr"), "").unwrap();
        let args = ["--env", "env.exr", "--depth", "3"].map(str::to_owned);
        let path = folder.path().join("env.exr").to_string_lossy().into_owned();
        assert_eq!(resolved(&args, folder.path()), ["--env", &path, "--depth", "3"]);
    }

    fn stored(json: &str) -> Result<(BlockMeans, [usize; 2]), String> {
        BlockMeans::of_stored(&serde_json::from_str(json).unwrap())
    }

    #[test]
    fn image_errors_come_from_blocks_unless_stored() {
        let text = r#"{"shape": [1, 2, 3], "mean": [1, 2, 3, 5, 6, 7], "stderr": [0.3, 0, 0, 0.4, 0, 0]"#;
        let (reference, shape) = stored(&format!("{text}}}")).unwrap();
        assert_eq!(shape, [1, 2]);
        assert_eq!(reference.image.map(|channel| channel.mean), [3.0, 4.0, 5.0]);
        assert!((reference.image[0].variance - 0.0625).abs() < 1e-15);
        assert_eq!(reference.image[1].variance, 0.0);
        let (reference, _) = stored(&format!("{text}, \"seeds\": 8, \"image_stderr\": [0.1, 0, 0]}}")).unwrap();
        assert!((reference.image[0].variance - 0.01).abs() < 1e-15);
        assert_eq!((reference.image[0].freedom, reference.blocks[0].freedom), (7.0, 7.0));
    }

    #[test]
    fn a_block_that_no_sample_lit_has_the_spread_of_rare_events() {
        let dark = BlockEstimate { mean: 0.0, variance: 0.0, freedom: 7.0 };
        let dim = BlockEstimate { mean: 2e-5, variance: 0.0, freedom: 1.0 };
        let of = |block| BlockMeans { blocks: vec![block; 3], image: [block; 3] };
        // Two events of 1e-5 were expected: none is no surprise.
        let score = |expected: BlockEstimate| {
            let ours = of(dark).with_rare_events(&of(expected), 1e-5);
            Score::of(ours.blocks[0], expected, RelativeTolerance { relative: 0.02, absolute: 0.0 }).z
        };
        assert!((score(dim) + 2.0_f64.sqrt()).abs() < 0.01, "{}", score(dim));
        // A hundred were: none is a fault.
        assert!((score(BlockEstimate { mean: 1e-3, ..dim }) + 10.0).abs() < 0.2);
    }

    #[test]
    fn references_that_do_not_fit_are_refused() {
        assert!(stored(r#"{"shape": [1, 1, 3], "mean": [1, 2], "stderr": [0, 0, 0]}"#).is_err());
        assert!(stored(r#"{"shape": [1, 1, 3], "mean": [1, 2, 3], "stderr": [0, 0, -1]}"#).is_err());
        assert!(stored(r#"{"shape": [0, 1, 3], "mean": [], "stderr": []}"#).is_err());
    }
}
