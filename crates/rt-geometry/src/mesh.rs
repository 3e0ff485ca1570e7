//! Triangle meshes.

use crate::triangle::{point_at, weights};
use crate::{
    Hit, InteractionFlags, MeshData, MeshError, MeshRepairs, PrimitiveGeometry, Primitives, SmoothPoint,
    SurfaceInteraction, VertexAttributes, WatertightRay, area::unit_normal, mesh_repair::repair, smooth_point,
};
use rt_math::{Aabb, DVec3, Interval, Ray, Vec3, Vector3};

/// Validated triangle mesh: a set of [`Primitives`], one for each triangle.
///
/// Its normals have unit length, and all of its triangles have an area.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    data: MeshData,
    bounds: Aabb,
}

impl TriangleMesh {
    /// Validates the arrays and repairs them where possible. Triangles keep their order; primitive indices count the
    /// remaining triangles.
    ///
    /// # Errors
    /// If an index or the length of an array is wrong, or there are too many.
    pub fn build(mut data: MeshData) -> Result<(Self, MeshRepairs), MeshError> {
        let repairs = repair(&mut data)?;
        let mut mesh = Self { data, bounds: Aabb::EMPTY };
        mesh.bounds = (0..mesh.data.triangles.len()).fold(Aabb::EMPTY, |sum, i| sum.union(mesh.triangle_bounds(i)));
        Ok((mesh, repairs))
    }

    /// Arrays of the mesh, after repair.
    pub const fn data(&self) -> &MeshData {
        &self.data
    }

    /// The smallest box around all triangles; empty without any.
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size of the arrays in bytes.
    pub fn memory(&self) -> usize {
        let MeshData { positions, triangles, normals, uvs, second_uvs, colors, tangents } = &self.data;
        size_of_val(positions.as_slice())
            + size_of_val(triangles.as_slice())
            + size_of_val(normals.as_slice())
            + size_of_val(uvs.as_slice())
            + size_of_val(second_uvs.as_slice())
            + size_of_val(colors.as_slice())
            + size_of_val(tangents.as_slice())
    }

    /// [`Primitives::intersect`] for a ray that was prepared once for many triangles.
    #[inline]
    pub fn intersect_sheared(&self, index: u32, ray: &WatertightRay, span: Interval) -> Option<Hit> {
        let triangle = *self.data.triangles.get(index as usize)?;
        let hit = ray.intersect(self.corners(triangle), span)?;
        Some(Hit { t: hit.t, instance: 0, primitive: index, uv: hit.uv })
    }

    /// Surface at a hit of this mesh with this ray; `None` for an invalid primitive index.
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceInteraction> {
        self.surface_with_normal(ray, hit, needs, None)
    }

    /// Version of [`surface`](Self::surface) for a triangle whose [`unit_normal`](Self::unit_normal) is known.
    #[inline(always)]
    pub fn surface_with_normal(
        &self,
        ray: &Ray,
        hit: &Hit,
        needs: InteractionFlags,
        unit_normal_if_known: Option<DVec3>,
    ) -> Option<SurfaceInteraction> {
        let triangle = *self.data.triangles.get(hit.primitive as usize)?;
        let corners = self.corners(triangle);
        let weights = weights(hit.uv);
        let (point, point_error) = point_at(corners, hit.uv);
        let uv = if needs.uv { interpolated(&self.data.uvs, triangle, weights).unwrap_or_default() } else { [0.0; 2] };
        let geometric_normal = unit_normal_if_known.unwrap_or_else(|| unit_normal(corners));
        let has_detail = needs.detail && self.data.has_attributes();
        let mut detail = if has_detail { self.detail(triangle, weights) } else { VertexAttributes::NONE };
        let (mut shading_normal, mut shadow_point) = (geometric_normal, point);
        if needs.shading_normal
            && !self.data.normals.is_empty()
            && let smooth = self.smooth(point, geometric_normal, triangle, corners, hit.uv, ray.direction)
            && smooth.is_valid
        {
            (shading_normal, shadow_point) = (smooth.normal.into(), smooth.shadow_point.into());
            // The cross product turns with the normal.
            detail.is_mirrored ^= smooth.is_turned;
        }
        // Last, so that it is constructed in place and not moved.
        Some(SurfaceInteraction { point, point_error, shadow_point, geometric_normal, shading_normal, uv, detail })
    }

