//! Limits on the size of the tree, measured before anyone unfolds it.

use crate::{Content, Group, GroupId, Node, Reason, limits};

/// Depth of a tree and number of objects in it, instances unfolded.
#[derive(Clone, Copy, Default)]
struct Size {
    depth: u64,
    objects: u64,
}

/// Checks the limits for a tree and the groups that it places, each after those that it contains.
pub(super) fn check(nodes: &[Node], groups: &[Group]) -> Result<(), Reason> {
    let mut sizes = Vec::with_capacity(groups.len());
    for group in groups {
        sizes.push(size(&group.nodes, &sizes));
    }
    let Size { depth, objects } = size(nodes, &sizes);
    if depth > limits::NODE_DEPTH {
        Err(Reason::TooLarge {
            what: "the depth of the tree, instances unfolded,",
            value: depth,
            limit: limits::NODE_DEPTH,
        })
    } else if objects > limits::OBJECTS {
        let what = "the number of objects, instances unfolded,";
        Err(Reason::TooLarge { what, value: objects, limit: limits::OBJECTS })
    } else {
        Ok(())
    }
}

fn size(nodes: &[Node], groups: &[Size]) -> Size {
    let mut total = Size::default();
    let mut open: Vec<(&Node, u64)> = nodes.iter().map(|node| (node, 1)).collect();
    while let Some((node, depth)) = open.pop() {
        let here = match node.content {
            None => Size::default(),
            Some(Content::Shape(_) | Content::Mesh(_)) => Size { depth: 0, objects: 1 },
            Some(Content::Instance(GroupId(id))) => groups.get(id as usize).copied().unwrap_or_default(),
        };
        total.depth = total.depth.max(depth.saturating_add(here.depth));
        total.objects = total.objects.saturating_add(here.objects);
        open.extend(node.children.iter().map(|child| (child, depth + 1)));
    }
    total
}
