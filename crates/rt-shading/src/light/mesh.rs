//! Mesh lights.

use super::light_sample::{by_solid_angle, density};
use super::piecewise_constant::{accumulate, find, probability};
use super::solid_angle::{self, MIN_SPHERICAL};
use super::{Emission, EmissionSides, LightBounds, LightError, LightLiSample, LightPoint};
use rt_geometry::{ShapeError, Triangle, WatertightRay};
use rt_math::{Aabb, DVec3, Interval, Ray, Vector3};

/// Largest distance from a plane that counts as in it, as a fraction of the size of the light.
const FLATNESS: f64 = 1e-6;

/// Maximum number of triangles that are tested for convexity, each against each.
const MAX_CONVEX: usize = 1024;

/// Set of triangles. One of them is sampled in proportion to its area, then a direction uniformly by solid angle (Arvo 1995).
/// A triangle that subtends less than 2⁻¹⁴ sr is sampled by area.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshLight {
    faces: Vec<Face>,
    /// Running sums of the areas of the faces.
    areas: Vec<f64>,
    area: f64,
    around: Aabb,
    emission: Emission,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    vertices: [DVec3; 3],
    /// Unit normal; zero without area.
    normal: DVec3,
    area: f64,
}

impl MeshLight {
    /// Light over triangles in world space. Vertices run counter-clockwise on the front side. Triangles without area keep their
    /// index and are never sampled.
    ///
    /// # Errors
    /// If all of them have no area together, or a coordinate is not finite.
    pub fn new(triangles: impl IntoIterator<Item = [DVec3; 3]>, emission: Emission) -> Result<Self, LightError> {
        let faces = triangles.into_iter().map(Face::new).collect::<Result<Vec<_>, _>>()?;
        let mut areas: Vec<f64> = faces.iter().map(|face| face.area).collect();
        let area = accumulate(&mut areas);
        if area == 0.0 {
            return Err(LightError::BadArea(faces.iter().map(|face| face.area).sum()));
        }
        let around = Aabb::from_points(faces.iter().flat_map(|face| face.vertices));
        Ok(Self { faces, areas, area, around, emission })
    }

    /// Area of one side of all triangles.
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// Emission of the surface.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// Samples a direction towards a point of the mesh. `None` if its triangle faces away or is edge-on. Other triangles of the
    /// mesh may occlude the point.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        let (index, rest) = find(&self.areas, u[0])?;
        let face = self.faces.get(index)?;
        let height = (face.vertices[0] - point).dot(face.normal);
        let radiance = self.emission.emitted(height);
        if radiance.is_black() {
            return None;
        }
        let on_light = face.sample(point, height, [rest, u[1]]);
        let at = LightPoint { point: on_light, normal: face.normal, triangle: u32::try_from(index).ok()? };
        // The rounding of hits on a triangle grows with its aspect ratio.
        let extent = self.around.extent().max_element() * face.aspect_ratio();
        LightLiSample::of_surface(point, &at, extent, radiance, self.pdf_li_at(point, on_light, at.triangle))
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples the direction from `point` to a point of the
    /// given triangle. 0 where it is invisible, and for an index out of range.
    pub fn pdf_li_at(&self, point: DVec3, on_light: DVec3, triangle: u32) -> f64 {
        let Some(face) = self.faces.get(triangle as usize) else { return 0.0 };
        let height = (face.vertices[0] - point).dot(face.normal);
        if self.emission.emitted(height).is_black() {
            return 0.0;
        }
        density(probability(&self.areas, triangle as usize) * face.pdf(point, height, on_light))
    }

