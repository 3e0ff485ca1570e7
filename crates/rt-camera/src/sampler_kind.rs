//! Sample patterns in the pixel.

/// A pattern of sample points over the pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// All in the middle of the pixel.
    Centre,
    /// A regular grid.
    Grid,
    /// Independent and uniform.
    Random,
    /// One uniform point in each cell of a grid (Cook 1986).
    Jittered,
    /// One point in the middle quarter of each cell: less noise, but **biased** at every sample count.
    HalfJittered,
    /// Jittered in the cells of a grid and in all rows and columns at once (Chiu, Shirley, Wang 1994).
    MultiJittered,
    /// The Sobol' sequence with Owen scrambling (Burley 2020).
    Sobol,
    /// The Halton sequence with Owen scrambling, for any number of samples (Halton 1960, Owen 1995).
    Halton,
    /// Sobol' points distributed among neighbouring pixels, so that the noise of few samples is fine and even, and less
    /// seen (Ahmed and Wonka 2020).
    BlueNoise,
}

/// Cells along the side of the largest grid; its square is the largest that fits in `u32`.
const MAX_SIDE: u32 = u16::MAX as u32;

impl SamplerKind {
    /// All patterns, from the simplest.
    pub const ALL: [Self; 9] = [
        Self::Centre,
        Self::Grid,
        Self::Random,
        Self::Jittered,
        Self::HalfJittered,
        Self::MultiJittered,
        Self::Sobol,
        Self::Halton,
        Self::BlueNoise,
    ];

    /// The name that users type.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Grid => "grid",
            Self::Random => "random",
            Self::Jittered => "jittered",
            Self::HalfJittered => "half-jittered",
            Self::MultiJittered => "multi-jittered",
            Self::Sobol => "sobol",
            Self::Halton => "halton",
            Self::BlueNoise => "blue-noise",
        }
    }

    /// True if the pixel's expected value differs from its true mean at every finite number of samples. Averages over
    /// seeds then do not converge to the true mean. Centre and grid are fixed quadrature rules. The half-jittered
    /// pattern never samples three quarters of the pixel's area.
    pub const fn is_biased(self) -> bool {
        matches!(self, Self::Centre | Self::Grid | Self::HalfJittered)
    }

    /// The patterns that are not [biased](Self::is_biased), from the simplest: each of their samples is uniform over
    /// the pixel.
    pub fn unbiased() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|pattern| !pattern.is_biased())
    }

    /// Samples per pixel that the pattern takes for a request of `spp`, at least 1. Patterns on a grid take the next
    /// square, Sobol' and blue noise the next power of two. The largest are 65,535² and 2³¹.
    ///
    /// Sobol' points are generated in blocks of 2¹⁶: beyond, independently scrambled blocks follow each other, and
    /// the error falls as that of their mean.
    pub const fn round_up(self, spp: u32) -> u32 {
        let spp = if spp == 0 { 1 } else { spp };
        match self {
            Self::Centre | Self::Random | Self::Halton => spp,
            Self::Grid | Self::Jittered | Self::HalfJittered | Self::MultiJittered => {
                let side = grid_side(spp);
                side * side
            }
            Self::Sobol | Self::BlueNoise => match spp.checked_next_power_of_two() {
                Some(power) => power,
                None => 1 << 31,
            },
        }
    }

    /// Maximum samples per pixel, at most `spp` but at least 1, that [`round_up`](Self::round_up) keeps.
    pub const fn round_down(self, spp: u32) -> u32 {
        let spp = if spp == 0 { 1 } else { spp };
        match self {
            Self::Centre | Self::Random | Self::Halton => spp,
            Self::Grid | Self::Jittered | Self::HalfJittered | Self::MultiJittered => {
                let side = spp.isqrt();
                side * side
            }
            Self::Sobol | Self::BlueNoise => 1 << spp.ilog2(),
        }
    }
}

/// Side of the smallest square grid with at least `cells` cells, at most [`MAX_SIDE`].
pub(crate) const fn grid_side(cells: u32) -> u32 {
    let floor = cells.isqrt();
    let side = if floor * floor == cells { floor } else { floor + 1 };
    if side < MAX_SIDE { side } else { MAX_SIDE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_rounded_up_to_what_the_pattern_needs() {
        for (pattern, expected) in [
            (SamplerKind::Centre, [1, 1, 5, 16, 17, 1000]),
            (SamplerKind::Grid, [1, 1, 9, 16, 25, 1024]),
            (SamplerKind::Random, [1, 1, 5, 16, 17, 1000]),
            (SamplerKind::Jittered, [1, 1, 9, 16, 25, 1024]),
            (SamplerKind::HalfJittered, [1, 1, 9, 16, 25, 1024]),
            (SamplerKind::MultiJittered, [1, 1, 9, 16, 25, 1024]),
            (SamplerKind::Sobol, [1, 1, 8, 16, 32, 1024]),
            (SamplerKind::Halton, [1, 1, 5, 16, 17, 1000]),
            (SamplerKind::BlueNoise, [1, 1, 8, 16, 32, 1024]),
        ] {
            assert_eq!([0, 1, 5, 16, 17, 1000].map(|spp| pattern.round_up(spp)), expected, "{pattern:?}");
        }
    }

    #[test]
    fn huge_counts_are_capped() {
        assert_eq!(SamplerKind::Jittered.round_up(u32::MAX), 65_535 * 65_535);
        assert_eq!(SamplerKind::Sobol.round_up(u32::MAX), 1 << 31);
    }

    #[test]
    fn rounding_is_idempotent() {
        for pattern in SamplerKind::ALL {
            for spp in (0..2000).chain([u32::MAX - 1, u32::MAX]) {
                let rounded = pattern.round_up(spp);
                assert_eq!(pattern.round_up(rounded), rounded, "{pattern:?}, {spp}");
            }
        }
    }

    #[test]
    fn fixed_and_half_jittered_patterns_are_biased_and_no_others() {
        let (biased, unbiased): (Vec<_>, Vec<_>) = SamplerKind::ALL.into_iter().partition(|p| p.is_biased());
        assert_eq!(biased, [SamplerKind::Centre, SamplerKind::Grid, SamplerKind::HalfJittered]);
        assert!(SamplerKind::unbiased().eq(unbiased));
    }

    #[test]
    fn names_are_unique() {
        let names: std::collections::HashSet<_> = SamplerKind::ALL.map(SamplerKind::name).into();
        assert_eq!(names.len(), SamplerKind::ALL.len());
    }
}
