//! Blocks of eight spheres.

/// Spheres to a block.
pub(super) const LANES: usize = 8;

/// Eight spheres relative to the centre of the list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct Block {
    /// By axis.
    pub(super) centres: [[f32; LANES]; 3],
    /// Squared radii, inflated by a safe margin.
    pub(super) inflated_r2: [f32; LANES],
}

impl Block {
    /// Spheres that no ray can hit.
    pub(super) const EMPTY: Self = Self { centres: [[0.0; LANES]; 3], inflated_r2: [f32::MIN; LANES] };

    pub(super) const fn sphere(&self, lane: usize) -> [f32; 4] {
        let [x, y, z] = &self.centres;
        [x[lane], y[lane], z[lane], self.inflated_r2[lane]]
    }

    pub(super) const fn set_sphere(&mut self, lane: usize, [x, y, z, inflated_r2]: [f32; 4]) {
        self.centres[0][lane] = x;
        self.centres[1][lane] = y;
        self.centres[2][lane] = z;
        self.inflated_r2[lane] = inflated_r2;
    }
}

/// Block and lane of a sphere.
pub(super) const fn slot(index: u32) -> (usize, usize) {
    (index as usize / LANES, index as usize % LANES)
}
