//! Shading in `f32` compared with `f64`, with the same samples.
//!
//! Each scene file is rendered twice by `whitted`, and twice by `path`. With one sample, a pixel is one ray tree or path: its relative
//! difference counts rounding errors, and rays that took another way. With more samples, the means of both images are compared.
//! Scenes that are shaded in `f64` anyway give equal images.

use std::path::{Path, PathBuf};

use rt_image::{Image, read_image};

use super::unit::{Context, Findings, Unit};
use crate::{error::TaskError, workspace::Workspace};

const REDUCED: &[&str] = &["--size", "160x120"];
/// Samples for the comparison of means: with the sizes of the scenes up to 2²⁶ in all.
const SAMPLES: [&str; 2] = ["4", "64"];

/// Bounds of the classes of relative differences.
const CLASSES: [f64; 5] = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3];
/// Most trees or paths in which a ray may take another way: those that differ by more than the last class.
const MAX_SHARE: f64 = 5e-3;
/// Most standard errors between the means, unless the difference is below [`MAX_SHIFT`].
const MAX_Z: f64 = 5.0;
/// Relative difference of means that is a rounding error, whatever its standard error.
const MAX_SHIFT: f64 = 1e-6;

struct Precision {
    scene: PathBuf,
    integrator: &'static str,
    name: String,
}

/// Units of scenes that must be shaded in `f32`.
const IN_F32: [&str; 3] = [
    "precision/whitted/scenes/report/whitted",
    "precision/path/scenes/lecture/cornell",
    "precision/path/scenes/lecture/cornell-full",
];

/// Scenes with blended surfaces. Rounding of a ray changes the random number that decides whether it passes one, so that more paths take
/// another way.
const BLENDED: [&str; 2] = ["tests/golden/gltf-materials/scene", "tests/golden/obj-materials/scene"];

/// Largest share of paths that may take another way in these.
const MAX_SHARE_BLENDED: f64 = 0.1;

/// Integrators that may shade in `f32`.
const INTEGRATORS: [&str; 2] = ["whitted", "path"];

/// One unit per integrator, and per scene file of the project and golden image.
pub(super) fn units(workspace: &Workspace) -> Result<Vec<Unit>, TaskError> {
    let mut scenes = workspace.files("scenes", ".ron")?;
    scenes.extend(workspace.files("scenes/spd", ".nff")?);
    scenes.extend(workspace.files("tests/golden", ".ron")?);
    let unit = |(scene, integrator): (PathBuf, &'static str)| {
        let name = format!("precision/{integrator}/{}", workspace.relative(&scene.with_extension("")));
        let precision = Precision { scene, integrator, name: name.clone() };
        Unit::new(name, move |context, folder, findings| precision.run(context, folder, findings))
    };
    let of_scene = |scene: PathBuf| INTEGRATORS.map(|integrator| (scene.clone(), integrator));
    Ok(scenes.into_iter().flat_map(of_scene).map(unit).collect())
}

impl Precision {
    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        let size = if context.full { &[] } else { REDUCED };
        let [trees, exact_trees] = self.images(context, folder, size, "1")?;
        let differences = Differences::of(&trees, &exact_trees);
        if differences.largest == 0.0 {
            if IN_F32.contains(&self.name.as_str()) {
                findings.problem("equal: shaded in f64, but should be shaded in f32");
            }
            findings.note("equal: shaded in f64");
            return Ok(());
        }
        let is_blended = BLENDED.iter().any(|scene| self.name.ends_with(scene));
        differences.check(if is_blended { MAX_SHARE_BLENDED } else { MAX_SHARE }, findings);
        let [image, exact] = self.images(context, folder, size, SAMPLES[usize::from(context.full)])?;
        check_means(&image, &exact, findings);
        Ok(())
    }

    /// Images in `f32` and in `f64`.
    fn images(&self, context: &Context, folder: &Path, size: &[&str], spp: &str) -> Result<[Image; 2], TaskError> {
        let image = |precision| {
            let options = ["--integrator", self.integrator, "--precision", precision, "--spp", spp];
            let args = size.iter().copied().chain(options);
            context.renderer.render(folder, &self.scene, "linear.pfm", args)?;
            read_image(&folder.join("linear.pfm")).map_err(TaskError::other)
        };
        Ok([image("f32")?, image("f64")?])
    }
}

