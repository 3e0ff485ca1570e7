//! Linear search: the best accelerator for up to about ten primitives.

use core::ops::ControlFlow;

use crate::{Accelerator, BuildError, BuildStats, RayQuery, Refit, RegionQuery, ValidationError, brute_force};
use rt_geometry::{Hit, HitStream, Primitives, Probe, RayStream};
use rt_math::{Aabb, Interval, Ray};

use crate::accelerator::{closest_one_by_one, occluded_one_by_one};
use crate::prim_bounds::{checked_padded_bounds, count};
use crate::wide::{SimdLevel, SmallSet, SphereList};

/// Tests every primitive. O(n) per ray; 16 bytes per sphere if there are more than 16 primitives and all are
/// spheres, otherwise no memory.
///
/// More than 16 spheres are tested eight at a time in `f32`, and those that a ray may hit in `f64`. Streams test up to
/// 16 primitives with eight rays at a time, as a [`SmallSet`]. Results and [`Counters`](crate::Counters) are those of
/// [`brute_force`], bit for bit; accelerators among the primitives may count less in streams.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct Linear {
    primitives: u32,
    unbounded: u32,
    /// Copy of all primitives, if they are many spheres.
    spheres: Option<SphereList>,
    #[cfg_attr(feature = "serde", serde(skip))]
    level: SimdLevel,
}

impl Linear {
    /// Checks the bounds of all primitives, and copies them if they are many spheres.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let mut linear =
            Self { primitives: count(primitives)?, unbounded: 0, spheres: None, level: SimdLevel::default() };
        for index in 0..linear.primitives {
            if checked_padded_bounds(primitives, index)?.is_none() {
                linear.unbounded += 1;
            }
        }
        linear.spheres = SphereList::of(primitives);
        Ok(linear)
    }

    /// Sets the instruction set, for tests and comparisons; the default is the best of the processor. An
    /// unavailable level is replaced by the best one below it.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.spheres = self.spheres.map(|spheres| spheres.with_level(level));
        self.level = level;
        self
    }

    /// All primitives, if they are few and not a list of spheres.
    pub(crate) fn small_set(&self) -> Option<SmallSet> {
        let are_few = self.spheres.is_none() && self.primitives as usize <= SmallSet::CAPACITY;
        are_few.then(|| SmallSet::new(0..self.primitives)).flatten().map(|few| few.with_level(self.level))
    }
}

#[cfg(feature = "serde")]
impl Linear {
    fn check_shape(&self) -> Result<(), ValidationError> {
        let Self { primitives: built, unbounded, ref spheres, .. } = *self;
        if unbounded > built {
            return Err(ValidationError::Count { built, given: unbounded as usize });
        }
        match spheres {
            Some(spheres) if spheres.count() != built || !spheres.is_whole() => {
                Err(ValidationError::Count { built, given: spheres.count() as usize })
            }
            _ => Ok(()),
        }
    }
}

impl Accelerator for Linear {
    #[inline]
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match &self.spheres {
            Some(spheres) => spheres.trace(primitives, ray, span, probe),
            None => brute_force::closest(primitives, ray, span, probe),
        }
    }

    #[inline]
    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        match &self.spheres {
            Some(spheres) => spheres.trace(primitives, ray, span, probe),
            None => brute_force::occluded(primitives, ray, span, probe),
        }
    }

    fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        match self.small_set() {
            Some(small_set) => small_set.closest_stream(primitives, rays, hits, probe),
            None => closest_one_by_one(self, primitives, rays, hits, probe),
        }
    }

    fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        match self.small_set() {
            Some(small_set) => small_set.occluded_stream(primitives, rays, occluded, probe),
            None => occluded_one_by_one(self, primitives, rays, occluded, probe),
        }
    }

    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        for index in 0..self.primitives {
            query.test_primitive(primitives, index, probe)?;
        }
        ControlFlow::Continue(())
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        for index in 0..self.primitives {
            query.test_primitive(index, |_| true)?;
        }
        ControlFlow::Continue(())
    }

    fn memory(&self) -> usize {
        size_of::<Self>() + self.spheres.as_ref().map_or(0, SphereList::memory)
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded as usize,
            references: (self.primitives - self.unbounded) as usize,
            ..BuildStats::default()
        }
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        if primitives.len() != self.primitives as usize {
            return Err(ValidationError::Count { built: self.primitives, given: primitives.len() });
        }
        match &self.spheres {
            Some(spheres) => spheres.validate(primitives),
            None => Ok(()),
        }
    }

    /// Visits no nodes: a list has no boxes.
    fn for_each_box(&self, _visit: impl FnMut(Aabb, u32)) {}
}

impl Refit for Linear {
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let Self { primitives: built, unbounded, .. } = *self;
        let fitted = Self::build(primitives)?;
        if (fitted.primitives, fitted.unbounded) != (built, unbounded) {
            return Err(BuildError::Changed(ValidationError::Count { built, given: primitives.len() }));
        }
        *self = fitted.with_level(self.level);
        Ok(())
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(Linear, Linear::check_shape);
