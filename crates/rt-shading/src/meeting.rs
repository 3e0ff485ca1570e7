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
    pub(crate) met: Met,
}

/// What the surface is to the ray.
pub(crate) enum Met {
    /// Light that is scattered stays on its side.
    Opaque,
    /// There is another medium behind it, or it is visible for another reason.
    Transparent(Crossing),
    /// Nothing, but something to note if there is a crossing; otherwise the list of bodies is full.
    Nothing(Option<Crossing>),
}

impl<'m> Meeting<'m> {
    /// The meeting of a ray that has come through the interior so far; `None` if the surface has no material.
    #[inline]
    pub(crate) fn new(
        interior: &mut Interior,
        needs: &Needs,
        materials: &'m [Material],
        ray: &Ray,
        hit: &SurfaceHit,
    ) -> Option<Self> {
        let material = materials.get(hit.material as usize)?;
        let length = ray.direction.length();
        let direction = ray.direction / length;
        let is_inside = is_inside(direction, &hit.interaction);
        let met = if needs.refraction && material.phong.transmission.is_some() {
            Met::transparent(interior, materials, material, hit, is_inside)
        } else {
            Met::Opaque
        };
        Some(Self { material, direction, length, is_inside, met })
    }
}

impl Met {
    #[inline(always)]
    fn transparent(
        interior: &mut Interior,
        materials: &[Material],
        material: &Material,
        hit: &SurfaceHit,
        is_inside: bool,
    ) -> Self {
        if material.body().is_none() {
            return Self::Transparent(interior.crossing_of_pane(materials));
        }
        match interior.crossing(materials, hit, is_inside) {
            None => Self::Nothing(None),
            Some(crossing) if crossing.is_boundary && !(crossing.is_null() && material.phong.is_clear()) => {
                Self::Transparent(crossing)
            }
            unseen => Self::Nothing(unseen),
        }
    }
}
