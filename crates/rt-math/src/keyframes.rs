//! Keyframes in time, and curves through their values.
//!
//! ```text
//!   key 0          key 1     key 2                  p(s) = (1−s)³·p₀ + 3s(1−s)²·c₀ + 3s²(1−s)·c₁ + s³·p₁
//!     ●──────────────●─────────●──── held           c₀ = p₀ + v₀·h/3,  c₁ = p₁ − v₁·h/3
//!   held before      h = t₁ − t₀
//! ```

use core::{
    fmt,
    ops::{Add, Mul, Sub},
};

use glam::DVec3;

/// Largest magnitude of a time.
const MAX_TIME: f64 = 1e60;

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Value of the earlier key.
    Step,
    /// Linear interpolation.
    #[default]
    Linear,
    /// Cubic curve with continuous velocity, which is zero at the first and last key. At each other key it is that of
    /// the parabola through this key and its two neighbours (Catmull and Rom 1974; Overhauser 1968).
    Smooth,
}

/// Times of keyframes and their interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframes {
    times: Vec<f64>,
    interpolation: Interpolation,
}

/// Error of [`Keyframes::new`]: numbers that are no valid times of keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyframesError {
    /// There is no key.
    Empty,
    /// The time of the key with this index is NaN, or of a magnitude above 10⁶⁰.
    Time(usize),
    /// The key with this index does not come after the one before it.
    Order(usize),
}

impl fmt::Display for KeyframesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("there is no key"),
            Self::Time(index) => write!(f, "the time of key {index} is NaN, or of a magnitude above 1e60"),
            Self::Order(index) => write!(f, "key {index} does not come after the one before it"),
        }
    }
}

impl core::error::Error for KeyframesError {}

/// Position of a time among keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum KeyframePosition {
    /// Exactly the key of this index.
    Key(usize),
    /// Fraction, from 0 to 1, of the segment from the key of this index to the next.
    Between(usize, f64),
}

impl Keyframes {
    /// Keys at these times, in ascending order.
    ///
    /// # Errors
    /// [`KeyframesError`] if there are none, or one exceeds 10⁶⁰ in magnitude or is not later than the one before it.
    pub fn new(times: Vec<f64>, interpolation: Interpolation) -> Result<Self, KeyframesError> {
        if times.is_empty() {
            return Err(KeyframesError::Empty);
        }
        if let Some(index) = times.iter().position(|time| !(time.abs() <= MAX_TIME)) {
            return Err(KeyframesError::Time(index));
        }
        match times.windows(2).position(|pair| pair[0] >= pair[1]) {
            Some(before) => Err(KeyframesError::Order(before + 1)),
            None => Ok(Self { times, interpolation }),
        }
    }

    /// The times of the keys; at least one.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Interpolation between two keys.
    pub const fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Interpolates points of the keys at any time: before the first and after the last key, those of the key.
    ///
    /// The origin if there are fewer points than keys.
    pub fn point(&self, points: &[DVec3], time: f64) -> DVec3 {
        if points.len() < self.times.len() {
            return DVec3::ZERO;
        }
        match self.find(time) {
            KeyframePosition::Key(key) => points[key],
            KeyframePosition::Between(key, s) => match self.interpolation {
                Interpolation::Step => points[key],
                Interpolation::Linear => points[key].lerp(points[key + 1], s),
                Interpolation::Smooth => {
                    let slope = |key: usize| (points[key + 1] - points[key]) * (1.0 / self.span(key));
                    let velocities = [key, key + 1].map(|key| self.velocity(key, slope));
                    let controls = self.controls(key, [points[key], points[key + 1]], velocities);
                    bezier(controls, s)
                }
            },
        }
    }

    /// Interpolates numbers of the keys at any time, as [`point`](Self::point), but monotonically. It never leaves the
    /// range of the two adjacent keys, and has zero velocity at extrema (Fritsch and Butland 1984).
    ///
    /// Zero if there are fewer numbers than keys.
    pub fn number(&self, numbers: &[f64], time: f64) -> f64 {
        if numbers.len() < self.times.len() {
            return 0.0;
        }
        match self.find(time) {
            KeyframePosition::Key(key) => numbers[key],
            KeyframePosition::Between(key, s) => {
                let [from, to] = [numbers[key], numbers[key + 1]];
                let between = match self.interpolation {
                    Interpolation::Step => from,
                    Interpolation::Linear => from * (1.0 - s) + to * s,
                    Interpolation::Smooth => {
                        let slope = |key: usize| (numbers[key + 1] - numbers[key]) / self.span(key);
                        let velocities = [key, key + 1].map(|key| self.monotone_velocity(key, slope));
                        bezier(self.controls(key, [from, to], velocities), s)
                    }
                };
                // The curve stays between both but for roundings.
                between.max(from.min(to)).min(from.max(to))
            }
        }
    }

