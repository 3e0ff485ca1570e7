//! The neutral files: little-endian, without a header beyond what is listed.
//!
//! ```text
//!   .mesh        u32 vertices, u32 triangles, then f32 x y z of each vertex, u32 a b c of each triangle
//!   .rays        f32 origin x y z, t_min, direction x y z, t_max of each ray
//!   .ref         f32 t (∞ for a miss), u32 triangle (2³² − 1 for none) of each ray
//!   .eps         text: the absolute part of the tolerance of t
//! ```

use std::{fs, path::Path};

use rt_geometry::{Hit, MeshData};
use rt_math::{DVec3, Interval, Ray, Vec3};

use crate::{error::TaskError, files};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayRecord {
    origin: [f32; 3],
    t_min: f32,
    direction: [f32; 3],
    t_max: f32,
}

impl RayRecord {
    /// The same ray and span in double precision.
    #[inline]
    pub(super) fn widen(&self) -> (Ray, Interval) {
        let [origin, direction] = [self.origin, self.direction].map(|v| DVec3::from_array(v.map(f64::from)));
        (Ray::new(origin, direction), Interval::new(f64::from(self.t_min), f64::from(self.t_max)))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HitRecord {
    pub t: f32,
    pub triangle: u32,
}

impl HitRecord {
    pub(super) const MISS: Self = Self { t: f32::INFINITY, triangle: u32::MAX };
    /// An occluded shadow ray.
    pub(super) const OCCLUDED: Self = Self { t: 0.0, triangle: u32::MAX };

    /// True unless it is a miss.
    pub(super) fn is_hit(&self) -> bool {
        self.t.is_finite()
    }
}

impl From<Option<Hit>> for HitRecord {
    #[inline]
    fn from(hit: Option<Hit>) -> Self {
        hit.map_or(Self::MISS, |hit| Self { t: hit.t as f32, triangle: hit.primitive })
    }
}

impl From<bool> for HitRecord {
    #[inline]
    fn from(is_occluded: bool) -> Self {
        if is_occluded { Self::OCCLUDED } else { Self::MISS }
    }
}

/// Reads a `.mesh`.
pub(super) fn read_mesh(path: &Path) -> Result<MeshData, TaskError> {
    let bytes = fs::read(path).map_err(TaskError::file(path))?;
    let mut words = words(&bytes);
    let mut next = || words.next().ok_or_else(|| damaged(path, "it ends too early"));
    let (vertices, triangles) = (next()?, next()?);
    let mut triple = || Ok([next()?, next()?, next()?]);
    let positions = (0..vertices).map(|_| triple().map(|v: [u32; 3]| Vec3::from_array(v.map(f32::from_bits))));
    let positions = positions.collect::<Result<_, TaskError>>()?;
    let triangles = (0..triangles).map(|_| triple()).collect::<Result<_, TaskError>>()?;
    if words.next().is_some() {
        return Err(damaged(path, "something follows the last triangle"));
    }
    Ok(MeshData { positions, triangles, ..MeshData::default() })
}

/// Reads a `.rays`.
pub(super) fn read_rays(path: &Path) -> Result<Vec<RayRecord>, TaskError> {
    let ray = |record: [u32; 8]| {
        let [x, y, z, t_min, dx, dy, dz, t_max] = record.map(f32::from_bits);
        RayRecord { origin: [x, y, z], t_min, direction: [dx, dy, dz], t_max }
    };
    Ok(records(path)?.into_iter().map(ray).collect())
}

/// Reads a `.ref`.
pub(super) fn read_hits(path: &Path) -> Result<Vec<HitRecord>, TaskError> {
    let hit = |[t, triangle]: [u32; 2]| HitRecord { t: f32::from_bits(t), triangle };
    Ok(records(path)?.into_iter().map(hit).collect())
}

/// Reads a `.eps`.
pub(super) fn read_tolerance(path: &Path) -> Result<f32, TaskError> {
    let text = files::read(path)?;
    text.trim().parse().map_err(|_| damaged(path, "it is no number"))
}

/// All records of `N` words.
fn records<const N: usize>(path: &Path) -> Result<Vec<[u32; N]>, TaskError> {
    let bytes = fs::read(path).map_err(TaskError::file(path))?;
    if bytes.len() % (4 * N) != 0 {
        return Err(damaged(path, "its last record is not whole"));
    }
    let record = |bytes: &[u8]| {
        let mut words = words(bytes);
        std::array::from_fn(|_| words.next().unwrap_or_default())
    };
    Ok(bytes.chunks_exact(4 * N).map(record).collect())
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

fn damaged(path: &Path, what: &str) -> TaskError {
    TaskError::Other(format!("{}: {what}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(folder: &tempfile::TempDir, words: &[u32]) -> std::path::PathBuf {
        let path = folder.path().join("file");
        fs::write(&path, words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
        path
    }

    #[test]
    fn a_mesh_is_read_and_a_damaged_one_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut words = vec![3, 1];
        words.extend([0.0, 0.0, 0.5, 1.0, 0.0, 0.5, 0.0, 1.0, 0.5].map(f32::to_bits));
        words.extend([2, 0, 1]);
        let mesh = read_mesh(&file(&folder, &words)).unwrap();
        assert_eq!((mesh.positions[2], mesh.triangles), (Vec3::new(0.0, 1.0, 0.5), vec![[2, 0, 1]]));
        assert!(read_mesh(&file(&folder, &words[..13])).is_err(), "a word too few");
        words.push(0);
        assert!(read_mesh(&file(&folder, &words)).is_err(), "a word too many");
    }

    #[test]
    fn rays_are_widened_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let words = [0.1, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8, 1e30f32].map(f32::to_bits);
        let [ray] = read_rays(&file(&folder, &words)).unwrap()[..] else { panic!("one ray") };
        let (ray, span) = ray.widen();
        assert_eq!(ray.origin, DVec3::new(f64::from(0.1f32), 2.0, 3.0));
        assert_eq!(ray.direction, DVec3::new(0.0, f64::from(0.6f32), f64::from(0.8f32)));
        assert_eq!(span, Interval::new(0.0, f64::from(1e30f32)));
        assert!(read_rays(&file(&folder, &words[..7])).is_err());
    }

    #[test]
    fn hits_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let words = [1.5f32.to_bits(), 7, f32::INFINITY.to_bits(), u32::MAX];
        let hits = [HitRecord { t: 1.5, triangle: 7 }, HitRecord::MISS];
        assert_eq!(read_hits(&file(&folder, &words)).unwrap(), hits);
    }
}
