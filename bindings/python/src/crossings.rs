//! Crossings of rays with one mesh: hits at the same point of a ray count once, as at a common edge of triangles.

use std::collections::TryReserveError;

use numpy::{IntoPyArray as _, PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;
use rt_accel::{DVec3, HitBatch, RayBatch};

use crate::arrays::{with_capacity, zeros};
use crate::error::{batch_error, memory_error, value_error};
use crate::geometry::PyMesh;
use crate::rays::{Rays, RaysView};
use crate::scene::PyScene;

/// Points that a thread interpolates at a time.
const POINTS_PER_TASK: usize = 4096;

/// Largest distance between hits at the same point, relative to the largest coordinates of the mesh and of the origin: 2⁻⁴⁰,
/// thousands of rounding errors.
const SAME_POINT: f64 = 1.0 / (1_u64 << 40) as f64;

/// Crossings in order of their rays, and along each ray.
#[derive(Default)]
struct Crossings {
    triangles: Vec<i64>,
    rays: Vec<i64>,
    /// Empty if they are not wanted.
    points: Vec<[f64; 3]>,
}

impl Crossings {
    /// Makes room for `n` more crossings.
    fn reserve(&mut self, n: usize, with_points: bool) -> Result<(), TryReserveError> {
        self.triangles.try_reserve(n)?;
        self.rays.try_reserve(n)?;
        self.points.try_reserve(if with_points { n } else { 0 })
    }
}

/// Triangles, rays, and coordinates of points, three for each.
type CrossingArrays<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

/// The first triangle that each ray hits in a scene of one mesh, -1 for a miss.
#[pyfunction]
pub(crate) fn first_triangles<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyScene>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    threads: usize,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let rays = Rays::extract_endless([origins, directions])?;
    let (view, scene) = (rays.view()?, scene.get());
    let first_triangles: Bound<'py, PyArray1<i64>> = zeros(py, view.len)?;
    {
        let mut first_triangles = first_triangles.readwrite();
        let first_triangles = first_triangles.as_slice_mut()?;
        let work = |is_parallel| {
            let mut closest = ClosestHits::default();
            view.for_each_small_slice(is_parallel, |first, rays| {
                closest.trace(scene, rays, is_parallel)?;
                for (triangle, found) in first_triangles[first..].iter_mut().zip(&closest.triangles) {
                    *triangle = if *found == HitBatch::MISS { -1 } else { i64::from(*found) };
                }
                Ok(())
            })
        };
        let threads = view.threads(py, threads)?;
        py.detach(|| threads.run(work))?;
    }
    Ok(first_triangles)
}

/// Crossings of rays with a mesh, at most `max_hits` for each ray, and its scene. Points are interpolated between vertices,
/// which is exact to rounding, however far away the ray starts.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a call from Python has one argument for each option")]
pub(crate) fn crossings<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyScene>,
    mesh: &Bound<'py, PyMesh>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    max_hits: usize,
    with_points: bool,
    threads: usize,
) -> PyResult<CrossingArrays<'py>> {
    let rays = Rays::extract_endless([origins, directions])?;
    let (view, scene, mesh) = (rays.view()?, scene.get(), mesh.get());
    let work = |is_parallel| match max_hits {
        1 => closest_crossings(scene, mesh, &view, with_points, is_parallel),
        _ => all_crossings(scene, mesh, &view, max_hits, with_points, is_parallel),
    };
    let threads = view.threads(py, threads)?;
    let mut found = py.detach(|| threads.run(work))?;
    found.triangles.shrink_to_fit();
    found.rays.shrink_to_fit();
    found.points.shrink_to_fit();
    let points = found.points.into_flattened();
    Ok((found.triangles.into_pyarray(py), found.rays.into_pyarray(py), points.into_pyarray(py)))
}

/// Closest hits of a slice of rays. The vectors are used again for the next slice.
#[derive(Default)]
struct ClosestHits {
    t: Vec<f64>,
    triangles: Vec<u32>,
    uv: Vec<[f64; 2]>,
}

impl ClosestHits {
    fn trace(&mut self, scene: &PyScene, rays: &RayBatch<'_>, is_parallel: bool) -> PyResult<()> {
        self.t.resize(rays.len(), 0.0);
        self.triangles.resize(rays.len(), 0);
        self.uv.resize(rays.len(), [0.0; 2]);
        let mut hits =
            HitBatch { t: &mut self.t, primitive: &mut self.triangles, instance: None, uv: Some(&mut self.uv) };
        let traced = if is_parallel {
            scene.scene.par_closest_batch(rays, &mut hits)
        } else {
            scene.scene.closest_batch(rays, &mut hits)
        };
        traced.map_err(batch_error)
    }
}

