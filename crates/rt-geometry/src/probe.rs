//! Statistics of queries, counted in `u64` against overflow, without cost if unused.

use core::ops::AddAssign;

/// Kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RayKind {
    /// From the camera.
    Primary,
    /// Towards a light.
    Shadow,
    /// Mirrored.
    Reflection,
    /// Refracted.
    Refraction,
    /// Scattered by a rough surface.
    Diffuse,
}

impl RayKind {
    /// All kinds, in the order in which statistics list them.
    pub const ALL: [Self; 5] = [Self::Primary, Self::Shadow, Self::Reflection, Self::Refraction, Self::Diffuse];

    /// Lower-case English name, as used in statistics files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::Diffuse => "diffuse",
        }
    }
}

/// Receiver of statistics. The default methods discard them.
pub trait Probe {
    /// False if counts of nodes, tests and hits are unused; accelerators may then skip counting.
    #[inline]
    fn counts_work(&self) -> bool {
        true
    }

    /// Starts a ray of this kind; the calls that follow belong to it.
    #[inline]
    fn ray(&mut self, _kind: RayKind) {}
    /// A node (or grid cell) of an accelerator is visited.
    #[inline]
    fn node(&mut self) {}
    /// A primitive is tested in a visited leaf.
    #[inline]
    fn test(&mut self) {}
    /// A tested primitive was hit within the span.
    #[inline]
    fn hit(&mut self) {}
    /// Adds numbers of nodes, tests and hits, as repeated calls of the other methods.
    #[inline]
    fn work(&mut self, nodes: u64, tests: u64, hits: u64) {
        (0..nodes).for_each(|_| self.node());
        (0..tests).for_each(|_| self.test());
        (0..hits).for_each(|_| self.hit());
    }
}

/// Discards all statistics, at no cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    #[inline]
    fn counts_work(&self) -> bool {
        false
    }

    #[inline]
    fn work(&mut self, _: u64, _: u64, _: u64) {}
}

/// Counts rays by kind only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays by kind, in the order of [`RayKind::ALL`].
    pub rays: [u64; 5],
}

impl Probe for RayCounts {
    #[inline]
    fn counts_work(&self) -> bool {
        false
    }

    #[inline]
    fn ray(&mut self, kind: RayKind) {
        self.rays[kind as usize] += 1;
    }
}

/// Statistics of the rays of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RayStats {
    /// Rays traced.
    pub rays: u64,
    /// Nodes or cells visited.
    pub nodes: u64,
    /// Primitives tested in visited leaves.
    pub tests: u64,
    /// Tested primitives that were hit.
    pub hits: u64,
}

impl AddAssign for RayStats {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nodes += other.nodes;
        self.tests += other.tests;
        self.hits += other.hits;
    }
}

/// Counts rays, nodes and tests by kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counters {
    by_kind: [RayStats; 5],
    current: RayKind,
}

impl Default for Counters {
    fn default() -> Self {
        Self { by_kind: [RayStats::default(); 5], current: RayKind::Primary }
    }
}

impl Counters {
    /// Statistics of the rays of `kind`.
    pub fn of(&self, kind: RayKind) -> RayStats {
        self.by_kind[kind as usize]
    }

    /// The sum over all kinds.
    pub fn total(&self) -> RayStats {
        let mut total = RayStats::default();
        for tally in self.by_kind {
            total += tally;
        }
        total
    }
}

impl From<RayCounts> for Counters {
    /// Counts of rays; all other counts are zero.
    #[inline]
    fn from(counts: RayCounts) -> Self {
        let mut counters = Self::default();
        for (tally, rays) in counters.by_kind.iter_mut().zip(counts.rays) {
            tally.rays = rays;
        }
        counters
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        for (mine, theirs) in self.by_kind.iter_mut().zip(other.by_kind) {
            *mine += theirs;
        }
    }
}

impl Probe for Counters {
    #[inline]
    fn ray(&mut self, kind: RayKind) {
        self.current = kind;
        self.by_kind[kind as usize].rays += 1;
    }

    #[inline]
    fn node(&mut self) {
        self.by_kind[self.current as usize].nodes += 1;
    }

    #[inline]
    fn test(&mut self) {
        self.by_kind[self.current as usize].tests += 1;
    }

    #[inline]
    fn hit(&mut self) {
        self.by_kind[self.current as usize].hits += 1;
    }

    #[inline]
    fn work(&mut self, nodes: u64, tests: u64, hits: u64) {
        self.by_kind[self.current as usize] += RayStats { rays: 0, nodes, tests, hits };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_booked_to_the_kind_of_the_last_ray() {
        let mut counters = Counters::default();
        counters.ray(RayKind::Primary);
        counters.node();
        counters.test();
        counters.hit();
        counters.ray(RayKind::Shadow);
        counters.test();
        assert_eq!(counters.of(RayKind::Primary), RayStats { rays: 1, nodes: 1, tests: 1, hits: 1 });
        assert_eq!(counters.of(RayKind::Shadow), RayStats { rays: 1, nodes: 0, tests: 1, hits: 0 });
        assert_eq!(counters.total().tests, 2);
    }

    #[test]
    fn no_probe_occupies_no_memory() {
        assert_eq!(size_of::<NoProbe>(), 0);
    }

    #[test]
    fn counters_do_not_wrap_at_32_bits() {
        let mut sum = RayStats { tests: u64::from(u32::MAX), ..RayStats::default() };
        sum += RayStats { tests: 1, ..RayStats::default() };
        assert_eq!(sum.tests, 1 << 32);
    }
}
