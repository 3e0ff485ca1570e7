//! Threads of a render, and the parallel loop over its work.
//!
//! The threads belong to no pool. A thread of a rayon pool that waits for another pool starts other work of its own pool
//! meanwhile. Many renders of one caller could therefore nest on one stack.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
    mpsc,
};
use std::thread;

/// Outcome of a parallel loop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outcome {
    /// True if the loop was interrupted before all items were done.
    pub(crate) interrupted: bool,
    /// Items in which a thread panicked.
    pub(crate) lost: Vec<usize>,
}

/// Threads to use for a request of `threads`, where 0 means one for each processor.
pub(crate) fn thread_count(threads: usize) -> usize {
    match threads {
        0 => thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    }
}

/// Runs work items on at most `threads` threads. Each thread has its own state and takes the next item until none is left or the
/// loop is interrupted. `work` returns `None` if it abandoned the item after an interrupt. A panic loses the item and replaces the
/// state of its thread. `finished` receives the results in any order, on this thread.
///
/// If the system refuses threads, fewer share the work, or this thread does all of it. This thread also does a single item.
pub(crate) fn parallel_for<W, T: Send>(
    threads: usize,
    items: &[usize],
    interrupt: Option<&AtomicBool>,
    (new_state, work): (impl Fn() -> W + Sync, impl Fn(&mut W, usize) -> Option<T> + Sync),
    mut finished: impl FnMut(usize, T),
) -> Outcome {
    // The channel announces results. One that carried them would be compiled for each type.
    let results = Mutex::new(VecDeque::new());
    let queue = || results.lock().unwrap_or_else(PoisonError::into_inner);
    let (sender, receiver) = mpsc::channel();
    let next = AtomicUsize::new(0);
    let is_interrupted = || interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed));
    let run = |sender: mpsc::Sender<()>| {
        let mut state = new_state();
        while !is_interrupted() {
            let Some(&item) = items.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
            // Unwind safety: the state is replaced after a panic, and work changes nothing else.
            let done = match catch_unwind(AssertUnwindSafe(|| work(&mut state, item))) {
                Ok(None) => break,
                Ok(done) => done,
                Err(_) => {
                    state = new_state();
                    None
                }
            };
            queue().push_back((item, done));
            // Sending cannot fail: the receiver outlives this loop.
            let _ = sender.send(());
        }
    };
    let mut left = items.len();
    let mut lost = Vec::new();
    thread::scope(|scope| {
        let run = &run;
        let start = |sender| thread::Builder::new().spawn_scoped(scope, move || run(sender));
        // Starting a thread takes longer than a pass over a small image.
        let useful = if items.len() > 1 { threads.min(items.len()) } else { 0 };
        let started = vec![sender.clone(); useful].into_iter().map_while(|sender| start(sender).ok());
        if started.count() == 0 {
            run(sender);
        } else {
            drop(sender);
        }
        for () in receiver {
            let result = queue().pop_front();
            left -= usize::from(result.is_some());
            match result {
                Some((item, Some(done))) => finished(item, done),
                Some((item, None)) => lost.push(item),
                None => {}
            }
        }
    });
    Outcome { interrupted: left > 0, lost }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_loses_its_item_and_replaces_the_state() {
        for threads in [1, 3] {
            let items: Vec<_> = (10..90).collect();
            let mut sum = 0;
            // The state is true after a panic: a state that is not replaced fails the first assertion.
            let work = |broken: &mut bool, item: usize| {
                assert!(!core::mem::replace(broken, true), "the state of a panic is still used");
                assert_ne!(item % 20, 7, "a defect");
                *broken = false;
                Some(item)
            };
            let finished = |item, done| {
                assert_eq!(item, done);
                sum += done;
            };
            let mut outcome = parallel_for(threads, &items, None, (|| false, work), finished);
            outcome.lost.sort_unstable();
            assert_eq!(outcome, Outcome { interrupted: false, lost: vec![27, 47, 67, 87] });
            assert_eq!(sum, (10..90).sum::<usize>() - (27 + 47 + 67 + 87));
        }
    }

    #[test]
    fn an_interruption_finishes_started_items() {
        let interrupt = AtomicBool::new(false);
        let (begun, mut finished) = (AtomicUsize::new(0), 0);
        let work = |(): &mut (), item: usize| {
            begun.fetch_add(1, Ordering::Relaxed);
            if item == 5 {
                interrupt.store(true, Ordering::Relaxed);
            }
            Some(())
        };
        let items: Vec<_> = (0..100_000).collect();
        let outcome = parallel_for(3, &items, Some(&interrupt), (|| (), work), |_, ()| finished += 1);
        assert!(outcome.interrupted && outcome.lost.is_empty());
        assert!(finished == begun.load(Ordering::Relaxed) && finished < 100_000, "{finished}");
    }

    #[test]
    fn the_caller_does_a_single_item_and_without_threads_all_of_them() {
        let caller = thread::current().id();
        let work = |(): &mut (), item: usize| Some((item, thread::current().id()));
        let mut results = Vec::new();
        let outcome = parallel_for(0, &[3, 1, 2], None, (|| (), work), |item, done| results.push((item, done)));
        assert_eq!(outcome, Outcome::default());
        assert_eq!(results, [3, 1, 2].map(|item| (item, (item, caller))));
        results.clear();
        let work = |(): &mut (), item: usize| Some((item, thread::current().id()));
        parallel_for(8, &[5], None, (|| (), work), |item, done| results.push((item, done)));
        assert_eq!(results, [(5, (5, caller))]);
    }
}
