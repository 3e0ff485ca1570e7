//! Room in large pages of memory: a structure that does not fit into the caches is looked for in fewer page tables, and
//! made with fewer calls of the system.

/// Room for so many items, in pages of 2 MiB where the system has them and it is large enough.
pub(super) fn room_for<T>(count: usize) -> Vec<T> {
    #[cfg_attr(
        not(all(target_os = "linux", feature = "large-pages")),
        expect(unused_mut, reason = "advice changes it")
    )]
    let mut room = Vec::with_capacity(count);
    #[cfg(all(target_os = "linux", feature = "large-pages"))]
    advise(room.spare_capacity_mut());
    room
}

/// Asks the system for large pages in memory that has not been touched. If it has none, nothing is lost.
#[cfg(all(target_os = "linux", feature = "large-pages"))]
fn advise<T>(memory: &mut [core::mem::MaybeUninit<T>]) {
    const PAGE: usize = 2 << 20;
    let range = memory.as_mut_ptr_range();
    let offset = range.start.addr().next_multiple_of(PAGE) - range.start.addr();
    // Whole pages alone: what is before and behind them would not be large.
    let length = size_of_val(memory).saturating_sub(offset) / PAGE * PAGE;
    if length > 0 {
        let first = range.start.wrapping_byte_add(offset);
        // SAFETY: these pages lie within the memory, which is borrowed, and the advice changes nothing that is in them.
        let _ = unsafe { rustix::mm::madvise(first.cast(), length, rustix::mm::Advice::LinuxHugepage) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_of_any_size() {
        for count in [0, 1, 1000, 3 << 20] {
            let mut room = room_for::<u64>(count);
            assert!(room.capacity() >= count);
            room.extend(0..count as u64);
            assert!(room.iter().copied().eq(0..count as u64));
        }
    }
}
