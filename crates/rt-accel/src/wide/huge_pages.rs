//! Allocation in huge pages, which saves page-table walks and system calls for trees that exceed the caches.

use core::mem::MaybeUninit;

use crate::parallel_for::parallel_for_each;

/// Allocates capacity in pages of 2 MiB, if the system has them and the capacity is large enough.
pub(super) fn with_huge_pages<T>(count: usize) -> Vec<T> {
    #[cfg_attr(
        not(all(target_os = "linux", feature = "large-pages")),
        expect(unused_mut, reason = "advice changes it")
    )]
    let mut allocation = Vec::with_capacity(count);
    #[cfg(all(target_os = "linux", feature = "large-pages"))]
    advise(allocation.spare_capacity_mut());
    allocation
}

/// Minimum items that are filled on several threads: fewer take less time than another thread takes to begin.
const MIN_SHARED: usize = 4096;

/// Fills a vector part by part in place, on several threads, each of which first touches its part. Unfilled items are
/// `empty`.
pub(super) fn filled<T, P>(parts: Vec<(usize, P)>, empty: T, fill: impl Fn(P, &mut [T]) + Sync + Send) -> Vec<T>
where
    T: Clone + Send + Sync,
    P: Send,
{
    let count = parts.iter().map(|(count, _)| count).sum();
    let mut all = with_huge_pages(count);
    let mut rest = all.spare_capacity_mut();
    let mut slots = Vec::with_capacity(parts.len());
    for (count, part) in parts {
        let (slot, others) = rest.split_at_mut(count);
        rest = others;
        slots.push((part, slot));
    }
    let fill = |(part, slot)| fill(part, emptied(slot, &empty));
    if count < MIN_SHARED {
        slots.into_iter().for_each(fill);
    } else {
        parallel_for_each(slots, fill);
    }
    // SAFETY: the parts cover exactly `count` items, which fit the allocation, and all are written.
    unsafe { all.set_len(count) };
    all
}

/// Writes an item everywhere.
fn emptied<'r, T: Clone>(slot: &'r mut [MaybeUninit<T>], empty: &T) -> &'r mut [T] {
    for item in &mut *slot {
        item.write(empty.clone());
    }
    // SAFETY: all items have just been written.
    unsafe { core::slice::from_raw_parts_mut(slot.as_mut_ptr().cast(), slot.len()) }
}

/// Requests huge pages for untouched memory. A failure is harmless.
#[cfg(all(target_os = "linux", feature = "large-pages"))]
fn advise<T>(memory: &mut [MaybeUninit<T>]) {
    const PAGE: usize = 2 << 20;
    let range = memory.as_mut_ptr_range();
    let offset = range.start.addr().next_multiple_of(PAGE) - range.start.addr();
    // Whole pages only.
    let length = size_of_val(memory).saturating_sub(offset) / PAGE * PAGE;
    if length > 0 {
        let first = range.start.wrapping_byte_add(offset);
        // SAFETY: these pages lie within the borrowed memory, and the advice does not change their content.
        let _ = unsafe { rustix::mm::madvise(first.cast(), length, rustix::mm::Advice::LinuxHugepage) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_any_size_are_allocated() {
        for count in [0, 1, 1000, 3 << 20] {
            let mut vec = with_huge_pages::<u64>(count);
            assert!(vec.capacity() >= count);
            vec.extend(0..count as u64);
            assert!(vec.iter().copied().eq(0..count as u64));
        }
    }

    #[test]
    fn parts_follow_each_other_and_are_empty_where_they_are_not_filled() {
        let parts = vec![(2, 7), (0, 8), (3, 9)];
        assert_eq!(
            filled(parts, 0, |part, slot| slot.iter_mut().take(2).for_each(|item| *item = part)),
            [7, 7, 9, 9, 0]
        );
        assert!(filled(Vec::new(), 0, |(), _| ()).is_empty());
    }
}
