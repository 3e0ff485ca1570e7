//! A tree over many lights, from which those that matter to a point are drawn.

use super::bounds::EmitterBounds;
use super::distribution::BELOW_ONE;
use super::{Choice, Emitter};
use rt_math::{Aabb, DVec3};

/// Places along an axis at which a split is tried.
const BUCKETS: usize = 12;

/// A binary tree of [`EmitterBounds`] (Conty Estevez, Kulla 2018): the choice goes down from the root, to each side with a
/// probability in proportion to its importance for the point.
///
/// Lights without bounds, as environments are, are chosen among with the same probability each, and the tree as a whole
/// counts as one of them.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// Lights without bounds.
    unbounded: Vec<u32>,
    /// Where each light is.
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: EmitterBounds,
    /// The node above; the root's own number at the root.
    parent: u32,
    content: Content,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Light(u32),
    /// Two nodes that follow each other, of which this is the first.
    Halves(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Leaf(u32),
    Unbounded,
    /// Has no power.
    Nowhere,
}

impl LightTree {
    /// The tree over a list of lights. Those without power are never chosen.
    pub fn new(emitters: &[Emitter]) -> Self {
        let is_black = |emitter: &Emitter| emitter.power(1.0).is_black();
        let entries = emitters.iter().map(|emitter| (!is_black(emitter)).then(|| emitter.bounds()));
        Self::over(entries.collect())
    }

    /// The tree over any lights of which the bounds are known; `None` for those without.
    pub fn of_bounds(lights: &[Option<EmitterBounds>]) -> Self {
        Self::over(lights.iter().map(|&bounds| Some(bounds)).collect())
    }

    /// The tree over lights, without bounds or not, if they have power.
    fn over(lights: Vec<Option<Option<EmitterBounds>>>) -> Self {
        let mut tree = Self { nodes: Vec::new(), unbounded: Vec::new(), places: vec![Place::Nowhere; lights.len()] };
        let mut bounded = Vec::new();
        for ((light, place), index) in lights.into_iter().zip(&mut tree.places).zip(0u32..) {
            match light {
                Some(Some(bounds)) if bounds.power > 0.0 => bounded.push((bounds, index)),
                Some(None) => {
                    *place = Place::Unbounded;
                    tree.unbounded.push(index);
                }
                _ => {}
            }
        }
        tree.grow(&mut bounded);
        tree
    }

    /// The light that belongs to `u` in `[0, 1)`, for a point and, if it lies on a surface that is lit on one side alone,
    /// the unit normal there. `None` if there is no light.
    pub fn choose(&self, point: DVec3, normal: Option<DVec3>, u: f64) -> Option<Choice> {
        let u = if u >= 0.0 { u.min(BELOW_ONE) } else { 0.0 };
        let unbounded = self.probability_of_unbounded();
        let place = u / unbounded;
        if let Some(&index) = self.unbounded.get(place as usize) {
            return Some(Choice { index, probability: unbounded });
        }
        let mut node = self.nodes.first()?;
        let mut probability = self.probability_of_tree();
        let mut u = ((u - (1.0 - probability)) / probability).clamp(0.0, BELOW_ONE);
        loop {
            let first = match node.content {
                Content::Light(index) => return Some(Choice { index, probability }),
                Content::Halves(first) => first as usize,
            };
            let split = self.probability_of_first(first, point, normal);
            let is_first = u < split;
            let part = if is_first { split } else { 1.0 - split };
            u = ((if is_first { u } else { u - split }) / part).min(BELOW_ONE);
            probability *= part;
            node = self.nodes.get(if is_first { first } else { first + 1 })?;
        }
    }

    /// The probability with which [`choose`](Self::choose) takes a light for this point; 0 for one that is not there or
    /// that cannot light the point.
    pub fn probability(&self, point: DVec3, normal: Option<DVec3>, index: u32) -> f64 {
        let mut place = match self.places.get(index as usize) {
            Some(Place::Unbounded) => return self.probability_of_unbounded(),
            Some(&Place::Leaf(leaf)) => leaf,
            _ => return 0.0,
        };
        let mut probability = self.probability_of_tree();
        while let Some(node) = self.nodes.get(place as usize).filter(|_| place > 0) {
            // Pairs begin at odd numbers, behind the root.
            let first = (place - 1) | 1;
            let split = self.probability_of_first(first as usize, point, normal);
            probability *= if place == first { split } else { 1.0 - split };
            place = node.parent;
        }
        probability
    }

    /// How many lights may be chosen.
    pub fn len(&self) -> usize {
        self.unbounded.len() + self.nodes.len().div_ceil(2)
    }

