//! Heckbert's minray scene against an independent program's image of it.

use std::path::{Path, PathBuf};

use image::RgbaImage;

use super::{
    case::GoldenReference,
    compare::max_difference,
    golden::{near_reference, open, save},
    panels::three_panels,
    unit::{Context, Findings, Unit},
};
use crate::error::TaskError;

/// Reference in the folder of shared test data, outside of the workspace.
const REFERENCE: &str = "reference/minray-512.png";
const SCENE: &str = "scenes/lecture/minray.ron";
/// A pixel that differs by more than this many steps of 255 is off.
const TOLERANCE: u8 = 8;

pub(super) fn unit() -> Unit {
    Unit::new("minray", run)
}

fn run(context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
    let Some(image) = rt_tests::shared(REFERENCE) else {
        findings.skip(format!("there is no shared/{REFERENCE}"));
        return Ok(());
    };
    let scene = context.workspace.root.join(SCENE);
    context.renderer.render(folder, &scene, "actual.png", ["--size", "512x512"])?;
    let (expected, actual) = (open(&image)?, open(&folder.join("actual.png"))?);
    let panels = folder.join("diff.png");
    save(&three_panels(&expected, &actual), &panels)?;
    findings.image = Some(panels);
    check(&expected, &actual, image, findings);
    Ok(())
}

/// Allows an RMSE of 1/255, and one pixel of 200 to be off, at silhouettes alone.
fn check(expected: &RgbaImage, actual: &RgbaImage, image: PathBuf, findings: &mut Findings) {
    let reference = GoldenReference { image, max_rmse: 1.0 / 255.0, tolerance: TOLERANCE, max_outlier_share: 0.005 };
    near_reference(expected, actual, &reference, findings);
    let pairs = expected.enumerate_pixels().zip(actual.pixels());
    let off = pairs.filter(|((_, _, expected), actual)| max_difference(expected, actual) > TOLERANCE);
    let stray = off.filter(|((x, y, _), _)| !on_edge(expected, *x, *y)).count();
    if stray > 0 {
        findings.problem(format!("{stray} pixels are off by more than {TOLERANCE} away from any silhouette"));
    }
}

/// True if the image changes by more than the tolerance within the 3×3 pixels around this one.
fn on_edge(image: &RgbaImage, x: u32, y: u32) -> bool {
    let centre = image.get_pixel(x, y);
    let columns = x.saturating_sub(1)..=(x + 1).min(image.width() - 1);
    columns
        .flat_map(|x| (y.saturating_sub(1)..=(y + 1).min(image.height() - 1)).map(move |y| (x, y)))
        .any(|(x, y)| max_difference(image.get_pixel(x, y), centre) > TOLERANCE)
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
        check(&halves(), actual, "reference.png".into(), &mut findings);
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
    fn too_many_pixels_off_and_too_large_an_error_are_problems() {
        for (pixels, level) in [(8, 246), (9, 246), (1, 0)] {
            let mut actual = halves();
            (0..pixels).for_each(|y| actual.put_pixel(20, y, Rgba([level, level, level, 255])));
            let expected = format!("against reference.png: {pixels} of 1600 pixels off");
            let problems = problems(&actual);
            assert_eq!(problems.iter().any(|problem| problem.starts_with(&expected)), pixels != 8, "{problems:?}");
            assert!(problems.len() <= 1, "{problems:?}");
        }
    }
}