fn closest_crossings(
    scene: &PyScene,
    mesh: &PyMesh,
    view: &RaysView<'_>,
    with_points: bool,
    is_parallel: bool,
) -> PyResult<Crossings> {
    // Room for a crossing of each ray.
    let mut found = Crossings {
        triangles: with_capacity(view.len)?,
        rays: with_capacity(view.len)?,
        points: with_capacity(if with_points { view.len } else { 0 })?,
    };
    let (mut closest, mut hits) = (ClosestHits::default(), Vec::new());
    view.for_each_small_slice(is_parallel, |first, rays| {
        closest.trace(scene, rays, is_parallel)?;
        hits.clear();
        for (ray, (triangle, uv)) in closest.triangles.iter().zip(&closest.uv).enumerate() {
            if *triangle != HitBatch::MISS {
                found.triangles.push(i64::from(*triangle));
                found.rays.push((first + ray) as i64);
                hits.push((*triangle, *uv));
            }
        }
        if with_points {
            append_points(mesh, &hits, is_parallel, &mut found.points)?;
        }
        Ok(())
    })?;
    Ok(found)
}

fn all_crossings(
    scene: &PyScene,
    mesh: &PyMesh,
    view: &RaysView<'_>,
    max_hits: usize,
    with_points: bool,
    is_parallel: bool,
) -> PyResult<Crossings> {
    let (mut found, mut hits, mut points) = (Crossings::default(), Vec::new(), Vec::new());
    view.for_each_small_slice(is_parallel, |first, rays| {
        let lists = if is_parallel { scene.scene.par_all_hits_batch(rays) } else { scene.scene.all_hits_batch(rays) };
        let lists = lists.map_err(batch_error)?;
        hits.clear();
        hits.try_reserve(lists.hits.len()).map_err(memory_error)?;
        hits.extend(lists.hits.iter().map(|hit| (hit.primitive, hit.uv)));
        points.clear();
        append_points(mesh, &hits, is_parallel, &mut points)?;
        found.reserve(hits.len(), with_points).map_err(memory_error)?;
        for (ray, range) in lists.offsets.windows(2).enumerate() {
            let [start, end] = range else { continue };
            let tolerance = SAME_POINT * (mesh.largest_coordinate + largest(rays.get(ray).0.origin));
            let (mut last, mut n_hits) = (None, 0);
            for ((triangle, _), point) in hits[*start..*end].iter().zip(&points[*start..*end]) {
                let is_same = |last: DVec3| largest(DVec3::from(*point) - last) <= tolerance;
                if last.is_some_and(is_same) {
                    // Hits on triangles that share the location may differ in `t` by rounding.
                    if let Some(kept) = found.triangles.last_mut() {
                        *kept = (*kept).min(i64::from(*triangle));
                    }
                    continue;
                }
                if n_hits == max_hits {
                    break;
                }
                (last, n_hits) = (Some(DVec3::from(*point)), n_hits + 1);
                found.triangles.push(i64::from(*triangle));
                found.rays.push((first + ray) as i64);
                if with_points {
                    found.points.push(*point);
                }
            }
        }
        Ok(())
    })?;
    Ok(found)
}

fn largest(vector: DVec3) -> f64 {
    vector.abs().max_element()
}

/// Appends points of triangles, interpolated between their vertices by the weights of the second and third one.
fn append_points(
    mesh: &PyMesh,
    hits: &[(u32, [f64; 2])],
    is_parallel: bool,
    points: &mut Vec<[f64; 3]>,
) -> PyResult<()> {
    let first = points.len();
    points.try_reserve(hits.len()).map_err(memory_error)?;
    points.resize(first + hits.len(), [0.0; 3]);
    let write = |((triangle, [u, v]), point): (&(u32, [f64; 2]), &mut [f64; 3])| {
        let corners =
            mesh.mesh.triangle(*triangle).ok_or_else(|| value_error(format!("there is no triangle {triangle}")))?;
        *point = ((1.0 - (u + v)) * corners[0] + *u * corners[1] + *v * corners[2]).to_array();
        Ok(())
    };
    if is_parallel {
        hits.par_iter().zip(&mut points[first..]).with_min_len(POINTS_PER_TASK).try_for_each(write)
    } else {
        hits.iter().zip(&mut points[first..]).try_for_each(write)
    }
}
