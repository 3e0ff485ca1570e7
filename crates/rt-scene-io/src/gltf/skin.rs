//! Meshes that follow bones (glTF 2.0, section 3.7.3).

use gltf::Skin;
use rt_geometry::MeshData;
use rt_math::{Aabb, DMat3, DVec3};

use super::{accessor::read_vectors, buffers::Buffers, node_pose::Affine};
use crate::{LoadError, LoadErrorKind};

/// Weights whose sum is farther than this from 1 cause a warning: four of them rounded to bytes are within it.
const MAX_DEVIATION: f64 = 1.0 / 64.0;

/// A mesh is far from the origin of the world if it is farther than this many times its size.
const FAR: f64 = 1024.0;

/// The maps of the joints, from where the mesh was bound to the world.
pub(super) fn joints(
    skin: &Skin<'_>,
    worlds: &[Option<Affine>],
    buffers: &Buffers<'_>,
) -> Result<Vec<Affine>, LoadError> {
    let fail = |reason: LoadErrorKind| reason.at(buffers.path(), format!("skins[{}]", skin.index()));
    let mut joints = Vec::new();
    for joint in skin.joints() {
        let world = worlds.get(joint.index()).copied().flatten();
        joints
            .push(world.ok_or_else(|| fail(LoadErrorKind::invalid(joint.index(), "is a joint and its own ancestor")))?);
    }
    let Some(accessor) = skin.inverse_bind_matrices() else { return Ok(joints) };
    let inverses = read_vectors::<16>(&accessor, buffers)?;
    if inverses.len() < joints.len() {
        let rule = format!("inverse bind matrices are too few for {} joints", joints.len());
        return Err(fail(LoadErrorKind::invalid(inverses.len(), rule)));
    }
    for (joint, inverse) in joints.iter_mut().zip(&inverses) {
        let columns = std::array::from_fn(|c| std::array::from_fn(|r| inverse[4 * c + r]));
        *joint = joint.compose(&Affine::from_columns(&columns));
    }
    Ok(joints)
}

/// Up to four joints of each vertex, as indices into the skin, and their weights.
pub(super) struct Influences {
    pub(super) joints: Vec<[f32; 4]>,
    pub(super) weights: Vec<[f32; 4]>,
}

/// Result of [`deform`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deformed {
    /// Origin of the mesh in world space: zero, or for a mesh far from the origin of the world a point near the mesh.
    pub(super) origin: DVec3,
    /// Number of vertices where the sum of the weights was not 1.
    pub(super) unnormalised: usize,
}

/// Takes a mesh to the world, less the origin that is returned, by its joints. Weights are made to have the sum 1.
pub(super) fn deform(data: &mut MeshData, sets: &[Influences], joints: &[Affine]) -> Result<Deformed, LoadErrorKind> {
    let mut bounds = Aabb::EMPTY;
    let mut unnormalised = 0;
    for vertex in 0..data.positions.len() {
        let (map, sum) = blend(sets, vertex, joints)?;
        unnormalised += usize::from(!((sum - 1.0).abs() <= MAX_DEVIATION));
        bounds = bounds.include(map.point(data.positions[vertex].as_dvec3()));
    }
    let origin = origin(&bounds);
    for vertex in 0..data.positions.len() {
        let (mut map, _) = blend(sets, vertex, joints)?;
        map.translation -= origin;
        move_vertex(data, vertex, &map);
    }
    Ok(Deformed { origin, unnormalised })
}

/// Centre of a mesh that is small against its distance from the origin of the world: positions in `f32` would be too coarse.
fn origin(bounds: &Aabb) -> DVec3 {
    let (centre, size) = (bounds.centre(), bounds.extent().max_element());
    let distance = centre.abs().max_element();
    // Positions beyond `f32` are left to the checks of meshes.
    let is_far = size > 0.0 && distance > FAR * size && distance <= f64::from(f32::MAX);
    if is_far { centre } else { DVec3::ZERO }
}

/// Mean of the joints of a vertex, and the sum of their weights in the file.
fn blend(sets: &[Influences], vertex: usize, joints: &[Affine]) -> Result<(Affine, f64), LoadErrorKind> {
    let mut sum = 0.0;
    let mut blend = Affine::ZERO;
    for set in sets {
        for (joint, weight) in set.joints[vertex].into_iter().zip(set.weights[vertex].map(f64::from)) {
            if weight > 0.0 {
                let rule = || format!("is not the index of a joint; there are {} (vertex {vertex})", joints.len());
                let map = joints.get(joint as usize).ok_or_else(|| LoadErrorKind::invalid(joint, rule()))?;
                sum += weight;
                blend.linear += map.linear * weight;
                blend.translation += map.translation * weight;
            }
        }
    }
    let map = if sum > 0.0 && sum.is_finite() {
        Affine { linear: blend.linear * (1.0 / sum), translation: blend.translation * (1.0 / sum) }
    } else {
        // A vertex that no joint holds goes with the first of those that it names.
        let first = sets.first().and_then(|set| joints.get(set.joints[vertex][0] as usize));
        *first.unwrap_or(&Affine::IDENTITY)
    };
    Ok((map, sum))
}