    /// Unit normal of a triangle; any unit vector for one without area. `None` for an invalid index.
    pub fn unit_normal(&self, triangle: u32) -> Option<DVec3> {
        self.data.triangles.get(triangle as usize).map(|&triangle| unit_normal(self.corners(triangle)))
    }

    /// Interpolated normal and lifted point.
    #[inline(always)]
    fn smooth(
        &self,
        point: DVec3,
        geometric_normal: DVec3,
        triangle: [u32; 3],
        corners: [DVec3; 3],
        uv: [f64; 2],
        direction: DVec3,
    ) -> SmoothPoint<f64> {
        let normal = |i: u32| Vector3::from(self.data.normals[i as usize].as_dvec3());
        let normals = [normal(triangle[0]), normal(triangle[1]), normal(triangle[2])];
        let corners = [corners[0].into(), corners[1].into(), corners[2].into()];
        smooth_point((point.into(), geometric_normal.into()), corners, normals, uv, direction.into())
    }

    #[inline(never)]
    fn detail(&self, triangle: [u32; 3], weights: [f64; 3]) -> VertexAttributes {
        let MeshData { second_uvs, colors, tangents, .. } = &self.data;
        let mut detail = VertexAttributes::default();
        if let Some(uv) = interpolated(second_uvs, triangle, weights) {
            detail.second_uv = uv.map(|x| x as f32);
        }
        if let Some([red, green, blue, _]) = interpolated(colors, triangle, weights) {
            detail.color = [red, green, blue].map(|x| x as f32);
        }
        if let Some([x, y, z, _]) = interpolated(tangents, triangle, weights) {
            detail.tangent = DVec3::new(x, y, z).as_vec3();
            detail.is_mirrored = tangents[triangle[0] as usize][3] < 0.0;
        }
        detail
    }

    /// Texture coordinates of both sets at a hit of this mesh, and the alpha of its vertex colours there: 1 without
    /// colours. `None` for an invalid primitive index.
    pub fn coverage_at(&self, hit: &Hit) -> Option<([[f64; 2]; 2], f64)> {
        let triangle = *self.data.triangles.get(hit.primitive as usize)?;
        let weights = weights(hit.uv);
        let uv = |uvs: &[[f32; 2]]| interpolated(uvs, triangle, weights).unwrap_or_default();
        let alpha = interpolated(&self.data.colors, triangle, weights).map_or(1.0, |color| color[3]);
        Some(([uv(&self.data.uvs), uv(&self.data.second_uvs)], alpha))
    }

    #[inline]
    fn corners(&self, [a, b, c]: [u32; 3]) -> [DVec3; 3] {
        let corner = |i: u32| self.data.positions[i as usize].as_dvec3();
        [corner(a), corner(b), corner(c)]
    }

    /// Vertices of a triangle, in the space of the mesh; `None` for an invalid index.
    #[inline]
    pub fn vertices(&self, index: u32) -> Option<[DVec3; 3]> {
        self.data.triangles.get(index as usize).map(|triangle| self.corners(*triangle))
    }

    /// Unit normals of the vertices of a triangle; `None` for a mesh without normals and for an invalid index.
    #[inline]
    pub fn vertex_normals(&self, index: u32) -> Option<[Vec3; 3]> {
        let (normals, [a, b, c]) = (&self.data.normals, *self.data.triangles.get(index as usize)?);
        let normal = |vertex: u32| normals.get(vertex as usize).copied();
        Some([normal(a)?, normal(b)?, normal(c)?])
    }

