//! View frusta.

use glam::DVec3;
use rt_math::{
    Aabb,
    float::{gamma, power_of_two_scale},
};

use crate::Region;

/// Convex region between six planes: the view of a camera, or a rectangle selected in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// `(n, w)`: points with `n · p + w ≥ 0` are inside.
    planes: [(DVec3, f64); 6],
    bounds: Aabb,
}

/// Error of [`Frustum::from_corners`]: corners that do not define a frustum.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrustumError {
    /// A corner is not finite.
    #[error("corner {corner} at {position} is not finite")]
    Corner {
        /// Index of the corner.
        corner: usize,
        /// Position of the corner.
        position: DVec3,
    },
    /// The corners do not enclose a volume: some lie on the wrong side of a face.
    #[error("the corners do not lie on one side of the {} face", FACE_NAMES[*face % 6])]
    NotConvex {
        /// Index of the face, in the order left, right, bottom, top, near, far.
        face: usize,
    },
}

/// Names of the faces.
const FACE_NAMES: [&str; 6] = ["left", "right", "bottom", "top", "near", "far"];

/// Three corners of each face, left, right, bottom, top, near, far, in an order that makes normals point inward.
const FACES: [[usize; 3]; 6] = [[0, 2, 4], [1, 5, 3], [0, 4, 1], [2, 3, 6], [0, 1, 2], [4, 6, 5]];

impl Frustum {
    /// Frustum with eight corners: bit 0 of the index is right, bit 1 top, bit 2 far. Mirrored corners are valid.
    ///
    /// # Errors
    /// If a corner is not finite, or the corners do not enclose a volume.
    pub fn from_corners(corners: [DVec3; 8]) -> Result<Self, FrustumError> {
        if let Some(corner) = corners.iter().position(|corner| !corner.is_finite()) {
            return Err(FrustumError::Corner { corner, position: corners[corner] });
        }
        // Of a size near 1, and near the origin: products neither overflow nor lose digits.
        let differences = corners.map(|corner| corner - corners[0]);
        let size = differences.iter().fold(DVec3::ZERO, |size, difference| size.max(difference.abs()));
        let near = differences.map(|difference| difference * power_of_two_scale(size));
        let mirrored = near[1].cross(near[2]).dot(near[4]) < 0.0;
        let mut planes = [(DVec3::ZERO, 0.0); 6];
        for (face, [a, b, c]) in FACES.into_iter().enumerate() {
            let normal = (near[b] - near[a]).cross(near[c] - near[a]);
            let normal = if mirrored { -normal } else { normal }.normalize_or_zero();
            let depth = near.iter().fold(0.0, |most: f64, corner| most.max(normal.dot(near[a] - *corner)));
            let extent = near.iter().fold(0.0, |most: f64, corner| most.max((*corner - near[a]).length()));
            if !(depth <= extent * 1e-6) || normal == DVec3::ZERO {
                return Err(FrustumError::NotConvex { face });
            }
            // Move the plane outward until all corners are inside, against rounding and slightly bent faces.
            let lowest = corners.iter().fold(f64::INFINITY, |lowest, corner| lowest.min(normal.dot(*corner)));
            planes[face] = (normal, -lowest);
        }
        Ok(Self { planes, bounds: Aabb::from_points(corners) })
    }
}

impl Region for Frustum {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// False only if the box lies outside one of the planes, or outside the bounds of the frustum.
    fn overlaps(&self, aabb: &Aabb) -> bool {
        self.bounds.overlaps(aabb)
            && self.planes.iter().all(|&(normal, offset)| {
                let farthest = DVec3::select(normal.cmpge(DVec3::ZERO), aabb.max, aabb.min);
                let rounding = gamma(4) * (normal.abs().dot(farthest.abs()) + offset.abs());
                normal.dot(farthest) + offset >= -rounding
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    /// View along −z from the origin, 90° wide and high, from 1 to 10.
    fn view(mirror: f64) -> Frustum {
        let corners = core::array::from_fn(|i| {
            let depth = if i & 4 == 0 { 1.0 } else { 10.0 };
            let side = |bit: usize| if i & bit == 0 { -depth } else { depth };
            DVec3::new(mirror * side(1), side(2), -depth)
        });
        Frustum::from_corners(corners).expect("a frustum")
    }

    fn cube(centre: DVec3, half: f64) -> Aabb {
        Aabb::new(centre - half, centre + half)
    }

    #[test]
    fn boxes_inside_across_and_outside() {
        for view in [view(1.0), view(-1.0)] {
            assert!(view.overlaps(&cube(DVec3::new(0.0, 0.0, -5.0), 0.1)));
            assert!(view.overlaps(&cube(DVec3::new(5.0, 0.0, -5.0), 0.1)));
            assert!(!view.overlaps(&cube(DVec3::new(5.3, 0.0, -5.0), 0.1)));
            assert!(!view.overlaps(&cube(DVec3::new(0.0, -5.3, -5.0), 0.1)));
            assert!(!view.overlaps(&cube(DVec3::new(0.0, 0.0, -0.8), 0.1)));
            assert!(!view.overlaps(&cube(DVec3::new(0.0, 0.0, 5.0), 0.1)));
            assert!(view.overlaps(&cube(DVec3::ZERO, 100.0)));
        }
    }

    #[test]
    fn no_box_with_a_point_inside_is_missed() {
        let view = view(1.0);
        for i in 0..100_000u64 {
            let draw = |k| unit(hash(&[i, k]));
            let depth = 1.0 + 9.0 * draw(0);
            let inside = DVec3::new((2.0 * draw(1) - 1.0) * depth, (2.0 * draw(2) - 1.0) * depth, -depth);
            let around = Aabb::new(inside - DVec3::new(draw(3), draw(4), draw(5)), inside + draw(6) * draw(7));
            assert!(view.overlaps(&around), "{inside} {around:?}");
        }
    }

    #[test]
    fn frusta_of_any_size_anywhere_are_accepted() {
        for (size, offset) in [(1e100, 0.0), (1e-100, 0.0), (1e-200, 0.0), (1.0, 1e11), (3.0, -1e13)] {
            let corners: [DVec3; 8] = core::array::from_fn(|i| {
                let depth = if i & 4 == 0 { 1.0 } else { 10.0 };
                let side = |bit: usize| if i & bit == 0 { -depth } else { depth };
                DVec3::new(side(1), side(2), -depth) * size + offset
            });
            let view = Frustum::from_corners(corners).unwrap_or_else(|error| panic!("{size:e} at {offset:e}: {error}"));
            let cube = |centre: DVec3, half: f64| cube(centre * size + offset, half * size);
            assert!(view.overlaps(&cube(DVec3::new(5.0, 0.0, -5.0), 0.1)), "{size:e} at {offset:e}");
            assert!(!view.overlaps(&cube(DVec3::new(7.0, 0.0, -5.0), 0.1)), "{size:e} at {offset:e}");
        }
    }

    #[test]
    fn corners_that_enclose_nothing_are_refused() {
        assert_eq!(Frustum::from_corners([DVec3::ONE; 8]), Err(FrustumError::NotConvex { face: 0 }));
        let mut corners = core::array::from_fn(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64));
        corners[7] = DVec3::splat(f64::NAN);
        assert!(matches!(Frustum::from_corners(corners), Err(FrustumError::Corner { corner: 7, .. })));
        corners[7] = DVec3::new(2.0, 1.0, 1.0);
        assert!(matches!(Frustum::from_corners(corners), Err(FrustumError::NotConvex { .. })));
    }
}
