//! Counts of shading operations.

/// Defines [`ShadingCounts`] by its fields. [`ShadingCounts::named`] has those that are marked with true.
macro_rules! shading_counts {
    ($($(#[$doc:meta])* $name:ident: $is_named:literal,)*) => {
        /// Counts of shading work, for statistics and to prove that omitted work is absent.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct ShadingCounts {
            $($(#[$doc])* pub $name: u64,)*
        }

        impl ShadingCounts {
            /// All counts but those of clamping, by the names of their fields.
            pub fn named(&self) -> impl Iterator<Item = (&'static str, u64)> {
                let all = [$((stringify!($name), self.$name, $is_named)),*];
                all.into_iter().filter(|(.., is_named)| *is_named).map(|(name, count, _)| (name, count))
            }
        }

        impl core::ops::AddAssign for ShadingCounts {
            fn add_assign(&mut self, other: Self) {
                $(self.$name = self.$name.saturating_add(other.$name);)*
            }
        }
    };
}

shading_counts! {
    /// Shadow rays that were not traced: the light is behind the surface, or the surface reflects none of it.
    shadow_rays_skipped: true,
    /// Highlights evaluated.
    highlights: true,
    /// Mirror directions considered.
    mirrors: true,
    /// Refractions considered.
    refractions: true,
    /// Evaluations of Fresnel's equations.
    fresnel: true,
    /// Evaluations of Beer's law.
    absorption: true,
    /// Null interfaces that rays have passed: both sides have the same medium.
    null_interfaces: true,
    /// Paths that ended at a specular surface at the maximum depth.
    depth_limited: true,
    /// Surfaces of dielectrics that were ignored, because the list of enclosing dielectrics was full.
    interior_overflows: true,
    /// Contributions of indirect light that a [`Clamp`](crate::Clamp) has reduced.
    clamped: false,
    /// Radiance that clamping has removed, in fractions of the bound; [`Clamp::lost`](crate::Clamp::lost) has it in radiance.
    clamped_units: false,
    /// Lanes of the SIMD vectors in which surfaces were shaded; 0 where each surface is shaded by itself.
    lanes: true,
    /// Those of `lanes` that held a surface; the others were empty, or their surface was shaded by itself after all.
    lanes_used: true,
}

impl ShadingCounts {
    /// The counts without those of lanes, which depend on the instruction sets of the processor and on the size of tiles.
    pub const fn without_lanes(self) -> Self {
        Self { lanes: 0, lanes_used: 0, ..self }
    }
}
