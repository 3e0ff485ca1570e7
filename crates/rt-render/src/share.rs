//! Share of the tiles of an image, for rendering on several machines.

use serde::{Deserialize, Serialize};

/// A share of the tiles of an image: one of `count` machines takes each tile whose number is `index` modulo
/// `count`. Neighbouring tiles go to different machines, which balances the load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    index: u32,
    count: u32,
}

impl Share {
    /// Everything.
    pub const ALL: Self = Self { index: 0, count: 1 };

    /// The greatest number of shares.
    pub const MOST: u32 = 1 << 20;

    /// Share number `index`, from 0 on, of `count`; `None` unless `index` is less and `count` at most [`MOST`](Self::MOST).
    pub const fn new(index: u32, count: u32) -> Option<Self> {
        if index < count && count <= Self::MOST { Some(Self { index, count }) } else { None }
    }

    /// Its number, from 0 on.
    pub const fn index(self) -> u32 {
        self.index
    }

    /// Shares in all.
    pub const fn count(self) -> u32 {
        self.count
    }

    /// Number of tiles of the share, of `all` tiles.
    pub(crate) const fn pieces(self, all: usize) -> usize {
        (all + self.count as usize - 1 - self.index as usize) / self.count as usize
    }

    /// True if the tile with this number belongs to the share.
    pub const fn holds(self, piece: usize) -> bool {
        piece % self.count as usize == self.index as usize
    }
}

impl Default for Share {
    fn default() -> Self {
        Self::ALL
    }
}
