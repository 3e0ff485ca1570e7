//! `analytic`: images and estimators whose mean is known in closed form.
//!
//! ```text
//!   z = (mean over seeds − truth) / standard error,   |z| ≤ 5
//! ```
//!
//! Each chapter is a file with its list of cases. A case repeats an estimate over independent seeds, with each sample
//! pattern and integrator that applies. The spread of the seeds gives the standard error; all z are printed. The
//! chapter of faults checks that planted faults are detected by the same means.

use super::{
    checks::{Checks, Tolerance},
    suite::{self, Case, Conditions, Fallible, cases, chapters},
    unit::Unit,
};

mod area_light;
mod closed_form;
mod coverage;
mod enclosures;
mod estimate;
mod exchange;
mod faults;
mod faulty_samplers;
mod furnace;
mod irradiance;
mod lens;
mod many_lights;
mod occlusion;
mod reflectance;
mod shadows;
mod slopes;
mod stopping;
mod test_image;

chapters! {
    coverage,
    slopes,
    irradiance,
    many_lights,
    exchange,
    shadows,
    occlusion,
    enclosures,
    furnace,
    lens,
    stopping,
    faults,
}

/// One unit per case.
pub(super) fn units() -> impl Iterator<Item = Unit> {
    suite::units("analytic", CHAPTERS)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_case_has_a_name_of_its_own() {
        let ids = IDS.concat();
        assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "{ids:?}");
        let numbers = [58, 59, 60, 61, 62, 63, 64, 65, 66, 67, 68, 69, 72, 73].map(|number| format!("S{number}"));
        for id in &numbers {
            assert!(ids.contains(&id.as_str()), "{id}");
        }
    }
}