    /// True if no light may be chosen.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Of each of the lights without bounds.
    fn probability_of_unbounded(&self) -> f64 {
        let sharing = self.unbounded.len() + usize::from(!self.nodes.is_empty());
        1.0 / sharing.max(1) as f64
    }

    fn probability_of_tree(&self) -> f64 {
        if self.nodes.is_empty() { 0.0 } else { self.probability_of_unbounded() }
    }

    /// Of the first of two nodes. If neither can light the point it does not matter which one is taken, and either is as
    /// likely: the probabilities of all lights add up to 1.
    fn probability_of_first(&self, first: usize, point: DVec3, normal: Option<DVec3>) -> f64 {
        let importance = |i| self.nodes.get(i).map_or(0.0, |node: &Node| node.bounds.importance(point, normal));
        let (a, b) = (importance(first), importance(first + 1));
        if a + b > 0.0 { a / (a + b) } else { 0.5 }
    }

    /// Builds the nodes, from the root down.
    fn grow(&mut self, lights: &mut [(EmitterBounds, u32)]) {
        let mut waiting = Vec::new();
        if let Some(bounds) = union(lights) {
            self.nodes.push(Node { bounds, parent: 0, content: Content::Halves(0) });
            waiting.push((0u32, 0..lights.len()));
        }
        while let Some((place, range)) = waiting.pop() {
            let node = place as usize;
            if let [(_, light)] = lights[range.clone()] {
                self.nodes[node].content = Content::Light(light);
                self.places[light as usize] = Place::Leaf(place);
                continue;
            }
            let middle = range.start + split(&self.nodes[node].bounds, &mut lights[range.clone()]);
            let first = self.nodes.len() as u32;
            self.nodes[node].content = Content::Halves(first);
            for (place, half) in [(first, range.start..middle), (first + 1, middle..range.end)] {
                let bounds = union(&lights[half.clone()]).unwrap_or(self.nodes[node].bounds);
                self.nodes.push(Node { bounds, parent: node as u32, content: Content::Halves(0) });
                waiting.push((place, half));
            }
        }
    }
}

fn union(lights: &[(EmitterBounds, u32)]) -> Option<EmitterBounds> {
    lights.iter().map(|(bounds, _)| *bounds).reduce(|a, b| a.union(&b))
}

/// Orders at least two lights so that a first half, whose length is returned, is to be kept apart from the rest: where the
/// sum of power · M_A · M_Ω is least (the surface area orientation heuristic, section 4.2 of the paper). Lights whose
/// centres coincide are halved as they come.
fn split(node: &EmitterBounds, lights: &mut [(EmitterBounds, u32)]) -> usize {
    let centres = Aabb::from_points(lights.iter().map(|(bounds, _)| bounds.around.centre()));
    let longest = node.around.extent().max_element();
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if !(centres.extent()[axis] > 0.0) {
            continue;
        }
        let regular = longest / node.around.extent()[axis];
        for (cost, bucket) in costs(&centres, axis, lights) {
            if best.is_none_or(|(least, ..)| regular * cost < least) {
                best = Some((regular * cost, axis, bucket));
            }
        }
    }
    let Some((_, axis, last)) = best else { return lights.len() / 2 };
    let is_first = |light: &(EmitterBounds, u32)| bucket_of(&centres, axis, &light.0) <= last;
    lights.sort_by_key(|light| !is_first(light));
    lights.partition_point(is_first)
}

/// The buckets behind which both sides have lights, and what it costs to split there.
fn costs(centres: &Aabb, axis: usize, lights: &[(EmitterBounds, u32)]) -> Vec<(f64, usize)> {
    let mut buckets = [None::<EmitterBounds>; BUCKETS];
    for (bounds, _) in lights {
        let bucket = &mut buckets[bucket_of(centres, axis, bounds)];
        *bucket = Some(bucket.map_or(*bounds, |sum| sum.union(bounds)));
    }
    let cost = |side: &[Option<EmitterBounds>]| {
        let sum = side.iter().flatten().copied().reduce(|a, b| a.union(&b))?;
        Some(sum.power * sum.directions() * sum.around.surface_area())
    };
    let split = |last: usize| Some((cost(&buckets[..=last])? + cost(&buckets[last + 1..])?, last));
    (0..BUCKETS - 1).filter_map(split).collect()
}

fn bucket_of(centres: &Aabb, axis: usize, bounds: &EmitterBounds) -> usize {
    let along = (bounds.around.centre()[axis] - centres.min[axis]) / centres.extent()[axis];
    ((along * BUCKETS as f64) as usize).min(BUCKETS - 1)
}
