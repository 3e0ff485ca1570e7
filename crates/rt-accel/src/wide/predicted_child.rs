//! Children chosen by a branch.
//!
//! A load of `children[lane]` waits for the test of eight boxes, some 40 cycles, and the next node waits for the load. After
//! a branch on the lane, each target loads a constant one of the children. A processor that predicts the branch thus begins
//! with the next node while the boxes of this one are still being tested. This turns the data dependency between nodes into a
//! control dependency. It pays where neighbouring rays visit the same children; a misprediction costs some 15 cycles.

use super::node::{Child, WideNode};

/// Child of a node in a lane below eight.
#[inline(always)]
pub(super) fn predicted_child(node: &WideNode, lane: usize) -> Child {
    macro_rules! by_branch {
        ($($lane:literal)*) => {
            match lane & 7 {
                $($lane => in_register(node.children[$lane]),)*
                _ => node.children[lane & 7],
            }
        };
    }
    by_branch!(0 1 2 3 4 5 6 7)
}

/// Returns its argument. Compilers do not merge assembly code, and without it they would merge the loads of all branches
/// into `children[lane]`.
#[inline(always)]
fn in_register(child: Child) -> Child {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        let mut bits = child.to_bits();
        // SAFETY: no instruction at all.
        unsafe { core::arch::asm!("/* {0:e} */", inout(reg) bits, options(nomem, nostack, preserves_flags)) };
        Child::from_bits(bits)
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    child
}