    /// Position of a time. A NaN is before all keys.
    pub(crate) fn find(&self, time: f64) -> KeyframePosition {
        let after = self.times.partition_point(|key| *key <= time);
        let Some(before) = after.checked_sub(1) else { return KeyframePosition::Key(0) };
        let start = self.times[before];
        if after == self.times.len() || time == start {
            return KeyframePosition::Key(before);
        }
        KeyframePosition::Between(before, (time - start) / self.span(before))
    }

    /// The time from a key to the next.
    pub(crate) fn span(&self, key: usize) -> f64 {
        self.times[key + 1] - self.times[key]
    }

    /// Velocity at a key, from the slopes of segments: zero at the first and last, and that of the parabola through
    /// three keys elsewhere.
    pub(crate) fn velocity<V>(&self, key: usize, slope: impl Fn(usize) -> V) -> V
    where
        V: Add<Output = V> + Mul<f64, Output = V>,
    {
        if key == 0 || key + 1 == self.times.len() {
            return slope(key.saturating_sub(1)) * 0.0;
        }
        let (before, after) = (self.span(key - 1), self.span(key));
        let share = before / (before + after);
        slope(key - 1) * (1.0 - share) + slope(key) * share
    }

    /// [`velocity`](Self::velocity) limited for a monotone curve: a weighted harmonic mean.
    fn monotone_velocity(&self, key: usize, slope: impl Fn(usize) -> f64) -> f64 {
        if key == 0 || key + 1 == self.times.len() {
            return 0.0;
        }
        let (first, second) = (slope(key - 1), slope(key));
        // A comparison of signs: the product of small slopes may be 0.
        if !(first > 0.0 && second > 0.0 || first < 0.0 && second < 0.0) {
            return 0.0;
        }
        let (before, after) = (self.span(key - 1), self.span(key));
        let weight = (before + 2.0 * after) / (3.0 * (before + after));
        1.0 / (weight / first + (1.0 - weight) / second)
    }

    /// The four control points of the curve from a key to the next.
    pub(crate) fn controls<V>(&self, key: usize, [from, to]: [V; 2], [out, into]: [V; 2]) -> [V; 4]
    where
        V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>,
    {
        let third = self.span(key) / 3.0;
        [from, from + out * third, to - into * third, to]
    }
}

