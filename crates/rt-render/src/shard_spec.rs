//! Choice of the tiles of a shard, for rendering on several machines.

use serde::{Deserialize, Serialize};

/// A shard of an image: one of `count` machines takes each tile whose number is `index` modulo
/// `count`. Neighbouring tiles go to different machines, which balances the load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardSpec {
    index: u32,
    count: u32,
}

impl ShardSpec {
    /// All tiles.
    pub const ALL: Self = Self { index: 0, count: 1 };

    /// Maximum number of shards.
    pub const MAX_COUNT: u32 = 1 << 20;

    /// Shard `index` of `count`, from 0 on. `None` unless `index` < `count` ≤ [`MAX_COUNT`](Self::MAX_COUNT).
    pub const fn new(index: u32, count: u32) -> Option<Self> {
        if index < count && count <= Self::MAX_COUNT { Some(Self { index, count }) } else { None }
    }

    /// Index, from 0 on.
    pub const fn index(self) -> u32 {
        self.index
    }

    /// Total number of shards.
    pub const fn count(self) -> u32 {
        self.count
    }

    /// Number of tiles of the shard, of `all` tiles.
    pub(crate) const fn tile_count(self, all: usize) -> usize {
        (all + self.count as usize - 1 - self.index as usize) / self.count as usize
    }

    /// True if the tile with this number belongs to the shard.
    pub const fn holds(self, tile: usize) -> bool {
        tile % self.count as usize == self.index as usize
    }
}

impl Default for ShardSpec {
    fn default() -> Self {
        Self::ALL
    }
}
