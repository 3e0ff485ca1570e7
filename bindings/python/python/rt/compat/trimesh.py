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

import threading
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import rt

#: Two hits of a ray are one location if they are closer than this.
_SAME_LOCATION = 1e-8

#: Rays that are traced at a time where there is one hit for each at most. More than all threads need, and few enough that
#: intermediate results take tens of megabytes.
_RAYS_PER_SLICE = 1 << 19


def _slices(n, size):
    return (slice(first, min(first + size, n)) for first in range(0, n, size))


def _floats(values):
    """The values as an array of doubles. Single precision stays as it is: it is converted without rounding later."""
    array = np.asarray(values)
    return array if array.dtype == np.float32 else array.astype(np.float64, copy=False)


class RayMeshIntersector:
    """Rays at a mesh of trimesh.

    Hits are exact: none is lost at an edge or a vertex, and all of them are found, in order along the ray. The tree is
    built at the first query, and again after the mesh has changed.

    Parameters
    ----------
    mesh : trimesh.Trimesh
    options
        Ignored; trimesh's own intersectors take some.
    """

    def __init__(self, mesh, **options):
        self.mesh = mesh
        self._lock = threading.Lock()
        self._built = None

    def _tree(self):
        key = hash(self.mesh)
        with self._lock:
            if self._built is None or self._built[0] != key:
                self._built = (key, rt.TriangleMesh(np.asarray(self.mesh.vertices), np.asarray(self.mesh.faces)))
            return self._built[1]

    @staticmethod
    def _rays(ray_origins, ray_directions):
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
        max_hits: int | None = None,
        **options: Any,
    ) -> tuple[np.ndarray, ...]:
        """Triangles that rays hit.

        Parameters
        ----------
        ray_origins, ray_directions : array_like, shape (n, 3)
        return_locations : bool
            Return locations as well. Hits of a ray at one location then count once, as at an edge.
        multiple_hits : bool
            All hits, or the closest of each ray.
        max_hits : int, optional
            Largest number of hits of a ray.
        options
            Ignored.

        Returns
        -------
        index_tri : ndarray of int64, shape (m,)
            Rows of ``mesh.faces``.
        index_ray : ndarray of int64, shape (m,)
            Rows of the rays, in rising order; hits of one ray are in order along it.
        locations : ndarray of float64, shape (m, 3)
            Only with `return_locations`.
        """
        origins, directions = self._rays(ray_origins, ray_directions)
        if not multiple_hits:
            return self._closest(origins, directions, return_locations)
        tree = self._tree()
        hits = tree.all_hits(origins, directions)
        index_ray, index_tri = hits.ray, hits.primitive.astype(np.int64)
        keep = np.ones(len(index_ray), dtype=bool)
        locations = None
        if return_locations:
            locations = np.empty((len(index_tri), 3))
            tree._geometry.interpolate(index_tri, hits.uv, locations)
            step = np.abs(np.diff(locations, axis=0)).max(axis=1)
            keep[1:] = (np.diff(index_ray) != 0) | (step > _SAME_LOCATION)
        if max_hits is not None:
            kept_before = np.cumsum(keep) - keep
            first = np.searchsorted(index_ray, index_ray)
            keep &= kept_before - kept_before[first] < max_hits
        if return_locations:
            return index_tri[keep], index_ray[keep], locations[keep]
        return index_tri[keep], index_ray[keep]

    def _closest(self, origins, directions, return_locations):
        """Results of `intersects_id` for the closest hits, without much memory beyond them."""
        tree = self._tree()
        n = 0
        index_tri, index_ray = np.empty(len(origins), dtype=np.int64), np.empty(len(origins), dtype=np.int64)
        locations = np.empty((len(origins) if return_locations else 0, 3))
        for rays in _slices(len(origins), _RAYS_PER_SLICE):
            closest = tree.closest(origins[rays], directions[rays])
            found = np.flatnonzero(closest.hit)
            hits = slice(n, n + len(found))
            index_tri[hits] = closest.primitive[found]
            np.add(found, rays.start, out=index_ray[hits])
            if return_locations:
                # Interpolated between vertices: exact to rounding, however far away the ray starts.
                tree._geometry.interpolate(index_tri[hits], closest.uv[found], locations[hits])
            n = hits.stop
        # In place: the memory that was never written is given back without a copy.
        index_tri.resize(n, refcheck=False)
        index_ray.resize(n, refcheck=False)
        if not return_locations:
            return index_tri, index_ray
        locations.resize((n, 3), refcheck=False)
        return index_tri, index_ray, locations

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, **options: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Locations at which rays hit the mesh. Hits of a ray at one location count once.

        Parameters and options are those of `intersects_id`.

        Returns
        -------
        locations : ndarray of float64, shape (m, 3)
        index_ray : ndarray of int64, shape (m,)
        index_tri : ndarray of int64, shape (m,)
        """
        options["return_locations"] = True
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
        tree = self._tree()
        first = np.empty(len(origins), dtype=np.int64)
        for rays in _slices(len(origins), _RAYS_PER_SLICE):
            first[rays] = tree.closest(origins[rays], directions[rays]).primitive
        return first

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **options: Any) -> np.ndarray:
        """True for each ray that hits the mesh.

        Returns
        -------
        ndarray of bool, shape (n,)
        """
        origins, directions = self._rays(ray_origins, ray_directions)
        return self._tree().any_hit(origins, directions)

    def contains_points(self, points: ArrayLike) -> np.ndarray:
        """True for each point inside the closed mesh or on its surface.

        Parameters
        ----------
        points : array_like, shape (n, 3)

        Returns
        -------
        ndarray of bool, shape (n,)
        """
        points = np.asarray(points, dtype=np.float64)
        if points.size == 0:
            return np.zeros(0, dtype=bool)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points must have the shape (n, 3), not {points.shape}")
        return self._tree().contains(points)

    def __getstate__(self):
        return {"mesh": self.mesh}

    def __setstate__(self, state):
        self.__init__(state["mesh"])

    def __copy__(self):
        return RayMeshIntersector(self.mesh)

    def __deepcopy__(self, memo):
        return RayMeshIntersector(self.mesh)
