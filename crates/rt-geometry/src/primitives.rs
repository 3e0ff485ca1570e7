//! Interface of primitives, against which rays are traced.

use crate::{Hit, HitStream, Plane, Probe, RayStream, SphereKernel};
use rt_math::{Aabb, Interval, Ray};
use rt_math::{DVec3, Vec3};

/// Geometry of a primitive for SIMD tests in leaves.
///
/// SIMD tests cull primitives by these numbers, and rely on a hit and on occlusion where these numbers imply a hit by a
/// wide margin. Primitives that can be hit without casting a shadow are `Opaque`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveGeometry {
    /// Unknown geometry: only the primitive's own test applies.
    Opaque,
    /// Exactly a triangle: `intersect` is [`WatertightRay::intersect`](crate::WatertightRay::intersect) of these
    /// vertices, with instance 0 and primitive `index`, and `bounds` is the smallest box around them. An accelerator
    /// may test a copy instead ([`intersect_triangle`](crate::intersect_triangle)); `occludes` agrees with it.
    ExactTriangle([Vec3; 3]),
    /// Three vertices in the order of the primitive.
    Triangle([DVec3; 3]),
    /// Centre and radius.
    Sphere(DVec3, f64),
    /// Exactly a sphere: `intersect` is [`SphereKernel::intersect`](crate::SphereKernel::intersect), with instance 0,
    /// primitive `index` and `uv` 0. `occludes` agrees with it; `bounds` contains the box of the centre plus and minus
    /// the radius, as rounded. An accelerator may test these numbers instead.
    ExactSphere(SphereKernel),
    /// An axis-aligned box.
    Box(Aabb),
}

/// Exact test of a primitive for many rays at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PacketKernel {
    /// [`WatertightRay::intersect`](crate::WatertightRay::intersect) of these vertices. The primitive's `bounds` are the smallest box
    /// around them.
    Triangle([DVec3; 3]),
    /// [`SphereKernel::intersect`](crate::SphereKernel::intersect), with `uv` 0. `bounds` contains the box of the centre plus and minus the
    /// radius, as rounded.
    Sphere(SphereKernel),
    /// [`Polygon::intersect`](crate::Polygon::intersect) of a polygon on this plane with these corners, one after the other around it
    /// ([`convex_quadrilateral`](crate::Polygon::convex_quadrilateral)), with `uv` 0. `bounds` is the smallest box around the corners.
    Quadrilateral(Plane, [DVec3; 4]),
    /// [`Plane::intersect`], unbounded.
    Plane(Plane),
    /// The primitive is an accelerator, which traces many rays faster together: [`Primitives::intersect_stream`]. Each
    /// level of nested wide trees takes some 125 KiB of the stack in streams.
    Instance,
    /// [`Primitives::intersect`] alone, ray by ray.
    Single,
}

/// Indexed set of primitives. Accelerators require [`len`](Self::len), [`bounds`](Self::bounds) and
/// [`intersect`](Self::intersect) only.
///
/// # Contract
///
/// * Indices are 0 to `len() - 1`; all results are pure functions of the arguments.
/// * `intersect` returns the first hit at or after `span.min`, if it is not after `span.max`. Shrinking `span.max` may
///   drop the hit, but never reveals another one ([`Interval::first`] does this for two roots).
/// * `bounds` contains every point that `intersect` can report, up to rounding.
pub trait Primitives: Sync {
    /// Number of primitives.
    fn len(&self) -> usize;

    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bounds of primitive `index`, in the space of the set. `None` for an unbounded primitive, which accelerators list
    /// separately; a NaN or inverted box is a build error.
    fn bounds(&self, index: u32) -> Option<Aabb>;

    /// Exact kernel in `f64`: the first hit of primitive `index` within the closed `span`, `None` on a miss. Callers
    /// use [`intersect_primitive`](crate::intersect_primitive), which adds the padded-bounds rule. A hit whose `t` is NaN counts as
    /// a miss.
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;

    /// True if primitive `index` occludes the ray within `span`. Override it if there is a faster test, or for
    /// primitives that are visible without casting shadows.
    #[inline(always)]
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.intersect(index, ray, span).is_some_and(|hit| !hit.t.is_nan())
    }

    /// [`intersect`](Self::intersect) with statistics, for primitives that are accelerators.
    #[inline(always)]
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, _probe: &mut S) -> Option<Hit> {
        self.intersect(index, ray, span)
    }

    /// [`occludes`](Self::occludes) with statistics, for primitives that are accelerators.
    #[inline(always)]
    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, _probe: &mut S) -> bool {
        self.occludes(index, ray, span)
    }

    /// Exact test of primitive `index` for many rays at a time; the default follows from [`geometry`](Self::geometry).
    #[inline]
    fn packet_kernel(&self, index: u32) -> PacketKernel {
        match self.geometry(index) {
            PrimitiveGeometry::ExactTriangle(vertices) => {
                PacketKernel::Triangle(vertices.map(|vertex| vertex.as_dvec3()))
            }
            PrimitiveGeometry::ExactSphere(sphere) => PacketKernel::Sphere(sphere),
            _ => PacketKernel::Single,
        }
    }

    /// Instance and primitive of hits on primitive `index`, if its [`packet_kernel`](Self::packet_kernel) is a shape.
    #[inline]
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        [0, index]
    }

    /// False if primitive `index` occludes no ray: [`occludes`](Self::occludes) is never true. Otherwise `occludes`
    /// agrees with the [`packet_kernel`](Self::packet_kernel), if that is a shape.
    #[inline]
    fn casts_shadow(&self, _index: u32) -> bool {
        true
    }

    /// [`intersect_with_stats`](Self::intersect_with_stats) for the rays of a stream, with identical hits, which are
    /// overwritten. Statistics may be lower, and are those of the work done.
    fn intersect_stream<S: Probe>(&self, index: u32, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        for at in 0..rays.len() {
            let (ray, span) = rays.get(at);
            hits.set(at, self.intersect_with_stats(index, &ray, span, probe).as_ref());
        }
    }

    /// [`occludes_with_stats`](Self::occludes_with_stats) for the rays of a stream, with identical results. Drops results
    /// beyond the slice, and leaves entries beyond the stream as they are.
    fn occludes_stream<S: Probe>(&self, index: u32, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        for (at, occluded) in occluded.iter_mut().enumerate().take(rays.len()) {
            let (ray, span) = rays.get(at);
            *occluded = self.occludes_with_stats(index, &ray, span, probe);
        }
    }

    /// Geometry of primitive `index`, for SIMD tests.
    fn geometry(&self, _index: u32) -> PrimitiveGeometry {
        PrimitiveGeometry::Opaque
    }
}