    /// Texture coordinates at the vertices of a triangle; zero without any. `None` for an invalid index.
    #[inline]
    pub fn vertex_uvs(&self, index: u32) -> Option<[[f32; 2]; 3]> {
        let [a, b, c] = *self.data.triangles.get(index as usize)?;
        let uv = |vertex: u32| self.data.uvs.get(vertex as usize).copied().unwrap_or_default();
        Some([uv(a), uv(b), uv(c)])
    }

    #[inline]
    fn triangle_bounds(&self, index: usize) -> Aabb {
        Aabb::from_points(self.corners(self.data.triangles[index]))
    }
}

/// Interpolated value; `None` if the mesh has none. Exact where all three corners have the same.
fn interpolated<const N: usize>(values: &[[f32; N]], triangle: [u32; 3], weights: [f64; 3]) -> Option<[f64; N]> {
    if values.is_empty() {
        return None;
    }
    let corner = |i: usize| &values[triangle[i] as usize];
    let (a, b, c) = (corner(0), corner(1), corner(2));
    let mut mean = [0.0; N];
    for (k, mean) in mean.iter_mut().enumerate() {
        let [a, b, c] = [a[k], b[k], c[k]].map(f64::from);
        *mean = if a == b && b == c { a } else { a * weights[0] + b * weights[1] + c * weights[2] };
    }
    Some(mean)
}

impl Primitives for TriangleMesh {
    fn len(&self) -> usize {
        self.data.triangles.len()
    }

    #[inline]
    fn bounds(&self, index: u32) -> Option<Aabb> {
        ((index as usize) < self.len()).then(|| self.triangle_bounds(index as usize))
    }

