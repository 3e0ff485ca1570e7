//! Rays that leave a triangle, at all scales and distances from the origin.

use crate::Draw;
use rt_geometry::{InteractionFlags, ShapeError, Triangle};
use rt_math::{DVec3, Frame, Interval, Ray};
use std::ops::AddAssign;

/// A triangle of some size somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpawnSetup {
    /// Size of the triangle.
    pub scale: f64,
    /// Distance from the origin along each axis.
    pub offset: f64,
    /// Nearly parallel to the plane z = 0. The rounding error of a sum of zero coordinates is 0, but not that of a
    /// sheared vertex.
    pub is_level: bool,
}

/// Results of spawned rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spawned {
    /// Rays that hit the triangle, from each of which another was spawned.
    pub spawned: u64,
    /// Spawned rays that hit the triangle again.
    pub acne: u64,
    /// Spawned rays that miss a sheet that is parallel to the triangle at a height of a thousandth of its size.
    pub leaks: u64,
}

impl AddAssign for Spawned {
    fn add_assign(&mut self, other: Self) {
        self.spawned += other.spawned;
        self.acne += other.acne;
        self.leaks += other.leaks;
    }
}

/// All scales at the origin and all offsets at scale 1, for both triangles.
pub fn spawn_setups() -> impl Iterator<Item = SpawnSetup> {
    let scales = [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6].map(|scale| (scale, 0.0));
    let offsets = [1e2, 1e4, 1e5, 1e7].map(|offset| (1.0, offset));
    let of_place = |(scale, offset)| [false, true].map(|is_level| SpawnSetup { scale, offset, is_level });
    scales.into_iter().chain(offsets).flat_map(of_place)
}

impl SpawnSetup {
    /// Spawns rays from random points of the triangle in random directions.
    ///
    /// # Errors
    /// If the triangle is flat.
    pub fn spawn(&self, rays: impl IntoIterator<Item = u64>) -> Result<Spawned, ShapeError> {
        let corners = if self.is_level {
            [[-1.0, -0.3, 0.0], [0.9, -0.8, 1e-17], [0.1, 1.0, -1e-17]]
        } else {
            [[-1.0, -0.3, 0.4], [0.9, -0.8, -0.5], [0.1, 1.0, 0.2]]
        };
        let place = |v: [f64; 3]| DVec3::from(v) * self.scale + self.offset;
        let vertices = corners.map(place);
        let triangle = Triangle::new(vertices)?;
        let [along, across] = [vertices[1] - vertices[0], vertices[2] - vertices[0]];
        let frame = Frame::from_z(along.cross(across).normalize());
        let sheet = self.sheet(&frame, place([0.0; 3]), vertices[0])?;
        let mut result = Spawned::default();
        for ray in rays {
            let mut draw = Draw::new(ray);
            let (v, w) = (draw.unit(), draw.unit());
            let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
            let aim = vertices[0] + along * v + across * w;
            let origin = aim + draw.above(frame.z, 1e-3) * self.scale;
            let arriving = Ray::new(origin, aim - origin);
            // Next to an edge, the rounding of the aim decides.
            let Some(hit) = triangle.intersect(&arriving, Interval::FORWARD) else { continue };
            let surface = triangle.surface(&arriving, &hit, InteractionFlags::ALL);
            let leaving = surface.spawn_ray(draw.above(frame.z, 1e-3), 0.0);
            result.spawned += 1;
            result.acne += u64::from(triangle.intersect(&leaving, Interval::FORWARD).is_some());
            result.leaks += u64::from(sheet.intersect(&leaving, Interval::FORWARD).is_none());
        }
        Ok(result)
    }

    /// A triangle so large that rays which leave at a cosine of at least 1e-3 hit it.
    fn sheet(&self, frame: &Frame, centre: DVec3, on_plane: DVec3) -> Result<Triangle, ShapeError> {
        let height = frame.z * ((on_plane - centre).dot(frame.z) + 1e-3 * self.scale);
        let corner = |x: f64, y: f64| centre + frame.from_local(DVec3::new(x, y, 0.0)) * self.scale + height;
        Triangle::new([corner(-20.0, -10.0), corner(20.0, -10.0), corner(0.0, 20.0)])
    }
}
