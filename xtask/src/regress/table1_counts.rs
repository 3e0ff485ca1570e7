//! Counts of the report's Table 1, exact or nearly so on every machine.

use std::path::Path;

use super::unit::{Context, Findings, Unit};
use crate::{
    error::TaskError,
    statistics::{REPORT, REPORT_PRIMARY, ReportRow, Statistics, measure},
};

/// The heap was made to cover as much of the image as the report's.
const SHADOW_TOLERANCE: f64 = 0.005;
const REDUCED: [&str; 2] = ["--size", "64x36"];
const REDUCED_PRIMARY: u64 = 64 * 36 * 16;

/// One unit per row.
pub(super) fn units() -> impl Iterator<Item = Unit> {
    let unit = |row: &'static ReportRow| {
        Unit::new(format!("table1/{}", row.spheres), |context, folder, findings| run(row, context, folder, findings))
    };
    REPORT.iter().map(unit)
}

fn run(row: &ReportRow, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
    let scene = context.workspace.root.join(row.scene);
    let mut args = vec!["--accel", "linear"];
    if !context.full {
        args.extend(REDUCED);
    }
    let statistics = measure(&context.renderer, folder, &scene, &args)?;
    let rays = if context.full { REPORT_PRIMARY } else { REDUCED_PRIMARY };
    check(row, &statistics, rays, context.full, findings);
    Ok(())
}

fn check(row: &ReportRow, statistics: &Statistics, rays: u64, full: bool, findings: &mut Findings) {
    let primary = statistics.rays.primary;
    if primary.rays != rays {
        findings.problem(format!("{} primary rays instead of {rays}", primary.rays));
    }
    let tests = rays * row.spheres;
    if primary.primitive_tests != tests {
        findings.problem(format!("{} primary sphere tests instead of {tests}", primary.primitive_tests));
    }
    let shadow = statistics.shadow_rays();
    if full {
        let off = shadow as f64 / row.shadow_rays - 1.0;
        let line = format!("{shadow} shadow rays, {:+.2} % from the report's {}", 100.0 * off, row.shadow_rays);
        findings.line(off.abs() <= SHADOW_TOLERANCE, line);
    } else if shadow == 0 {
        findings.problem("no shadow rays");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Cost, Rays, Shading};

    fn problems(primary: u64, tests: u64, shadow: u64, skipped: u64) -> usize {
        let cost = |rays, primitive_tests| Cost { rays, primitive_tests, hits: 0 };
        let statistics = Statistics {
            rays: Rays { primary: cost(primary, tests), shadow: cost(shadow, 0), total: cost(0, 0) },
            shading: Shading { shadow_rays_skipped: skipped },
        };
        let mut findings = Findings::default();
        check(&REPORT[0], &statistics, REPORT_PRIMARY, true, &mut findings);
        findings.problems.len()
    }

    #[test]
    fn counts_are_exact_and_shadow_rays_nearly() {
        let (rays, tests) = (REPORT_PRIMARY, REPORT_PRIMARY * 10);
        assert_eq!(problems(rays, tests, 2_000_000, 840_000), 0);
        assert_eq!(problems(rays, tests, 2_854_000, 0), 0);
        assert_eq!(problems(rays - 1, tests, 2_840_000, 0), 1);
        assert_eq!(problems(rays, tests + 1, 2_840_000, 0), 1);
        assert_eq!(problems(rays, tests, 2_855_000, 0), 1);
        assert_eq!(problems(rays, tests, 2_825_000, 0), 1);
    }
}
