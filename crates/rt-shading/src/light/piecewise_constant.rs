//! Piecewise-constant distributions, sampled by inversion.
//!
//! A distribution is stored as cumulative sums divided by the last, which is thus exactly 1. The probability of an entry is the
//! difference of two neighbours: exactly the width that the search finds. An entry without weight is never found.

/// Greatest number below 1.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Replaces weights by their cumulative distribution and returns their sum. If the sum is not positive and finite, all results
/// are 0.
pub(super) fn accumulate(weights: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for weight in weights.iter_mut() {
        sum += *weight;
        *weight = sum;
    }
    let is_usable = sum > 0.0 && sum.is_finite();
    for running in weights.iter_mut() {
        *running = if is_usable { *running / sum } else { 0.0 };
    }
    if is_usable { sum } else { 0.0 }
}

/// Entry that contains `u`, and the fraction within it, in `[0, 1)`. `None` if all weights are 0.
pub(super) fn find(sums: &[f64], u: f64) -> Option<(usize, f64)> {
    let u = if u >= 0.0 { u.min(BELOW_ONE) } else { 0.0 };
    let index = sums.partition_point(|&sum| sum <= u);
    let probability = probability(sums, index);
    let rest = (u - before(sums, index)) / probability;
    (probability > 0.0).then_some((index, rest.min(BELOW_ONE)))
}

/// Probability of an entry; 0 beyond the end.
pub(super) fn probability(sums: &[f64], index: usize) -> f64 {
    sums.get(index).map_or(0.0, |sum| sum - before(sums, index))
}

fn before(sums: &[f64], index: usize) -> f64 {
    index.checked_sub(1).and_then(|last| sums.get(last)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_where_they_lie() {
        let mut sums = [0.0, 1.0, 0.0, 3.0, 0.0];
        assert_eq!(accumulate(&mut sums), 4.0);
        for (u, expected) in [(0.0, (1, 0.0)), (0.125, (1, 0.5)), (0.25, (3, 0.0)), (0.625, (3, 0.5)), (1.0, (3, 1.0))]
        {
            let (index, rest) = find(&sums, u).expect("an entry");
            assert!(index == expected.0 && (rest - expected.1).abs() < 1e-15 && rest < 1.0, "{u}: {index}, {rest}");
        }
        assert_eq!((0..6).map(|i| probability(&sums, i)).collect::<Vec<_>>(), [0.0, 0.25, 0.0, 0.75, 0.0, 0.0]);
        assert_eq!(find(&sums, f64::NAN), find(&sums, 0.0));
    }

    #[test]
    fn nothing_is_found_where_nothing_has_weight() {
        for mut weights in [vec![], vec![0.0, 0.0], vec![f64::NAN, 1.0], vec![f64::MAX, f64::MAX]] {
            assert_eq!(accumulate(&mut weights), 0.0);
            assert_eq!(find(&weights, 0.5), None);
        }
    }
}
