//! Meshes with an alpha test: hits on transparent points are skipped.

use rt_geometry::{Hit, Primitives, TriangleMesh, VertexAttributes};
use rt_math::{Aabb, DVec3, Interval, Ray, random};
use rt_shading::{Alpha, AlphaMode, Material, Texture, TexturePoint};

/// Alpha test of a mesh: rays pass where the material does not cover it.
#[derive(Clone, Debug)]
pub(crate) struct AlphaTest {
    /// Number of the surface: no other mesh of the scene has it, nor this mesh with another material.
    surface: u64,
    alpha: Alpha,
    culls_back_faces: bool,
}

impl AlphaTest {
    /// Alpha test of a mesh with this material; `None` if every hit passes. Back faces of closed meshes need no culling. `ids` are those of
    /// the mesh and of the material.
    pub(crate) fn of(material: &Material, mesh: &TriangleMesh, ids: [u32; 2]) -> Option<Self> {
        let alpha = &material.alpha;
        let culls_back_faces = alpha.culls_back_faces && !mesh.data().is_closed();
        let [mesh, material] = ids.map(u64::from);
        (alpha.mode != AlphaMode::Opaque || culls_back_faces).then(|| Self {
            surface: mesh << 32 | material,
            alpha: alpha.clone(),
            culls_back_faces,
        })
    }
}

/// Triangles of a mesh with an alpha test.
///
/// The random threshold of a blended surface is a hash of ray, surface and triangle. It is the same for all accelerators.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlphaTestedMesh<'w> {
    pub(crate) mesh: &'w TriangleMesh,
    pub(crate) alpha_test: &'w AlphaTest,
    pub(crate) textures: &'w [Texture],
}

impl AlphaTestedMesh<'_> {
    fn passes_test(&self, ray: &Ray, hit: &Hit) -> bool {
        if self.alpha_test.culls_back_faces {
            let Some([a, b, c]) = self.mesh.vertices(hit.primitive) else { return false };
            if (b - a).cross(c - a).dot(ray.direction) > 0.0 {
                return false;
            }
        }
        if self.alpha_test.alpha.mode == AlphaMode::Opaque {
            return true;
        }
        let Some(([uv, second], alpha)) = self.mesh.coverage_at(hit) else { return false };
        let detail = VertexAttributes { second_uv: second.map(|x| x as f32), ..VertexAttributes::default() };
        let threshold = || random::unit(hash(ray, self.alpha_test.surface, hit.primitive));
        self.alpha_test.alpha.hits(self.textures, &TexturePoint { uv, detail }, alpha, threshold)
    }
}

fn hash(ray: &Ray, surface: u64, triangle: u32) -> u64 {
    let bits = |v: DVec3| v.to_array().map(f64::to_bits);
    let ([a, b, c], [d, e, f]) = (bits(ray.origin), bits(ray.direction));
    random::hash(&[a, b, c, d, e, f, ray.time.to_bits(), surface, u64::from(triangle)])
}

impl Primitives for AlphaTestedMesh<'_> {
    fn len(&self) -> usize {
        self.mesh.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        Primitives::bounds(self.mesh, index)
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.mesh.intersect(index, ray, span).filter(|hit| self.passes_test(ray, hit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_geometry::MeshData;
    use rt_math::Vec3;
    use rt_shading::Phong;

    /// Two triangles of the unit square in z = 0, facing +z.
    fn square() -> TriangleMesh {
        let data = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            ..MeshData::default()
        };
        TriangleMesh::build(data).expect("a mesh").0
    }

    fn alpha_test(alpha: Alpha) -> Option<AlphaTest> {
        AlphaTest::of(&Material { alpha, ..Material::new(String::new(), Phong::default()) }, &square(), [0; 2])
    }

    fn hits(alpha_test: &AlphaTest, textures: &[Texture], ray: &Ray) -> usize {
        let (mesh, set) = (square(), |mesh| AlphaTestedMesh { mesh, alpha_test, textures });
        (0..2).filter(|index| set(&mesh).intersect(*index, ray, Interval::FORWARD).is_some()).count()
    }

    #[test]
    fn back_faces_of_open_meshes_are_culled_if_the_material_is_single_sided() {
        let front_only = alpha_test(Alpha { culls_back_faces: true, ..Alpha::OPAQUE }).expect("an open mesh");
        let point = DVec3::new(0.6, 0.3, 1.0);
        assert_eq!(hits(&front_only, &[], &Ray::new(point, DVec3::NEG_Z)), 1);
        assert_eq!(hits(&front_only, &[], &Ray::new(-point + point.with_z(0.0) * 2.0, DVec3::Z)), 0);
        assert!(alpha_test(Alpha::OPAQUE).is_none());
    }
}
