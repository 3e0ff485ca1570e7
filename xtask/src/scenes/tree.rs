//! A tree of branches that fork.

use rt_geometry::{CappedQuadric, Shape, Sphere, TransformedShape};
use rt_math::{DMat3, DVec3, Frame, Transform, transcendental::sincos};
use rt_tests::ShapeSet;

use super::{Scene, nearest};
use crate::error::TaskError;

/// Length and thickness of a branch relative to its parent.
const SHRINK: f64 = 0.8;
/// Angle between a branch and its parent, in radians.
const LEAN: f64 = 0.5;
/// Turn of the forks of a branch against its own fork, in radians.
const TURN: f64 = 1.9;

/// A tree after Haines, "A Proposal for Standard Graphics Environments", 1987. Branches are frusta with a sphere at the
/// joint, and fork in two. Primitives are long, thin, oblique, of all sizes, and leave most of space empty.
pub(crate) fn tree(wanted: usize) -> Result<Scene<ShapeSet>, TaskError> {
    let generations = nearest(wanted, 0..24, |generations| 2 * ((1 << (generations + 1)) - 1));
    let trunk = Branch { foot: DVec3::ZERO, frame: Frame::from_z(DVec3::Y), length: 1.0, radius: 0.1 };
    let mut solids = Vec::new();
    let mut growing = vec![trunk];
    for _ in 0..=generations {
        let mut next = Vec::with_capacity(2 * growing.len());
        for branch in growing {
            solids.extend(branch.solids()?);
            next.extend([1.0, -1.0].map(|side| branch.fork(side)));
        }
        growing = next;
    }
    Ok(Scene::whole("tree", ShapeSet::new(solids)))
}

struct Branch {
    foot: DVec3,
    /// Its z axis is the direction of the branch.
    frame: Frame,
    length: f64,
    radius: f64,
}

impl Branch {
    fn tip(&self) -> DVec3 {
        self.foot + self.frame.z * self.length
    }

    fn solids(&self) -> Result<[TransformedShape; 2], TaskError> {
        let frustum =
            CappedQuadric::frustum(self.radius, self.radius * SHRINK, self.length, false).map_err(TaskError::other)?;
        // A frustum stands along y.
        let axes = DMat3::from_cols(self.frame.y, self.frame.z, self.frame.x);
        let stand = Transform::from_linear(axes, self.foot).map_err(TaskError::other)?;
        let joint = Sphere::new(self.tip(), self.radius * SHRINK).map_err(TaskError::other)?;
        let joint = TransformedShape::new(Shape::Sphere(joint), Transform::IDENTITY);
        Ok([TransformedShape::new(Shape::Frustum(frustum), stand), joint])
    }

    fn fork(&self, side: f64) -> Self {
        let (sin_turn, cos_turn) = sincos(TURN);
        let (sin_lean, cos_lean) = sincos(LEAN * side);
        let across = self.frame.x * cos_turn + self.frame.y * sin_turn;
        let z = (self.frame.z * cos_lean + across * sin_lean).normalize();
        let y = z.cross(across).normalize();
        let frame = Frame { x: y.cross(z), y, z };
        Self { foot: self.tip(), frame, length: self.length * SHRINK, radius: self.radius * SHRINK }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_grow_from_the_tip_of_their_parent_at_the_lean() {
        let trunk = Branch { foot: DVec3::ZERO, frame: Frame::from_z(DVec3::Y), length: 1.0, radius: 0.1 };
        for side in [1.0, -1.0] {
            let branch = trunk.fork(side);
            assert_eq!(branch.foot, trunk.tip());
            assert!((branch.frame.z.dot(trunk.frame.z) - rt_math::transcendental::cos(LEAN)).abs() < 1e-14);
            let Frame { x, y, z } = branch.frame;
            assert!((x.cross(y) - z).length() < 1e-14, "right-handed and orthonormal");
        }
    }
}
