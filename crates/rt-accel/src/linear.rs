//! Brute force: the definition of the right answer, and the best structure for a handful of primitives.

use rt_math::{Accelerator, Hit, Interval, Primitives, Probe, Ray, SlabRay, decide_occluded};

use crate::nearest::Nearest;
use crate::own_boxes::{checked_own_box, count};
use crate::{BuildError, BuildStats, Violation};

/// Tests every primitive in turn. O(n) per ray, no memory.
///
/// What it answers is by definition right; every other structure gives the same bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Linear {
    primitives: u32,
    unbounded: u32,
}

impl Linear {
    /// Checks the bounds of all primitives, as other structures do, and remembers their number.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or 32 bits cannot number the primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let mut linear = Self { primitives: count(primitives)?, unbounded: 0 };
        for index in 0..linear.primitives {
            if checked_own_box(primitives, index)?.is_none() {
                linear.unbounded += 1;
            }
        }
        Ok(linear)
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        size_of::<Self>()
    }

    /// Size of the list.
    pub fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded as usize,
            references: (self.primitives - self.unbounded) as usize,
            ..BuildStats::default()
        }
    }

    /// Checks that the list still fits the primitives.
    ///
    /// # Errors
    ///
    /// [`Violation::Count`] if the number of primitives has changed.
    pub fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), Violation> {
        if primitives.len() == self.primitives as usize {
            Ok(())
        } else {
            Err(Violation::Count { built: self.primitives, given: primitives.len() })
        }
    }
}

impl Accelerator for Linear {
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let mut nearest = Nearest::new(ray, span);
        for index in 0..self.primitives {
            nearest.offer(primitives, index, probe);
        }
        nearest.hit
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let ray = SlabRay::new(ray);
        (0..self.primitives).any(|index| decide_occluded(primitives, index, &ray, span, probe))
    }
}
