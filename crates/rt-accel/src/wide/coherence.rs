//! Coherence of rays: directions that are close to each other, or in one octant.

use rt_math::DVec3;

use super::f64x8::F64x8;
use super::simd::Simd;

/// Maximum spread of coherent directions, on both axes across the largest component of the first, scaled to 1 along it.
const MAX_SPREAD: f64 = 0.125;

/// Maximum shear of a direction along the axis of the first of a coherent packet.
pub(super) const MAX_SHEAR: f64 = 1.0 + MAX_SPREAD;

/// True if the directions of the first `n` of eight rays are close to each other. Their signs may differ, as those of rays along an axis
/// do. May be true of others where products overflow; [`RayPacket::new`](super::ray_packet::RayPacket::new) rejects those.
#[inline(always)]
pub(super) fn are_coherent<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3], n: usize) -> bool {
    let (u, v, w) = (x.first(simd), y.first(simd), z.first(simd));
    let size = DVec3::new(u, v, w).abs();
    let coherent = if size.x > size.y && size.x > size.z {
        coherent_along(simd, [y, z, x], [v, w, u])
    } else if size.y > size.z {
        coherent_along(simd, [z, x, y], [w, u, v])
    } else {
        coherent_along(simd, [x, y, z], [u, v, w])
    };
    // The first is not compared with itself.
    let others = (1 << n) - 2;
    coherent & others == others
}

/// A bit for each direction that is coherent with the first one, along the last axis.
#[inline(always)]
fn coherent_along<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3], [u, v, w]: [f64; 3]) -> u32 {
    let (u, v, w) = (F64x8::splat(simd, u), F64x8::splat(simd, v), F64x8::splat(simd, w));
    // No bit for NaN.
    let most = F64x8::splat(simd, MAX_SPREAD).mul(simd, w.mul(simd, z));
    let (spread_x, spread_y) = (x.mul(simd, w).sub(simd, u.mul(simd, z)), y.mul(simd, w).sub(simd, v.mul(simd, z)));
    spread_x.abs(simd).le(simd, most) & spread_y.abs(simd).le(simd, most)
}

/// Sign bits of the first direction.
#[inline(always)]
pub(super) fn first_octant<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3]) -> [bool; 3] {
    [x.signs(simd) & 1 != 0, y.signs(simd) & 1 != 0, z.signs(simd) & 1 != 0]
}

/// True if all directions have these sign bits.
#[inline(always)]
pub(super) fn are_in_octant<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3], [u, v, w]: [bool; 3]) -> bool {
    let all = |is_negative: bool| if is_negative { 0xff } else { 0 };
    (x.signs(simd) ^ all(u)) | (y.signs(simd) ^ all(v)) | (z.signs(simd) ^ all(w)) == 0
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit};
    use rt_math::{Interval, Ray};

    use super::super::f64x8::PACKET;
    use super::super::ray_soa::directions;
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;

    type Packet = [(Ray, Interval); PACKET];

    struct Tested<'a>(usize, &'a mut bool);

    impl WithSimd<&Packet, ()> for Tested<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, rays: &Packet, (): ()) {
            let Self(n, result) = self;
            *result = are_coherent(simd, directions(simd, rays), n);
        }
    }

    /// Tests the first `n` rays, with the same result at all levels.
    fn is_coherent(rays: &Packet, n: usize) -> bool {
        let mut results = SimdLevel::ALL.iter().filter(|level| level.is_available()).map(|&level| {
            let mut result = false;
            DetectedSimd::new(level).dispatch(Tested(n, &mut result), rays, ());
            result
        });
        let first = results.next().expect("a level");
        assert!(results.all(|result| result == first), "{rays:?}");
        first
    }

    #[test]
    fn coherence_ignores_signs_and_rejects_spread() {
        let with = |other: DVec3| {
            let mut rays = [(Ray::new(DVec3::ZERO, DVec3::new(0.01, -0.02, -3.0)), Interval::FORWARD); PACKET];
            rays[5].0.direction = other;
            assert!(is_coherent(&rays, 5), "others do not matter");
            is_coherent(&rays, PACKET)
        };
        assert!(with(DVec3::new(-0.01, 0.02, -1.0)) && with(DVec3::new(0.1, -0.1, -1.0)));
        assert!(!with(DVec3::new(0.01, -0.02, 3.0)) && !with(DVec3::new(0.2, 0.0, -1.0)));
        assert!(!with(DVec3::new(f64::NAN, 0.0, -1.0)) && !with(DVec3::new(0.0, 0.0, f64::NAN)));
        assert!(!with(DVec3::X) && !with(DVec3::new(0.0, f64::INFINITY, -1.0)));
    }

    /// Coherence by the formula, for one ray after the other.
    #[test]
    fn coherence_is_that_of_each_ray_with_the_first() {
        let special = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-300, 1.0];
        let mut n_coherent = 0;
        for seed in 0..4000 {
            let number = |k: u64| 2.0 * unit(hash(&[seed, k])) - 1.0;
            let vector = |k: u64| DVec3::new(number(k), number(k + 1), number(k + 2));
            let spread = [0.0, 0.02, 0.06, 0.2][seed as usize % 4];
            let mut rays: Packet = core::array::from_fn(|lane| {
                (Ray::new(DVec3::ZERO, vector(0) + vector(3 + 3 * lane as u64) * spread), Interval::FORWARD)
            });
            if seed % 3 == 0 {
                let bits = hash(&[seed]) as usize;
                rays[bits % PACKET].0.direction[bits / 8 % 3] = special[bits / 32 % special.len()];
            }
            let size = rays[0].0.direction.abs();
            let along = if size.x > size.y && size.x > size.z { 0 } else { 1 + usize::from(size.y <= size.z) };
            let turned = |lane: usize| {
                let d: DVec3 = rays[lane].0.direction;
                [d[(along + 1) % 3], d[(along + 2) % 3], d[along]]
            };
            let [x, y, z] = turned(0);
            let expected = (1..PACKET).all(|lane| {
                let [u, v, w] = turned(lane);
                let most = MAX_SPREAD * (z * w);
                (u * z - x * w).abs() <= most && (v * z - y * w).abs() <= most
            });
            assert_eq!(is_coherent(&rays, PACKET), expected, "{rays:?}");
            n_coherent += u32::from(expected);
        }
        assert!((500..3500).contains(&n_coherent), "{n_coherent}");
    }
}
