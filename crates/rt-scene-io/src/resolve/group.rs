//! The order of groups, in which each comes after those that it contains.

use indexmap::IndexMap;

use crate::LoadErrorKind;
use crate::format::Node;

/// Indices of the groups in an order in which instances only refer backwards. Unknown names are left to be reported
/// where they stand.
///
/// # Errors
/// If groups contain each other.
pub(super) fn order(groups: &IndexMap<String, Vec<Node>>) -> Result<Vec<usize>, LoadErrorKind> {
    let contained: Vec<Vec<usize>> = groups.values().map(|nodes| instances(nodes, groups)).collect();
    let mut order = Vec::with_capacity(groups.len());
    let mut state = vec![Visit::New; groups.len()];
    for root in 0..groups.len() {
        // Depth-first search with its own stack: chains of groups may be long. Each entry counts the contained
        // groups that were looked at.
        let mut path = vec![(root, 0)];
        while let Some((group, looked_at)) = path.last_mut() {
            let group = *group;
            if state[group] == Visit::Done {
                path.pop();
                continue;
            }
            state[group] = Visit::Open;
            match contained[group].get(*looked_at) {
                None => {
                    state[group] = Visit::Done;
                    order.push(group);
                }
                Some(&next) => {
                    *looked_at += 1;
                    if state[next] == Visit::Open {
                        let names = path.iter().map(|&(group, _)| group).chain([next]);
                        let around = names.skip_while(|&group| group != next);
                        return Err(LoadErrorKind::Cycle(around.map(|group| name(groups, group)).collect()));
                    }
                    path.push((next, 0));
                }
            }
        }
    }
    Ok(order)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    New,
    Open,
    Done,
}

fn name(groups: &IndexMap<String, Vec<Node>>, group: usize) -> String {
    groups.get_index(group).map(|(name, _)| name.clone()).unwrap_or_default()
}

/// The groups that are placed somewhere in a tree.
fn instances(nodes: &[Node], groups: &IndexMap<String, Vec<Node>>) -> Vec<usize> {
    let mut found = Vec::new();
    let mut open: Vec<&Node> = nodes.iter().collect();
    while let Some(node) = open.pop() {
        found.extend(node.instance.as_ref().and_then(|name| groups.get_index_of(name)));
        open.extend(&node.children);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups(contained: &[(&str, &[&str])]) -> IndexMap<String, Vec<Node>> {
        let instance = |name: &&str| Node { instance: Some((*name).to_owned()), ..Node::default() };
        let parent = |names: &[&str]| Node { children: names.iter().map(instance).collect(), ..Node::default() };
        contained.iter().map(|(name, names)| ((*name).to_owned(), vec![parent(names)])).collect()
    }

    #[test]
    fn contained_groups_come_first() {
        let groups = groups(&[("a", &["b", "c"]), ("b", &["c", "missing"]), ("c", &[])]);
        assert_eq!(order(&groups).unwrap(), [2, 1, 0]);
    }

    #[test]
    fn cycles_are_named_without_what_leads_to_them() {
        let cycle = |groups| order(&groups).unwrap_err().to_string();
        assert_eq!(
            cycle(groups(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"])])),
            "groups contain each other: b -> c -> b; remove one of the instances"
        );
        assert!(cycle(groups(&[("a", &["a"])])).contains("a -> a"));
    }

    #[test]
    fn a_long_cycle_is_named_in_short() {
        let names: Vec<String> = (0..100_000).map(|i| format!("g{i}")).collect();
        let contained: Vec<[&str; 1]> =
            names.iter().cycle().skip(1).take(100_000).map(|name| [name.as_str()]).collect();
        let cycle: Vec<(&str, &[&str])> =
            names.iter().map(String::as_str).zip(contained.iter().map(|c| c.as_slice())).collect();
        let said = order(&groups(&cycle)).unwrap_err().to_string();
        assert!(said.contains(" more) -> ") && said.len() < 200, "{said}");
        let chain = |count: usize| LoadErrorKind::Cycle(names[..count].to_vec()).to_string();
        assert!(chain(9).contains("g0 -> g1 -> g2 -> g3 -> g4 -> g5 -> g6 -> g7 -> g8;"), "{}", chain(9));
        assert!(chain(10).contains("g0 -> g1 -> g2 -> g3 -> (2 more) -> g6 -> g7 -> g8 -> g9;"), "{}", chain(10));
    }

    #[test]
    fn a_long_chain_does_not_overflow_the_stack() {
        let names: Vec<String> = (0..100_000).map(|i| format!("g{i}")).collect();
        let contained: Vec<[&str; 1]> = names.iter().skip(1).map(|name| [name.as_str()]).collect();
        let chain: Vec<(&str, &[&str])> =
            names.iter().map(String::as_str).zip(contained.iter().map(|c| c.as_slice())).collect();
        assert_eq!(order(&groups(&chain)).unwrap().len(), 99_999);
    }
}
