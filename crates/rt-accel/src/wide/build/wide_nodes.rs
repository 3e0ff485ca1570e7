//! Creates the wide nodes as planned: the uppermost first, then the subtrees below them in chunks, on several threads.

use super::binary::Content;
use super::collapse::{ChildSlot, WIDTH};
use super::parallel::{NodeId, SubtreeSet};
use super::prim_ref::PrimRange;
use crate::parallel_for::parallel_map;
use crate::wide::huge_pages::filled;
use crate::wide::leaf::{LeafKind, LeafOrder};
use crate::wide::node::{Child, WideNode};

/// Nodes down to this depth, at most 73, precede the at most 512 chunks below.
const TOP: u32 = 3;

/// Primitives below which one thread creates all nodes, as it makes all other decisions about them.
const MIN_SHARED: usize = 4096;

/// A tree whose nodes have up to eight children. The first node is the root, which may have a leaf as its only child.
#[derive(Debug, PartialEq)]
pub(in crate::wide) struct WideTree {
    /// Children come after their parents.
    pub(in crate::wide) nodes: Vec<WideNode>,
    /// Leaves in the order of nodes and lanes, chunk by chunk.
    pub(in crate::wide) listings: Vec<LeafOrder>,
    /// Depth of the deepest leaf; leaves below the root have depth 1.
    pub(in crate::wide) depth: u32,
}

/// A wide node to be created.
#[derive(Clone, Copy)]
struct PendingNode {
    place: NodeId,
    /// Number of children from the left side.
    from_left: usize,
    depth: u32,
    /// Parent and lane; both 0 for the first node of a chunk.
    parent: (usize, usize),
}

pub(super) struct WideBuilder<'a> {
    pub(super) forest: &'a SubtreeSet,
    pub(super) indices: &'a [PrimRange],
    pub(super) kind: LeafKind,
}

/// Nodes in depth-first order with chunk-local indices, and the leaves among their children in order.
#[derive(Default)]
struct Chunk {
    nodes: Vec<WideNode>,
    listing: LeafOrder,
    depth: u32,
    /// Nodes below the chunk.
    deferred: Vec<PendingNode>,
}

impl WideBuilder<'_> {
    /// Creates all nodes; `None` if 28 bits cannot index nodes and leaves.
    pub(super) fn run(&self) -> Option<WideTree> {
        let root = self.forest.root();
        let first = PendingNode { place: root, from_left: 0, depth: 1, parent: (0, 0) };
        let top = match self.forest.plan(root).share(1) {
            ChildSlot::Node(from_left) => self.part(PendingNode { from_left, ..first }, TOP),
            ChildSlot::Leaf | ChildSlot::Open(_) => self.single_leaf(root),
        };
        let part = |at: usize| self.part(PendingNode { parent: (0, 0), ..top.deferred[at] }, u32::MAX);
        let below = if self.indices.len() < MIN_SHARED {
            (0..top.deferred.len()).map(part).collect()
        } else {
            parallel_map(top.deferred.len(), part)
        };
        join(top, below)
    }

    /// A node with one leaf of all references as its only child.
    fn single_leaf(&self, root: NodeId) -> Chunk {
        let mut part = Chunk { depth: 1, ..Chunk::default() };
        let mut node = WideNode::EMPTY;
        node.set(0, &self.forest.bounds(root), self.leaf(&mut part.listing, root));
        part.nodes.push(node);
        part
    }

    /// Nodes from the first down to a depth.
    fn part(&self, first: PendingNode, down_to: u32) -> Chunk {
        let mut part = Chunk::default();
        let mut pending = vec![first];
        while let Some(next) = pending.pop() {
            if next.depth > down_to {
                part.deferred.push(next);
            } else {
                self.node(next, &mut part, &mut pending);
            }
        }
        part
    }

    fn node(&self, next: PendingNode, part: &mut Chunk, pending: &mut Vec<PendingNode>) {
        let PendingNode { place, from_left, depth, parent: (above, lane) } = next;
        let number = part.nodes.len();
        if number > 0 {
            part.nodes[above].children[lane] = Child::node(number as u32);
        }
        part.depth = part.depth.max(depth);
        let mut node = WideNode::EMPTY;
        let mut lane = 0;
        let first_pending = pending.len();
        // Pending child slots, the next one last.
        let mut shares = [(place, 0); WIDTH];
        let mut len = self.open(place, [from_left, WIDTH - from_left], &mut shares);
        while len > 0 {
            let (place, children) = shares[len - 1];
            match self.forest.plan(place).share(children) {
                ChildSlot::Open(children) => {
                    len += self.open(place, children, &mut shares[len - 1..]) - 1;
                    continue;
                }
                ChildSlot::Node(from_left) => {
                    pending.push(PendingNode { place, from_left, depth: depth + 1, parent: (number, lane) });
                    node.set(lane, &self.forest.bounds(place), Child::node(0));
                }
                ChildSlot::Leaf => node.set(lane, &self.forest.bounds(place), self.leaf(&mut part.listing, place)),
            }
            len -= 1;
            lane += 1;
        }
        pending[first_pending..].reverse();
        part.nodes.push(node);
    }

    /// Lists both sides of a node with their numbers of children, the left one last; returns their count.
    fn open(&self, place: NodeId, [of_left, of_right]: [usize; 2], shares: &mut [(NodeId, usize)]) -> usize {
        let Content::Inner([left, right]) = self.forest.content(place) else { return 0 };
        shares[0] = (self.forest.follow(NodeId { node: right, ..place }), of_right);
        shares[1] = (self.forest.follow(NodeId { node: left, ..place }), of_left);
        2
    }

    fn leaf(&self, listing: &mut LeafOrder, place: NodeId) -> Child {
        let first = listing.order.len();
        self.list(place, &mut listing.order);
        listing.order[first..].sort_unstable();
        listing.close(first, self.kind)
    }

    /// Lists the primitives of a leaf.
    fn list(&self, place: NodeId, order: &mut Vec<u32>) {
        match self.forest.content(place) {
            Content::Leaf { first, count } => {
                for run in &self.indices[first as usize..][..count as usize] {
                    order.push(run.first);
                    if run.count == 2 {
                        order.push(run.first + 1);
                    }
                }
            }
            Content::Inner(children) => {
                for node in children {
                    self.list(self.forest.follow(NodeId { node, ..place }), order);
                }
            }
            Content::Link(_) => {}
        }
    }
}

/// Concatenates chunks below the uppermost nodes, and shifts their indices.
fn join(mut top: Chunk, below: Vec<Chunk>) -> Option<WideTree> {
    let (mut first_node, mut first_line, mut depth) = (top.nodes.len(), top.listing.n_lines, top.depth);
    let mut listings = vec![top.listing];
    let mut parts = Vec::with_capacity(below.len() + 1);
    for (deferred, part) in top.deferred.iter().zip(below) {
        let (above, lane) = deferred.parent;
        top.nodes[above].children[lane] = Child::node(first_node as u32);
        let count = part.nodes.len();
        parts.push((count, (part.nodes, first_node, first_line)));
        first_node += count;
        first_line += part.listing.n_lines;
        depth = depth.max(part.depth);
        listings.push(part.listing);
    }
    if first_node.max(first_line) > Child::LIMIT {
        return None;
    }
    parts.insert(0, (top.nodes.len(), (top.nodes, 0, 0)));
    let nodes = filled(parts, WideNode::EMPTY, |(nodes, first_node, first_line), output| {
        for (place, node) in output.iter_mut().zip(nodes) {
            *place = node.moved(first_node, first_line);
        }
    });
    Some(WideTree { nodes, listings, depth })
}