    /// First hit of a ray from `point` with the mesh, from either side. All triangles are tested.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        let ray = WatertightRay::new(&Ray::new(point, direction));
        let mut nearest = None;
        let mut span = Interval::SPAWNED;
        for (face, triangle) in self.faces.iter().zip(0u32..) {
            let Some(hit) = ray.intersect(face.vertices, span) else { continue };
            if face.area > 0.0 && (nearest.is_none() || hit.t < span.max) {
                span.max = hit.t;
                nearest = Some(LightPoint { point: point + direction * hit.t, normal: face.normal, triangle });
            }
        }
        nearest
    }

    /// Samples a point uniformly by area, by two numbers in `[0, 1)`. Its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> Option<LightPoint> {
        let (index, rest) = find(&self.areas, u[0])?;
        let face = self.faces.get(index)?;
        let [a, b, c] = face.vertices;
        let root = rest.sqrt();
        let point = a + (b - a) * (root * (1.0 - u[1])) + (c - a) * (root * u[1]);
        Some(LightPoint { point, normal: face.normal, triangle: u32::try_from(index).ok()? })
    }

    /// True if an emissive side of a triangle may lie behind another triangle. It may not if all lie in a plane, or around a convex body
    /// that emits outwards. Of more than 1024 triangles, only planes are recognised.
    pub fn may_hide_itself(&self) -> bool {
        let tolerance = FLATNESS * self.around.extent().max_element();
        let heights = |face: &Face, of: &Face| of.vertices.map(|vertex| (vertex - face.vertices[0]).dot(face.normal));
        let faces = || self.faces.iter().filter(|face| face.area > 0.0);
        let is_off_plane =
            |face: &Face, other: &Face| heights(face, other).iter().any(|height| height.abs() > tolerance);
        let is_flat = faces().next().is_none_or(|first| !faces().any(|other| is_off_plane(first, other)));
        let may_be_convex = self.emission.sides() == EmissionSides::Front && self.faces.len() <= MAX_CONVEX;
        let is_before = |face: &Face, other: &Face| heights(face, other).iter().any(|height| *height > tolerance);
        !is_flat && (!may_be_convex || faces().any(|face| faces().any(|other| is_before(face, other))))
    }

    /// Bounds of positions and directions.
    pub fn bounds(&self) -> Option<LightBounds> {
        if self.emission.sides() == EmissionSides::Both {
            return Some(LightBounds::all_around(self.around, self.emission.power(self.area)));
        }
        let emissive = self.faces.iter().filter(|face| face.area > 0.0);
        let bounds = |face: &Face| {
            let around = Aabb::from_points(face.vertices);
            LightBounds::of_flat(around, face.normal, &self.emission, face.area)
        };
        emissive.map(bounds).reduce(|a, b| a.union(&b))
    }
}

impl Face {
    /// Longest edge divided by the height over it, at most 10⁴.
    fn aspect_ratio(&self) -> f64 {
        let [a, b, c] = self.vertices;
        let longest = [b - a, c - b, a - c].map(DVec3::length_squared).into_iter().fold(0.0, f64::max);
        (longest / (2.0 * self.area)).clamp(1.0, 1e4)
    }

    fn new(vertices: [DVec3; 3]) -> Result<Self, ShapeError> {
        match Triangle::new(vertices) {
            Ok(_) => {}
            Err(ShapeError::NoArea(_)) => return Ok(Self { vertices, normal: DVec3::ZERO, area: 0.0 }),
            Err(error) => return Err(error),
        }
        let [a, b, c] = vertices;
        let area = (b - a).cross(c - a);
        // Scaled first: the square of a small area underflows.
        let scale = area.abs().max_element();
        let normal = (area / scale).normalize_or_zero();
        let area = if normal == DVec3::ZERO { 0.0 } else { 0.5 * area.dot(normal) };
        Ok(Self { vertices, normal, area })
    }

    fn solid_angle(&self, point: DVec3, height: f64) -> f64 {
        solid_angle::of_fan(self.vertices.map(|vertex| Vector3::from(vertex - point)), height, 2.0 * self.area)
    }

