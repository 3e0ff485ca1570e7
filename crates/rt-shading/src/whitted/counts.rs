//! Counts of shading operations.

/// Work of shading, for statistics and to prove that what is left out is really absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShadingCounts {
    /// Shadow rays that were not traced, because the light could not contribute: it stands behind the surface, or the
    /// surface reflects none of it.
    pub shadow_rays_spared: u64,
    /// Highlights evaluated.
    pub highlights: u64,
    /// Mirror directions considered.
    pub mirrors: u64,
    /// Refractions considered.
    pub refractions: u64,
    /// Evaluations of Fresnel's equations.
    pub fresnel: u64,
    /// Evaluations of Beer's law.
    pub absorption: u64,
    /// Surfaces that did nothing to a ray: the same was on both sides of them.
    pub passages: u64,
    /// Paths that ended at a mirror or at glass because there were as many bounces as allowed.
    pub depth_limited: u64,
    /// Surfaces of transparent bodies that were ignored, because the ray was inside of too many others.
    pub interior_overflows: u64,
    /// Contributions of indirect light that a [`Clamp`](crate::Clamp) has reduced.
    pub clamped: u64,
    /// Light that they have lost, in parts of the bound; [`Clamp::lost`](crate::Clamp::lost) has it in radiance.
    pub clamped_units: u64,
}

impl core::ops::AddAssign for ShadingCounts {
    fn add_assign(&mut self, o: Self) {
        self.shadow_rays_spared += o.shadow_rays_spared;
        self.highlights += o.highlights;
        self.mirrors += o.mirrors;
        self.refractions += o.refractions;
        self.fresnel += o.fresnel;
        self.absorption += o.absorption;
        self.passages += o.passages;
        self.depth_limited += o.depth_limited;
        self.interior_overflows += o.interior_overflows;
        self.clamped += o.clamped;
        self.clamped_units = self.clamped_units.saturating_add(o.clamped_units);
    }
}
