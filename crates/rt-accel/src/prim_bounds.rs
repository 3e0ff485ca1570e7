//! Padded bounds of the primitives, from which all accelerators are built.

use glam::DVec3;
use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use crate::{BuildError, ValidationError};

/// Bounded primitive and its padded bounds.
pub(crate) type Item = (u32, Aabb);

/// Padded bounds of all bounded primitives, and the list of the others.
pub(crate) struct PrimBounds {
    /// Bounded primitives by rising index.
    pub(crate) bounded: Vec<Item>,
    /// Unbounded primitives, by rising index.
    pub(crate) unbounded: Vec<u32>,
    /// Union of all boxes.
    pub(crate) union: Aabb,
}

impl PrimBounds {
    pub(crate) fn collect<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let count = count(primitives)?;
        let mut all = Self { bounded: Vec::with_capacity(count as usize), unbounded: Vec::new(), union: Aabb::EMPTY };
        for index in 0..count {
            match checked_padded_bounds(primitives, index)? {
                Some(own) => {
                    all.union = all.union.union(own);
                    all.bounded.push((index, own));
                }
                None => all.unbounded.push(index),
            }
        }
        Ok(all)
    }

    /// Union of all bounds; a point at the origin without any, because not every serialisation format has infinity.
    pub(crate) fn finite_union(&self) -> Aabb {
        if self.bounded.is_empty() { Aabb::new(DVec3::ZERO, DVec3::ZERO) } else { self.union }
    }
}

/// Number of primitives, if 32 bits can index them with one value left over.
pub(crate) fn count<P: Primitives>(primitives: &P) -> Result<u32, BuildError> {
    let limit = u32::MAX - 1;
    match u32::try_from(primitives.len()) {
        Ok(count) if count <= limit => Ok(count),
        _ => Err(BuildError::TooMany { count: primitives.len() as u64, limit: u64::from(limit) }),
    }
}

/// Padded bounds of a primitive, `None` if it is unbounded.
pub(crate) fn checked_padded_bounds<P: Primitives>(primitives: &P, index: u32) -> Result<Option<Aabb>, BuildError> {
    match padded_bounds(primitives, index) {
        Some(own) if own.is_empty() || !own.is_finite() => {
            let bounds = primitives.bounds(index).unwrap_or(own);
            Err(BuildError::BadBounds { index, bounds })
        }
        own => Ok(own),
    }
}

/// Checks that `bounds` contains the padded bounds of all bounded primitives.
pub(crate) fn validate_union<P: Primitives>(bounds: &Aabb, primitives: &P) -> Result<(), ValidationError> {
    let is_outside = |&index: &u32| padded_bounds(primitives, index).is_some_and(|own| !bounds.encloses(&own));
    match (0..primitives.len() as u32).find(is_outside) {
        Some(primitive) => Err(ValidationError::Outside { primitive }),
        None => Ok(()),
    }
}

/// Checks that `unbounded` lists exactly the primitives without bounds, out of `built` primitives.
pub(crate) fn validate_lists<P: Primitives>(
    primitives: &P,
    built: u32,
    unbounded: &[u32],
) -> Result<(), ValidationError> {
    if primitives.len() != built as usize {
        return Err(ValidationError::Count { built, given: primitives.len() });
    }
    let mut listed = unbounded.iter().peekable();
    for primitive in 0..built {
        let is_listed = listed.next_if(|&&next| next == primitive).is_some();
        if is_listed != primitives.bounds(primitive).is_none() {
            return Err(ValidationError::Misplaced { primitive });
        }
    }
    listed.next().map_or(Ok(()), |&primitive| Err(ValidationError::Misplaced { primitive }))
}
