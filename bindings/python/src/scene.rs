//! Queries of a scene.

use std::collections::{BTreeMap, TryReserveError};

use numpy::{
    Element, IntoPyArray as _, PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use rayon::prelude::*;
use rt_accel::{
    BatchError, BuildParams, DVec3, Geometry, GeometryId, HitBatch, HitLists, Primitives as _, RayBatch, Scene,
    SceneBuilder, Transform,
};

use crate::arrays::{Rows, RowsView, collected, with_capacity, zeros};
use crate::error::{batch_error, memory_error, value_error};
use crate::geometry::{PyMesh, PySpheres};
use crate::rays::Rays;
use crate::threads::Threads;

/// Points that a thread takes at a time.
const POINTS_PER_TASK: usize = 64;

/// Meshes and spheres with their trees.
#[pyclass(name = "Scene", module = "rt._rt", frozen)]
pub(crate) struct PyScene {
    pub(crate) scene: Scene<'static>,
    /// By key: the caller chooses keys of geometries.
    geometries: GeometryIds,
}

type GeometryIds = BTreeMap<u64, GeometryId>;

/// Error text of a refused change.
type Refused = String;

/// Key of a geometry, and a matrix of 4 x 4 numbers or `None` for the identity.
type Placement<'py> = (u64, Option<PyReadonlyArray2<'py, f64>>);

