//! Results of independent tasks, in order.

/// Computes `count` results on several threads, in order. A single one stays on this thread: small trees are built in less
/// time than another thread takes to begin.
#[cfg(feature = "parallel")]
pub(super) fn in_order<T: Send>(count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    use rayon::prelude::*;
    if count < 2 {
        return (0..count).map(each).collect();
    }
    (0..count).into_par_iter().map(each).collect()
}

/// Computes `count` results in order.
#[cfg(not(feature = "parallel"))]
pub(super) fn in_order<T: Send>(count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).map(each).collect()
}
