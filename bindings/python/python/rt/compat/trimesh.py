"""The interface of trimesh's module of rays.

One line replaces trimesh's own intersector, and everything in trimesh that casts rays at the mesh then uses this package:

>>> import trimesh
>>> from rt.compat.trimesh import RayMeshIntersector
>>> mesh = trimesh.creation.box()
>>> mesh.ray = RayMeshIntersector(mesh)
>>> locations, index_ray, index_tri = mesh.ray.intersects_location([[0, 0, 5]], [[0, 0, -1]])
>>> locations[:, 2]
array([ 0.5, -0.5])
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

import rt
from rt import _arrays, _rt
from rt._locks import Lock

if TYPE_CHECKING:
    from typing_extensions import Self

#: More than any mesh has.
_NO_LIMIT = 2**63 - 1


def _floats(values: ArrayLike) -> NDArray[Any]:
    """The values as an array of doubles. Single precision stays as it is: it is converted without rounding later."""
    array = np.asarray(values)
    return _arrays.aligned(array if array.dtype == np.float32 else array.astype(np.float64, copy=False))


class RayMeshIntersector:
    """Rays at a mesh of trimesh.

    It has the methods of both intersectors of trimesh, with the same arguments and results. Hits are exact: none is lost at
    an edge or a vertex, and all of them are found. Those of one ray are in order along it, and hits at one location, as at an
    edge, count once. The tree is built at the first query, and again after the mesh has changed.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        One intersector of trimesh names it `geometry`, which is accepted as well.
    scale_to_box : bool
        Ignored: meshes of any size are traced exactly.
    threads : int, optional
        Number of threads, by default all processors.
    """

    def __init__(
        self,
        mesh: Any = None,
        scale_to_box: bool = True,
        *,
        geometry: Any = None,
        threads: SupportsIndex | None = None,
    ) -> None:
        self.mesh = geometry if mesh is None else mesh
        if self.mesh is None:
            raise TypeError("a RayMeshIntersector takes a mesh")
        self._scale_to_box = scale_to_box
        self._threads = threads
        self._thread_count = _arrays.thread_count(threads)
        self._lock = Lock()
        self._built: tuple[int, rt.TriangleMesh] | None = None

    def _tree(self) -> rt.TriangleMesh:
        key = hash(self.mesh)
        with self._lock:
            if self._built is None or self._built[0] != key:
                self._built = (key, rt.TriangleMesh(np.asarray(self.mesh.vertices), np.asarray(self.mesh.faces)))
            return self._built[1]

    @staticmethod
    def _rays(ray_origins: ArrayLike, ray_directions: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        origins, directions = _floats(ray_origins), _floats(ray_directions)
        if origins.size == 0 and directions.size == 0:
            return np.empty((0, 3)), np.empty((0, 3))
        if origins.shape != directions.shape or origins.ndim != 2 or origins.shape[1] != 3:
            raise ValueError(f"origins of shape {origins.shape} and directions of shape {directions.shape} must be (n, 3)")
        return origins, directions

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        return_locations: bool = False,
        multiple_hits: bool = True,
        max_hits: SupportsIndex | None = None,
        **options: Any,
    ) -> tuple[np.ndarray, ...]:
        """Triangles that rays hit. Hits of a ray at one location, as at an edge, count once.

        Parameters
        ----------
        ray_origins, ray_directions : array_like, shape (n, 3)
        return_locations : bool
            Return locations as well.
        multiple_hits : bool
            All hits, or the closest of each ray.
        max_hits : int, optional
            Largest number of hits of a ray; by default all.
        options
            Ignored.

        Returns
        -------
        index_tri : ndarray of int64, shape (m,)
            Rows of ``mesh.faces``; the lowest one of those that share the location. With ``multiple_hits=False``, of faces
            that lie in each other the one that is closest up to rounding.
        index_ray : ndarray of int64, shape (m,)
            Rows of the rays, in rising order; hits of one ray are in order along it.
        locations : ndarray of float64, shape (m, 3)
            Only with `return_locations`.
        """
        origins, directions = self._rays(ray_origins, ray_directions)
        limit = (_NO_LIMIT if max_hits is None else max(int(max_hits), 0)) if multiple_hits else 1
        tree = self._tree()
        index_tri, index_ray, locations = _rt.crossings(
            tree._core(), tree._geometry, origins, directions, limit, bool(return_locations), self._thread_count
        )
        if return_locations:
            return index_tri, index_ray, locations.reshape(-1, 3)
        return index_tri, index_ray

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True, **options: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Locations at which rays hit the mesh. Hits of a ray at one location count once.

        Parameters and options are those of `intersects_id`.

        Returns
        -------
        locations : ndarray of float64, shape (m, 3)
            Interpolated between vertices: exact to rounding, however far away the ray starts.
        index_ray : ndarray of int64, shape (m,)
        index_tri : ndarray of int64, shape (m,)
        """
        options |= {"multiple_hits": multiple_hits, "return_locations": True}
        index_tri, index_ray, locations = self.intersects_id(ray_origins, ray_directions, **options)
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **options: Any) -> np.ndarray:
        """The first triangle that each ray hits.

        Returns
        -------
        ndarray of int64, shape (n,)
            Rows of ``mesh.faces``, -1 for rays that hit nothing.
        """
        origins, directions = self._rays(ray_origins, ray_directions)
        return _rt.first_triangles(self._tree()._core(), origins, directions, self._thread_count)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **options: Any) -> np.ndarray:
        """True for each ray that hits the mesh.

        Returns
        -------
        ndarray of bool, shape (n,)
        """
        origins, directions = self._rays(ray_origins, ray_directions)
        return self._tree().any_hit(origins, directions, threads=self._threads)

    def contains_points(self, points: ArrayLike) -> np.ndarray:
        """True for each point inside the closed mesh or on its surface.

        Parameters
        ----------
        points : array_like, shape (n, 3)

        Returns
        -------
        ndarray of bool, shape (n,)
        """
        array = np.asarray(points, dtype=np.float64)
        if array.size == 0:
            return np.zeros(0, dtype=bool)
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"points must have the shape (n, 3), not {array.shape}")
        return self._tree().contains(array, threads=self._threads)

    def __getstate__(self) -> dict[str, Any]:
        return {"mesh": self.mesh, "scale_to_box": self._scale_to_box, "threads": self._threads}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]

    def __copy__(self) -> Self:
        return type(self)(**self.__getstate__())

    def __deepcopy__(self, memo: object) -> Self:
        return self.__copy__()
