//! Brute force: the definition of the right answer, and the best structure for a handful of primitives.

use core::ops::ControlFlow;

use rt_math::{Aabb, Primitives, Probe};

use crate::own_boxes::{checked_own_box, count};
use crate::structure::accelerator_by_walk;
use crate::{BuildError, BuildStats, RayQuery, Refit, RegionQuery, Structure, Violation};

/// Tests every primitive in turn. O(n) per ray, no memory.
///
/// What it answers is by definition right; every other structure gives the same bits.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
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
}

#[cfg(feature = "serde")]
impl Linear {
    const fn check_shape(&self) -> Result<(), Violation> {
        if self.unbounded <= self.primitives {
            Ok(())
        } else {
            Err(Violation::Count { built: self.primitives, given: self.unbounded as usize })
        }
    }
}

impl Structure for Linear {
    fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        for index in 0..self.primitives {
            query.offer(primitives, index, probe)?;
        }
        ControlFlow::Continue(())
    }

    fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        for index in 0..self.primitives {
            query.offer(index, |_| true)?;
        }
        ControlFlow::Continue(())
    }

    fn memory(&self) -> usize {
        size_of::<Self>()
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded as usize,
            references: (self.primitives - self.unbounded) as usize,
            ..BuildStats::default()
        }
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), Violation> {
        if primitives.len() == self.primitives as usize {
            Ok(())
        } else {
            Err(Violation::Count { built: self.primitives, given: primitives.len() })
        }
    }

    /// There are none.
    fn for_each_box(&self, _visit: impl FnMut(Aabb, u32)) {}
}

impl Refit for Linear {
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let fitted = Self::build(primitives)?;
        if fitted == *self {
            Ok(())
        } else {
            let built = self.primitives;
            Err(BuildError::Changed(Violation::Count { built, given: primitives.len() }))
        }
    }
}

accelerator_by_walk!(Linear);
#[cfg(feature = "serde")]
crate::saved::saved_and_checked!(Linear, Linear::check_shape);
