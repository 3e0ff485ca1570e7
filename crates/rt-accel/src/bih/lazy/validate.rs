//! Checks a hierarchy as far as it is known.

use rt_math::{Aabb, Primitives, own_box};

use super::LazyBih;
use super::node::Known;
use crate::Violation;
use crate::bih::walk::Step;
use crate::bounded_depth::MAX_DEPTH;

/// Each primitive is in one leaf or waits in one node, between all planes above, and the boxes that wait are right.
pub(super) fn check<P: Primitives>(bih: &LazyBih, primitives: &P) -> Result<(), Violation> {
    let mut check = Check { primitives, is_placed: vec![false; bih.primitives as usize] };
    let mut verdict = Ok(());
    bih.for_each_node(|known, bounds, depth| {
        if verdict.is_ok() {
            verdict = check.node(known, &bounds, depth);
        }
    });
    verdict?;
    for &primitive in &bih.unbounded {
        check.place(primitive)?;
    }
    match check.is_placed.iter().position(|placed| !placed) {
        Some(primitive) => Err(Violation::Misplaced { primitive: primitive as u32 }),
        None => Ok(()),
    }
}

struct Check<'p, P> {
    primitives: &'p P,
    is_placed: Vec<bool>,
}

impl<P: Primitives> Check<'_, P> {
    fn node(&mut self, known: &Known<'_>, bounds: &Aabb, depth: u32) -> Result<(), Violation> {
        if depth > MAX_DEPTH {
            return Err(Violation::Depth { depth });
        }
        match known {
            Known::Split(Step::Node(..)) => Ok(()),
            Known::Split(Step::Leaf(indices)) => indices.iter().try_for_each(|&index| self.inside(index, &[bounds])),
            Known::Waiting(waiting) => {
                let mut items = waiting.iter().flat_map(|waiting| &waiting.items);
                items.try_for_each(|(index, own)| self.inside(*index, &[bounds, own]))
            }
        }
    }

    fn inside(&mut self, primitive: u32, boxes: &[&Aabb]) -> Result<(), Violation> {
        self.place(primitive)?;
        let own = own_box(self.primitives, primitive).ok_or(Violation::Misplaced { primitive })?;
        if boxes.iter().all(|aabb| aabb.encloses(&own)) { Ok(()) } else { Err(Violation::Outside { primitive }) }
    }

    fn place(&mut self, primitive: u32) -> Result<(), Violation> {
        match self.is_placed.get_mut(primitive as usize) {
            Some(placed) if !*placed => *placed = true,
            _ => return Err(Violation::Misplaced { primitive }),
        }
        Ok(())
    }
}
