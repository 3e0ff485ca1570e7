//! Counts of shading operations.

/// Counts of shading work, for statistics and to prove that omitted work is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShadingCounts {
    /// Shadow rays that were not traced: the light is behind the surface, or the surface reflects none of it.
    pub shadow_rays_skipped: u64,
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
    /// Null interfaces that rays have passed: both sides have the same medium.
    pub passages: u64,
    /// Paths that ended at a specular surface at the maximum depth.
    pub depth_limited: u64,
    /// Surfaces of dielectrics that were ignored, because the list of enclosing dielectrics was full.
    pub interior_overflows: u64,
    /// Contributions of indirect light that a [`Clamp`](crate::Clamp) has reduced.
    pub clamped: u64,
    /// Radiance that clamping has removed, in fractions of the bound; [`Clamp::lost`](crate::Clamp::lost) has it in radiance.
    pub clamped_units: u64,
    /// Lanes of the SIMD vectors in which surfaces were shaded; 0 where each surface is shaded by itself.
    pub lanes: u64,
    /// Those of `lanes` that held a surface; the others were empty, or their surface was shaded by itself after all.
    pub lanes_used: u64,
}

impl ShadingCounts {
    /// The counts without those of lanes, which depend on the instruction sets of the processor and on the size of tiles.
    pub const fn without_lanes(self) -> Self {
        Self { lanes: 0, lanes_used: 0, ..self }
    }

    /// All counts but those of clamping, by the names of their fields.
    pub const fn named(&self) -> [(&'static str, u64); 11] {
        // All fields are listed, so that a new one cannot be forgotten.
        let Self {
            shadow_rays_skipped,
            highlights,
            mirrors,
            refractions,
            fresnel,
            absorption,
            passages,
            depth_limited,
            interior_overflows,
            clamped: _,
            clamped_units: _,
            lanes,
            lanes_used,
        } = *self;
        [
            ("shadow_rays_skipped", shadow_rays_skipped),
            ("highlights", highlights),
            ("mirrors", mirrors),
            ("refractions", refractions),
            ("fresnel", fresnel),
            ("absorption", absorption),
            ("passages", passages),
            ("depth_limited", depth_limited),
            ("interior_overflows", interior_overflows),
            ("lanes", lanes),
            ("lanes_used", lanes_used),
        ]
    }
}

impl core::ops::AddAssign for ShadingCounts {
    fn add_assign(&mut self, o: Self) {
        self.shadow_rays_skipped += o.shadow_rays_skipped;
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
        self.lanes += o.lanes;
        self.lanes_used += o.lanes_used;
    }
}