    fn sample(&self, point: DVec3, height: f64, u: [f64; 2]) -> DVec3 {
        let corners = self.vertices.map(|vertex| vertex - point);
        let solid_angle = self.solid_angle(point, height);
        let [a, b, c] = self.vertices;
        let (mut v, mut w) = if solid_angle >= MIN_SPHERICAL {
            let direction = solid_angle::sample_triangle(corners, solid_angle, u);
            let offset = direction * (height / direction.dot(self.normal)) - corners[0];
            let across = 0.5 / self.area * self.normal;
            (offset.cross(c - a).dot(across), (b - a).cross(offset).dot(across))
        } else {
            let root = u[0].sqrt();
            (root * (1.0 - u[1]), root * u[1])
        };
        // Rounding may put a point next to an edge beyond it.
        v = v.clamp(0.0, 1.0);
        w = w.max(0.0).min(1.0 - v);
        a + (b - a) * v + (c - a) * w
    }

    fn pdf(&self, point: DVec3, height: f64, on_light: DVec3) -> f64 {
        let solid_angle = self.solid_angle(point, height);
        if solid_angle >= MIN_SPHERICAL {
            return 1.0 / solid_angle;
        }
        by_solid_angle(1.0 / self.area, Vector3::from(on_light - point), height)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Light;
    use super::super::polygon_irradiance;
    use super::super::test_estimate::{
        Estimate, assert_rays_agree, assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, white,
    };
    use super::*;

    /// The triangle of which the irradiance is published; its normal is +z.
    const TRIANGLE: [DVec3; 3] = [DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];

    fn mesh(triangles: &[[DVec3; 3]], sides: EmissionSides) -> Light {
        Light::Mesh(MeshLight::new(triangles.iter().copied(), white(sides)).expect("a light"))
    }

    /// A cube of side 2 around a point, its normals outside; a square without area is among its triangles.
    fn cube(centre: DVec3) -> Vec<[DVec3; 3]> {
        let mut triangles = vec![[centre; 3]];
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let [x, y, z] = [0, 1, 2].map(|k| DVec3::AXES[(axis + k) % 3]);
                let corner = |s: f64, t: f64| centre + side * x + s * side * y + t * z;
                let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        triangles
    }

    #[test]
    fn irradiance_is_lamberts() {
        let tilted = DVec3::ONE.normalize();
        for at in [
            [DVec3::ZERO, DVec3::Z],
            [DVec3::ZERO, tilted],
            [DVec3::new(0.2, 0.3, 0.99), DVec3::Z],
            [DVec3::new(0.2, 0.3, 1.0 - 1e-6), tilted],
            [DVec3::new(-2.0, 0.5, 0.9), DVec3::X],
            [DVec3::new(-2.0, 0.5, 0.999_9), DVec3::X],
            [DVec3::new(0.6, 0.6, 0.9), DVec3::NEG_X],
            [DVec3::new(0.0, 0.0, -200.0), DVec3::Z],
        ] {
            let light = mesh(&[TRIANGLE], EmissionSides::Both);
            irradiance(&light, at, 200_000)
                .assert(&format!("triangle from {}", at[0]), polygon_irradiance(&TRIANGLE, at[0], at[1]));
            assert_samples_and_pdf_agree(&light, at[0], 1e-6);
        }
        let far = [DVec3::new(0.0, 0.0, -1e6), DVec3::Z];
        irradiance(&mesh(&[TRIANGLE], EmissionSides::Both), far, 1000)
            .assert("triangle from afar", 0.5 / (1e6 + 1.0) / (1e6 + 1.0));
    }

    #[test]
    fn a_square_of_triangles_is_a_square() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let [a, b, c, d] = corners;
        let light = mesh(&[[a, b, c], [a, a, b], [a, c, d]], EmissionSides::Front);
        for point in [DVec3::new(0.5, 0.3, 0.1), DVec3::new(3.0, 2.0, 1.0), DVec3::new(0.2, -0.1, 30.0)] {
            let at = [point, DVec3::new(0.1, -0.2, -1.0).normalize()];
            irradiance(&light, at, 200_000)
                .assert(&format!("from {point}"), polygon_irradiance(&corners, at[0], at[1]));
            integral_of_pdf(&light, point, 200_000).assert(&format!("pdf from {point}"), 1.0);
        }
    }

