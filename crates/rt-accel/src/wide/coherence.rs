//! Coherence of rays: directions that are close to each other, or in one octant.

use rt_math::{DVec3, Interval, Ray};

use super::f64x8::PACKET;

/// Maximum spread of coherent directions, on both axes across the largest component of the first, scaled to 1 along it.
const MAX_SPREAD: f64 = 0.125;

/// Maximum shear of a direction along the axis of the first of a coherent packet.
pub(super) const MAX_SHEAR: f64 = 1.0 + MAX_SPREAD;

/// True if the directions of all rays are close to each other. Their signs may differ, as those of rays along an axis do.
/// May be true of others where products overflow; [`RayPacket::new`](super::ray_packet::RayPacket::new) rejects those.
#[inline(always)]
pub(super) fn is_coherent(rays: &[(Ray, Interval); PACKET]) -> bool {
    let size = rays[0].0.direction.abs();
    if size.x > size.y && size.x > size.z {
        is_coherent_along(rays, |d| [d.y, d.z, d.x])
    } else if size.y > size.z {
        is_coherent_along(rays, |d| [d.z, d.x, d.y])
    } else {
        is_coherent_along(rays, |d| [d.x, d.y, d.z])
    }
}

/// Tests coherence along the last axis of `turned`.
#[inline(always)]
fn is_coherent_along(rays: &[(Ray, Interval); PACKET], turned: impl Fn(DVec3) -> [f64; 3]) -> bool {
    let [x, y, z] = turned(rays[0].0.direction);
    rays[1..].iter().all(|(ray, _)| {
        let [other_x, other_y, other_z] = turned(ray.direction);
        // False for NaN.
        let most = MAX_SPREAD * (z * other_z);
        ((other_x * z - x * other_z).abs() <= most) & ((other_y * z - y * other_z).abs() <= most)
    })
}

/// Octant of a direction, by its sign bits.
#[inline(always)]
pub(super) fn signs(d: DVec3) -> u32 {
    ((d.x.to_bits() >> 63) | (d.y.to_bits() >> 63) << 1 | (d.z.to_bits() >> 63) << 2) as u32
}

/// Number of leading rays in the octant of the first.
#[inline(always)]
pub(super) fn same_octant_prefix(rays: &[(Ray, Interval)]) -> usize {
    let Some((first, _)) = rays.first() else { return 0 };
    let signs_of_first = signs(first.direction);
    rays.iter().position(|(ray, _)| signs(ray.direction) != signs_of_first).unwrap_or(rays.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coherence_ignores_signs_and_rejects_spread() {
        let with = |other: DVec3| {
            let mut rays = [(Ray::new(DVec3::ZERO, DVec3::new(0.01, -0.02, -3.0)), Interval::FORWARD); PACKET];
            rays[5].0.direction = other;
            is_coherent(&rays)
        };
        assert!(with(DVec3::new(-0.01, 0.02, -1.0)) && with(DVec3::new(0.1, -0.1, -1.0)));
        assert!(!with(DVec3::new(0.01, -0.02, 3.0)) && !with(DVec3::new(0.2, 0.0, -1.0)));
        assert!(!with(DVec3::new(f64::NAN, 0.0, -1.0)) && !with(DVec3::new(0.0, 0.0, f64::NAN)));
        assert!(!with(DVec3::X) && !with(DVec3::new(0.0, f64::INFINITY, -1.0)));
    }
}
