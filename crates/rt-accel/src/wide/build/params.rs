//! Parameters of the builder.

/// Build quality: longer builds give faster traversal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Quality {
    /// Binned splits of the widest axis only, and leaves wherever a set fits: 10 to 20 % less build time than medium.
    /// For scenes that change before many rays are traced.
    Low,
    /// Binned splits of all axes (Wald 2007), then reinsertion of the thousand largest subtrees (Bittner, Hapala and
    /// Havran 2013). Takes 0.2 to 0.3 µs per triangle on one thread.
    #[default]
    Medium,
    /// Medium without merged primitives, with smaller leaves, and with three reinsertion passes over subtrees of all
    /// sizes: 3 to 6 times the build time. Helps if large primitives lie among small ones, where rays visit 12 to 25 %
    /// fewer nodes.
    High,
}

impl Quality {
    /// All qualities, from fast to slow builds.
    pub const ALL: &[Self] = &[Self::Low, Self::Medium, Self::High];

    /// Lower-case name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// Parameters of the builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BuildParams {
    /// Build quality.
    pub quality: Quality,
    /// Maximum primitives per leaf, clamped to 1 to 8.
    pub max_leaf: usize,
}

impl BuildParams {
    /// [`Quality::Low`], leaves of up to 8: for geometry that is rebuilt before many rays are traced.
    pub const FAST: Self = Self { quality: Quality::Low, max_leaf: 8 };

    /// [`Quality::Medium`], leaves of up to 8: the default.
    pub const BALANCED: Self = Self { quality: Quality::Medium, max_leaf: 8 };

    /// [`Quality::High`], leaves of up to 8: for geometry that millions of rays are traced against.
    pub const HIGH: Self = Self { quality: Quality::High, max_leaf: 8 };

    pub(super) fn leaf_limit(&self) -> usize {
        self.max_leaf.clamp(1, 8)
    }
}

impl Default for BuildParams {
    /// Medium quality, and leaves of up to eight primitives.
    fn default() -> Self {
        Self::BALANCED
    }
}