    /// A triangle that is seen from behind gives nothing: the density integrates to the part of the area that faces the
    /// point.
    #[test]
    fn visible_sides_of_a_cube_emit() {
        let light = mesh(&cube(DVec3::ZERO), EmissionSides::Front);
        for (point, sides) in
            [(DVec3::new(0.0, 3.0, 0.0), 1.0), (DVec3::new(2.0, 3.0, -4.0), 3.0), (DVec3::X * 1.001, 1.0)]
        {
            integral_of_pdf(&light, point, 100_000).assert(&format!("pdf from {point}"), sides / 6.0);
            assert_samples_and_pdf_agree(&light, point, 1e-6);
            assert_rays_agree(&light, [point, -point.normalize()], 100_000);
        }
        assert_eq!(
            (light.sample_li(DVec3::ZERO, [0.4; 2]), light.pdf_li(DVec3::ZERO, DVec3::X)),
            (None, 0.0),
            "within"
        );
        irradiance(&mesh(&cube(DVec3::X), EmissionSides::Both), [DVec3::ZERO + 1.1 * DVec3::X, DVec3::Y], 100_000)
            .assert("within a cube", std::f64::consts::PI);
    }

    /// By area, the estimate next to a triangle of size 1 would vary by about d⁻²; here it varies by the receiver's cosine.
    #[test]
    fn samples_by_solid_angle_vary_less_than_those_by_area() {
        let at = [DVec3::new(0.25, 0.25, 0.9), DVec3::Z];
        let by_angle = irradiance(&mesh(&[TRIANGLE], EmissionSides::Both), at, 50_000);
        let by_area = Estimate::of(50_000, |u| {
            let root = u[0].sqrt();
            let on_light = DVec3::new(root * (1.0 - u[1]), root * u[1], 1.0);
            let offset = on_light - at[0];
            0.1 * 0.1 * 0.5 / (offset.length_squared() * offset.length_squared())
        });
        by_area.assert("by area", polygon_irradiance(&TRIANGLE, at[0], at[1]));
        println!("standard errors by area and by angle: {} and {}", by_area.standard_error, by_angle.standard_error);
        assert!(by_area.standard_error > 4.0 * by_angle.standard_error);
    }

    #[test]
    fn a_wrong_density_is_caught() {
        let (light, at) = (mesh(&[TRIANGLE], EmissionSides::Both), [DVec3::ZERO, DVec3::Z]);
        assert!(
            irradiance_by(&light, at, 200_000, |s| s.pdf * 1.01).z(polygon_irradiance(&TRIANGLE, at[0], at[1])) > 5.0
        );
    }

    #[test]
    fn odd_numbers_are_refused_and_missing_triangles_have_no_density() {
        let light = mesh(&cube(DVec3::ZERO), EmissionSides::Both);
        let missing = LightPoint { point: DVec3::X, normal: DVec3::X, triangle: 99 };
        assert_eq!(light.pdf_li_at(DVec3::ZERO, &missing), 0.0);
        for bad in [vec![], vec![[DVec3::X; 3]], vec![[DVec3::NAN; 3]], vec![[DVec3::X, DVec3::Y, DVec3::INFINITY]]] {
            assert!(MeshLight::new(bad, white(EmissionSides::Front)).is_err());
        }
    }

    #[test]
    fn bounds_hold_the_directions_of_all_normals() {
        let roof = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::ZERO, DVec3::Y, DVec3::Z]];
        let bounds = mesh(&roof, EmissionSides::Front).bounds().expect("bounds");
        assert!((bounds.spread() - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
        assert!((bounds.axis() - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-15);
        assert_eq!(
            mesh(&cube(DVec3::ZERO), EmissionSides::Front).bounds().expect("bounds").around().extent(),
            DVec3::splat(2.0)
        );
    }
}
