//! Frustum culling for camera rays: a second accelerator without the objects outside the view.

use core::ops::ControlFlow;

use rt_accel::{Accelerator, AnyAccelerator, BuildError, Region, wide::SmallSet};
use rt_camera::ViewVolume;
use rt_geometry::{
    Hit, HitStream, PacketKernel, PrimitiveGeometry, Primitives, Probe, RayStream, SphereKernel, padded_bounds,
};
use rt_math::{Aabb, DVec3, Interval, Ray};

use crate::accel_choice::{self, AccelOptions, MAX_LINEAR_SPHERES, is_small};

/// Primitives of a set in the view volume, with their accelerator.
///
/// Hits of camera rays are bit-identical to those of the whole set. A hit lies in the padded bounds of its primitive, and the
/// view volume excludes bounds only if no camera ray passes them. Other rays use the whole set.
#[derive(Debug)]
pub(crate) struct VisibleSet {
    /// Indices into the whole set, ascending.
    indices: Vec<u32>,
    accelerator: AnyAccelerator,
    /// Number of primitives of the whole set.
    of: usize,
}

impl VisibleSet {
    /// Collects the primitives in a view volume and builds their accelerator. `None` for [small](is_small) sets, and if more
    /// than half of the primitives are in view. The second accelerator has at most half the size of the first.
    pub(crate) fn build<P: Primitives>(
        accel_options: AccelOptions,
        primitives: &P,
        volume: &ViewVolume,
    ) -> Result<Option<Self>, BuildError> {
        let of = primitives.len();
        if is_small(primitives, 0..of as u32) {
            return Ok(None);
        }
        let inside = |index: &u32| padded_bounds(primitives, *index).is_none_or(|bounds| !volume.excludes(&bounds));
        let indices: Vec<u32> = (0..of as u32).filter(inside).collect();
        if indices.len() > of / 2 {
            return Ok(None);
        }
        let accelerator = accel_choice::build(accel_options, &Subset { all: primitives, indices: &indices })?;
        Ok(Some(Self { indices, accelerator, of }))
    }

    const fn subset<'a, P>(&'a self, all: &'a P) -> Subset<'a, P> {
        Subset { all, indices: self.indices.as_slice() }
    }

    pub(crate) const fn accelerator(&self) -> &AnyAccelerator {
        &self.accelerator
    }

    /// Rule by which the accelerator was chosen.
    pub(crate) fn reason<P: Primitives>(&self, accel_options: AccelOptions, all: &P) -> String {
        accel_choice::reason(accel_options, &self.subset(all))
    }

    /// Number of culled primitives.
    pub(crate) const fn left_out(&self) -> usize {
        self.of - self.indices.len()
    }

    /// Number of primitives of the whole set.
    pub(crate) const fn of(&self) -> usize {
        self.of
    }
}

/// Objects that a narrower volume does not exclude; `None` if the set is not [small](is_small). Searches the
/// `wider` set, if there is one, and otherwise the accelerator of all primitives.
pub(crate) fn collect_small<P: Primitives>(
    primitives: &P,
    accelerator: &AnyAccelerator,
    wider: Option<&VisibleSet>,
    volume: &ViewVolume,
) -> Option<SmallSet> {
    let mut indices = [0; MAX_LINEAR_SPHERES];
    let mut len = 0;
    let mut note = |index: u32| match indices.get_mut(len) {
        Some(slot) => {
            *slot = index;
            len += 1;
            ControlFlow::Continue(())
        }
        None => {
            len = MAX_LINEAR_SPHERES + 1;
            ControlFlow::Break(())
        }
    };
    let region = FrustumRegion(volume);
    match wider {
        None => accelerator.visit_overlapping(primitives, &region, note),
        Some(wider) => {
            wider
                .accelerator
                .visit_overlapping(&wider.subset(primitives), &region, |at| note(wider.indices[at as usize]));
        }
    }
    let indices = indices.get(..len)?.iter().copied();
    if is_small(primitives, indices.clone()) { SmallSet::new(indices) } else { None }
}

