//! Results of queries.

use rt_geometry::{Hit, HitStream, RayStream, StreamBuffers};

/// Result of a query for one ray.
pub(crate) trait Output: Copy + Default {
    /// True if any hit ends the query; false to find the closest.
    const ANY_HIT: bool;

    /// Output of an any-hit query that ends with a hit.
    const HIT: Self;

    /// Outputs of the rays of a stream.
    type OfStream: ?Sized;

    /// Writes the output of a ray of a stream. Nothing happens if there is no space for it.
    fn write(self, outputs: &mut Self::OfStream, at: usize);

    /// The output of a ray of a stream, as it was written.
    fn read(outputs: &Self::OfStream, at: usize) -> Self;

    /// Rays and outputs of buffers.
    fn of_buffers(buffers: &mut StreamBuffers) -> (&mut RayStream, &mut Self::OfStream);

    fn from_hit(hit: Option<Hit>) -> Self;

    /// The hit; a placeholder for an any-hit query.
    fn to_hit(self) -> Option<Hit>;

    /// True if no other primitive can change the result.
    #[inline(always)]
    fn is_final(self) -> bool {
        Self::ANY_HIT && self.to_hit().is_some()
    }

    /// End of the interval in which further hits matter.
    #[inline(always)]
    fn t_max(self, max: f64) -> f64 {
        match self.to_hit() {
            Some(hit) if !Self::ANY_HIT => hit.t,
            _ => max,
        }
    }

    /// Merges the result for another primitive.
    #[inline(always)]
    fn merge(&mut self, other: Self) {
        if let Some(hit) = other.to_hit()
            && (Self::ANY_HIT || self.to_hit().is_none_or(|closest| hit.precedes(&closest)))
        {
            *self = other;
        }
    }
}

impl Output for Option<Hit> {
    const ANY_HIT: bool = false;
    const HIT: Self = Some(NO_HIT);

    type OfStream = HitStream;

    #[inline(always)]
    fn write(self, hits: &mut HitStream, at: usize) {
        hits.set(at, self.as_ref());
    }

    #[inline(always)]
    fn read(hits: &HitStream, at: usize) -> Self {
        hits.get(at)
    }

    fn of_buffers(buffers: &mut StreamBuffers) -> (&mut RayStream, &mut HitStream) {
        (&mut buffers.rays, &mut buffers.hits)
    }

    #[inline(always)]
    fn from_hit(hit: Option<Hit>) -> Self {
        hit
    }

    #[inline(always)]
    fn to_hit(self) -> Option<Hit> {
        self
    }
}

impl Output for bool {
    const ANY_HIT: bool = true;
    const HIT: Self = true;

    type OfStream = [bool];

    #[inline(always)]
    fn write(self, occluded: &mut [bool], at: usize) {
        if let Some(occluded) = occluded.get_mut(at) {
            *occluded = self;
        }
    }

    #[inline(always)]
    fn read(occluded: &[bool], at: usize) -> Self {
        occluded.get(at).is_some_and(|occluded| *occluded)
    }

    fn of_buffers(buffers: &mut StreamBuffers) -> (&mut RayStream, &mut [bool]) {
        (&mut buffers.rays, buffers.occluded.as_mut_slice())
    }

    #[inline(always)]
    fn from_hit(hit: Option<Hit>) -> Self {
        hit.is_some()
    }

    #[inline(always)]
    fn to_hit(self) -> Option<Hit> {
        self.then_some(NO_HIT)
    }
}

/// Placeholder for a hit that is unknown or does not matter.
pub(in crate::wide) const NO_HIT: Hit = Hit { t: f64::INFINITY, instance: 0, primitive: 0, uv: [0.0; 2] };
