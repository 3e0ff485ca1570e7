//! `numerics`: extreme cases with exactly known answers.
//!
//! Each chapter is a file with its list of cases. Expected values are closed forms, or roots that were computed with 80
//! digits from the numbers as `f64` has them.

use super::{
    checks::{Checks, FOUR_U, Tolerance},
    suite::{self, Case, Conditions, Fallible, cases, chapters},
    unit::Unit,
};

mod accelerators;
mod boxes_planes;
mod differential;
mod exact;
mod images;
mod invariance;
mod meshes;
mod optics;
mod polygons;
mod quadrics;
mod scenes;
mod spawn;
mod spheres;

chapters! {
    spheres,
    boxes_planes,
    quadrics,
    meshes,
    polygons,
    spawn,
    accelerators,
    differential,
    optics,
    images,
    invariance,
}

/// One unit per case.
pub(super) fn units() -> impl Iterator<Item = Unit> {
    suite::units("numerics", CHAPTERS)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_case_of_the_table_is_here_once() {
        let ids = IDS.concat();
        let numbers = (1..=57).chain([70, 71, 80]).map(|number| format!("S{number:02}"));
        let expected: BTreeSet<String> = numbers.chain(["differential".to_owned()]).collect();
        assert_eq!(ids.len(), expected.len(), "{ids:?}");
        assert_eq!(ids.into_iter().map(str::to_owned).collect::<BTreeSet<_>>(), expected);
    }
}