/// Radiance of all pixels.
fn pixels(image: &Image) -> impl Iterator<Item = [f64; 3]> {
    image.pixels().iter().map(|pixel| pixel.map(f64::from))
}

/// Relative differences of pixels.
#[derive(Debug, PartialEq)]
struct Differences {
    /// Pixels in each class, the last beyond all bounds.
    counts: [u64; CLASSES.len() + 1],
    largest: f64,
    /// Pixels with a number that is not finite in only one of the images.
    not_finite: u64,
}

impl Differences {
    fn of(a: &Image, b: &Image) -> Self {
        let mut this = Self { counts: [0; CLASSES.len() + 1], largest: 0.0, not_finite: 0 };
        for (a, b) in pixels(a).zip(pixels(b)) {
            this.add(a, b);
        }
        this
    }

    fn add(&mut self, a: [f64; 3], b: [f64; 3]) {
        let is_finite = |radiance: &[f64; 3]| radiance.iter().all(|component| component.is_finite());
        if is_finite(&a) != is_finite(&b) {
            self.not_finite += 1;
            return;
        }
        let size = a.iter().chain(&b).fold(1e-6, |size: f64, component| size.max(component.abs()));
        let difference = a.iter().zip(b).fold(0.0, |max: f64, (a, b)| max.max((a - b).abs())) / size;
        self.counts[CLASSES.iter().take_while(|bound| difference > **bound).count()] += 1;
        self.largest = self.largest.max(difference);
    }

    fn check(&self, max_share: f64, findings: &mut Findings) {
        let total: u64 = self.counts.iter().sum();
        let share = |count: u64| 100.0 * count as f64 / total.max(1) as f64;
        let classes: Vec<_> = CLASSES
            .iter()
            .zip(self.counts)
            .map(|(bound, count)| format!("≤ {bound:e}: {:.3} %", share(count)))
            .collect();
        let other_ways = self.counts[CLASSES.len()];
        findings.note(format!(
            "trees or paths by relative difference: {}, more: {:.3} %; largest {:.2e}",
            classes.join(", "),
            share(other_ways),
            self.largest
        ));
        if self.not_finite > 0 {
            findings.problem(format!("{} pixels are finite in one image only", self.not_finite));
        }
        if other_ways as f64 > max_share * total as f64 {
            findings.problem(format!(
                "{other_ways} of {total} trees or paths differ by more than {:e}",
                CLASSES[CLASSES.len() - 1]
            ));
        }
    }
}

/// Compares the means of two images of the same samples.
fn check_means(image: &Image, exact: &Image, findings: &mut Findings) {
    let mean = |radiance: [f64; 3]| radiance.iter().sum::<f64>() / 3.0;
    let differences: Vec<f64> = pixels(image).zip(pixels(exact)).map(|(a, b)| mean(a) - mean(b)).collect();
    let n = differences.len().max(1) as f64;
    let shift = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|difference| (difference - shift) * (difference - shift)).sum::<f64>() / n;
    let error = (variance / n).sqrt();
    let size = pixels(exact).map(mean).sum::<f64>() / n;
    let relative = shift / size.max(f64::MIN_POSITIVE);
    let line = format!("means differ by {relative:+.1e} ± {:.1e} (z = {:+.1})", error / size, shift / error);
    findings.line(relative.abs() <= MAX_SHIFT || shift.abs() <= MAX_Z * error, line);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_by_size() {
        let mut differences = Differences { counts: [0; 6], largest: 0.0, not_finite: 0 };
        for b in [1.0, 1.0 + 5e-7, 1.0 + 5e-6, 1.2, f64::NAN] {
            differences.add([1.0, 0.5, 0.0], [b, 0.5, 0.0]);
        }
        assert_eq!((differences.counts, differences.not_finite), ([1, 1, 1, 0, 0, 1], 1));
        let mut findings = Findings::default();
        differences.check(MAX_SHARE, &mut findings);
        assert_eq!(findings.problems.len(), 2, "{findings:?}");
    }
}
