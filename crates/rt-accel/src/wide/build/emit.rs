//! Turns the binary tree into the wide one, as planned.

use super::binary::Content;
use super::collapse::{LEAF, NODE, PRIMITIVE, Share, WIDTH};
use super::forest::{Forest, Place};
use super::reference::Run;
use super::{WideChild, WideNode, WideTree};
use crate::bvh::NodeBox;

/// A wide node to be made.
struct Pending {
    place: Place,
    /// How many of the children come from the left side.
    from_left: usize,
    depth: u32,
    /// The node above, and which child of it this one is.
    parent: Option<(usize, usize)>,
}

pub(super) struct Emission<'a> {
    forest: &'a Forest,
    /// Indices of primitives, by place.
    indices: &'a [Run],
    wide: WideTree,
}

impl<'a> Emission<'a> {
    pub(super) fn new(forest: &'a Forest, indices: &'a [Run], count: usize) -> Self {
        let wide = WideTree { nodes: Vec::new(), order: Vec::with_capacity(count), depth: 1, sah_cost: 0.0 };
        Self { forest, indices, wide }
    }

    pub(super) fn run(mut self) -> WideTree {
        let root = self.forest.root();
        let mut pending = Vec::new();
        match self.forest.plan(root).share(1) {
            Share::Node(from_left) => pending.push(Pending { place: root, from_left, depth: 1, parent: None }),
            Share::Leaf | Share::Open(_) => {
                let mut node = WideNode::EMPTY;
                self.leaf(&mut node, root);
                self.wide.nodes.push(node);
            }
        }
        while let Some(next) = pending.pop() {
            self.node(next, &mut pending);
        }
        self.wide.sah_cost = self.wide.cost(&self.forest.bounds(root));
        self.wide
    }

    fn node(&mut self, Pending { place, from_left, depth, parent }: Pending, pending: &mut Vec<Pending>) {
        let number = self.wide.nodes.len();
        if let Some((above, child)) = parent {
            self.wide.nodes[above].children[child] = WideChild::Node(number as u32);
        }
        self.wide.depth = self.wide.depth.max(depth);
        let mut node = WideNode::EMPTY;
        let first_pending = pending.len();
        // The parts that are yet to be looked at, the next one last.
        let mut parts = [(place, 0); WIDTH];
        let mut len = 0;
        if let Content::Inner([left, right]) = self.forest.content(place) {
            parts[0] = (self.forest.follow(Place { node: right, ..place }), WIDTH - from_left);
            parts[1] = (self.forest.follow(Place { node: left, ..place }), from_left);
            len = 2;
        }
        while len > 0 {
            len -= 1;
            let (place, children) = parts[len];
            match (self.forest.plan(place).share(children), self.forest.content(place)) {
                (Share::Open([of_left, of_right]), Content::Inner([left, right])) => {
                    parts[len] = (self.forest.follow(Place { node: right, ..place }), of_right);
                    parts[len + 1] = (self.forest.follow(Place { node: left, ..place }), of_left);
                    len += 2;
                }
                (Share::Node(from_left), _) => {
                    let parent = Some((number, usize::from(node.count)));
                    pending.push(Pending { place, from_left, depth: depth + 1, parent });
                    node.push(self.forest.bounds(place), WideChild::Node(0));
                }
                _ => self.leaf(&mut node, place),
            }
        }
        pending[first_pending..].reverse();
        self.wide.nodes.push(node);
    }

    fn leaf(&mut self, node: &mut WideNode, place: Place) {
        let first = self.wide.order.len();
        self.list(place);
        self.wide.order[first..].sort_unstable();
        let count = self.wide.order.len() - first;
        node.push(self.forest.bounds(place), WideChild::Leaf { first: first as u32, count: count as u32 });
    }

    /// Lists what is below a node that becomes a leaf.
    fn list(&mut self, place: Place) {
        match self.forest.content(place) {
            Content::Leaf { first, count } => {
                for run in &self.indices[first as usize..][..count as usize] {
                    self.wide.order.push(run.first);
                    if run.count == 2 {
                        self.wide.order.push(run.first + 1);
                    }
                }
            }
            Content::Inner(children) => {
                for node in children {
                    self.list(self.forest.follow(Place { node, ..place }));
                }
            }
            Content::Link(_) => {}
        }
    }
}

impl WideTree {
    /// Expected cost of a ray that meets the root's box: by the ratio of the areas, it meets the others.
    fn cost(&self, root: &NodeBox) -> f64 {
        let mut sum = root.half_area() * f64::from(NODE);
        for node in &self.nodes {
            for (bounds, child) in node.boxes.iter().zip(&node.children).take(usize::from(node.count)) {
                sum += bounds.half_area()
                    * match *child {
                        WideChild::Node(_) => f64::from(NODE),
                        WideChild::Leaf { count, .. } => f64::from(LEAF) + f64::from(PRIMITIVE) * f64::from(count),
                    };
            }
        }
        let area = root.half_area();
        if area > 0.0 { sum / area } else { 0.0 }
    }
}
