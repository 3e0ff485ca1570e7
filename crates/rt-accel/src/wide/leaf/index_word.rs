//! Indices of primitives as they are stored in leaves.

/// The word of an index. Loads beyond a row of numbers read it as `f32`, where a small index would be subnormal. One operation on such a
/// number takes a hundred cycles on Intel processors. Words are normal for all indices below 2³⁰.
#[derive(Clone, Copy)]
pub(super) struct IndexWord(pub(super) u32);

impl IndexWord {
    /// The bits of the number 2.
    const TWO: u32 = 0x4000_0000;

    pub(super) const fn new(index: u32) -> Self {
        Self(index ^ Self::TWO)
    }

    #[inline(always)]
    pub(super) const fn index(self) -> u32 {
        self.0 ^ Self::TWO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_indices_are_no_subnormal_numbers() {
        for index in (0..31).map(|bit| (1u32 << bit) - 1).chain([0, 1, 12_345_678]) {
            let word = IndexWord::new(index);
            assert_eq!(word.index(), index);
            assert!(f32::from_bits(word.0).is_normal() || index > 1_000_000_000, "{index}");
        }
    }
}