/// The cubic with these control points, by Bernstein's polynomials.
pub(crate) fn bezier<V: Add<Output = V> + Mul<f64, Output = V>>([a, b, c, d]: [V; 4], s: f64) -> V {
    let r = 1.0 - s;
    a * (r * r * r) + b * (3.0 * s * r * r) + c * (3.0 * s * s * r) + d * (s * s * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn timeline(times: &[f64], interpolation: Interpolation) -> Keyframes {
        Keyframes::new(times.to_vec(), interpolation).expect("times that rise")
    }

    #[test]
    fn times_must_rise() {
        let refused = |times: &[f64]| Keyframes::new(times.to_vec(), Interpolation::Linear).expect_err("refused");
        assert_eq!(refused(&[]), KeyframesError::Empty);
        assert_eq!(refused(&[0.0, f64::NAN]), KeyframesError::Time(1));
        assert_eq!(refused(&[f64::NEG_INFINITY]), KeyframesError::Time(0));
        assert_eq!(refused(&[0.0, 1.0, 1.0]), KeyframesError::Order(2));
        assert_eq!(refused(&[0.0, -1.0, 1.0]), KeyframesError::Order(1));
    }

    #[test]
    fn the_first_and_the_last_key_hold() {
        for interpolation in [Interpolation::Step, Interpolation::Linear, Interpolation::Smooth] {
            let line = timeline(&[1.0, 2.0, 4.0], interpolation);
            let (points, numbers) = ([DVec3::X, DVec3::Y, DVec3::Z], [1.0, 3.0, 2.0]);
            for (time, key) in
                [(f64::NEG_INFINITY, 0), (f64::NAN, 0), (0.9, 0), (1.0, 0), (2.0, 1), (4.0, 2), (f64::INFINITY, 2)]
            {
                assert_eq!(line.point(&points, time), points[key], "{interpolation:?} {time}");
                assert_eq!(line.number(&numbers, time), numbers[key], "{interpolation:?} {time}");
            }
        }
    }

    #[test]
    fn steps_hold_and_lines_are_straight() {
        let points = [DVec3::ZERO, DVec3::X * 8.0, DVec3::Y];
        let (step, line) = [Interpolation::Step, Interpolation::Linear].map(|i| timeline(&[0.0, 2.0, 3.0], i)).into();
        assert_eq!(step.point(&points, 1.999), DVec3::ZERO);
        assert_eq!(line.point(&points, 0.5), DVec3::X * 2.0);
        assert_eq!(step.number(&[1.0, 2.0, 3.0], 2.5), 2.0);
        assert_eq!(line.number(&[1.0, 2.0, 3.0], 2.5), 2.5);
    }

    #[test]
    fn smooth_curves_follow_parabolas_between_inner_keys() {
        // p = t², whose velocities at the inner keys the parabolas through neighbours give exactly.
        let times = [-1.0, 0.0, 0.5, 2.0, 3.0];
        let points = times.map(|t| DVec3::new(t * t, t, 1.0));
        let line = timeline(&times, Interpolation::Smooth);
        for t in [0.0, 0.1, 0.25, 0.5, 0.9, 1.7, 2.0] {
            let expected = DVec3::new(t * t, t, 1.0);
            assert!((line.point(&points, t) - expected).length() < 1e-14, "{t}");
        }
    }

    #[test]
    fn smooth_curves_start_and_end_at_rest() {
        // With two keys, the cubic 3s² − 2s³.
        let line = timeline(&[2.0, 6.0], Interpolation::Smooth);
        for s in [0.0, 0.125, 0.5, 0.75, 1.0] {
            let (expected, at) = (3.0 * s * s - 2.0 * s * s * s, 2.0 + 4.0 * s);
            assert!((line.number(&[0.0, 1.0], at) - expected).abs() < 1e-15, "{s}");
            assert!((line.point(&[DVec3::ZERO, DVec3::ONE], at).y - expected).abs() < 1e-15, "{s}");
        }
    }

    #[test]
    fn too_few_values_are_no_reason_to_panic() {
        let line = timeline(&[0.0, 1.0], Interpolation::Smooth);
        assert_eq!((line.point(&[DVec3::X], 0.5), line.number(&[], 0.5)), (DVec3::ZERO, 0.0));
        assert!(line.number(&[f64::NAN; 2], 0.5).is_nan());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn numbers_are_monotone_between_keys(
            steps in prop::collection::vec(0.01..10.0f64, 1..6), numbers in prop::collection::vec(-5.0..5.0f64, 6), a in 0.0..1.0f64, b in 0.0..1.0f64,
        ) {
            let times: Vec<f64> = steps.iter().scan(0.0, |time, step| { *time += step; Some(*time) }).collect();
            let line = timeline(&times, Interpolation::Smooth);
            for key in 0..times.len() - 1 {
                let at = |s: f64| line.number(&numbers, times[key] + line.span(key) * s);
                let (early, late) = (at(a.min(b)), at(a.max(b)));
                let rises = numbers[key] <= numbers[key + 1];
                let falls_by = if rises { early - late } else { late - early };
                prop_assert!(falls_by <= 1e-12);
            }
        }

        #[test]
        fn smooth_curves_have_no_kinks(
            steps in prop::collection::vec(0.5..2.0f64, 3..6), points in prop::collection::vec(prop::array::uniform3(-5.0..5.0f64), 6),
        ) {
            let times: Vec<f64> = steps.iter().scan(0.0, |time, step| { *time += step; Some(*time) }).collect();
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
            let line = timeline(&times, Interpolation::Smooth);
            let h = 1e-6;
            for &time in &times {
                let [before, here, after] = [-h, 0.0, h].map(|d| line.point(&points, time + d));
                prop_assert!(((after - here) - (here - before)).length() / h < 1e-3);
            }
        }
    }
}
