//! Heckbert's minray scene against an independent program's picture of it.

use std::path::Path;

use image::RgbaImage;

use super::{
    compare::Difference,
    compare::greatest,
    golden::open,
    golden::save,
    panels,
    unit::{Context, Findings, Unit},
};
use crate::error::TaskError;

/// In the folder of shared test data, as it is no part of the workspace.
const REFERENCE: &str = "reference/minray-512.png";
const SCENE: &str = "scenes/lecture/minray.ron";
const MAX_RMSE: f64 = 1.0 / 255.0;
/// A pixel that differs by more than this many steps of 255 is off.
const TOLERANCE: u8 = 8;
const MAX_OFF: f64 = 0.005;

pub(super) struct Minray;

impl Unit for Minray {
    fn name(&self) -> String {
        "minray".to_owned()
    }

    fn run(&self, context: &Context, folder: &Path) -> Result<Findings, TaskError> {
        let mut findings = Findings::default();
        let Some(reference) = rt_tests::shared(REFERENCE) else {
            findings.skip(format!("there is no shared/{REFERENCE}"));
            return Ok(findings);
        };
        let scene = context.workspace.root.join(SCENE);
        let run = context.renderer.render(folder, &scene, "actual.png", ["--size", "512x512"])?;
        if let Err(problem) = run.succeeded() {
            findings.problem(problem);
            return Ok(findings);
        }
        let (expected, actual) = (open(&reference)?, open(&folder.join("actual.png"))?);
        let picture = folder.join("diff.png");
        save(&panels::three_panels(&expected, &actual), &picture)?;
        findings.picture = Some(picture);
        match Difference::of(&expected, &actual, TOLERANCE) {
            Ok(difference) => judge(&expected, &actual, &difference, &mut findings),
            Err(error) => findings.problem(error.to_string()),
        }
        Ok(findings)
    }
}

fn judge(expected: &RgbaImage, actual: &RgbaImage, difference: &Difference, findings: &mut Findings) {
    findings.note(difference.to_string());
    if difference.rmse >= MAX_RMSE {
        findings.problem("the RMSE is not below 1/255");
    }
    if difference.outlier_share() > MAX_OFF {
        findings.problem(format!("more than {} % of the pixels are off by more than {TOLERANCE}", MAX_OFF * 100.0));
    }
    let off = expected.enumerate_pixels().zip(actual.pixels());
    let stray = off
        .filter(|((x, y, expected_pixel), actual_pixel)| {
            greatest(expected_pixel, actual_pixel) > TOLERANCE && !on_edge(expected, *x, *y)
        })
        .count();
    if stray > 0 {
        findings.problem(format!("{stray} pixels are off by more than {TOLERANCE} away from any silhouette"));
    }
}

/// True if the picture changes by more than the tolerance within the 3×3 pixels around this one.
fn on_edge(picture: &RgbaImage, x: u32, y: u32) -> bool {
    let centre = picture.get_pixel(x, y);
    let columns = x.saturating_sub(1)..=(x + 1).min(picture.width() - 1);
    columns
        .flat_map(|x| (y.saturating_sub(1)..=(y + 1).min(picture.height() - 1)).map(move |y| (x, y)))
        .any(|(x, y)| greatest(picture.get_pixel(x, y), centre) > TOLERANCE)
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    /// Black on the left, white from x = 20 on.
    fn halves() -> RgbaImage {
        RgbaImage::from_fn(40, 40, |x, _| Rgba(if x < 20 { [0, 0, 0, 255] } else { [255; 4] }))
    }

    fn problems(actual: &RgbaImage) -> Vec<String> {
        let mut findings = Findings::default();
        let difference = Difference::of(&halves(), actual, TOLERANCE).unwrap();
        judge(&halves(), actual, &difference, &mut findings);
        findings.problems
    }

    #[test]
    fn edges_are_next_to_a_change() {
        assert_eq!([17, 18, 19, 20, 21].map(|x| on_edge(&halves(), x, 0)), [false, false, true, true, false]);
    }

    #[test]
    fn a_pixel_off_on_the_silhouette_is_forgiven_and_elsewhere_not() {
        let mut actual = halves();
        actual.put_pixel(19, 5, Rgba([9, 9, 9, 255]));
        assert!(problems(&actual).is_empty());
        actual.put_pixel(5, 5, Rgba([9, 0, 0, 255]));
        assert_eq!(problems(&actual), ["1 pixels are off by more than 8 away from any silhouette"]);
    }

    #[test]
    fn too_many_pixels_off_are_a_problem() {
        let mut actual = halves();
        for y in 0..9 {
            actual.put_pixel(20, y, Rgba([0, 0, 0, 255]));
        }
        assert_eq!(problems(&actual).len(), 2, "RMSE and share");
    }
}
