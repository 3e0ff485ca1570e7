//! Products of constant and animated transforms.

use std::sync::Arc;

use crate::{Aabb, AnimatedTransform, Transform};

/// Product of constant and animated transforms, as above a node of a scene tree: `A₁ · M₁(τ) · A₂ · M₂(τ) · … · L`.
///
/// ```
/// use rt_math::{DVec3, AnimatedTransform, AnimatedTransformChain, Transform};
///
/// let moved = |x: f64| Transform::translate(DVec3::X * x);
/// let walk = AnimatedTransform::new(&Transform::IDENTITY, &moved(1.0))?;
/// let chain = AnimatedTransformChain::constant(moved(5.0)).compose_animated(&walk).compose(&moved(0.25));
/// assert_eq!(chain.at(0.5).point(DVec3::ZERO).x, 5.75);
/// assert!(chain.as_constant().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedTransformChain {
    /// The innermost animated transform and the chain that is applied after it. Shared by all chains below.
    outer: Option<Arc<(Self, AnimatedTransform)>>,
    /// Constant transform that is applied first; `None` for the identity, which most nodes that move have.
    last: Option<Transform>,
}

impl AnimatedTransformChain {
    /// Identity.
    pub const IDENTITY: Self = Self { outer: None, last: None };

    /// Chain without animated transforms.
    pub fn constant(transform: Transform) -> Self {
        Self { outer: None, last: (!transform.is_identity()).then_some(transform) }
    }

    /// The transform, if the chain is constant.
    pub const fn as_constant(&self) -> Option<&Transform> {
        if self.outer.is_none() { Some(self.last()) } else { None }
    }

    /// Chain that applies `first` and then this one.
    #[must_use]
    pub fn compose(mut self, first: &Transform) -> Self {
        if !first.is_identity() {
            self.last = Some(self.last.map_or(*first, |last| last.compose(first)));
        }
        self
    }

    /// Chain that applies the animated transform `first` and then this one.
    #[must_use]
    pub fn compose_animated(self, first: &AnimatedTransform) -> Self {
        Self { outer: Some(Arc::new((self, *first))), last: None }
    }

    /// Constant transform that is applied first.
    const fn last(&self) -> &Transform {
        match &self.last {
            Some(last) => last,
            None => &Transform::IDENTITY,
        }
    }

    /// The map at a time.
    pub fn at(&self, time: f64) -> Transform {
        let Some((outer, motion)) = self.outer.as_deref() else { return *self.last() };
        let mut map = outer.compose_at(motion, time);
        if let Some(first) = &self.last {
            map = map.compose(first);
        }
        let mut chain = outer;
        while let Some((outer, motion)) = chain.outer.as_deref() {
            map = outer.compose_at(motion, time).compose(&map);
            chain = outer;
        }
        map
    }

    /// Applies an animated transform at a time, and then the last constant transform.
    #[inline]
    fn compose_at(&self, motion: &AnimatedTransform, time: f64) -> Transform {
        match &self.last {
            Some(last) => last.compose(&motion.at(time)),
            None => motion.at(time),
        }
    }

    /// Bounds of the image of a box over times 0 to 1; exactly those of its image for a constant chain. Each transform
    /// is applied to the bounds of the previous one. Empty stays empty.
    pub fn aabb(&self, aabb: &Aabb) -> Aabb {
        let (mut chain, mut sum) = (self, self.last().aabb(aabb));
        while let Some((outer, motion)) = chain.outer.as_deref() {
            sum = outer.last().aabb(&motion.aabb(&sum));
            chain = outer;
        }
        sum
    }
}

impl Drop for AnimatedTransformChain {
    /// Drops link by link: recursion could overflow the call stack.
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
        let long =
            (0..1_000_000).fold(AnimatedTransformChain::constant(step), |chain, _| chain.compose_animated(&motion));
        let branch = long.clone().compose(&step);
        drop(long);
        assert_eq!(branch.at(0.5).point(DVec3::ZERO).x, 500_002.0);
    }
}
