//! Turns the binary tree into the wide one, as planned: the uppermost nodes first, then what hangs below them, part by
//! part and on several threads.

use super::binary::Content;
use super::collapse::{ChildSlot, WIDTH};
use super::parallel::{Place, SubtreeSet};
use super::reference::Run;
use super::{WideTree, in_order};
use crate::wide::huge_pages::filled;
use crate::wide::leaf::{LeafKind, LeafOrder};
use crate::wide::node::{Child, Node};

/// Nodes down to this depth, up to 73, are made before those below, which are up to 512 parts.
const TOP: u32 = 3;

/// A wide node to be made.
#[derive(Clone, Copy)]
struct PendingNode {
    place: Place,
    /// How many of the children come from the left side.
    from_left: usize,
    depth: u32,
    /// The node above, and which child of it this one is; both 0 for the first of a part.
    parent: (usize, usize),
}

pub(super) struct WideBuilder<'a> {
    pub(super) forest: &'a SubtreeSet,
    /// Indices of primitives, by place.
    pub(super) indices: &'a [Run],
    pub(super) kind: LeafKind,
}

/// Nodes in depth-first order, numbered from 0, and the leaves among their children, in the order of these.
#[derive(Default)]
struct Chunk {
    nodes: Vec<Node>,
    listing: LeafOrder,
    depth: u32,
    /// What was put off: the nodes whose numbers are yet to be known.
    deferred: Vec<PendingNode>,
}

impl WideBuilder<'_> {
    /// The whole tree, `None` if numbers run out.
    pub(super) fn run(&self) -> Option<WideTree> {
        let root = self.forest.root();
        let first = PendingNode { place: root, from_left: 0, depth: 1, parent: (0, 0) };
        let top = match self.forest.plan(root).share(1) {
            ChildSlot::Node(from_left) => self.part(PendingNode { from_left, ..first }, TOP),
            ChildSlot::Leaf | ChildSlot::Open(_) => self.single_leaf(root),
        };
        let below =
            in_order(top.deferred.len(), |at| self.part(PendingNode { parent: (0, 0), ..top.deferred[at] }, u32::MAX));
        join(top, below)
    }

    /// A node whose only child is a leaf of everything.
    fn single_leaf(&self, root: Place) -> Chunk {
        let mut part = Chunk { depth: 1, ..Chunk::default() };
        let mut node = Node::EMPTY;
        node.set(0, &self.forest.bounds(root), self.leaf(&mut part.listing, root));
        part.nodes.push(node);
        part
    }

    /// The nodes from one on, down to a depth.
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
        let mut node = Node::EMPTY;
        let mut lane = 0;
        let first_pending = pending.len();
        // The shares that are yet to be looked at, the next one last.
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

    /// Lists both sides of a node with their shares, the left one last, and says how many there are.
    fn open(&self, place: Place, [of_left, of_right]: [usize; 2], shares: &mut [(Place, usize)]) -> usize {
        let Content::Inner([left, right]) = self.forest.content(place) else { return 0 };
        shares[0] = (self.forest.follow(Place { node: right, ..place }), of_right);
        shares[1] = (self.forest.follow(Place { node: left, ..place }), of_left);
        2
    }

    fn leaf(&self, listing: &mut LeafOrder, place: Place) -> Child {
        let first = listing.order.len();
        self.list(place, &mut listing.order);
        listing.order[first..].sort_unstable();
        listing.close(first, self.kind)
    }

    /// Lists what is below a node that becomes a leaf.
    fn list(&self, place: Place, order: &mut Vec<u32>) {
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
                    self.list(self.forest.follow(Place { node, ..place }), order);
                }
            }
            Content::Link(_) => {}
        }
    }
}

/// Numbers the parts one after the other, and hangs them below the nodes that were made first.
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
    let nodes = filled(parts, Node::EMPTY, |(nodes, first_node, first_line), room| {
        for (place, node) in room.iter_mut().zip(nodes) {
            *place = node.moved(first_node, first_line);
        }
    });
    Some(WideTree { nodes, listings, depth })
}
