//! Maps one after the other, some of which move.

use crate::{Aabb, Motion, Transform};

/// A product of transforms and motions, as it stands above a node of a tree: `A₁ · M₁(τ) · A₂ · M₂(τ) · … · L`.
///
/// ```
/// use rt_math::{DVec3, Motion, MotionChain, Transform};
///
/// let moved = |x: f64| Transform::translate(DVec3::X * x);
/// let walk = Motion::new(&Transform::IDENTITY, &moved(1.0))?;
/// let chain = MotionChain::still(moved(5.0)).then_first_motion(&walk).then_first(&moved(0.25));
/// assert_eq!(chain.at(0.5).point(DVec3::ZERO).x, 5.75);
/// assert!(chain.as_still().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MotionChain {
    /// Each with the transform that is applied after it.
    links: Vec<(Transform, Motion)>,
    /// What is applied first.
    last: Transform,
}

impl MotionChain {
    /// A chain in which nothing moves.
    pub const fn still(transform: Transform) -> Self {
        Self { links: Vec::new(), last: transform }
    }

    /// The transform, if nothing moves.
    pub const fn as_still(&self) -> Option<&Transform> {
        if self.links.is_empty() { Some(&self.last) } else { None }
    }

    /// The chain that applies `first` and then this one.
    #[must_use]
    pub fn then_first(mut self, first: &Transform) -> Self {
        self.last = self.last.then_first(first);
        self
    }

    /// The chain that applies `first`, which moves, and then this one.
    #[must_use]
    pub fn then_first_motion(mut self, first: &Motion) -> Self {
        self.links.push((self.last, *first));
        self.last = Transform::IDENTITY;
        self
    }

    /// The map at a moment.
    pub fn at(&self, time: f64) -> Transform {
        let Some(((still, motion), rest)) = self.links.split_first() else { return self.last };
        let first = still.then_first(&motion.at(time));
        let all = rest.iter().fold(first, |all, (still, motion)| all.then_first(still).then_first(&motion.at(time)));
        all.then_first(&self.last)
    }

    /// A box around the image of a box at all moments from 0 to 1; the box around its image if nothing moves. Each map takes a
    /// box that contains what the maps before it make of the points. Empty stays empty.
    pub fn aabb(&self, aabb: &Aabb) -> Aabb {
        let local = self.last.aabb(aabb);
        self.links.iter().rev().fold(local, |sum, (still, motion)| still.aabb(&motion.aabb(&sum)))
    }
}
