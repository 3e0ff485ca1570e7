"""Results of queries."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Hits(NamedTuple):
    """Closest hits, one for each ray.

    Attributes
    ----------
    t : ndarray of float64
        Ray parameters: the hit is at ``origin + t * direction``. ``inf`` where nothing is hit.
    primitive : ndarray of int32
        Numbers of the triangles or spheres in their geometries, -1 where nothing is hit.
    instance : ndarray of int32
        Numbers of the geometries or instances in the scene, -1 where nothing is hit.
    uv : ndarray of float64
        Barycentric weights of the second and third vertex, in an additional last axis of length 2.
    """

    t: NDArray[np.float64]
    primitive: NDArray[np.int32]
    instance: NDArray[np.int32]
    uv: NDArray[np.float64]

    @property
    def hit(self) -> NDArray[np.bool_]:
        """True where something is hit."""
        return self.primitive >= 0


class AllHits(NamedTuple):
    """All hits of all rays, one ray after the other, each in order of t.

    The hits of ray ``i`` are those from ``offsets[i]`` to ``offsets[i + 1] - 1``: compressed sparse rows.

    Attributes
    ----------
    offsets : ndarray of int64
        One more than there are rays.
    t : ndarray of float64
        Ray parameters.
    primitive : ndarray of int32
        Numbers of the triangles or spheres in their geometries.
    instance : ndarray of int32
        Numbers of the geometries or instances in the scene.
    uv : ndarray of float64, shape (n, 2)
        Barycentric weights of the second and third vertex.
    """

    offsets: NDArray[np.int64]
    t: NDArray[np.float64]
    primitive: NDArray[np.int32]
    instance: NDArray[np.int32]
    uv: NDArray[np.float64]

    @property
    def ray(self) -> NDArray[np.int64]:
        """Index of the ray of each hit, among all rays in C order after origins and directions are broadcast.

        It is a row of origins and of directions only if both have the shape (n, 3).
        """
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


class NearestPoints(NamedTuple):
    """Nearest points of surfaces, one for each query.

    Attributes
    ----------
    point : ndarray of float64, shape (..., 3)
        The points, NaN where there is none.
    distance : ndarray of float64
        Distances from the queries, ``inf`` where there is none.
    primitive : ndarray of int32
        Numbers of the triangles or spheres in their geometries, -1 where there is none.
    instance : ndarray of int32
        Numbers of the geometries or instances in the scene, -1 where there is none.
    """

    point: NDArray[np.float64]
    distance: NDArray[np.float64]
    primitive: NDArray[np.int32]
    instance: NDArray[np.int32]
