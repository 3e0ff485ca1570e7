"""Extension module; use the package `rt` instead."""

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

VERSION: str

class Mesh:
    def __new__(cls, vertices: NDArray[Any], faces: NDArray[np.uint32]) -> Mesh: ...
    def with_vertices(self, vertices: NDArray[Any]) -> Mesh: ...
    def vertices(self) -> NDArray[Any]: ...
    def faces(self) -> NDArray[np.uint32]: ...
    def has_area(self, centre: list[float]) -> bool: ...

class SphereSet:
    def __new__(cls, centres: NDArray[np.float64], radii: NDArray[np.float64]) -> SphereSet: ...
    def numbers(self) -> NDArray[np.float64]: ...

def check_quality(quality: str) -> None: ...

_Limit = float | NDArray[np.float64]

class Scene:
    def __new__(
        cls,
        geometries: list[tuple[int, Mesh | SphereSet]],
        instances: list[tuple[int, NDArray[np.float64] | None]],
        quality: str,
    ) -> Scene: ...
    def updated(
        self,
        vertices: list[tuple[int, Mesh]],
        transforms: list[tuple[int, NDArray[np.float64]]],
        removed_instances: list[int],
        removed_geometries: list[int],
        geometries: list[tuple[int, Mesh | SphereSet]],
        instances: list[tuple[int, NDArray[np.float64] | None]],
    ) -> tuple[Scene, list[int]]: ...
    @property
    def memory(self) -> int: ...
    def closest(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: _Limit, t_max: _Limit, threads: int
    ) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float64]]: ...
    def any_hit(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: _Limit, t_max: _Limit, threads: int
    ) -> NDArray[np.bool_]: ...
    def count_hits(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: _Limit, t_max: _Limit, threads: int
    ) -> NDArray[np.uint32]: ...
    def all_hits(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: _Limit, t_max: _Limit, threads: int
    ) -> tuple[
        NDArray[np.int64], NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float64]
    ]: ...
    def nearest_point(
        self, points: NDArray[Any], max_distance: float, threads: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32]]: ...
    def contains(self, points: NDArray[Any], threads: int) -> NDArray[np.bool_]: ...
    def signed_distance(self, points: NDArray[Any], threads: int) -> NDArray[np.float64]: ...

def first_triangles(
    scene: Scene, origins: NDArray[Any], directions: NDArray[Any], threads: int
) -> NDArray[np.int64]: ...
def crossings(
    scene: Scene,
    mesh: Mesh,
    origins: NDArray[Any],
    directions: NDArray[Any],
    max_hits: int,
    with_points: bool,
    threads: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]: ...

class Rendering:
    def pixels(self) -> NDArray[np.float32]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def samples_per_pixel(self) -> tuple[int, float, int]: ...
    @property
    def error(self) -> tuple[float, tuple[float, float]] | None: ...
    @property
    def statistics(self) -> list[tuple[str, float]]: ...
    @property
    def stopped(self) -> str: ...

def render(
    path: str | PathLike[str],
    *,
    spp: int | None,
    size: tuple[int, int] | None,
    seed: int | None,
    integrator: str | None,
    depth: int | None,
    time: float | None,
    target_error: float | None,
    threads: int,
) -> Rendering: ...
