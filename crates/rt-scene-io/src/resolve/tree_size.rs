//! Limits on the size of the tree, measured before anyone unfolds it.

use crate::{Content, Group, GroupId, LoadErrorKind, SceneNode, limits};

/// Depth of a tree and number of objects in it, instances unfolded.
#[derive(Clone, Copy, Default)]
struct TreeSize {
    depth: u64,
    objects: u64,
}

/// Checks the limits for a tree and its groups, each after those that it contains.
pub(super) fn check(nodes: &[SceneNode], groups: &[Group]) -> Result<(), LoadErrorKind> {
    let mut sizes = Vec::with_capacity(groups.len());
    for group in groups {
        sizes.push(size(&group.nodes, &sizes));
    }
    let TreeSize { depth, objects } = size(nodes, &sizes);
    LoadErrorKind::check_limit("the depth of the tree, with expanded instances,", depth, limits::NODE_DEPTH)?;
    LoadErrorKind::check_limit("the number of objects, with expanded instances,", objects, limits::OBJECTS)
}

fn size(nodes: &[SceneNode], groups: &[TreeSize]) -> TreeSize {
    let mut total = TreeSize::default();
    let mut open: Vec<(&SceneNode, u64)> = nodes.iter().map(|node| (node, 1)).collect();
    while let Some((node, depth)) = open.pop() {
        let here = match node.content {
            None => TreeSize::default(),
            Some(Content::Shape(_) | Content::Mesh(_)) => TreeSize { depth: 0, objects: 1 },
            Some(Content::Instance(GroupId(id))) => groups.get(id as usize).copied().unwrap_or_default(),
        };
        total.depth = total.depth.max(depth.saturating_add(here.depth));
        total.objects = total.objects.saturating_add(here.objects);
        open.extend(node.children.iter().map(|child| (child, depth + 1)));
    }
    total
}
