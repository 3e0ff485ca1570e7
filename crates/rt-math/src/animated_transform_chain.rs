//! Maps one after the other, some of which move.

use std::sync::Arc;

use crate::{Aabb, AnimatedTransform, Transform};

/// A product of transforms and motions, as it stands above a node of a tree: `A₁ · M₁(τ) · A₂ · M₂(τ) · … · L`.
///
/// ```
/// use rt_math::{DVec3, AnimatedTransform, AnimatedTransformChain, Transform};
///
/// let moved = |x: f64| Transform::translate(DVec3::X * x);
/// let walk = AnimatedTransform::new(&Transform::IDENTITY, &moved(1.0))?;
/// let chain = AnimatedTransformChain::still(moved(5.0)).compose_animated(&walk).compose(&moved(0.25));
/// assert_eq!(chain.at(0.5).point(DVec3::ZERO).x, 5.75);
/// assert!(chain.as_still().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedTransformChain {
    /// The innermost motion, with the chain that is applied after it. Shared by all that is below.
    outer: Option<Arc<(Self, AnimatedTransform)>>,
    /// What is applied first.
    last: Transform,
}

impl AnimatedTransformChain {
    /// A chain in which nothing moves.
    pub const fn still(transform: Transform) -> Self {
        Self { outer: None, last: transform }
    }

    /// The transform, if nothing moves.
    pub const fn as_still(&self) -> Option<&Transform> {
        if self.outer.is_none() { Some(&self.last) } else { None }
    }

    /// The chain that applies `first` and then this one.
    #[must_use]
    pub fn compose(mut self, first: &Transform) -> Self {
        self.last = self.last.compose(first);
        self
    }

    /// The chain that applies `first`, which moves, and then this one.
    #[must_use]
    pub fn compose_animated(self, first: &AnimatedTransform) -> Self {
        Self { outer: Some(Arc::new((self, *first))), last: Transform::IDENTITY }
    }

    /// The map at a time.
    pub fn at(&self, time: f64) -> Transform {
        let (mut chain, mut map) = (self, self.last);
        while let Some((outer, motion)) = chain.outer.as_deref() {
            map = outer.last.compose(&motion.at(time)).compose(&map);
            chain = outer;
        }
        map
    }

    /// A box around the image of a box at all times from 0 to 1; the box around its image if nothing moves. Each map takes a
    /// box that contains what the maps before it make of the points. Empty stays empty.
    pub fn aabb(&self, aabb: &Aabb) -> Aabb {
        let (mut chain, mut sum) = (self, self.last.aabb(aabb));
        while let Some((outer, motion)) = chain.outer.as_deref() {
            sum = outer.last.aabb(&motion.aabb(&sum));
            chain = outer;
        }
        sum
    }
}

impl Drop for AnimatedTransformChain {
    /// Link by link: a chain may be longer than the call stack is deep.
    fn drop(&mut self) {
        let mut outer = self.outer.take();
        while let Some((mut chain, _)) = outer.and_then(Arc::into_inner) {
            outer = chain.outer.take();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn long_chains_do_not_exhaust_the_call_stack() {
        let step = Transform::translate(DVec3::X);
        let motion = AnimatedTransform::new(&Transform::IDENTITY, &step).expect("a motion");
        let long = (0..1_000_000).fold(AnimatedTransformChain::still(step), |chain, _| chain.compose_animated(&motion));
        let branch = long.clone().compose(&step);
        drop(long);
        assert_eq!(branch.at(0.5).point(DVec3::ZERO).x, 500_002.0);
    }
}