    #[inline]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.intersect_sheared(index, &WatertightRay::new(ray), span)
    }

    #[inline]
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        let corner = |i: u32| self.data.positions[i as usize];
        let corners = |&[a, b, c]: &[u32; 3]| [corner(a), corner(b), corner(c)];
        self.data
            .triangles
            .get(index as usize)
            .map(corners)
            .map_or(PrimitiveGeometry::Opaque, PrimitiveGeometry::ExactTriangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{NoProbe, intersect_primitive};
    use rt_math::transcendental::sincos;
    use rt_math::{SlabRay, Vec3};
    use std::f64::consts::{PI, TAU};

    fn build(data: MeshData) -> (TriangleMesh, MeshRepairs) {
        TriangleMesh::build(data).expect("a mesh")
    }

    /// Two triangles of the unit square in z = 0, facing +z.
    fn square() -> MeshData {
        MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: vec![Vec3::Z * 3.0; 4],
            uvs: vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]],
            ..MeshData::default()
        }
    }

    fn closest(mesh: &TriangleMesh, ray: &Ray) -> Option<Hit> {
        let slab = SlabRay::new(ray);
        let hits =
            (0..mesh.len() as u32).filter_map(|i| intersect_primitive(mesh, i, &slab, Interval::FORWARD, &mut NoProbe));
        hits.reduce(|best, hit| if hit.precedes(&best) { hit } else { best })
    }

    #[test]
    fn hits_are_interpolated() {
        let (mesh, repairs) = build(square());
        assert_eq!(repairs, MeshRepairs::default());
        assert_eq!(mesh.data().normals, [Vec3::Z; 4]);
        let ray = Ray::new(DVec3::new(0.25, 0.75, 2.0), DVec3::NEG_Z);
        let hit = closest(&mesh, &ray).expect("a hit");
        assert_eq!((hit.t, hit.instance, hit.primitive, hit.uv), (2.0, 0, 1, [0.25, 0.5]));
        let surface = mesh.surface(&ray, &hit, InteractionFlags::ALL).expect("its own hit");
        assert_eq!((surface.point, surface.uv), (DVec3::new(0.25, 0.75, 0.0), [0.5, 1.5]));
        assert_eq!((surface.geometric_normal, surface.shading_normal), (DVec3::Z, DVec3::Z));
        let bare = mesh.surface(&ray, &hit, InteractionFlags::NONE).expect("its own hit");
        let foreign = Hit { primitive: 1_000_000, ..hit };
        assert_eq!(mesh.surface(&ray, &foreign, InteractionFlags::ALL), None);
        assert_eq!((bare.uv, bare.shadow_point), ([0.0; 2], bare.point));
        assert_eq!(mesh.bounds(), Aabb::new(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)));
        assert_eq!(mesh.memory(), 4 * 12 + 2 * 12 + 4 * 12 + 4 * 8);
        assert_eq!(mesh.geometry(0), PrimitiveGeometry::ExactTriangle([Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]));
    }

    /// Regression: equal values of all corners were rounded below them, so that an alpha test at this value left holes.
    #[test]
    fn equal_values_of_corners_are_interpolated_exactly() {
        for alpha in [1.0, 0.4, 0.9f32] {
            for index in 0..10_000 {
                let (v, w) = (f64::from(index % 100) / 199.0, f64::from(index / 100) / 203.0);
                let mean = interpolated(&[[alpha]; 3], [0, 1, 2], [1.0 - v - w, v, w]);
                assert_eq!(mean, Some([f64::from(alpha)]));
            }
        }
    }

    #[test]
    fn a_hit_on_the_shared_edge_belongs_to_the_lower_triangle() {
        let (mesh, _) = build(square());
        let hit = closest(&mesh, &Ray::new(DVec3::new(0.5, 0.5, 1.0), DVec3::NEG_Z));
        assert_eq!(hit.map(|hit| hit.primitive), Some(0));
    }

    #[test]
    fn repairable_input_is_repaired_and_counted() {
        let mut data = square();
        data.positions.extend([Vec3::new(0.0, f32::NAN, 0.0), Vec3::new(0.1, 0.1, 0.1), Vec3::splat(0.3)]);
        data.normals.extend([Vec3::ZERO; 3]);
        data.normals[1] = Vec3::ZERO;
        data.normals[2] = Vec3::INFINITY;
        data.uvs.extend([[0.0, 1.0]; 3]);
        data.uvs[3] = [f32::NAN, 0.0];
        // Repeated, not finite, and collinear vertices; 0.1 and 0.3 are rounded, but on the diagonal all the same.
        data.triangles.splice(1..1, [[0, 1, 1], [0, 1, 4], [0, 5, 6]]);
        let (mesh, repairs) = build(data);
        assert_eq!(
            repairs,
            MeshRepairs { degenerate: 2, non_finite: 1, bad_normals: 2, bad_uvs: 1, ..MeshRepairs::default() }
        );
        assert_eq!(mesh.data().triangles, square().triangles);
        assert_eq!(mesh.data().normals[1..3], [Vec3::Z; 2]);
        assert_eq!(mesh.data().uvs[3], [0.0; 2]);
        assert_eq!(mesh.bounds(), Aabb::new(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)));
    }

    #[test]
    fn other_input_is_rejected() {
        let mut bad = square();
        bad.triangles[1][2] = 4;
        assert_eq!(TriangleMesh::build(bad).err(), Some(MeshError::BadIndex { triangle: 1, vertex: 4, count: 4 }));
        let mut bad = square();
        bad.normals.pop();
        let mismatch = |what| Some(MeshError::CountMismatch { what, count: 3, positions: 4 });
        assert_eq!(TriangleMesh::build(bad).err(), mismatch("normals"));
        let mut bad = square();
        bad.uvs.pop();
        assert_eq!(TriangleMesh::build(bad).err(), mismatch("texture coordinates"));
    }

    #[test]
    fn an_empty_mesh_is_a_mesh() {
        let (mesh, _) = build(MeshData::default());
        assert!(mesh.is_empty() && mesh.bounds().is_empty());
        assert_eq!((Primitives::bounds(&mesh, 0), mesh.geometry(0)), (None, PrimitiveGeometry::Opaque));
        assert_eq!(mesh.intersect(0, &Ray::new(DVec3::ZERO, DVec3::X), Interval::FORWARD), None);
    }

    #[test]
    fn shading_normals_keep_to_the_front_whichever_way_the_file_has_them() {
        let mut inward = square();
        inward.normals = vec![Vec3::new(0.6, 0.0, -0.8); 4];
        let (mesh, _) = build(inward);
        for z in [1.0, -1.0] {
            let ray = Ray::new(DVec3::new(0.25, 0.5, z), DVec3::new(0.0, 0.0, -z));
            let surface =
                mesh.surface(&ray, &closest(&mesh, &ray).expect("a hit"), InteractionFlags::ALL).expect("its own hit");
            assert!((surface.shading_normal - DVec3::new(-0.6, 0.0, 0.8)).length() < 1e-7);
            assert_eq!(surface.geometric_normal, DVec3::Z);
        }
    }

    /// Tessellated sphere around the origin, with the normals of the sphere.
    fn tessellated_sphere(around: u32, up: u32) -> TriangleMesh {
        let vertex = |i: u32| {
            let (column, row) = (i % around, i / around);
            let (sin, cos) = sincos(TAU * f64::from(column) / f64::from(around));
            let (ring, height) = sincos(PI * f64::from(row) / f64::from(up));
            DVec3::new(ring * cos, ring * sin, height).as_vec3()
        };
        let positions: Vec<Vec3> = (0..around * (up + 1)).map(vertex).collect();
        let quad = |row: u32, column: u32| {
            let next = (column + 1) % around;
            let [a, b] = [row * around + column, row * around + next];
            [[a, a + around, b + around], [a, b + around, b]]
        };
        let triangles = (0..up).flat_map(|row| (0..around).flat_map(move |column| quad(row, column))).collect();
        build(MeshData { normals: positions.clone(), positions, triangles, ..MeshData::default() }).0
    }

    /// Mean of cos θ over the orthographic image of a sphere along −z, with zero where a shadow ray is occluded. Also
    /// returns the number of occluded points that face the light.
    fn lit(mesh: &TriangleMesh, light: DVec3, start: impl Fn(&SurfaceInteraction) -> Ray) -> (f64, usize) {
        const SIDE: i32 = 100;
        let (mut sum, mut covered, mut dark) = (0.0, 0, 0);
        for pixel in 0..SIDE * SIDE {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
            let ray = Ray::new(DVec3::new(at(pixel % SIDE), at(pixel / SIDE), 2.0), DVec3::NEG_Z);
            let Some(hit) = closest(mesh, &ray) else { continue };
            let surface = mesh.surface(&ray, &hit, InteractionFlags::ALL).expect("its own hit");
            covered += 1;
            let cosine = surface.shading_normal.dot(light);
            if cosine > 0.0 {
                let seen = closest(mesh, &start(&surface)).is_none();
                sum += if seen { cosine } else { 0.0 };
                dark += usize::from(!seen);
            }
        }
        (sum / f64::from(covered), dark)
    }

    #[test]
    fn facets_on_the_lit_side_of_a_ball_are_not_dark() {
        let angle = 80.0f64.to_radians();
        let (sin, cos) = sincos(angle);
        let light = DVec3::new(sin, 0.0, cos);
        // Lambert's phase function of a sphere, over the area π of its disc.
        let truth = 2.0 / 3.0 * (sin + (PI - angle) * cos) / PI;
        let mesh = tessellated_sphere(8, 8);
        let (_, dark) = lit(&mesh, light, |surface| surface.spawn_ray(light, 0.0));
        assert!(dark > 100, "{dark}: the terminator is in view");
        let (mean, dark) = lit(&mesh, light, |surface| surface.spawn_shadow_ray_towards(light, 0.0));
        assert_eq!(dark, 0);
        assert!((mean / truth - 1.0).abs() < 0.02, "{mean} instead of {truth}");
        let far = light * 1e9;
        let (near_mean, dark) = lit(&mesh, light, |surface| surface.spawn_shadow_ray(far, 0.0));
        assert_eq!((near_mean, dark), (mean, 0));
    }
}
