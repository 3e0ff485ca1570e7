//! What camera rays can meet: a second structure without the objects outside the view.

use core::ops::ControlFlow;

use rt_accel::{Accelerator, AcceleratorQueries as _, AnyAccelerator, BuildError, Region, wide::SmallSet};
use rt_camera::ViewVolume;
use rt_geometry::{BatchKernel, Hit, PrimitiveGeometry, Primitives, Probe, SphereKernel, padded_bounds};
use rt_math::{Aabb, DVec3, Interval, Ray};

use crate::structure::{self, FEW_SPHERES, Wanted, are_few};

/// The primitives of a set that camera rays can meet, and the structure over them.
///
/// A hit counts only if the ray passes the primitive's own box, and the view volume rules a box out only if no camera
/// ray passes it, so that asking these alone gives the same hit to the bit. Mirrors, glass and shadows look everywhere:
/// their rays are asked of the whole set.
#[derive(Debug)]
pub(crate) struct Visible {
    /// Indices in the whole set, rising.
    indices: Vec<u32>,
    structure: AnyAccelerator,
    /// Number of primitives of the whole set.
    of: usize,
}

impl Visible {
    /// Finds what the volume does not exclude. `None` where a second structure does not pay: if fewer than half of the
    /// primitives lie outside, or if there are few anyway. So it is at most half as large as the first.
    pub(crate) fn build<P: Primitives>(
        wanted: Wanted,
        primitives: &P,
        volume: &ViewVolume,
    ) -> Result<Option<Self>, BuildError> {
        let of = primitives.len();
        if are_few(primitives, 0..of as u32) {
            return Ok(None);
        }
        let inside = |index: &u32| padded_bounds(primitives, *index).is_none_or(|own| !volume.excludes(&own));
        let indices: Vec<u32> = (0..of as u32).filter(inside).collect();
        if indices.len() > of / 2 {
            return Ok(None);
        }
        let structure = structure::build(wanted, &Subset { all: primitives, indices: &indices })?;
        Ok(Some(Self { indices, structure, of }))
    }

    fn closest<P: Primitives, S: Probe>(&self, all: &P, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        self.structure.closest(&Subset { all, indices: &self.indices }, ray, span, probe)
    }

    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        all: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        self.structure.closest_batch(&Subset { all, indices: &self.indices }, rays, hits, probe);
    }

    pub(crate) const fn structure(&self) -> &AnyAccelerator {
        &self.structure
    }

    /// The rule by which the structure was chosen.
    pub(crate) fn why<P: Primitives>(&self, wanted: Wanted, all: &P) -> String {
        structure::why(wanted, &Subset { all, indices: &self.indices })
    }

    /// Number of primitives that camera rays are spared.
    pub(crate) const fn left_out(&self) -> usize {
        self.of - self.indices.len()
    }

    /// Number of primitives of the whole set.
    pub(crate) const fn of(&self) -> usize {
        self.of
    }
}

/// What a narrower volume does not exclude, to be asked in turn; `None` if these are not [few](are_few). Looks in the
/// `wider` part, if there is one, and otherwise in the structure over all primitives.
pub(crate) fn few<P: Primitives>(
    primitives: &P,
    structure: &AnyAccelerator,
    wider: Option<&Visible>,
    volume: &ViewVolume,
) -> Option<SmallSet> {
    let mut indices = [0; FEW_SPHERES];
    let mut len = 0;
    let mut note = |index: u32| match indices.get_mut(len) {
        Some(place) => {
            *place = index;
            len += 1;
            ControlFlow::Continue(())
        }
        None => {
            len = FEW_SPHERES + 1;
            ControlFlow::Break(())
        }
    };
    let region = OwnBoxesIn(volume);
    match wider {
        None => structure.visit_overlapping(primitives, &region, note),
        Some(wider) => {
            let subset = Subset { all: primitives, indices: &wider.indices };
            wider.structure.visit_overlapping(&subset, &region, |at| note(wider.indices[at as usize]));
        }
    }
    let indices = indices.get(..len)?.iter().copied();
    if are_few(primitives, indices.clone()) { SmallSet::new(indices) } else { None }
}

/// What camera rays are asked of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InView<'v> {
    /// All there is.
    All(&'v AnyAccelerator),
    /// What the picture shows of it.
    Part(&'v Visible),
    /// What a tile shows of it.
    Few(&'v SmallSet),
}

impl InView<'_> {
    /// True if camera rays can meet nothing.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::All(_) => false,
            Self::Part(visible) => visible.indices.is_empty(),
            Self::Few(few) => few.indices().is_empty(),
        }
    }

    /// The first hit of a camera ray, named as in the whole set.
    pub(crate) fn closest<P: Primitives, S: Probe>(
        &self,
        all: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match self {
            Self::All(structure) => structure.closest(all, ray, span, probe),
            Self::Part(visible) => visible.closest(all, ray, span, probe),
            Self::Few(few) => few.closest(all, ray, span, probe),
        }
    }

    /// As [`closest`](Self::closest), for many camera rays: `hits[i]` answers `rays[i]`. All are `None` beforehand.
    pub(crate) fn closest_batch<P: Primitives, S: Probe>(
        &self,
        all: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        match self {
            Self::All(structure) => structure.closest_batch(all, rays, hits, probe),
            Self::Part(visible) => visible.closest_batch(all, rays, hits, probe),
            Self::Few(few) => few.closest_batch(all, rays, hits, probe),
        }
    }
}

/// All boxes that a view volume may have something in common with, once they are widened to own boxes.
pub(crate) struct OwnBoxesIn<'v>(pub(crate) &'v ViewVolume);

impl Region for OwnBoxesIn<'_> {
    fn bounds(&self) -> Aabb {
        Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY)
    }

    fn overlaps(&self, aabb: &Aabb) -> bool {
        !self.0.excludes(&aabb.padded())
    }
}

/// Some primitives of a set. Hits name them as in the whole set, so that ties go to the same.
struct Subset<'a, P> {
    all: &'a P,
    /// Rising indices in the whole set.
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

    fn batch_kernel(&self, index: u32) -> BatchKernel {
        self.all.batch_kernel(self.indices[index as usize])
    }

    fn hit_ids(&self, index: u32) -> [u32; 2] {
        self.all.hit_ids(self.indices[index as usize])
    }

    fn blocks(&self, index: u32) -> bool {
        self.all.blocks(self.indices[index as usize])
    }

    fn intersect_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>], probe: &mut S) {
        self.all.intersect_batch(self.indices[index as usize], rays, hits, probe);
    }

    fn occludes_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool], probe: &mut S) {
        self.all.occludes_batch(self.indices[index as usize], rays, blocked, probe);
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        match self.all.geometry(self.indices[index as usize]) {
            // Hits are named as the whole set names them, which a structure that decides by itself would not know.
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
