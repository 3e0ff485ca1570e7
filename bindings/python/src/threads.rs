//! Threads of a call: pools of this process, which are kept for the next call.
//!
//! The global pool of rayon is not used. Its threads do not survive a fork, as by `multiprocessing`, and a child process would
//! wait for them for ever.

use std::process;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::value_error;

/// Primitives below which the thread of the caller builds a tree: far below the 4096 from which rt-accel calls rayon.
const MIN_PRIMITIVES_TO_SHARE: usize = 512;

/// Kept pools have at most this number of threads in total, or twice the number of processors if that is more.
const MIN_THREADS_TO_KEEP: usize = 64;

/// Kept pools by the number of threads of a call, the last one to be used at the end, and the process that started them.
struct Pools {
    process: u32,
    pools: Vec<(usize, Arc<ThreadPool>)>,
}

static POOLS: Mutex<Pools> = Mutex::new(Pools { process: 0, pools: Vec::new() });

/// Threads of a call: a pool, or the thread of the caller.
pub(crate) struct Threads(Option<Arc<ThreadPool>>);

impl Threads {
    /// The given number of threads: all processors for 0. A single task runs on the thread of the caller.
    pub(crate) fn new(py: Python<'_>, threads: usize, n_tasks: usize) -> PyResult<Self> {
        if threads == 1 || n_tasks < 2 {
            return Ok(Self(None));
        }
        let pool = pool(py, threads)?;
        Ok(Self((pool.current_num_threads() > 1).then_some(pool)))
    }

    /// All processors, for work that may call rayon by itself: a pool even of one thread.
    pub(crate) fn all(py: Python<'_>) -> PyResult<Self> {
        pool(py, 0).map(|pool| Self(Some(pool)))
    }

    /// Threads to build trees, the largest of which has the given number of primitives.
    pub(crate) fn to_build(py: Python<'_>, largest: usize) -> PyResult<Self> {
        if largest < MIN_PRIMITIVES_TO_SHARE { Ok(Self(None)) } else { Self::all(py) }
    }

    /// Calls `work` on these threads. Its argument is true if there are several.
    pub(crate) fn run<T: Send>(&self, work: impl FnOnce(bool) -> T + Send) -> T {
        match &self.0 {
            Some(pool) => pool.install(|| work(true)),
            None => work(false),
        }
    }
}

/// The pool of a number of threads. Python forks under the lock of the interpreter, as proved by the argument, so that a child never
/// finds the pools locked.
fn pool(_: Python<'_>, threads: usize) -> PyResult<Arc<ThreadPool>> {
    let mut kept = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let Pools { process, pools } = &mut *kept;
    if *process != process::id() {
        // Pools of the parent cannot be dropped: their locks may be held by threads that do not exist here.
        core::mem::forget(core::mem::take(pools));
        *process = process::id();
    }
    let found = pools.iter().position(|(of_call, _)| *of_call == threads);
    let pool = match found.map(|i| pools.remove(i)) {
        Some((_, pool)) => pool,
        None => Arc::new(ThreadPoolBuilder::new().num_threads(threads).build().map_err(value_error)?),
    };
    let limit = threads_to_keep();
    // A pool of more threads ends with its call.
    if pool.current_num_threads() <= limit {
        pools.push((threads, Arc::clone(&pool)));
        drop_oldest(pools, limit);
    }
    Ok(pool)
}

/// Drops the oldest pools, so that the others have at most `limit` threads in total. A pool in use ends with its call.
fn drop_oldest(pools: &mut Vec<(usize, Arc<ThreadPool>)>, limit: usize) {
    let mut kept = 0;
    let is_too_many = |(_, pool): &(usize, Arc<ThreadPool>)| {
        kept += pool.current_num_threads();
        kept > limit
    };
    if let Some(last_dropped) = pools.iter().rposition(is_too_many) {
        pools.drain(..=last_dropped);
    }
}

fn threads_to_keep() -> usize {
    let processors = thread::available_parallelism().map_or(1, usize::from);
    MIN_THREADS_TO_KEEP.max(2 * processors)
}