/// Geometries and instances to add to a scene.
struct Insertion {
    geometries: Vec<(u64, Geometry<'static>)>,
    instances: Vec<(u64, Option<Transform>)>,
    /// Argument that holds the objects, for messages: ` of insert`, or nothing for objects of a new scene.
    argument: &'static str,
}

impl Insertion {
    fn extract(
        geometries: &[(u64, Bound<'_, PyAny>)],
        instances: &[Placement<'_>],
        argument: &'static str,
    ) -> PyResult<Self> {
        let geometry = |(key, geometry): &(u64, Bound<'_, PyAny>)| -> PyResult<_> {
            Ok(match geometry.cast::<PyMesh>() {
                Ok(mesh) => (*key, mesh.get().mesh.clone().into()),
                Err(_) => (*key, geometry.cast::<PySpheres>()?.get().0.clone().into()),
            })
        };
        let instance = |(i, (key, matrix)): (usize, &Placement<'_>)| {
            let transform = matrix.as_ref().map(transform_of).transpose();
            Ok((*key, transform.map_err(|error| value_error(format!("object {i}{argument}: {error}")))?))
        };
        Ok(Self {
            geometries: geometries.iter().map(geometry).collect::<PyResult<_>>()?,
            instances: instances.iter().enumerate().map(instance).collect::<PyResult<_>>()?,
            argument,
        })
    }

    /// Largest number of primitives in a tree, if the scene has `n_instances` others.
    fn largest_tree(&self, n_instances: usize) -> usize {
        let len = |(_, geometry): &(u64, Geometry<'static>)| match geometry {
            Geometry::Mesh(mesh) => mesh.len(),
            Geometry::Spheres(spheres) => spheres.len(),
        };
        self.geometries.iter().map(len).fold(n_instances + self.instances.len(), usize::max)
    }

    /// Builds the trees of geometries, and returns the numbers of the instances.
    fn add_to(self, builder: &mut SceneBuilder<'static>, ids: &mut GeometryIds) -> Result<Vec<u32>, Refused> {
        for (key, geometry) in self.geometries {
            ids.insert(key, builder.add(geometry).map_err(|error| error.to_string())?);
        }
        let place = |(i, (key, transform)): (usize, &(u64, Option<Transform>))| {
            let id = geometry_of(ids, *key)?;
            let placed = match transform {
                None => builder.place(id),
                Some(transform) => builder.place_at(id, transform),
            };
            placed.map_err(|error| format!("object {i}{}: {error}", self.argument))
        };
        self.instances.iter().enumerate().map(place).collect()
    }
}

fn params_of(quality: &str) -> PyResult<BuildParams> {
    match quality {
        "fast" => Ok(BuildParams::FAST),
        "balanced" => Ok(BuildParams::BALANCED),
        "high" => Ok(BuildParams::HIGH),
        _ => Err(value_error(format!("quality {quality:?} is not one of 'fast', 'balanced', 'high'"))),
    }
}

/// Refuses an unknown quality of trees.
#[pyfunction]
pub(crate) fn check_quality(quality: &str) -> PyResult<()> {
    params_of(quality).map(|_| ())
}

fn geometry_of(ids: &GeometryIds, key: u64) -> Result<GeometryId, Refused> {
    ids.get(&key).copied().ok_or_else(|| format!("there is no geometry with the key {key}"))
}

/// `work` for each point, on the given number of threads.
fn for_each_point<T: Send>(
    py: Python<'_>,
    points: RowsView<'_>,
    threads: usize,
    work: impl Fn(DVec3) -> T + Send + Sync,
) -> PyResult<Vec<T>> {
    let threads = Threads::new(py, threads, points.len().div_ceil(POINTS_PER_TASK))?;
    py.detach(|| for_each_point_on(&threads, points, work))
}

fn for_each_point_on<T: Send>(
    threads: &Threads,
    points: RowsView<'_>,
    work: impl Fn(DVec3) -> T + Send + Sync,
) -> PyResult<Vec<T>> {
    let mut results = with_capacity(points.len())?;
    if let Some(row) = points.first_non_finite(0, points.len(), false) {
        return Err(value_error(format!("row {row} of points holds a number that is not finite")));
    }
    let at = |i: usize| match points {
        RowsView::F32(rows) => DVec3::new(rows[[i, 0]].into(), rows[[i, 1]].into(), rows[[i, 2]].into()),
        RowsView::F64(rows) => DVec3::new(rows[[i, 0]], rows[[i, 1]], rows[[i, 2]]),
    };
    threads.run(|is_parallel| {
        if is_parallel {
            let each = (0..points.len()).into_par_iter().with_min_len(POINTS_PER_TASK).map(|i| work(at(i)));
            each.collect_into_vec(&mut results);
        } else {
            results.extend((0..points.len()).map(|i| work(at(i))));
        }
    });
    Ok(results)
}

/// Array of what `trace` computes for each ray, on the given number of threads.
fn per_ray<'py, T: Element + Send + Sync>(
    py: Python<'py>,
    rays: [&Bound<'py, PyAny>; 4],
    threads: usize,
    trace: impl Fn(bool, &RayBatch<'_>, &mut [T]) -> Result<(), BatchError> + Send + Sync,
) -> PyResult<Bound<'py, PyArray1<T>>> {
    let rays = Rays::extract(rays)?;
    let view = rays.view()?;
    let results: Bound<'py, PyArray1<T>> = zeros(py, view.len)?;
    {
        let mut results = results.readwrite();
        let results = results.as_slice_mut()?;
        let work = |is_parallel| {
            view.for_each_slice(is_parallel, |first, rays| {
                let results = &mut results[first..first + rays.len()];
                trace(is_parallel, rays, results).map_err(batch_error)
            })
        };
        let threads = view.threads(py, threads)?;
        py.detach(|| threads.run(work))?;
    }
    Ok(results)
}

/// All hits of many rays as a structure of arrays.
#[derive(Default)]
struct HitArrays {
    offsets: Vec<i64>,
    t: Vec<f64>,
    primitive: Vec<u32>,
    instance: Vec<u32>,
    uv: Vec<[f64; 2]>,
}

impl HitArrays {
    /// Appends the hits of more rays.
    fn extend(&mut self, lists: &HitLists) -> Result<(), TryReserveError> {
        let (first, n) = (self.t.len(), lists.hits.len());
        self.t.try_reserve(n)?;
        self.primitive.try_reserve(n)?;
        self.instance.try_reserve(n)?;
        self.uv.try_reserve(n)?;
        self.offsets.extend(lists.offsets.iter().skip(1).map(|offset| (first + offset) as i64));
        self.t.extend(lists.hits.iter().map(|hit| hit.t));
        self.primitive.extend(lists.hits.iter().map(|hit| hit.primitive));
        self.instance.extend(lists.hits.iter().map(|hit| hit.instance));
        self.uv.extend(lists.hits.iter().map(|hit| hit.uv));
        Ok(())
    }
}

type Closest<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray2<f64>>);

type AllHits<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
);

type Nearest<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>);

#[pymethods]
impl PyScene {
    /// Builds trees over geometries, each with a key; instances are pairs of a key and a matrix of 4 x 4 numbers.
    #[new]
    fn new(
        py: Python<'_>,
        geometries: Vec<(u64, Bound<'_, PyAny>)>,
        instances: Vec<Placement<'_>>,
        quality: &str,
    ) -> PyResult<Self> {
        let (mut builder, mut ids) = (SceneBuilder::new(params_of(quality)?), GeometryIds::new());
        let insertion = Insertion::extract(&geometries, &instances, "")?;
        let threads = Threads::to_build(py, insertion.largest_tree(0))?;
        let work = |_| {
            insertion.add_to(&mut builder, &mut ids)?;
            builder.build().map_err(|error| error.to_string())
        };
        let scene = py.detach(|| threads.run(work)).map_err(value_error)?;
        Ok(Self { scene, geometries: ids })
    }

    /// A changed copy, which shares the trees of unchanged geometries, and the numbers of the new instances. Instances and
    /// geometries are removed before others are added.
    #[expect(clippy::too_many_arguments, reason = "a call from Python has one argument for each kind of change")]
    fn updated(
        &self,
        py: Python<'_>,
        vertices: Vec<(u64, Bound<'_, PyMesh>)>,
        transforms: Vec<(u32, PyReadonlyArray2<'_, f64>)>,
        removed_instances: Vec<u32>,
        removed_geometries: Vec<u64>,
        geometries: Vec<(u64, Bound<'_, PyAny>)>,
        instances: Vec<Placement<'_>>,
    ) -> PyResult<(Self, Vec<u32>)> {
        let (mut builder, mut ids) = (self.scene.to_builder(), self.geometries.clone());
        for (instance, matrix) in transforms {
            let refused = |error: String| value_error(format!("object {instance}: {error}"));
            let transform = transform_of(&matrix).map_err(refused)?;
            builder.set_transform(instance, &transform).map_err(|error| refused(error.to_string()))?;
        }
        let insertion = Insertion::extract(&geometries, &instances, " of insert")?;
        let largest_changed = vertices.iter().map(|(_, mesh)| mesh.get().mesh.len()).max().unwrap_or(0);
        let threads = Threads::to_build(py, insertion.largest_tree(self.scene.n_instances()).max(largest_changed))?;
        let vertices: Vec<_> = vertices.iter().map(|(key, mesh)| (*key, mesh.get().mesh.vertices().clone())).collect();
        let work = |_| {
            for (key, vertices) in vertices {
                builder.set_vertices(geometry_of(&ids, key)?, vertices).map_err(|error| error.to_string())?;
            }
            for instance in removed_instances {
                builder.remove(instance).map_err(|error| error.to_string())?;
            }
            for key in removed_geometries {
                builder.remove_geometry(geometry_of(&ids, key)?).map_err(|error| error.to_string())?;
                ids.remove(&key);
            }
            let numbers = insertion.add_to(&mut builder, &mut ids)?;
            Ok::<_, Refused>((builder.build().map_err(|error| error.to_string())?, numbers))
        };
        let (scene, numbers) = py.detach(|| threads.run(work)).map_err(value_error)?;
        Ok((Self { scene, geometries: ids }, numbers))
    }

    /// Bytes of the trees.
    #[getter]
    fn memory(&self) -> usize {
        self.scene.memory()
    }

    fn closest<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: &Bound<'py, PyAny>,
        t_max: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Closest<'py>> {
        let rays = Rays::extract([origins, directions, t_min, t_max])?;
        let view = rays.view()?;
        let n = view.len;
        let (t, primitive, instance, uv): Closest<'py> =
            (zeros(py, n)?, zeros(py, n)?, zeros(py, n)?, zeros(py, (n, 2))?);
        {
            let (mut t, mut primitive) = (t.readwrite(), primitive.readwrite());
            let (mut instance, mut uv) = (instance.readwrite(), uv.readwrite());
            let (t, primitive) = (t.as_slice_mut()?, primitive.as_slice_mut()?);
            let (instance, uv) = (instance.as_slice_mut()?, uv.as_slice_mut()?.as_chunks_mut().0);
            let work = |is_parallel| {
                view.for_each_slice(is_parallel, |first, rays| {
                    let range = first..first + rays.len();
                    let mut hits = HitBatch {
                        t: &mut t[range.clone()],
                        primitive: &mut primitive[range.clone()],
                        instance: Some(&mut instance[range.clone()]),
                        uv: Some(&mut uv[range]),
                    };
                    let traced = if is_parallel {
                        self.scene.par_closest_batch(rays, &mut hits)
                    } else {
                        self.scene.closest_batch(rays, &mut hits)
                    };
                    traced.map_err(batch_error)
                })
            };
            let threads = view.threads(py, threads)?;
            py.detach(|| threads.run(work))?;
        }
        Ok((t, primitive, instance, uv))
    }

    fn any_hit<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: &Bound<'py, PyAny>,
        t_max: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        per_ray(py, [origins, directions, t_min, t_max], threads, |is_parallel, rays, occluded| {
            if is_parallel {
                self.scene.par_occluded_batch(rays, occluded)
            } else {
                self.scene.occluded_batch(rays, occluded)
            }
        })
    }

    fn count_hits<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: &Bound<'py, PyAny>,
        t_max: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<u32>>> {
        per_ray(py, [origins, directions, t_min, t_max], threads, |is_parallel, rays, counts| {
            if is_parallel {
                self.scene.par_count_hits_batch(rays, counts)
            } else {
                self.scene.count_hits_batch(rays, counts)
            }
        })
    }

    /// Offsets, t, primitives, instances, and barycentric coordinates, two for each hit.
    fn all_hits<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: &Bound<'py, PyAny>,
        t_max: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<AllHits<'py>> {
        let rays = Rays::extract([origins, directions, t_min, t_max])?;
        let view = rays.view()?;
        let work = |is_parallel| {
            // Room for all offsets. Lists of hits grow.
            let mut all = HitArrays { offsets: with_capacity(view.len + 1)?, ..HitArrays::default() };
            all.offsets.push(0);
            view.for_each_small_slice(is_parallel, |_, rays| {
                let lists =
                    if is_parallel { self.scene.par_all_hits_batch(rays) } else { self.scene.all_hits_batch(rays) };
                all.extend(&lists.map_err(batch_error)?).map_err(memory_error)
            })?;
            Ok::<_, PyErr>(all)
        };
        let threads = view.threads(py, threads)?;
        let HitArrays { offsets, t, primitive, instance, uv } = py.detach(|| threads.run(work))?;
        Ok((
            offsets.into_pyarray(py),
            t.into_pyarray(py),
            primitive.into_pyarray(py),
            instance.into_pyarray(py),
            uv.into_flattened().into_pyarray(py),
        ))
    }

    /// Coordinates of the nearest points, three for each, distances, primitives and instances.
    fn nearest_point<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        max_distance: f64,
        threads: usize,
    ) -> PyResult<Nearest<'py>> {
        if max_distance.is_nan() {
            return Err(value_error("max_distance is not a number"));
        }
        let points = Rows::extract("points", points)?;
        let view = points.view();
        let nearest = |point| self.scene.nearest_point(point, max_distance);
        let found = for_each_point(py, view, threads, nearest)?;
        let coordinates = found.iter().map(|hit| hit.map_or([f64::NAN; 3], |hit| hit.point.to_array()));
        let distances = found.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance));
        let primitives = found.iter().map(|hit| hit.map_or(HitBatch::MISS, |hit| hit.primitive));
        let instances = found.iter().map(|hit| hit.map_or(HitBatch::MISS, |hit| hit.instance));
        Ok((
            collected(coordinates)?.into_flattened().into_pyarray(py),
            collected(distances)?.into_pyarray(py),
            collected(primitives)?.into_pyarray(py),
            collected(instances)?.into_pyarray(py),
        ))
    }

    fn contains<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let points = Rows::extract("points", points)?;
        let view = points.view();
        let inside = for_each_point(py, view, threads, |point| self.scene.contains(point))?;
        Ok(inside.into_pyarray(py))
    }

    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = Rows::extract("points", points)?;
        let view = points.view();
        let distance = |point| self.scene.signed_distance(point).unwrap_or(f64::INFINITY);
        let distances = for_each_point(py, view, threads, distance)?;
        Ok(distances.into_pyarray(py))
    }
}

fn transform_of(matrix: &PyReadonlyArray2<'_, f64>) -> Result<Transform, Refused> {
    if !matrix.is_aligned() {
        return Err("a transform must be aligned in memory".into());
    }
    let matrix = matrix.as_array();
    if matrix.dim() != (4, 4) {
        return Err(format!("a transform has the shape (4, 4), not {:?}", matrix.dim()));
    }
    if matrix.iter().all(|number| *number == 0.0) {
        return Err("the transform is singular: all of its numbers are zero".into());
    }
    let rows = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| matrix[[i, j]]));
    Transform::from_rows(rows).map_err(|error| error.to_string())
}
