//! Exact intersection of one primitive with eight rays. Traversals call it for the few primitives that their filters leave open. It is
//! compiled once.

use rt_geometry::PacketKernel;

use super::f64x8::{F64x8, PACKET};
use super::packet_spheres::SpherePacket;
use super::packet_triangles;
use super::ray_soa::PacketHit;
use super::simd::{DetectedSimd, Simd, WithSimd};
use super::stream_rays::PacketRays;

/// Rays of a packet that hit a primitive within their spans.
#[derive(Clone, Copy, Default)]
pub(super) struct ExactPacketHits {
    /// A bit for each ray that hits.
    pub(super) hit: u32,
    /// A bit for each ray that needs the scalar test. All others miss.
    pub(super) uncertain: u32,
    /// Parameters of the hits.
    pub(super) t: [f64; PACKET],
}

impl ExactPacketHits {
    /// Intersects the rays of a mask. Those of other primitives than spheres and triangles are uncertain, and so are all at levels
    /// without packets.
    #[inline(never)]
    pub(super) fn of(level: DetectedSimd, kernel: &PacketKernel, rays: PacketRays<'_>, mask: u32) -> Self {
        let mut hits = Self { uncertain: mask, ..Self::default() };
        let _ = level.dispatch_lists(ExactPacket { kernel, mask }, rays, &mut hits);
        hits
    }
}

struct ExactPacket<'k> {
    kernel: &'k PacketKernel,
    mask: u32,
}

impl WithSimd<PacketRays<'_>, &mut ExactPacketHits> for ExactPacket<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: PacketRays<'_>, hits: &mut ExactPacketHits) {
        let soa = rays.soa(simd);
        let mask = self.mask & soa.in_safe_range(simd);
        let mut add = |rays: u32, found: &PacketHit<S>| {
            hits.hit |= rays & found.hit;
            hits.uncertain &= !rays | found.uncertain;
            for (lane, (to, t)) in hits.t.iter_mut().zip(found.t.to_array(simd)).enumerate() {
                *to = if rays >> lane & 1 != 0 { t } else { *to };
            }
        };
        match self.kernel {
            PacketKernel::Sphere(sphere) => add(mask, &SpherePacket::all(simd, sphere).intersect(simd, &soa)),
            PacketKernel::Triangle(vertices) => {
                for (axis, along) in soa.by_steepest_axis(simd).into_iter().enumerate() {
                    let rays = mask & along;
                    let missed = PacketHit { hit: 0, uncertain: 0, t: soa.min, uv: [F64x8::splat(simd, 0.0); 2] };
                    if rays != 0 {
                        add(rays, &packet_triangles::intersect(simd, vertices, axis, &soa, rays).unwrap_or(missed));
                    }
                }
            }
            PacketKernel::Quadrilateral(..)
            | PacketKernel::Plane(_)
            | PacketKernel::Instance
            | PacketKernel::Single => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use core::cell::OnceCell;

    use rt_geometry::{RayStream, SphereKernel, WatertightRay, intersect_triangle};
    use rt_math::random::{hash, unit};
    use rt_math::{DVec3, Interval, Ray, SlabRay};

    use super::super::simd::SimdLevel;
    use super::super::stream_rays::{N_PACKETS, StreamRays};
    use super::*;

    fn vector(seed: u64, index: u64) -> DVec3 {
        let number = |axis| 2.0 * unit(hash(&[seed, index, axis])) - 1.0;
        DVec3::new(number(0), number(1), number(2))
    }

    /// Hits of a slice.
    fn hits_of(level: DetectedSimd, kernel: &PacketKernel, rays: &[(Ray, Interval)], mask: u32) -> ExactPacketHits {
        let mut stream = RayStream::default();
        rays.iter().for_each(|(ray, span)| stream.push(ray, *span));
        let copies = [const { OnceCell::new() }; N_PACKETS];
        ExactPacketHits::of(level, kernel, StreamRays::new(&stream, &copies).packet(0), mask)
    }

    /// Compares results at all levels. Returns the counts of hits, and of rays that need the scalar test, at levels with packets.
    fn compare(kernel: &PacketKernel, exact: impl Fn(&Ray, Interval) -> Option<f64>) -> [u32; 2] {
        let mut counts = [0; 2];
        for &level in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            for seed in 0..100 {
                let rays: [_; PACKET] = core::array::from_fn(|lane| {
                    let origin = vector(seed, 2 * lane as u64) * 2.0;
                    let target = vector(seed, 2 * lane as u64 + 1);
                    (Ray::new(origin, target - origin), Interval::new(0.0, 0.25 + 0.25 * lane as f64))
                });
                let mask = hash(&[seed]) as u32 & 0xff;
                let hits = hits_of(DetectedSimd::new(level), kernel, &rays, mask);
                assert_eq!((hits.hit | hits.uncertain) & !mask, 0);
                assert_eq!(hits.hit & hits.uncertain, 0);
                for (lane, (ray, span)) in rays.iter().enumerate().filter(|(lane, _)| mask >> lane & 1 != 0) {
                    let hit = (hits.hit >> lane & 1 != 0).then_some(hits.t[lane].to_bits());
                    if hits.uncertain >> lane & 1 == 0 {
                        assert_eq!(
                            hit,
                            exact(ray, *span).map(f64::to_bits),
                            "{level:?}, seed {seed}, {ray:?} {span:?}"
                        );
                    }
                }
                // The portable level may have no packets.
                if level != SimdLevel::Portable {
                    counts[0] += hits.hit.count_ones();
                    counts[1] += hits.uncertain.count_ones();
                }
            }
        }
        counts
    }

    #[test]
    fn certain_results_are_those_of_the_scalar_tests() {
        let sphere = SphereKernel { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.75 };
        let of_sphere = compare(&PacketKernel::Sphere(sphere), |ray, span| sphere.intersect(ray, span));
        let vertices = [DVec3::new(-2.0, 0.1, -1.5), DVec3::new(2.0, -0.1, -1.5), DVec3::new(0.1, 0.2, 2.0)];
        let of_triangle = compare(&PacketKernel::Triangle(vertices), |ray, span| {
            intersect_triangle(vertices, 0, &SlabRay::new(ray), &WatertightRay::new(ray), span).map(|hit| hit.t)
        });
        if SimdLevel::best() != SimdLevel::Portable {
            for [hits, uncertain] in [of_sphere, of_triangle] {
                assert!(hits > 50 && uncertain < 5, "{hits} hits, {uncertain} uncertain");
            }
        }
    }

    #[test]
    fn other_primitives_and_extreme_rays_are_left_to_the_scalar_test() {
        let rays = [(Ray::new(DVec3::ZERO, DVec3::X * 1e-200), Interval::FORWARD); PACKET];
        let sphere = PacketKernel::Sphere(SphereKernel { centre: DVec3::X, radius: 0.5 });
        for kernel in [PacketKernel::Instance, PacketKernel::Single, sphere] {
            let hits = hits_of(DetectedSimd::default(), &kernel, &rays, 0b101);
            assert_eq!((hits.hit, hits.uncertain), (0, 0b101));
        }
    }
}
