//! Bounding volume hierarchy with eight children to a node.

#[allow(dead_code, unreachable_pub, unused_imports, reason = "the structure over the tree is the next step")]
mod build;
