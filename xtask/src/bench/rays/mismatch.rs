//! Comparison with reference hits.

use serde::Serialize;

use super::{files::HitRecord, trace::Query};

/// The relative part of the tolerance of `t`.
const RELATIVE: f32 = 1e-4;

/// Hits that are not those of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Mismatches {
    /// The reference hits and we do not.
    pub leaks: usize,
    /// We hit and the reference does not.
    pub ghosts: usize,
    /// Both hit, at parameters that differ by more than 10⁻⁴ t + ε. Shadow rays have no parameter.
    pub wrong_t: usize,
}

impl Mismatches {
    /// Compares in `f32`, as all programs that read these files do.
    pub(super) fn count(reference: &[HitRecord], ours: &[HitRecord], query: Query, tolerance: f32) -> Self {
        let mut wrong = Self::default();
        for (reference, ours) in reference.iter().zip(ours) {
            match (reference.is_hit(), ours.is_hit()) {
                (true, false) => wrong.leaks += 1,
                (false, true) => wrong.ghosts += 1,
                (true, true) if query == Query::Closest => {
                    let apart = (reference.t - ours.t).abs();
                    wrong.wrong_t += usize::from(apart > RELATIVE * reference.t + tolerance);
                }
                _ => {}
            }
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_wrong_hit_is_counted() {
        let hit = |t| HitRecord { t, triangle: 0 };
        let reference = [hit(1.0), HitRecord::MISS, hit(10.0), hit(10.0), HitRecord::MISS];
        let ours = [HitRecord::MISS, hit(1.0), hit(10.0015), hit(9.998), HitRecord::MISS];
        let wrong = |query| Mismatches::count(&reference, &ours, query, 0.0007);
        assert_eq!(wrong(Query::Closest), Mismatches { leaks: 1, ghosts: 1, wrong_t: 1 });
        assert_eq!(wrong(Query::Occluded), Mismatches { leaks: 1, ghosts: 1, wrong_t: 0 });
    }
}
