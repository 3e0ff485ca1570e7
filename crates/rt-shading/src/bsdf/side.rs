//! On which side of the surface directions are.

use rt_math::DVec3;

/// The direction seen in the plane of the surface.
pub(super) fn across(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// The direction to which a mirror in the plane of the surface sends what arrives along `w`.
pub(super) fn mirrored(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}

/// Both directions, seen from the side of `wo`, where its cosine is positive; `None` if a cosine is 0 or anything is not
/// finite.
pub(super) fn seen_from(wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3)> {
    if !(wo + wi).is_finite() || wo.z == 0.0 || wi.z == 0.0 {
        return None;
    }
    Some(if wo.z > 0.0 { (wo, wi) } else { (across(wo), across(wi)) })
}

/// As [`seen_from`], and `None` as well if the directions are on different sides: both cosines are positive.
pub(super) fn same_side(wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3)> {
    seen_from(wo, wi).filter(|(_, wi)| wi.z > 0.0)
}

/// The side that samples are taken on.
#[derive(Clone, Copy)]
pub(super) struct Side {
    is_above: bool,
}

impl Side {
    /// `wo` with a positive cosine, and the way back to its side; `None` if there is nothing to sample: its cosine is 0, it
    /// is not finite, or the numbers `u` are not in \[0, 1\].
    pub(super) fn of(wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Self)> {
        let is_sound = wo.is_finite() && wo.z != 0.0 && u.iter().all(|u| (0.0..=1.0).contains(u));
        let is_above = wo.z > 0.0;
        is_sound.then(|| (if is_above { wo } else { across(wo) }, Self { is_above }))
    }

    /// A direction found where `wo` is above, as it is.
    pub(super) fn restore(self, w: DVec3) -> DVec3 {
        if self.is_above { w } else { across(w) }
    }
}
