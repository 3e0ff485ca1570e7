//! What a surface is to a ray that meets it, with regard to the bodies on both sides.

use crate::{
    Material, Needs, SurfaceHit,
    interior::{Crossing, Interior},
    view::is_inside,
};
use rt_math::{DVec3, Ray};

/// So many surfaces that do nothing to a ray may stand one behind the other in its way; each further one costs a bounce,
/// so that paths end.
pub(crate) const FREE_PASSAGES: u32 = 1024;

/// A ray that has come to a surface.
pub(crate) struct Meeting<'m> {
    pub(crate) material: &'m Material,
    /// Unit direction of the ray.
    pub(crate) direction: DVec3,
    /// World units per unit of the ray's parameter.
    pub(crate) length: f64,
    /// True if the ray comes from behind the surface.
    pub(crate) is_inside: bool,
    behind: Behind,
}

/// What is behind a surface.
#[derive(Clone, Copy, PartialEq)]
enum Behind {
    /// Nothing that light comes to, or nobody asks.
    Opaque,
    /// The same as before it.
    Pane,
    Body,
}

impl<'m> Meeting<'m> {
    /// The meeting of a ray; `None` if the surface has no material.
    #[inline]
    pub(crate) fn new(needs: &Needs, materials: &'m [Material], ray: &Ray, hit: &SurfaceHit) -> Option<Self> {
        let material = materials.get(hit.material as usize)?;
        let length = ray.direction.length();
        let direction = ray.direction / length;
        let is_inside = is_inside(direction, &hit.interaction);
        let behind = if !needs.refraction || material.phong.transmission.is_none() {
            Behind::Opaque
        } else if material.body().is_none() {
            Behind::Pane
        } else {
            Behind::Body
        };
        Some(Self { material, direction, length, is_inside, behind })
    }

    /// The way through the surface for a ray that has come through the interior so far. `None` where light that is scattered
    /// stays on its side, and of a body if the list of bodies is full. To be asked for once: a body that nobody saw being
    /// entered is noted.
    #[inline]
    pub(crate) fn crossing(
        &self,
        interior: &mut Interior,
        materials: &[Material],
        hit: &SurfaceHit,
    ) -> Option<Crossing> {
        match self.behind {
            Behind::Opaque => None,
            Behind::Pane => Some(interior.crossing_of_pane(materials)),
            Behind::Body => interior.crossing(materials, hit, self.is_inside),
        }
    }

    /// False if the surface does nothing to the ray: all there is to do is to note this [`crossing`](Self::crossing).
    #[inline]
    pub(crate) fn is_noticed(&self, crossing: Option<&Crossing>) -> bool {
        let is_clear = |crossing: &Crossing| crossing.is_null() && self.material.phong.is_clear();
        self.behind != Behind::Body || crossing.is_some_and(|crossing| crossing.is_boundary && !is_clear(crossing))
    }
}
