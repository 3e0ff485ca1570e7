//! Sides of the surface.

use rt_math::DVec3;

/// Smaller cosines count as 0: their products would underflow.
pub(crate) const HORIZON: f64 = 1e-100;

/// True for a finite direction that is not in the plane of the surface.
#[inline]
pub(super) fn is_valid(w: DVec3) -> bool {
    w.is_finite() && w.z.abs() > HORIZON
}

/// Direction mirrored at the plane of the surface.
#[inline]
pub(super) fn flip(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// Direction of specular reflection of `w`.
#[inline]
pub(super) fn reflect_dir(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}

/// Both directions, seen from the side of `wo`, where its cosine is positive; `None` unless both leave the surface.
#[inline]
pub(super) fn seen_from(wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3)> {
    if !(is_valid(wo) && is_valid(wi)) {
        return None;
    }
    Some(if wo.z > 0.0 { (wo, wi) } else { (flip(wo), flip(wi)) })
}

/// Version of [`seen_from`] that is `None` if the directions are on different sides. Both cosines are positive.
#[inline]
pub(super) fn same_side(wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3)> {
    seen_from(wo, wi).filter(|(_, wi)| wi.z > 0.0)
}

/// Side of `wo`, on which samples are computed.
#[derive(Clone, Copy)]
pub(super) struct Side {
    is_above: bool,
}

impl Side {
    /// `wo` with a positive cosine, and its side. `None` if `wo` is in the plane of the surface, or `u` is not in
    /// \[0, 1\].
    #[inline]
    pub(super) fn of(wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Self)> {
        let is_sound = is_valid(wo) && u.iter().all(|u| (0.0..=1.0).contains(u));
        let is_above = wo.z > 0.0;
        is_sound.then(|| (if is_above { wo } else { flip(wo) }, Self { is_above }))
    }

    /// Direction on the actual side, from one computed with `wo` above the surface.
    #[inline]
    pub(super) fn restore(self, w: DVec3) -> DVec3 {
        if self.is_above { w } else { flip(w) }
    }
}
