//! What a surface is to a ray that meets it, with regard to the bodies on both sides.

use crate::{
    Material, Phong, SurfaceHit,
    interior::{Crossing, Interior},
};

/// So many surfaces that do nothing to a ray may stand one behind the other in its way; each further one costs a bounce,
/// so that paths end.
pub(crate) const FREE_PASSAGES: u32 = 1024;

/// What a surface is to a ray that meets it.
pub(crate) enum Meeting {
    Opaque,
    /// There is another medium behind it, or it is visible for another reason.
    Transparent(Crossing),
    /// Nothing, but something to note if there is a crossing; otherwise the list of bodies is full.
    Nothing(Option<Crossing>),
}

impl Meeting {
    /// The meeting with the surface of a transparent body.
    pub(crate) fn with_body(
        interior: &mut Interior,
        materials: &[Material],
        phong: &Phong,
        hit: &SurfaceHit,
        is_inside: bool,
    ) -> Self {
        match interior.crossing(materials, hit, is_inside) {
            None => Self::Nothing(None),
            Some(crossing) if crossing.is_boundary && !(crossing.is_null() && phong.is_clear()) => {
                Self::Transparent(crossing)
            }
            unseen => Self::Nothing(unseen),
        }
    }
}
