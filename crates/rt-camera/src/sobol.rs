//! Owen-scrambled Sobol' points, four dimensions at a time.

use rt_math::random::mix;

/// Four coordinates of the last set that a sample has used.
///
/// Dimensions beyond the fourth are further sets of the same four dimensions, each with its own scramble and order
/// ("padding", Burley 2020, section 5). They are well distributed within a set, and independent between sets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SobolSet {
    number: u32,
    coordinates: [f32; 4],
}

impl SobolSet {
    /// One scramble yields 2^`INDEX_BITS` points.
    pub(crate) const INDEX_BITS: u32 = 16;
    /// The bits of a sample's index that choose the point of a scramble.
    pub(crate) const INDEX_MASK: u32 = (1 << Self::INDEX_BITS) - 1;
    /// Without drawn coordinates.
    pub(crate) const EMPTY: Self = Self { number: u32::MAX, coordinates: [0.0; 4] };

    /// A coordinate of the point `index`, below 2^`INDEX_BITS`, of the pattern chosen by `key`.
    pub(crate) fn coordinate(&mut self, key: u64, index: u32, dimension: u32) -> f64 {
        let (set, lane) = (dimension / 4, dimension % 4);
        if set != self.number {
            let seed = (mix(key ^ u64::from(set)) >> 32) as u32;
            *self = Self { number: set, coordinates: sobol_burley::sample_4d(index, 0, seed) };
        }
        f64::from(self.coordinates[lane as usize])
    }
}
