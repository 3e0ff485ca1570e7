//! Golden images: `tests/golden/<case>/` holds a scene with one idea and its expected image.

use std::path::{Path, PathBuf};

use image::RgbaImage;

use super::{
    case::{GoldenCase, GoldenReference, KnownMean, locate},
    compare::Difference,
    panels::three_panels,
    unit::{Context, Findings, Unit},
};
use crate::{error::TaskError, workspace::Workspace};

/// A folder of `tests/golden`.
struct Golden {
    folder: PathBuf,
}

/// One unit per folder.
pub(super) fn units(workspace: &Workspace) -> Result<Vec<Unit>, TaskError> {
    let unit = |case: &PathBuf| {
        let golden = Golden { folder: case.parent()?.to_path_buf() };
        let name = format!("golden/{}", golden.folder.file_name()?.to_string_lossy());
        Some(Unit::new(name, move |context, folder, findings| golden.run(context, folder, findings)))
    };
    Ok(workspace.files("tests/golden", "case.toml")?.iter().filter_map(unit).collect())
}

impl Golden {
    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        let case = GoldenCase::load(&self.folder)?;
        if let Some(actual) = render(context, folder, &self.folder, &case, "actual.png", findings)? {
            let actual = open(&actual)?;
            self.compare(context, folder, &case, &actual, findings)?;
            if let Some(reference) = &case.reference {
                let expected = open(&locate(&reference.image, &self.folder, &context.workspace.root))?;
                near_reference(&expected, &actual, reference, findings);
            }
        }
        if let Some(truth) = &case.truth
            && let Some(linear) = render(context, folder, &self.folder, &case, "actual.pfm", findings)?
        {
            near_truth(&linear, truth, findings)?;
        }
        if let Some(reason) = case.known_failure {
            *findings = known_failure(std::mem::take(findings), &reason);
        }
        Ok(())
    }

    fn compare(
        &self,
        context: &Context,
        folder: &Path,
        case: &GoldenCase,
        actual: &RgbaImage,
        findings: &mut Findings,
    ) -> Result<(), TaskError> {
        let path = self.folder.join("expected.png");
        if path.exists() {
            let expected = open(&path)?;
            let image = folder.join("diff.png");
            save(&three_panels(&expected, actual), &image)?;
            findings.image = Some(image);
            match check(&expected, actual, case) {
                Ok(()) => return Ok(()),
                Err(problem) => findings.problem(problem),
            }
        } else {
            findings.image = Some(folder.join("actual.png"));
            findings.problem("there is no expected.png");
        }
        if context.bless && case.known_failure.is_none() {
            save(actual, &path)?;
            findings.note(format!("blessed {}: look at it before you commit it", context.workspace.relative(&path)));
        }
        Ok(())
    }
}

/// Renders the case to `output` in `folder`; `None`, with a problem, if that fails.
fn render(
    context: &Context,
    folder: &Path,
    case_folder: &Path,
    case: &GoldenCase,
    output: &str,
    findings: &mut Findings,
) -> Result<Option<PathBuf>, TaskError> {
    let scene = case.scene_path(case_folder, &context.workspace.root);
    let args = case.args.iter().map(String::as_str);
    match context.renderer.render(folder, &scene, output, args) {
        Ok(()) => Ok(Some(folder.join(output))),
        Err(error) => {
            findings.problem(error.to_string());
            Ok(None)
        }
    }
}

/// Compares within the bounds of the case.
fn check(expected: &RgbaImage, actual: &RgbaImage, case: &GoldenCase) -> Result<(), String> {
    let difference = Difference::of(expected, actual, case.tolerance).map_err(|error| error.to_string())?;
    if difference.outliers <= case.max_outliers { Ok(()) } else { Err(difference.to_string()) }
}

/// Compares with an independent image of the same scene.
pub(super) fn near_reference(
    expected: &RgbaImage,
    actual: &RgbaImage,
    reference: &GoldenReference,
    findings: &mut Findings,
) {
    match Difference::of(expected, actual, reference.tolerance) {
        Ok(difference) => {
            let near =
                difference.rmse <= reference.max_rmse && difference.outlier_share() <= reference.max_outlier_share;
            findings.line(near, format!("against {}: {difference}", reference.image.display()));
        }
        Err(error) => findings.problem(error.to_string()),
    }
}

fn near_truth(linear: &Path, truth: &KnownMean, findings: &mut Findings) -> Result<(), TaskError> {
    let image = rt_image::read_image(linear).map_err(TaskError::other)?;
    let mean = mean(image.pixels());
    let near = mean.iter().zip(truth.mean).all(|(mean, truth_mean)| (mean - truth_mean).abs() <= truth.tolerance);
    let line = format!("mean radiance {mean:?}, {} gives {:?} ± {}", truth.note, truth.mean, truth.tolerance);
    findings.line(near, line);
    Ok(())
}

fn mean(pixels: &[[f32; 3]]) -> [f64; 3] {
    let sums = pixels.iter().fold([0.0; 3], |sums, pixel| [0, 1, 2].map(|i| sums[i] + f64::from(pixel[i])));
    sums.map(|sum| sum / pixels.len() as f64)
}

/// Inverts the verdict of a known failure.
fn known_failure(findings: Findings, reason: &str) -> Findings {
    let Findings { problems, mut notes, image, skipped, .. } = findings;
    if problems.is_empty() {
        let problem = format!("passes, although it is known to fail ({reason}): remove `known_failure`");
        return Findings { problems: vec![problem], notes, image, skipped, ..Findings::default() };
    }
    notes.push(format!("known failure: {reason}"));
    notes.extend(problems);
    Findings { notes, image, skipped, ..Findings::default() }
}

pub(super) fn open(path: &Path) -> Result<RgbaImage, TaskError> {
    Ok(image::open(path).map_err(TaskError::file(path))?.into_rgba8())
}

pub(super) fn save(image: &RgbaImage, path: &Path) -> Result<(), TaskError> {
    image.save(path).map_err(TaskError::file(path))
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    fn pair() -> (RgbaImage, RgbaImage) {
        let expected = RgbaImage::from_pixel(4, 4, Rgba([50, 50, 50, 255]));
        let mut actual = expected.clone();
        actual.put_pixel(1, 2, Rgba([50, 53, 50, 255]));
        (expected, actual)
    }

    #[test]
    fn one_changed_pixel_fails_unless_tolerance_or_outliers_let_it_pass() {
        let (expected, actual) = pair();
        assert_eq!(check(&expected, &expected, &GoldenCase::default()), Ok(()));
        for (tolerance, max_outliers, passes) in [(0, 0, false), (2, 0, false), (3, 0, true), (0, 1, true)] {
            let result = check(&expected, &actual, &GoldenCase { tolerance, max_outliers, ..GoldenCase::default() });
            assert_eq!(result.is_ok(), passes, "{tolerance}, {max_outliers}: {result:?}");
            assert!(passes || result.unwrap_err().contains("worst by 3 at (1, 2)"));
        }
    }

    #[test]
    fn a_known_failure_that_passes_is_a_problem() {
        assert_eq!(known_failure(Findings::default(), "why").problems.len(), 1);
        let mut failing = Findings::default();
        failing.problem("differs");
        let findings = known_failure(failing, "why");
        assert_eq!((findings.problems.len(), findings.notes), (0, vec!["known failure: why".into(), "differs".into()]));
    }

    #[test]
    fn the_mean_is_taken_by_channel() {
        assert_eq!(mean(&[[1.0, 2.0, 3.0], [3.0, 2.0, 5.0]]), [2.0, 2.0, 4.0]);
    }
}
