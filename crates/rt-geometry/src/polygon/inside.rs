//! Point-in-polygon rules.

use crate::WatertightRay;
use rt_math::DVec3;

/// Definition of the inside of a polygon.
///
/// A polygon that does not cross itself has the same inside under all three, but for its edge:
///
/// | on the edge | |
/// |---|---|
/// | `Convex` | belongs to the polygon, as for triangles: where two meet, both are hit, at the same place |
/// | `Winding`, `EvenOdd` | belongs to one of two polygons that share it in a plane, never to both or neither |
///
/// The second is the half-open rule. It decides as if the ray were moved off the edge by less than any number, to the
/// same side for all polygons. So it leaves no gap between polygons in different planes either.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InsideRule {
    /// For convex polygons: the intersection of the half-planes of the edges.
    ///
    /// Rounding may dent the image of a convex polygon by the width of a rounding error, most easily at corners on a
    /// straight edge. Where the half-planes disagree, the winding number decides.
    Convex,
    /// The outline winds around the point a number of times other than zero (Sunday, "Inclusion of a Point in a
    /// Polygon", 2001). All of a pentagram is inside.
    Winding,
    /// A line from the point to infinity crosses the outline an odd number of times (Shimrat, "Position of Point
    /// Relative to Polygon", CACM 5(8), 1962). The middle of a pentagram is outside.
    EvenOdd,
}

impl InsideRule {
    /// True if the ray passes inside the rings.
    pub(super) fn is_inside<'r>(self, rings: impl Iterator<Item = &'r [DVec3]>, ray: &WatertightRay) -> bool {
        let mut sides = Sides::default();
        match self {
            Self::Convex => rings.for_each(|ring| sides.add_ring::<true>(ring, ray)),
            Self::Winding | Self::EvenOdd => rings.for_each(|ring| sides.add_ring::<false>(ring, ray)),
        }
        let Sides { winding, left, right } = sides;
        match self {
            Self::Convex => left != right || winding != 0,
            Self::Winding => winding != 0,
            // Each crossing counts as +1 or −1, so their number is odd when this sum is.
            Self::EvenOdd => winding % 2 != 0,
        }
    }
}

/// Position of the image's origin relative to the edges.
#[derive(Default)]
struct Sides {
    /// Edges that cross the positive x axis upwards, less those that cross it downwards.
    winding: i64,
    /// True if the origin is strictly to the left of any edge.
    left: bool,
    /// True if the origin is strictly to the right of any edge.
    right: bool,
}

impl Sides {
    /// Adds all edges of a ring; sets `left` and `right` for `ALL` only.
    fn add_ring<const ALL: bool>(&mut self, ring: &[DVec3], ray: &WatertightRay) {
        let Some(last) = ring.last() else { return };
        let at = |vertex: DVec3| {
            let sheared = ray.shear_point(vertex);
            (vertex, sheared, ray.is_above(vertex, sheared))
        };
        let mut a = at(*last);
        for vertex in ring {
            let b = at(*vertex);
            // Corners on the axis count as below it: one crossing, not two, where the ring goes on upwards.
            let (from, to) = (a.2, b.2);
            if ALL || from != to {
                // Positive with the ray to the left.
                let side = ray.side_of_edge([a.0, b.0], [a.1, b.1]);
                self.left |= side > 0.0;
                self.right |= side < 0.0;
                self.winding += i64::from(!from & to & (side > 0.0)) - i64::from(from & !to & (side < 0.0));
            }
            a = b;
        }
    }
}