/// Objects that camera rays are tested against.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PrimaryTarget<'v> {
    /// All objects.
    All(&'v AnyAccelerator),
    /// Objects in view of the image.
    Culled(&'v VisibleSet),
    /// Objects in view of a tile.
    Tile(&'v SmallSet),
}

impl PrimaryTarget<'_> {
    /// True if camera rays can hit nothing.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::All(_) => false,
            Self::Culled(visible) => visible.indices.is_empty(),
            Self::Tile(small) => small.indices().is_empty(),
        }
    }

    /// Closest hit of a camera ray, with the ids of the whole set.
    pub(crate) fn closest<P: Primitives, S: Probe>(
        &self,
        all: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match self {
            Self::All(accelerator) => accelerator.closest(all, ray, span, probe),
            Self::Culled(visible) => visible.accelerator.closest(&visible.subset(all), ray, span, probe),
            Self::Tile(small) => small.closest(all, ray, span, probe),
        }
    }

    /// Version of [`closest`](Self::closest) for a stream.
    pub(crate) fn closest_stream<P: Primitives, S: Probe>(
        &self,
        all: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        match self {
            Self::All(accelerator) => accelerator.closest_stream(all, rays, hits, probe),
            Self::Culled(visible) => visible.accelerator.closest_stream(&visible.subset(all), rays, hits, probe),
            Self::Tile(small) => small.closest_stream(all, rays, hits, probe),
        }
    }
}

/// Region of all boxes whose padded bounds may overlap a view volume.
pub(crate) struct FrustumRegion<'v>(pub(crate) &'v ViewVolume);

impl Region for FrustumRegion<'_> {
    fn bounds(&self) -> Aabb {
        Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY)
    }

    fn overlaps(&self, aabb: &Aabb) -> bool {
        !self.0.excludes(&aabb.padded())
    }
}

/// Subset of primitives. Hits have the ids of the whole set, so that ties in t resolve equally.
struct Subset<'a, P> {
    all: &'a P,
    /// Indices into the whole set, ascending.
    indices: &'a [u32],
}

impl<P: Primitives> Primitives for Subset<'_, P> {
    fn len(&self) -> usize {
        self.indices.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.all.bounds(self.indices[index as usize])
    }

    #[inline(always)]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.all.intersect(self.indices[index as usize], ray, span)
    }

    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.all.occludes(self.indices[index as usize], ray, span)
    }

    #[inline(always)]
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        self.all.intersect_with_stats(self.indices[index as usize], ray, span, probe)
    }

    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        self.all.occludes_with_stats(self.indices[index as usize], ray, span, probe)
    }

    fn packet_kernel(&self, index: u32) -> PacketKernel {
        self.all.packet_kernel(self.indices[index as usize])
    }

    fn hit_ids(&self, index: u32) -> [u32; 2] {
        self.all.hit_ids(self.indices[index as usize])
    }

    fn casts_shadow(&self, index: u32) -> bool {
        self.all.casts_shadow(self.indices[index as usize])
    }

    fn intersect_stream<S: Probe>(&self, index: u32, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        self.all.intersect_stream(self.indices[index as usize], rays, hits, probe);
    }

    fn occludes_stream<S: Probe>(&self, index: u32, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        self.all.occludes_stream(self.indices[index as usize], rays, occluded, probe);
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        match self.all.geometry(self.indices[index as usize]) {
            // An accelerator that intersects its own copies cannot return the ids of the whole set.
            PrimitiveGeometry::ExactTriangle(vertices) => {
                PrimitiveGeometry::Triangle(vertices.map(|vertex| vertex.as_dvec3()))
            }
            PrimitiveGeometry::ExactSphere(SphereKernel { centre, radius }) => {
                PrimitiveGeometry::Sphere(centre, radius)
            }
            layout => layout,
        }
    }
}
