//! Checks that faces with many corners are flat and free of self-intersections.
//!
//! Cutting a face into triangles needs a plane. Bent quadrilaterals are common, and two triangles represent them well. The
//! triangles of a bent or self-intersecting face with more corners are ambiguous.

use rt_math::{DVec3, Frame, Vec3};

use crate::limits;

/// Corners may lie off the plane by this part of the face's diameter: coordinates are written with few digits.
const FLATNESS: f64 = 1e-3;

/// Faces that are shown otherwise than they were meant, counted.
#[derive(Debug, Default)]
pub(super) struct FaceShapes {
    bent: usize,
    /// Maximum distance of a corner from the plane, relative to the diameter of the face.
    max_deviation: f64,
    crossed: usize,
}

impl FaceShapes {
    /// Looks at a face by its corners. Those without area or with corners that are not finite are left to the mesh.
    pub(super) fn check(&mut self, positions: &[Vec3], outline: &[u32]) {
        if outline.len() <= 4 {
            return;
        }
        let corner = |&index: &u32| positions.get(index as usize).map(|position| position.as_dvec3());
        let corners: Option<Vec<DVec3>> = outline.iter().map(corner).collect();
        let Some(corners) = corners.filter(|corners| corners.iter().all(|corner| corner.is_finite())) else { return };
        let Some(frame) = area_vector(&corners).try_normalize().map(Frame::from_z) else { return };
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let local: Vec<DVec3> = corners.iter().map(|corner| frame.to_local(*corner - middle)).collect();
        let [low, high] =
            [DVec3::min, DVec3::max].map(|choose| local.iter().copied().reduce(choose).unwrap_or_default());
        let off = (high.z - low.z) / 2.0 / (high - low).length();
        if off > FLATNESS {
            self.bent += 1;
            self.max_deviation = self.max_deviation.max(off);
        }
        if local.len() <= limits::CROSSING_CORNERS && crosses_itself(&local) {
            self.crossed += 1;
        }
    }

    /// Warnings about the faces.
    pub(super) fn messages(&self) -> impl Iterator<Item = String> {
        let Self { bent, max_deviation, crossed } = *self;
        let of_bent = (bent > 0).then(|| {
            let percent = 100.0 * max_deviation;
            format!(
                "faces with more than four corners are not flat: {bent}; corners lie up to {percent:.2} % of the face's \
                 diameter off its plane; cut the faces into flat parts"
            )
        });
        let of_crossed = (crossed > 0).then(|| {
            format!(
                "faces intersect themselves: {crossed}; they may be filled unexpectedly; split them into simple polygons"
            )
        });
        of_bent.into_iter().chain(of_crossed)
    }
}

/// Newell's normal, with twice the area as its length (Sutherland et al., ACM Computing Surveys 6(1), 1974).
fn area_vector(corners: &[DVec3]) -> DVec3 {
    let from_first = |i: usize| corners[i] - corners[0];
    (1..corners.len() - 1).map(|i| from_first(i).cross(from_first(i + 1))).sum()
}

/// True if two edges that are not neighbours cross; touching does not count.
fn crosses_itself(corners: &[DVec3]) -> bool {
    let n = corners.len();
    let edge = |i: usize| [corners[i], corners[(i + 1) % n]];
    (0..n).any(|i| (i + 2..n).any(|j| (j + 1) % n != i && cross(edge(i), edge(j))))
}

fn cross(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    let side = |[from, to]: [DVec3; 2], point: DVec3| (to - from).truncate().perp_dot((point - from).truncate());
    let apart = |edge: [DVec3; 2], ends: [DVec3; 2]| {
        let [s, t] = ends.map(|end| side(edge, end));
        (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0)
    };
    apart(a, b) && apart(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(corners: &[[f32; 3]]) -> Vec<String> {
        let positions: Vec<Vec3> = corners.iter().copied().map(Vec3::from).collect();
        let outline: Vec<u32> = (0..corners.len() as u32).collect();
        let mut shapes = FaceShapes::default();
        shapes.check(&positions, &outline);
        shapes.messages().collect()
    }

    #[test]
    fn flat_faces_are_fine_concave_or_not() {
        let arrow = [[0., 0., 1.], [4., 0., 1.], [4., 4., 1.], [2., 1., 1.], [0., 4., 1.]];
        assert!(messages(&arrow).is_empty());
        assert!(messages(&arrow.map(|[x, y, z]| [y, z, x + 1e5])).is_empty());
        let bent_quad = [[0., 0., 0.], [1., 0., 1.], [1., 1., 0.], [0., 1., 1.]];
        assert!(messages(&bent_quad).is_empty(), "two triangles show it");
    }

    #[test]
    fn bent_faces_tell_how_far_they_are_off() {
        // The normal is (0, −1, 8)/√65: heights run from −2/√65 to 2/√65, and the box of the face has a diagonal of 2.9.
        let bent = [[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [1., 2., 0.5], [0., 2., 0.]];
        let [message] = &messages(&bent)[..] else { panic!("one message") };
        assert!(message.contains("corners lie up to 8.54 % of"), "{message}");
    }

    #[test]
    fn a_pentagram_crosses_itself() {
        let star = [[0., 3., 0.], [2., -3., 0.], [-3., 1., 0.], [3., 1., 0.], [-2., -3., 0.]];
        assert!(messages(&star)[0].starts_with("faces intersect themselves: 1"));
    }

    #[test]
    fn faces_that_are_no_faces_are_left_to_the_mesh() {
        assert!(messages(&[[0., 0., 0.]; 6]).is_empty());
        assert!(messages(&[[f32::NAN, 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0.5, 0.]]).is_empty());
    }
}