fn move_vertex(data: &mut MeshData, vertex: usize, map: &Affine) {
    let position = &mut data.positions[vertex];
    *position = map.point(position.as_dvec3()).as_vec3();
    let mirrors = if map.linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    if let Some(normal) = data.normals.get_mut(vertex) {
        *normal = (cofactors(&map.linear) * normal.as_dvec3() * mirrors).normalize_or_zero().as_vec3();
    }
    if let Some([x, y, z, side]) = data.tangents.get_mut(vertex) {
        let tangent = map.linear * DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
        [*x, *y, *z] = tangent.normalize_or_zero().as_vec3().to_array();
        *side *= mirrors as f32;
    }
}

/// The matrix that takes normals, up to a factor with the sign of the determinant; defined for singular maps, too.
fn cofactors(m: &DMat3) -> DMat3 {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Vec3;

    /// A vertex at (1, 0, 0) with the normal x and the tangent y.
    fn vertex() -> MeshData {
        MeshData {
            positions: vec![Vec3::X],
            normals: vec![Vec3::X],
            tangents: vec![[0.0, 1.0, 0.0, 1.0]],
            ..MeshData::default()
        }
    }

    fn deformed(maps: &[Affine], joints: [f32; 4], weights: [f32; 4]) -> (MeshData, usize) {
        let mut data = vertex();
        let set = Influences { joints: vec![joints], weights: vec![weights] };
        let deformed = deform(&mut data, &[set], maps).expect("joints that are there");
        (data, deformed.unnormalised)
    }

    fn moved(offset: DVec3) -> Affine {
        Affine { translation: offset, ..Affine::IDENTITY }
    }

    #[test]
    fn vertices_go_with_the_mean_of_their_joints() {
        let maps = [moved(DVec3::X * 4.0), moved(DVec3::Y * 8.0)];
        let (data, bad) = deformed(&maps, [0.0, 1.0, 0.0, 0.0], [0.25, 0.75, 0.0, 0.0]);
        assert_eq!((data.positions[0], bad), (Vec3::new(2.0, 6.0, 0.0), 0));
        assert_eq!((data.normals[0], data.tangents[0]), (Vec3::X, [0.0, 1.0, 0.0, 1.0]));
    }

    #[test]
    fn weights_are_made_to_have_the_sum_one() {
        let maps = [moved(DVec3::X * 4.0), moved(DVec3::Y * 8.0)];
        let (data, bad) = deformed(&maps, [0.0, 1.0, 9.0, 0.0], [0.5, 1.5, 0.0, 0.0]);
        assert_eq!((data.positions[0], bad), (Vec3::new(2.0, 6.0, 0.0), 1));
        let (data, bad) = deformed(&maps, [1.0, 0.0, 0.0, 0.0], [0.0; 4]);
        assert_eq!((data.positions[0], bad), (Vec3::new(1.0, 8.0, 0.0), 1));
    }

    #[test]
    fn normals_stay_normal_and_mirrors_turn_the_side() {
        let squeeze = Affine { linear: DMat3::from_diagonal(DVec3::new(-0.5, 2.0, 1.0)), translation: DVec3::ZERO };
        let mut data = vertex();
        data.normals[0] = Vec3::new(1.0, 1.0, 0.0);
        let set = Influences { joints: vec![[0.0; 4]], weights: vec![[1.0, 0.0, 0.0, 0.0]] };
        deform(&mut data, &[set], &[squeeze]).expect("a joint");
        // The inverse transpose is (−2, 1/2, 1).
        let expected = Vec3::new(-2.0, 0.5, 0.0).normalize();
        assert!((data.normals[0] - expected).length() < 1e-6, "{}", data.normals[0]);
        assert_eq!(data.tangents[0], [0.0, 1.0, 0.0, -1.0]);
    }

    #[test]
    fn joints_that_are_not_there_are_refused() {
        let set = Influences { joints: vec![[7.0, 0.0, 0.0, 0.0]], weights: vec![[1.0, 0.0, 0.0, 0.0]] };
        let error = deform(&mut vertex(), &[set], &[Affine::IDENTITY]).expect_err("no joint 7").to_string();
        assert_eq!(error, "7 is not the index of a joint; there are 1 (vertex 0)");
    }
}
