"""Geometries, scenes and their queries."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _rt
from ._locks import Lock
from ._results import AllHits, Hits, NearestPoints

if TYPE_CHECKING:
    from typing_extensions import Self


class _Queries:
    """Queries that geometries and scenes have in common."""

    __slots__ = ()

    def _core(self) -> _rt.Scene:
        raise NotImplementedError

    def closest(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: SupportsIndex | None = None,
    ) -> Hits:
        """Closest hit of each ray.

        Parameters
        ----------
        origins, directions : array_like, shape (..., 3)
            Rays, in single or double precision. The leading axes broadcast, so that one origin serves many directions.
            Directions of any length other than zero; rays with the direction zero hit nothing.
        t_min, t_max : float or array_like
            Hits count from `t_min` to `t_max`, both inclusive, in multiples of the direction.
            `t_min` is inclusive up to rounding of `t`.
        threads : int, optional
            Number of threads, by default all processors. Results do not depend on it.

        Returns
        -------
        Hits
            ``t``, ``primitive``, ``instance`` and ``uv``, in the shape of the leading axes. Of hits at equal ``t``, the
            lowest (instance, primitive) counts.

        Raises
        ------
        ValueError
            If shapes do not fit together, if a number of a ray is NaN or infinite, or if a limit is NaN. The message names
            its row: the index in the array with its leading axes flattened, after it is broadcast.

        Examples
        --------
        >>> import rt
        >>> mesh = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> hits = mesh.closest([[0.25, 0.25, 2.0], [2.0, 2.0, 2.0]], [0, 0, -1])
        >>> hits.t, hits.primitive
        (array([ 2., inf]), array([ 0, -1], dtype=int32))
        """
        origins, directions, shape = _arrays.rays(origins, directions)
        limits = _arrays.parameters("t_min", t_min, shape), _arrays.parameters("t_max", t_max, shape)
        count = _arrays.thread_count(threads)
        t, primitive, instance, uv = self._core().closest(origins, directions, *limits, count)
        ids = _arrays.ids(primitive, shape), _arrays.ids(instance, shape)
        return Hits(t.reshape(shape), *ids, uv.reshape(*shape, 2))

    def any_hit(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: SupportsIndex | None = None,
    ) -> NDArray[np.bool_]:
        """True for each ray that hits anything, which is faster than the closest hit.

        Parameters and errors are those of `closest`.

        Returns
        -------
        ndarray of bool
        """
        origins, directions, shape = _arrays.rays(origins, directions)
        limits = _arrays.parameters("t_min", t_min, shape), _arrays.parameters("t_max", t_max, shape)
        return self._core().any_hit(origins, directions, *limits, _arrays.thread_count(threads)).reshape(shape)

    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: SupportsIndex | None = None,
    ) -> AllHits:
        """All hits of each ray, each once, in order of t. A sphere is hit twice.

        Edges and vertices belong to all of their triangles: a ray that passes exactly through an edge hits both.
        Parameters and errors are those of `closest`.

        Returns
        -------
        AllHits
            Compressed sparse rows over the rays in C order, after origins and directions are broadcast.
        """
        origins, directions, shape = _arrays.rays(origins, directions)
        limits = _arrays.parameters("t_min", t_min, shape), _arrays.parameters("t_max", t_max, shape)
        count = _arrays.thread_count(threads)
        offsets, t, primitive, instance, uv = self._core().all_hits(origins, directions, *limits, count)
        return AllHits(offsets, t, primitive.view(np.int32), instance.view(np.int32), uv.reshape(-1, 2))

    def count_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: SupportsIndex | None = None,
    ) -> NDArray[np.int32]:
        """Number of hits of each ray, as `all_hits` lists them.

        Parameters and errors are those of `closest`.

        Returns
        -------
        ndarray of int32
        """
        origins, directions, shape = _arrays.rays(origins, directions)
        limits = _arrays.parameters("t_min", t_min, shape), _arrays.parameters("t_max", t_max, shape)
        counts = self._core().count_hits(origins, directions, *limits, _arrays.thread_count(threads))
        return _arrays.ids(counts, shape)

    def nearest_point(
        self, points: ArrayLike, *, max_distance: SupportsFloat = np.inf, threads: SupportsIndex | None = None
    ) -> NearestPoints:
        """Point of the surface nearest to each point.

        Parameters
        ----------
        points : array_like, shape (..., 3)
            Coordinates up to 1e60 in magnitude. Farther points have no nearest point.
        max_distance : float
            Farther surfaces do not count.
        threads : int, optional

        Returns
        -------
        NearestPoints

        Raises
        ------
        ValueError
            If a coordinate is NaN or infinite, or `max_distance` is NaN. The message names the row.
        """
        points = _arrays.vectors("points", points)
        shape = points.shape[:-1]
        count = _arrays.thread_count(threads)
        nearest, distance, primitive, instance = self._core().nearest_point(
            points.reshape(-1, 3), _arrays.number("max_distance", max_distance), count
        )
        ids = _arrays.ids(primitive, shape), _arrays.ids(instance, shape)
        return NearestPoints(nearest.reshape(*shape, 3), distance.reshape(shape), *ids)

    def contains(self, points: ArrayLike, *, threads: SupportsIndex | None = None) -> NDArray[np.bool_]:
        """True for each point inside a closed mesh or a sphere, or on its surface.

        A point is inside a mesh if a ray from it crosses the surface an odd number of times. Crossings are decided
        exactly. For a mesh with holes the answer depends on the direction of that ray.

        Returns
        -------
        ndarray of bool
        """
        points = _arrays.vectors("points", points)
        inside = self._core().contains(points.reshape(-1, 3), _arrays.thread_count(threads))
        return inside.reshape(points.shape[:-1])

    def signed_distance(self, points: ArrayLike, *, threads: SupportsIndex | None = None) -> NDArray[np.float64]:
        """Distance of each point from the nearest surface: negative inside, as by `contains`; ``inf`` without a surface.

        Points with a coordinate beyond 1e60 in magnitude have the distance ``inf``.

        Returns
        -------
        ndarray of float64
        """
        points = _arrays.vectors("points", points)
        distance = self._core().signed_distance(points.reshape(-1, 3), _arrays.thread_count(threads))
        return distance.reshape(points.shape[:-1])


class _Geometry(_Queries):
    """A geometry, which is a scene of its own as soon as it is queried."""

    __slots__ = ("__weakref__", "_geometry", "_lock", "_scene", "quality")

    quality: str
    _geometry: _rt.Mesh | _rt.SphereSet
    _scene: _rt.Scene | None

    def __init__(self, geometry: _rt.Mesh | _rt.SphereSet, quality: str) -> None:
        self._geometry = geometry
        self._lock = Lock(reentrant=True)
        self._scene = None
        _rt.check_quality(quality)
        self.quality = quality

    def _core(self) -> _rt.Scene:
        with self._lock:
            if self._scene is None:
                self._scene = _rt.Scene([(0, self._geometry)], [(0, None)], self.quality)
            return self._scene

    def _arguments(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """Arrays of which the class makes an equal geometry."""
        raise NotImplementedError

    def __bool__(self) -> bool:
        return True

    def __reduce__(self) -> tuple[Any, ...]:
        return _geometry_from, (type(self), self._arguments(), self.quality)

    # A geometry never changes.
    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: object) -> Self:
        return self


def _geometry_from(
    of_type: type[TriangleMesh] | type[Spheres], arguments: tuple[NDArray[Any], NDArray[Any]], quality: str
) -> TriangleMesh | Spheres:
    """The geometry of a pickle."""
    return of_type(*arguments, quality=quality)


class TriangleMesh(_Geometry):
    """Triangles over shared vertices. The arrays are copied and never changed.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Vertices in single or double precision, which are used exactly.
    faces : array_like of int, shape (m, 3)
        Vertices of each triangle. Triangles without area are kept, so that numbers of triangles are rows of `faces`,
        and never hit.
    quality : {'fast', 'balanced', 'high'}
        Time to build the tree against time to trace rays.

    Raises
    ------
    ValueError
        For a vertex that is not finite, or beyond 1e60 in magnitude, and for an index without a vertex. The message names
        the vertex or the triangle by its row.

    Examples
    --------
    >>> import rt
    >>> mesh = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh.any_hit([0.2, 0.2, 1.0], [[0, 0, -1], [0, 0, 1]])
    array([ True, False])
    """

    __slots__ = ("n_faces", "n_vertices")

    _geometry: _rt.Mesh

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, *, quality: str = "balanced") -> None:
        corners, triangles = self._checked(vertices), _arrays.faces(faces)
        super().__init__(_rt.Mesh(corners, triangles), quality)
        self.n_vertices = len(corners)
        self.n_faces = len(triangles)

    @staticmethod
    def _checked(vertices: ArrayLike) -> NDArray[Any]:
        array = _arrays.numbers("vertices", vertices)
        array = _arrays.vectors("vertices", array if array.size else np.empty((0, 3)))
        if array.ndim != 2:
            raise ValueError(f"vertices must have the shape (n, 3), not {array.shape}")
        return array

    def _with_vertices(self, vertices: ArrayLike) -> TriangleMesh:
        array = self._checked(vertices)
        mesh = TriangleMesh.__new__(TriangleMesh)
        _Geometry.__init__(mesh, self._geometry.with_vertices(array), self.quality)
        mesh.n_vertices, mesh.n_faces = len(array), self.n_faces
        return mesh

    @property
    def vertices(self) -> NDArray[Any]:
        """Copy of the vertices, in single precision if it holds all of them exactly."""
        return self._geometry.vertices().reshape(-1, 3)

    @property
    def faces(self) -> NDArray[np.uint32]:
        """Copy of the faces."""
        return self._geometry.faces().reshape(-1, 3)

    def _arguments(self) -> tuple[NDArray[Any], NDArray[Any]]:
        return self.vertices, self.faces

    def __len__(self) -> int:
        return self.n_faces

    def __repr__(self) -> str:
        return f"<rt.TriangleMesh: {self.n_faces} triangles, {self.n_vertices} vertices>"


class Spheres(_Geometry):
    """Spheres, whose hits are numbered by row.

    Parameters
    ----------
    centres : array_like, shape (n, 3)
    radii : float or array_like, shape (n,)
        Positive; a single one serves all spheres.
    quality : {'fast', 'balanced', 'high'}

    Raises
    ------
    ValueError
        For a radius that is not positive and for numbers that are not finite. The message names the sphere by its row.
    """

    __slots__ = ("n_spheres",)

    _geometry: _rt.SphereSet

    def __init__(self, centres: ArrayLike, radii: ArrayLike, *, quality: str = "balanced") -> None:
        points = np.ascontiguousarray(_arrays.vectors("centres", centres).reshape(-1, 3), dtype=np.float64)
        super().__init__(_rt.SphereSet(points, _arrays.one_for_each("radii", radii, (len(points),))), quality)
        self.n_spheres = len(points)

    @property
    def centres(self) -> NDArray[np.float64]:
        """Copy of the centres."""
        return self._geometry.numbers().reshape(-1, 4)[:, :3]

    @property
    def radii(self) -> NDArray[np.float64]:
        """Copy of the radii."""
        return self._geometry.numbers().reshape(-1, 4)[:, 3]

    def _arguments(self) -> tuple[NDArray[Any], NDArray[Any]]:
        return self.centres, self.radii

    def __len__(self) -> int:
        return self.n_spheres

    def __repr__(self) -> str:
        return f"<rt.Spheres: {self.n_spheres} spheres>"


class Instance:
    """A geometry at another place, without a copy of it. An instance never changes.

    Parameters
    ----------
    geometry : TriangleMesh or Spheres
    transform : array_like, shape (4, 4)
        From the space of the geometry to the space of the scene, for column vectors. Spheres may be moved, rotated, and
        scaled by one factor.
    """

    __slots__ = ("__weakref__", "_geometry", "_transform")

    def __init__(self, geometry: TriangleMesh | Spheres, transform: ArrayLike) -> None:
        if not isinstance(geometry, _Geometry):
            raise TypeError(f"an instance takes a TriangleMesh or Spheres, not {type(geometry).__name__}")
        matrix = _arrays.numbers("a transform", transform).astype(np.float64)
        if matrix.shape != (4, 4):
            raise ValueError(f"a transform has the shape (4, 4), not {matrix.shape}")
        matrix.setflags(write=False)
        self._geometry = geometry
        self._transform = matrix

    @property
    def geometry(self) -> TriangleMesh | Spheres:
        """The geometry that is placed."""
        return self._geometry

    @property
    def transform(self) -> NDArray[np.float64]:
        """The matrix, which is read-only. `Scene.update` moves objects of a scene."""
        return self._transform

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.geometry, self.transform)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: object) -> Self:
        return self

    def __repr__(self) -> str:
        return f"rt.Instance({self.geometry!r}, {self.transform.tolist()})"


def _number(value: SupportsIndex) -> int:
    """Number of an object of a scene."""
    try:
        return operator.index(value)
    except TypeError:
        raise ValueError(f"numbers of objects are integers, not {value!r}") from None


def _geometry_of(item: TriangleMesh | Spheres | Instance) -> TriangleMesh | Spheres:
    return item.geometry if isinstance(item, Instance) else item


class Scene(_Queries):
    """Geometries and instances, queried together.

    Parameters
    ----------
    objects : iterable of TriangleMesh, Spheres and Instance
        Their positions are the numbers of ``instance`` in results. `update` changes them.
    quality : {'fast', 'balanced', 'high'}
        Time to build the trees against time to trace rays.

    Examples
    --------
    >>> import numpy as np, rt
    >>> ball = rt.Spheres([[0, 0, 0]], 1.0)
    >>> moved = np.eye(4); moved[0, 3] = 10
    >>> scene = rt.Scene([ball, rt.Instance(ball, moved)])
    >>> hits = scene.closest([[0, 0, 5], [10, 0, 5]], [0, 0, -1])
    >>> hits.t, hits.instance
    (array([4., 4.]), array([0, 1], dtype=int32))
    """

    __slots__ = ("__weakref__", "_geometries", "_lock", "_n_geometries", "_objects", "_quality", "_scene")

    def __init__(
        self,
        objects: TriangleMesh | Spheres | Instance | Iterable[TriangleMesh | Spheres | Instance],
        *,
        quality: str = "balanced",
    ) -> None:
        if isinstance(objects, (_Geometry, Instance)):
            objects = [objects]
        self._lock = Lock()
        # By identity: the geometries that are placed, with their keys. Keys are not used again.
        self._geometries: dict[int, tuple[int, TriangleMesh | Spheres]] = {}
        self._n_geometries = 0
        self._objects: dict[int, TriangleMesh | Spheres | Instance] = dict(enumerate(objects))
        self._scene = _rt.Scene(*self._added(self._objects.values(), ""), quality)
        self._quality = quality

    def _added(
        self, objects: Iterable[TriangleMesh | Spheres | Instance], argument: str
    ) -> tuple[list[tuple[int, _rt.Mesh | _rt.SphereSet]], list[tuple[int, NDArray[np.float64] | None]]]:
        """New geometries with their keys, and the key of the geometry and the transform of each object.

        `argument` names the list of objects in messages.
        """
        geometries: list[tuple[int, _rt.Mesh | _rt.SphereSet]] = []
        instances: list[tuple[int, NDArray[np.float64] | None]] = []
        for i, item in enumerate(objects):
            geometry = _geometry_of(item)
            if not isinstance(geometry, _Geometry):
                raise TypeError(f"object {i}{argument} is a {type(item).__name__}, not a TriangleMesh, Spheres or Instance")
            if id(geometry) not in self._geometries:
                self._geometries[id(geometry)] = (self._n_geometries, geometry)
                geometries.append((self._n_geometries, geometry._geometry))
                self._n_geometries += 1
            instances.append((self._geometries[id(geometry)][0], item.transform if isinstance(item, Instance) else None))
        return geometries, instances

    def update(
        self,
        *,
        insert: TriangleMesh | Spheres | Instance | Iterable[TriangleMesh | Spheres | Instance] = (),
        remove: Iterable[SupportsIndex] = (),
        transforms: Mapping[Any, ArrayLike] | None = None,
        vertices: Mapping[Any, ArrayLike] | None = None,
    ) -> list[int]:
        """Changes objects without building the trees of the others again.

        The tree over the objects is built once for each call, so one call with many changes is faster than many calls.
        Queries in other threads see the scene before or after all changes of a call, and calls in several threads follow each
        other.

        Parameters
        ----------
        insert : iterable of TriangleMesh, Spheres and Instance
            Objects to add. They get the lowest numbers that are free after `remove`.
        remove : iterable of int
            Numbers of objects to remove. The numbers of others stay. A geometry without objects frees its memory.
        transforms : mapping from int to array_like of shape (4, 4)
            New transform by number of the object, which replaces the former one.
        vertices : mapping from int to array_like of shape (n, 3)
            New vertices by number of the object, which has to be a mesh; its triangles stay. All objects of the scene with
            the same mesh change, and no other scene. The tree is refitted, or built again if refitting made it too slow.

        Returns
        -------
        list of int
            Numbers of the inserted objects.

        Raises
        ------
        KeyError
            For a number without an object.
        ValueError
            For vertices and transforms that do not fit, for numbers that are no integers, and for vertices of one mesh
            given twice. The scene is unchanged then.

        Examples
        --------
        >>> import numpy as np, rt
        >>> ball = rt.Spheres([[0, 0, 0]], 1.0)
        >>> scene = rt.Scene([ball])
        >>> raised = np.eye(4); raised[2, 3] = 2
        >>> scene.update(insert=[rt.Instance(ball, raised)])
        [1]
        >>> scene.closest([0, 0, 5], [0, 0, -1]).t
        array(2.)
        >>> scene.update(remove=[1])
        []
        >>> scene.closest([0, 0, 5], [0, 0, -1]).t
        array(4.)
        """
        inserted = [insert] if isinstance(insert, (_Geometry, Instance)) else list(insert)
        removed = [_number(number) for number in remove]
        matrices = {_number(number): matrix for number, matrix in (transforms or {}).items()}
        of_meshes = {_number(number): of_mesh for number, of_mesh in (vertices or {}).items()}
        with self._lock:
            return self._update(inserted, removed, matrices, of_meshes)

    def _update(
        self,
        insert: list[TriangleMesh | Spheres | Instance],
        remove: list[int],
        transforms: dict[int, ArrayLike],
        vertices: dict[int, ArrayLike],
    ) -> list[int]:
        changed = Scene.__new__(Scene)
        changed._geometries, changed._n_geometries = dict(self._geometries), self._n_geometries
        changed._objects = dict(self._objects)
        for number in (*vertices, *transforms, *remove):
            if number not in self._objects:
                raise KeyError(f"there is no object {number}")
        first: dict[int, int] = {}
        for number in vertices:
            other = first.setdefault(id(_geometry_of(self._objects[number])), number)
            if other != number:
                raise ValueError(f"objects {other} and {number} share a mesh: give its vertices once")
        new_meshes = [changed._set_vertices(number, of_object) for number, of_object in vertices.items()]
        new_transforms = [changed._set_transform(number, matrix) for number, matrix in transforms.items()]
        for number in remove:
            if changed._objects.pop(number, None) is None:
                raise ValueError(f"object {number} is removed twice")
        unused = changed._drop_unused()
        geometries, instances = changed._added(insert, " of insert")
        scene, numbers = self._scene.updated(
            new_meshes, new_transforms, remove, unused, geometries, instances
        )
        changed._objects.update(zip(numbers, insert, strict=True))
        self._objects = dict(sorted(changed._objects.items()))
        self._geometries, self._n_geometries, self._scene = changed._geometries, changed._n_geometries, scene
        return numbers

    def _set_vertices(self, number: int, vertices: ArrayLike) -> tuple[int, _rt.Mesh]:
        """Replaces the mesh of an object and of all that share it. Returns its key and the new arrays."""
        item = self._objects[number]
        old = _geometry_of(item)
        if not isinstance(old, TriangleMesh):
            raise ValueError(f"object {number} has no vertices: {old!r}")
        try:
            new = old._with_vertices(vertices)
        except ValueError as error:
            raise ValueError(f"object {number}: {error}") from None
        index, _ = self._geometries.pop(id(old))
        self._geometries[id(new)] = (index, new)
        for other, placed in self._objects.items():
            if placed is old:
                self._objects[other] = new
            elif isinstance(placed, Instance) and placed.geometry is old:
                self._objects[other] = Instance(new, placed.transform)
        return index, new._geometry

    def _set_transform(self, number: int, transform: ArrayLike) -> tuple[int, NDArray[np.float64]]:
        item = self._objects[number]
        try:
            moved = Instance(_geometry_of(item), transform)
        except ValueError as error:
            raise ValueError(f"object {number}: {error}") from None
        self._objects[number] = moved
        return number, moved.transform

    def _drop_unused(self) -> list[int]:
        """Removes geometries without objects. Returns their keys."""
        used = {id(_geometry_of(item)) for item in self._objects.values()}
        unused = {key: index for key, (index, _) in self._geometries.items() if key not in used}
        for key in unused:
            del self._geometries[key]
        return list(unused.values())

    @property
    def objects(self) -> tuple[TriangleMesh | Spheres | Instance, ...]:
        """The objects in the order of their numbers."""
        return tuple(self._objects.values())

    @property
    def numbers(self) -> tuple[int, ...]:
        """The numbers of the objects, ascending: ``instance`` in results. Without `update`, these are 0, 1, 2, ..."""
        return tuple(self._objects)

    def _core(self) -> _rt.Scene:
        return self._scene

    def __len__(self) -> int:
        return len(self._objects)

    def __bool__(self) -> bool:
        return True

    def __reduce__(self) -> tuple[Any, ...]:
        with self._lock:
            return _scene_from, (type(self), dict(self._objects), self._quality)

    def __copy__(self) -> Self:
        copied = type(self).__new__(type(self))
        copied._lock = Lock()
        with self._lock:
            copied._geometries, copied._n_geometries = dict(self._geometries), self._n_geometries
            copied._objects, copied._scene, copied._quality = dict(self._objects), self._scene, self._quality
        return copied

    def __deepcopy__(self, memo: object) -> Self:
        # Geometries, instances and trees never change.
        return self.__copy__()

    def __repr__(self) -> str:
        return f"<rt.Scene: {len(self._objects)} objects>"


def _scene_from(
    of_type: type[Scene], objects: dict[int, TriangleMesh | Spheres | Instance], quality: str
) -> Scene:
    """The scene of a pickle: objects by number."""
    nothing = Spheres([], [])
    unused = [number for number in range(max(objects, default=-1)) if number not in objects]
    scene = of_type([objects.get(number, nothing) for number in range(len(objects) + len(unused))], quality=quality)
    if unused:
        scene.update(remove=unused)
    return scene
