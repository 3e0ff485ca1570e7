//! Queries: down to the nearer child first, back to the one that was put off.

use rt_math::{Accelerator, Hit, Interval, Primitives, Probe, Ray, SlabRay};

use super::Bvh;
use super::node::{Child, NodeRay};
use super::split::MAX_DEPTH;
use crate::nearest::{Nearest, any_blocks, is_finite};

impl Accelerator for Bvh {
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let mut nearest = Nearest::new(ray, span);
        nearest.offer_all(primitives, &self.unbounded, probe);
        if is_finite(ray) {
            self.descend(primitives, &mut nearest, probe);
        } else {
            nearest.offer_all(primitives, &self.indices, probe);
        }
        nearest.hit
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let slab_ray = SlabRay::new(ray);
        if any_blocks(primitives, &self.unbounded, &slab_ray, span, probe) {
            return true;
        }
        if is_finite(ray) {
            self.descend_to_any(primitives, &slab_ray, span, probe)
        } else {
            any_blocks(primitives, &self.indices, &slab_ray, span, probe)
        }
    }
}

impl Bvh {
    fn descend<P: Primitives, S: Probe>(&self, primitives: &P, nearest: &mut Nearest, probe: &mut S) {
        let node_ray = NodeRay::new(&nearest.ray, self.centre);
        let mut stack = Stack::new((0.0, Child::leaf(0, 0)));
        let mut child = self.root;
        loop {
            if child.count > 0 {
                nearest.offer_all(primitives, self.leaf(child), probe);
            } else if let Some(node) = self.nodes.get(child.first as usize) {
                probe.node();
                let crossings = node_ray.clip(node, nearest.span);
                if let Some((near, both)) = crossings.nearer() {
                    let far = near ^ 1;
                    stack.push_if(both, (crossings.enter[far], node.children[far]));
                    child = node.children[near];
                    continue;
                }
            }
            child = loop {
                let Some((enter, child)) = stack.pop() else { return };
                // Strictly: an equally near primitive of lower index must still be found.
                if enter <= nearest.span.max {
                    break child;
                }
            };
        }
    }

    fn descend_to_any<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &SlabRay,
        span: Interval,
        probe: &mut S,
    ) -> bool {
        let node_ray = NodeRay::new(ray, self.centre);
        let mut stack = Stack::new(Child::leaf(0, 0));
        let mut child = self.root;
        loop {
            if child.count > 0 {
                if any_blocks(primitives, self.leaf(child), ray, span, probe) {
                    return true;
                }
            } else if let Some(node) = self.nodes.get(child.first as usize) {
                probe.node();
                if let Some((near, both)) = node_ray.clip(node, span).nearer() {
                    stack.push_if(both, node.children[near ^ 1]);
                    child = node.children[near];
                    continue;
                }
            }
            match stack.pop() {
                Some(next) => child = next,
                None => return false,
            }
        }
    }
}

/// Children that were put off: one at most on every level of the tree.
struct Stack<T> {
    entries: [T; STACK],
    len: usize,
}

/// A power of two, so that the remainder is a mask.
const STACK: usize = (MAX_DEPTH as usize).next_power_of_two();

impl<T: Copy> Stack<T> {
    fn new(filler: T) -> Self {
        Self { entries: [filler; STACK], len: 0 }
    }

    /// Pushes the entry if `wanted`, without a branch: which boxes are hit cannot be predicted.
    #[inline(always)]
    fn push_if(&mut self, wanted: bool, entry: T) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        self.entries[self.len % STACK] = entry;
        self.len += usize::from(wanted);
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len % STACK])
    }
}
