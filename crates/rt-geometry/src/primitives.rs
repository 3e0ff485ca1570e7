//! The contract of anything that rays can be traced against.

use crate::{Hit, Probe, SphereKernel};
use rt_math::{Aabb, Interval, Ray};
use rt_math::{DVec3, Vec3};

/// Plain numbers of a primitive that a wide leaf filter can pack, or nothing.
///
/// Filters rule out what these numbers say is missed, and rely on it that a primitive is hit, and occludes, where they
/// say that it is hit by a wide margin. Primitives that can be hit without casting a shadow are `Opaque`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveGeometry {
    /// Only the primitive itself knows its shape.
    Opaque,
    /// Exactly a triangle: `intersect` is [`WatertightRay::intersect`](crate::WatertightRay::intersect) of these vertices and
    /// names the hit (instance 0, primitive `index`), and `bounds` is the smallest box around them. An accelerator may
    /// keep a copy and decide by it ([`intersect_triangle`](crate::intersect_triangle)); `occludes` agrees with it.
    ExactTriangle([Vec3; 3]),
    /// Three vertices in the order of the primitive.
    Triangle([DVec3; 3]),
    /// Centre and radius.
    Sphere(DVec3, f64),
    /// Exactly a sphere: `intersect` is [`SphereKernel::intersect`](crate::SphereKernel::intersect), and names the hit
    /// (instance 0, primitive `index`, `uv` 0); `occludes` agrees with it; `bounds` contains the box of the centre plus and
    /// minus the radius, as rounded. An accelerator may decide by these numbers.
    ExactSphere(SphereKernel),
    /// An axis-aligned box.
    Box(Aabb),
}

/// What decides about a primitive that is asked for many rays at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BatchKernel {
    /// [`WatertightRay::intersect`](crate::WatertightRay::intersect) of these vertices. The primitive's `bounds` are the smallest box
    /// around them.
    Triangle([Vec3; 3]),
    /// [`SphereKernel::intersect`](crate::SphereKernel::intersect), with `uv` 0. `bounds` contains the box of the centre plus and minus the
    /// radius, as rounded.
    Sphere(SphereKernel),
    /// The primitive is an accelerator, which answers many rays faster together than one by one:
    /// [`Primitives::intersect_batch`]. Each level of wide trees within each other takes some 100 KiB of the stack in batches.
    Instance,
    /// [`Primitives::intersect`] alone, ray by ray.
    Single,
}

/// An indexed set of primitives. Shapes of this project implement it, and so can anyone:
/// [`bounds`](Self::bounds) and [`intersect`](Self::intersect) are all that an accelerator needs.
///
/// # Contract
///
/// * Indices run from 0 to `len() - 1`; all answers are pure functions of their arguments.
/// * `intersect` returns the first hit at or after `span.min`, if it is not after `span.max`: shrinking `span.max`
///   may drop the hit, but never reveals another one ([`Interval::first`] does this for two roots).
/// * `bounds` contains every point that `intersect` can report, up to rounding.
pub trait Primitives: Sync {
    /// Number of primitives.
    fn len(&self) -> usize;

    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Box around primitive `index`, in the space of the set. `None` for an unbounded primitive (accelerators keep
    /// those in a list of their own); a NaN or inverted box is a build error.
    fn bounds(&self, index: u32) -> Option<Aabb>;

    /// The one kernel that decides, in `f64`: the first hit of primitive `index` within the closed `span`, `None` on
    /// a miss. Callers go through [`intersect_primitive`](crate::decide), which adds the padded-bounds rule.
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;

    /// True if primitive `index` blocks the ray anywhere in `span`. Override it where there is a faster answer, or
    /// where something is visible without casting a shadow.
    #[inline(always)]
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.intersect(index, ray, span).is_some()
    }

    /// As [`intersect`](Self::intersect), for primitives that are accelerators themselves and report their inner work.
    #[inline(always)]
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, _probe: &mut S) -> Option<Hit> {
        self.intersect(index, ray, span)
    }

    /// As [`occludes`](Self::occludes), for primitives that are accelerators themselves and report their inner work.
    #[inline(always)]
    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, _probe: &mut S) -> bool {
        self.occludes(index, ray, span)
    }

    /// What decides about primitive `index`, for accelerators that ask it for many rays at a time; by default what
    /// [`geometry`](Self::geometry) promises.
    #[inline]
    fn batch_kernel(&self, index: u32) -> BatchKernel {
        match self.geometry(index) {
            PrimitiveGeometry::ExactTriangle(vertices) => BatchKernel::Triangle(vertices),
            PrimitiveGeometry::ExactSphere(sphere) => BatchKernel::Sphere(sphere),
            _ => BatchKernel::Single,
        }
    }

    /// Instance and primitive of hits on primitive `index`, if its [`batch_kernel`](Self::batch_kernel) is a triangle or a sphere.
    #[inline]
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        [0, index]
    }

    /// False if primitive `index` blocks no ray, whatever it is: [`occludes`](Self::occludes) is never true. Otherwise `occludes`
    /// agrees with the [`batch_kernel`](Self::batch_kernel), if that is a triangle or a sphere.
    #[inline]
    fn blocks(&self, _index: u32) -> bool {
        true
    }

    /// As [`intersect_with_stats`](Self::intersect_with_stats) for many rays, with the same hits: `hits[i]` answers `rays[i]`, whatever it was
    /// before. Rays beyond the shorter slice are left alone. Inner work may be less, and is counted as it is.
    fn intersect_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>], probe: &mut S) {
        for ((ray, span), hit) in rays.iter().zip(hits) {
            *hit = self.intersect_with_stats(index, ray, *span, probe);
        }
    }

    /// As [`occludes_with_stats`](Self::occludes_with_stats) for many rays, with the same results; `blocked[i]` answers `rays[i]`.
    fn occludes_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool], probe: &mut S) {
        for ((ray, span), blocked) in rays.iter().zip(blocked) {
            *blocked = self.occludes_with_stats(index, ray, *span, probe);
        }
    }

    /// The numbers of primitive `index`, if it is of a kind that wide filters know.
    fn geometry(&self, _index: u32) -> PrimitiveGeometry {
        PrimitiveGeometry::Opaque
    }
}
