//! What a caller may ask of the builder.

/// How much time the builder takes to make rays cheap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Quality {
    /// Binned splits of the widest axis alone, and a leaf of most sets that fit into one: a tenth to a fifth less time than
    /// medium, for scenes that change before many rays have been traced.
    Low,
    /// Binned splits of all axes (Wald 2007), after which the thousand largest subtrees are moved to where they cost least
    /// (Bittner, Hapala and Havran 2013): 0.2 to 0.3 µs per triangle on one thread.
    #[default]
    Medium,
    /// As medium, but no primitives are joined before the tree grows, small sets are cut more readily, and subtrees of all sizes
    /// are moved, three times: three to six times as slow to build. Pays where large primitives lie among small ones: there
    /// rays meet an eighth to a quarter fewer nodes.
    High,
}

impl Quality {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Low, Self::Medium, Self::High];

    /// Its name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// How a wide hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BuildParams {
    /// Time to build against time to trace.
    pub quality: Quality,
    /// Most primitives in a leaf; what is outside 1 to 8 is taken for the nearer of these.
    pub max_leaf: usize,
}

impl BuildParams {
    /// Most primitives in a leaf, in 1 to 8.
    pub(super) fn leaf_limit(&self) -> usize {
        self.max_leaf.clamp(1, 8)
    }
}

impl Default for BuildParams {
    /// Medium quality, leaves of up to eight primitives.
    fn default() -> Self {
        Self { quality: Quality::Medium, max_leaf: 8 }
    }
}
