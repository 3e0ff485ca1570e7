//! Loops whose steps may run on several threads: those of the current rayon pool.
//!
//! Steps are called dynamically, so that rayon's code is compiled once and not for each loop. A step therefore has to be long:
//! some thousand primitives or hundred rays. Without the feature `parallel` all steps run in order on this thread.

use std::sync::Mutex;

/// Calls `step` with each item. Returns after the last call has returned.
pub(crate) fn parallel_for_each<T: Send>(items: Vec<T>, step: impl Fn(T) + Sync) {
    if items.len() < 2 {
        return items.into_iter().for_each(step);
    }
    let items: Vec<_> = items.into_iter().map(|item| Mutex::new(Some(item))).collect();
    parallel_for(0, items.len(), &|i| {
        // Each index comes once, so no lock waits and no item is missing.
        if let Some(item) = items[i].lock().ok().and_then(|mut item| item.take()) {
            step(item);
        }
    });
}

/// Results of `step` for all indices below `count`, in their order.
pub(crate) fn parallel_map<R: Send>(count: usize, step: impl Fn(usize) -> R + Sync) -> Vec<R> {
    if count < 2 {
        return (0..count).map(step).collect();
    }
    let mut results: Vec<Option<R>> = (0..count).map(|_| None).collect();
    parallel_for_each(results.iter_mut().enumerate().collect(), |(i, result)| *result = Some(step(i)));
    results.into_iter().flatten().collect()
}

#[cfg(feature = "parallel")]
fn parallel_for(start: usize, end: usize, step: &(dyn Fn(usize) + Sync)) {
    if end - start < 2 {
        return (start..end).for_each(step);
    }
    let middle = start.midpoint(end);
    rayon::join(|| parallel_for(start, middle, step), || parallel_for(middle, end, step));
}

#[cfg(not(feature = "parallel"))]
fn parallel_for(start: usize, end: usize, step: &(dyn Fn(usize) + Sync)) {
    (start..end).for_each(step);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_item_is_used_once_and_results_are_in_order() {
        for n in [0, 1, 2, 3, 100] {
            let mut seen = vec![0; n];
            parallel_for_each(seen.iter_mut().collect(), |count| *count += 1);
            assert_eq!(seen, vec![1; n]);
            assert_eq!(parallel_map(n, |i| i * i), (0..n).map(|i| i * i).collect::<Vec<_>>());
        }
    }
}
