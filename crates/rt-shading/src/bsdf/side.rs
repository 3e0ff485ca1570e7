//! On which side of the surface directions are.

use rt_math::DVec3;

/// Cosines up to it are taken for 0: their products would leave the range of numbers.
const HORIZON: f64 = 1e-100;

/// True if light may come along `w`: it is finite and not in the plane of the surface.
#[inline]
pub(super) fn is_valid(w: DVec3) -> bool {
    w.is_finite() && w.z.abs() > HORIZON
}

/// The direction seen in the plane of the surface.
#[inline]
pub(super) fn flip(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// The direction to which a mirror in the plane of the surface sends what arrives along `w`.
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

/// As [`seen_from`], and `None` as well if the directions are on different sides: both cosines are positive.
#[inline]
pub(super) fn same_side(wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3)> {
    seen_from(wo, wi).filter(|(_, wi)| wi.z > 0.0)
}

/// The side that samples are taken on.
#[derive(Clone, Copy)]
pub(super) struct Side {
    is_above: bool,
}

impl Side {
    /// `wo` with a positive cosine, and the way back to its side; `None` if there is nothing to sample: it does not leave
    /// the surface, or the numbers `u` are not in \[0, 1\].
    #[inline]
    pub(super) fn of(wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Self)> {
        let is_sound = is_valid(wo) && u.iter().all(|u| (0.0..=1.0).contains(u));
        let is_above = wo.z > 0.0;
        is_sound.then(|| (if is_above { wo } else { flip(wo) }, Self { is_above }))
    }

    /// A direction found where `wo` is above, as it is.
    #[inline]
    pub(super) fn restore(self, w: DVec3) -> DVec3 {
        if self.is_above { w } else { flip(w) }
    }
}
