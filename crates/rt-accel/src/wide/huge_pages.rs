//! Room in large pages of memory: a structure that does not fit into the caches is looked for in fewer page tables, and
//! made with fewer calls of the system.

use core::mem::MaybeUninit;

/// Room for so many items, in pages of 2 MiB where the system has them and it is large enough.
pub(super) fn with_huge_pages<T>(count: usize) -> Vec<T> {
    #[cfg_attr(
        not(all(target_os = "linux", feature = "large-pages")),
        expect(unused_mut, reason = "advice changes it")
    )]
    let mut room = Vec::with_capacity(count);
    #[cfg(all(target_os = "linux", feature = "large-pages"))]
    advise(room.spare_capacity_mut());
    room
}

/// Items part by part, each part filled where it stays and by one of several threads, which touches its memory first.
/// What is not filled is `empty`.
pub(super) fn filled<T, P>(parts: Vec<(usize, P)>, empty: T, fill: impl Fn(P, &mut [T]) + Sync + Send) -> Vec<T>
where
    T: Clone + Send + Sync,
    P: Send,
{
    let count = parts.iter().map(|(count, _)| count).sum();
    let mut all = with_huge_pages(count);
    let mut rest = all.spare_capacity_mut();
    let mut rooms = Vec::with_capacity(parts.len());
    for (count, part) in parts {
        let (room, others) = rest.split_at_mut(count);
        rest = others;
        rooms.push((part, room));
    }
    for_each(rooms, |(part, room)| fill(part, emptied(room, &empty)));
    // SAFETY: the parts are so many items together, or the room would not have sufficed for them, and all have been written.
    unsafe { all.set_len(count) };
    all
}

/// The same room with this item everywhere.
fn emptied<'r, T: Clone>(room: &'r mut [MaybeUninit<T>], empty: &T) -> &'r mut [T] {
    for item in &mut *room {
        item.write(empty.clone());
    }
    // SAFETY: all items have just been written.
    unsafe { core::slice::from_raw_parts_mut(room.as_mut_ptr().cast(), room.len()) }
}

#[cfg(feature = "parallel")]
fn for_each<T: Send>(all: Vec<T>, each: impl Fn(T) + Sync + Send) {
    use rayon::prelude::*;
    all.into_par_iter().for_each(each);
}

#[cfg(not(feature = "parallel"))]
fn for_each<T: Send>(all: Vec<T>, each: impl Fn(T)) {
    all.into_iter().for_each(each);
}

/// Asks the system for large pages in memory that has not been touched. If it has none, nothing is lost.
#[cfg(all(target_os = "linux", feature = "large-pages"))]
fn advise<T>(memory: &mut [MaybeUninit<T>]) {
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
            let mut room = with_huge_pages::<u64>(count);
            assert!(room.capacity() >= count);
            room.extend(0..count as u64);
            assert!(room.iter().copied().eq(0..count as u64));
        }
    }

    #[test]
    fn parts_follow_each_other_and_are_empty_where_they_are_not_filled() {
        let parts = vec![(2, 7), (0, 8), (3, 9)];
        assert_eq!(
            filled(parts, 0, |part, room| room.iter_mut().take(2).for_each(|item| *item = part)),
            [7, 7, 9, 9, 0]
        );
        assert!(filled(Vec::new(), 0, |(), _| ()).is_empty());
    }
}
