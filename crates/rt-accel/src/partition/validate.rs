//! Checks what the proof of the walks rests on.

use rt_math::{Primitives, own_box};

use super::node::check_order;
use super::{Cut, Node, Partition};
use crate::Violation;
use crate::own_boxes::validate_lists;

impl<C: Cut> Partition<C> {
    pub(crate) fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), Violation> {
        self.check()?;
        validate_lists(primitives, self.primitives, &self.unbounded)?;
        for primitive in 0..self.primitives {
            let Some(own) = own_box(primitives, primitive) else { continue };
            if !self.bounds.encloses(&own) {
                return Err(Violation::Outside { primitive });
            }
            let mut pending = vec![0];
            while let Some(number) = pending.pop() {
                match self.nodes[number as usize] {
                    Node::Split { cut, above } => {
                        let children = [number + 1, above];
                        pending.extend((0..2).filter(|&side| cut.sides(&own)[side]).map(|side| children[side]));
                    }
                    Node::Leaf { first, count } => {
                        if self.leaf(first, count).binary_search(&primitive).is_err() {
                            return Err(Violation::Misplaced { primitive });
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Checks all that can be checked without the primitives: enough for walks to end, and to ask for no primitive
    /// that was not there.
    pub(crate) fn check(&self) -> Result<(), Violation> {
        check_order(&self.nodes, self.indices.len())?;
        for (number, node) in (0..).zip(&self.nodes) {
            if let Node::Split { cut, .. } = node
                && !cut.is_sound()
            {
                return Err(Violation::Node { node: number });
            }
        }
        match self.indices.iter().chain(&self.unbounded).find(|&&index| index >= self.primitives) {
            Some(&primitive) => Err(Violation::Misplaced { primitive }),
            None => Ok(()),
        }
    }
}

#[cfg(feature = "serde")]
mod saved {
    use super::{Cut, Partition};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    impl<C: Cut + Serialize> Serialize for Partition<C> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            Self::serialize(self, serializer)
        }
    }

    impl<'de, C: Cut + Deserialize<'de>> Deserialize<'de> for Partition<C> {
        /// Refuses what could lead a walk astray.
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let partition = Self::deserialize(deserializer)?;
            partition.check().map_err(D::Error::custom)?;
            Ok(partition)
        }
    }
}
