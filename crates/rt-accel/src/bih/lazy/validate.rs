//! Validation of the existing nodes.

use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::node::NodeState;
use crate::{ValidationError, bih::traverse::BihNode, traversal::MAX_DEPTH};

/// Check that each primitive is in one leaf or one unsplit node, between all planes above, and that stored bounds are
/// current.
pub(super) struct Check<'p, P> {
    primitives: &'p P,
    is_placed: Vec<bool>,
}

impl<'p, P: Primitives> Check<'p, P> {
    pub(super) fn new(primitives: &'p P, count: u32) -> Self {
        Self { primitives, is_placed: vec![false; count as usize] }
    }

    /// Checks that the unbounded primitives are in no node, and all others in one of those seen.
    pub(super) fn finish(mut self, unbounded: &[u32]) -> Result<(), ValidationError> {
        for &primitive in unbounded {
            self.place(primitive)?;
        }
        match self.is_placed.iter().position(|placed| !placed) {
            Some(primitive) => Err(ValidationError::Misplaced { primitive: primitive as u32 }),
            None => Ok(()),
        }
    }

    /// Checks one node.
    pub(super) fn node(&mut self, state: &NodeState<'_>, bounds: &Aabb, depth: u32) -> Result<(), ValidationError> {
        if depth > MAX_DEPTH {
            return Err(ValidationError::Depth { depth });
        }
        match state {
            NodeState::Split(BihNode::Inner(..)) => Ok(()),
            NodeState::Split(BihNode::Leaf(indices)) => {
                indices.iter().try_for_each(|&index| self.inside(index, &[bounds]))
            }
            NodeState::Unsplit(unsplit) => {
                let mut items = unsplit.iter().flat_map(|unsplit| &unsplit.items);
                items.try_for_each(|(index, own)| self.inside(*index, &[bounds, own]))
            }
        }
    }

    fn inside(&mut self, primitive: u32, boxes: &[&Aabb]) -> Result<(), ValidationError> {
        self.place(primitive)?;
        let own = padded_bounds(self.primitives, primitive).ok_or(ValidationError::Misplaced { primitive })?;
        if boxes.iter().all(|aabb| aabb.encloses(&own)) { Ok(()) } else { Err(ValidationError::Outside { primitive }) }
    }

    fn place(&mut self, primitive: u32) -> Result<(), ValidationError> {
        match self.is_placed.get_mut(primitive as usize) {
            Some(placed) if !*placed => *placed = true,
            _ => return Err(ValidationError::Misplaced { primitive }),
        }
        Ok(())
    }
}
