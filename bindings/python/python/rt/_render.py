"""Images of scene files and geometry."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterable
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any, Concatenate, Literal, NamedTuple, ParamSpec, SupportsFloat, SupportsIndex, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _rt, _scene_file
from ._scene import Scene, Spheres, TriangleMesh

_Value = TypeVar("_Value")
_Checked = TypeVar("_Checked")
_Limits = ParamSpec("_Limits")


class Image(np.ndarray):
    """Linear radiance of shape (height, width, 3) in single precision, with what is known about it.

    Attributes
    ----------
    statistics : dict of float
        Numbers of samples and rays, and seconds.
    error : float or None
        Estimated root mean square error of this image over its mean radiance, without bias of the method. `None` if the
        samples give no estimate.
    error_interval : tuple of float or None
        Interval that holds `error` with a confidence of 95 %.
    samples_per_pixel : float
        Mean over the pixels.
    stopped : str
        Why the render ended: ``'samples'``, ``'time'`` or ``'target'``.

    Copies and pickles of the image keep these attributes. They are `None` in other arrays that are made from it, such as
    crops and products.
    """

    statistics: dict[str, float] | None
    error: float | None
    error_interval: tuple[float, float] | None
    samples_per_pixel: float | None
    stopped: str | None

    def __array_finalize__(self, source: object) -> None:
        vars(self).update(dict.fromkeys(("statistics", "error", "error_interval", "samples_per_pixel", "stopped")))

    def copy(self, order: Literal["K", "A", "C", "F"] | None = "C") -> Image:
        """Copy of the pixels and the attributes."""
        copied = super().copy(order)
        vars(copied).update(deepcopy(vars(self)))
        return copied

    def __copy__(self) -> Image:
        return self.copy("K")

    def __deepcopy__(self, memo: object) -> Image:
        return self.copy("K")

    def __reduce__(self) -> tuple[Any, ...]:
        function, arguments, state = tuple(super().__reduce__())
        return function, arguments, (state, vars(self))

    def __setstate__(self, state: Any) -> None:
        array, attributes = state
        super().__setstate__(array)
        vars(self).update(attributes)


def render(
    scene: str | os.PathLike[str] | Scene | TriangleMesh | Spheres,
    *,
    spp: SupportsIndex | None = None,
    size: Iterable[SupportsIndex] | None = None,
    look_from: ArrayLike | None = None,
    look_at: ArrayLike | None = None,
    up: ArrayLike | None = None,
    fov: SupportsFloat | None = None,
    seed: SupportsIndex | None = None,
    integrator: str | None = None,
    depth: SupportsIndex | None = None,
    time: SupportsFloat | None = None,
    target_error: SupportsFloat | None = None,
    threads: SupportsIndex | None = None,
) -> Image:
    """Renders a scene.

    Parameters
    ----------
    scene : str or path, Scene, TriangleMesh or Spheres
        A file: a scene in ``.ron`` or ``.json``, or a model in glTF, OBJ, PLY, STL, NFF or pbrt format. Or geometry, which
        is gray and lit by studio lights. Its vertices are rounded to single precision, those of meshes far from the
        origin relative to a centre. Triangles without area are left out.
    spp : int, optional
        Samples per pixel, by default those of the scene. With `time` or `target_error`, the largest number: by default
        4096 with `target_error`, and 1,048,576 with `time` alone. Numbers that do not suit the sample pattern are rounded
        up, as 3 to 4: ``samples_per_pixel`` of the image is the actual one.
    size : iterable of int, optional
        Width and height.
    look_from, look_at : array_like, optional
        Position of the camera and its target, for geometry. With `look_from` alone, the target is the centre of the
        bounds. By default the whole object is shown.
    up : array_like, optional
        Direction that is up in the image, for geometry with `look_from`. By default the y axis, or the z axis for a view
        along y.
    fov : float, optional
        Vertical opening angle of the camera in degrees, for geometry.
    seed : int, optional
        Seed of all random numbers. Equal seeds give equal images, on any number of threads.
    integrator : str, optional
        Such as ``'path'`` or ``'whitted'``.
    depth : int, optional
        Largest number of bounces.
    time : float, optional
        Seconds after which the render ends, positive. It ends earlier at the largest number of samples per pixel.
    target_error : float, optional
        Estimated relative error at which the render ends, positive, such as 0.02. It ends earlier at the largest number
        of samples per pixel: ``stopped`` of the image is ``'samples'`` then.
    threads : int, optional
        Number of threads, by default all processors.

    Returns
    -------
    Image
        An array of shape (height, width, 3) in single precision.

    Raises
    ------
    ValueError
        If the scene cannot be loaded or an option is not valid. The message says where.

    A signal handler may end the render by an exception, as Ctrl-C does.
    """
    rendered = partial(
        _rt.render,
        spp=_optional(_arrays.integer, "spp", spp, 1, 2**32 - 1),
        size=_optional(_size, "size", size),
        seed=_optional(_arrays.integer, "seed", seed, 0, 2**64 - 1),
        integrator=integrator,
        depth=_optional(_arrays.integer, "depth", depth, 0, 2**32 - 1),
        time=_optional(_arrays.positive, "time", time),
        target_error=_optional(_arrays.positive, "target_error", target_error),
        threads=_arrays.thread_count(threads),
    )
    if isinstance(scene, (Scene, TriangleMesh, Spheres)) and look_from is not None and look_at is None:
        look_at = _scene_file.centre(scene)
    camera = _camera(look_from, look_at, up, fov)
    if isinstance(scene, (Scene, TriangleMesh, Spheres)):
        with tempfile.TemporaryDirectory() as folder:
            path = _scene_file.write(Path(folder), scene, camera)
            try:
                rendering = rendered(os.fspath(path))
            except ValueError as error:
                raise ValueError(_of_arguments(str(error), folder)) from None
    elif camera:
        raise ValueError("look_from, look_at, up and fov are for geometry; a scene file has cameras of its own")
    else:
        rendering = rendered(os.fspath(scene))
    image = rendering.pixels().reshape(rendering.height, rendering.width, 3).view(Image)
    image.statistics = dict(rendering.statistics)
    image.error, image.error_interval = rendering.error or (None, None)
    image.samples_per_pixel = rendering.samples_per_pixel[1]
    image.stopped = rendering.stopped
    return image


def _of_arguments(message: str, folder: str) -> str:
    """Message about the files in a temporary folder, in terms of the arguments of `render`."""
    message = re.sub(rf"{re.escape(folder)}\S*?: ", "", message)
    # Excerpts of the scene file: a line of text, and a line that marks the place.
    message = re.sub(r"\n *\d+ \|.*\n *\|.*", "", message)
    message = re.sub(r"^(camera|film|settings)(\.|: )", "", message, flags=re.M)
    return re.sub(r"^(nodes|groups)[^:\n]*: ", "scene: ", message, flags=re.M)


def _optional(
    check: Callable[Concatenate[str, _Value, _Limits], _Checked],
    what: str,
    value: _Value | None,
    *limits: _Limits.args,
    **options: _Limits.kwargs,
) -> _Checked | None:
    return None if value is None else check(what, value, *limits, **options)


def _size(what: str, size: Iterable[SupportsIndex]) -> tuple[int, int]:
    try:
        width, height = size
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be a width and a height, not {size!r}") from None
    limits = 1, 2**32 - 1
    return _arrays.integer(f"the width of {what}", width, *limits), _arrays.integer(f"the height of {what}", height, *limits)


def _camera(
    look_from: ArrayLike | None, look_at: ArrayLike | None, up: ArrayLike | None, fov: SupportsFloat | None
) -> dict[str, object]:
    given = {"look_from": look_from, "look_at": look_at, "up": up}
    points = {name: _point(name, value) for name, value in given.items() if value is not None}
    for name in ("look_at", "up"):
        if name in points and look_from is None:
            raise ValueError(f"{name} needs look_from")
    if points:
        eye, target = points["look_from"], points.get("look_at", np.zeros(3))
        if (eye == target).all():
            raise ValueError("look_from and look_at are the same point")
        # Half of each, so that the difference stays in range.
        view = 0.5 * target - 0.5 * eye
        if "up" not in points and not view[[0, 2]].any():
            points["up"] = np.array([0.0, 0.0, 1.0])
        if "up" in points and not np.cross(_unit(points["up"]), _unit(view)).any():
            raise ValueError(f"up {points['up'].tolist()} is zero or parallel to the view from look_from to look_at")
    camera: dict[str, object] = {name: point.tolist() for name, point in points.items()}
    if fov is not None:
        camera["fov"] = _arrays.positive("fov", fov, 180)
    return camera


def _unit(vector: NDArray[np.float64]) -> NDArray[Any]:
    """The vector divided by its largest coordinate, so that products stay in range."""
    return vector / (np.abs(vector).max() or 1.0)


def _point(what: str, value: ArrayLike) -> NDArray[np.float64]:
    point = _arrays.vectors(what, value).astype(np.float64)
    if point.shape != (3,):
        raise ValueError(f"{what} must be one point, not an array of shape {point.shape}")
    if not np.isfinite(point).all():
        raise ValueError(f"{what} {point.tolist()} holds a number that is not finite")
    return point


class ConvergenceRow(NamedTuple):
    """One line of the table of `converge`.

    Attributes
    ----------
    spp : float
        Samples per pixel that were rendered, the mean over the images.
    seconds : float
        Mean wall-clock time to render, without loading and building.
    relative_rmse : float
        Root mean square error against the reference, over the mean radiance of the reference.
    estimated : float or None
        The mean of the errors that the images themselves estimate.
    bias : float
        Mean difference from the reference, over the mean radiance of the reference.
    """

    spp: float
    seconds: float
    relative_rmse: float
    estimated: float | None
    bias: float


def converge(
    scene: str | os.PathLike[str] | Scene | TriangleMesh | Spheres,
    *,
    spp: Iterable[SupportsIndex] = (1, 4, 16, 64),
    reference_spp: SupportsIndex | None = None,
    seeds: SupportsIndex = 4,
    **options: Any,
) -> list[ConvergenceRow]:
    """Error against run time: renders with rising numbers of samples and compares with a reference.

    Parameters
    ----------
    scene : str or path, Scene, TriangleMesh or Spheres
    spp : iterable of int
        Samples per pixel of each line of the table. `render` rounds them up to what the sample pattern needs.
    reference_spp : int, optional
        Samples per pixel of the reference, by default 16 times the largest of `spp`. Its own error is part of the
        result: it adds about 3 % to the error of the last line.
    seeds : int
        Images for each line; their squared errors are averaged.
    options
        Further options of `render`, such as `size` and `integrator`. The reference ignores `time` and `target_error`.

    Returns
    -------
    list of ConvergenceRow
    """
    most = 2**32 - 1
    sample_counts = [_arrays.integer("spp", count, 1, most) for count in spp]
    if not sample_counts:
        raise ValueError("spp must hold a number of samples")
    seeds = _arrays.integer("seeds", seeds, 1, most)
    # Each image needs it: an iterator would be empty after the first one.
    options["size"] = _optional(_size, "size", options.get("size"))
    first_seed = options.pop("seed", None)
    first_seed = 0 if first_seed is None else _arrays.integer("seed", first_seed, 0, 2**64 - 1)
    if first_seed + seeds >= 2**64:
        message = f"seed {first_seed} is too large for {seeds} seeds: the reference has the seed {first_seed + seeds}"
        raise ValueError(f"{message}, and the largest one is {2**64 - 1}")
    of_caller = _optional(_arrays.integer, "reference_spp", reference_spp, 1, most)
    samples = of_caller or min(16 * max(sample_counts), most)
    # A seed of its own: a reference from the same samples would look closer than it is. All of its samples are taken.
    of_reference = {name: value for name, value in options.items() if name not in ("time", "target_error")}
    reference = np.asarray(render(scene, spp=samples, seed=first_seed + seeds, **of_reference), dtype=np.float64)
    mean = reference.mean()
    scale = mean if mean > 0 else np.nan
    rows = []
    for count in sample_counts:
        squares, biases, seconds, estimates, counts = [], [], [], [], []
        for seed in range(first_seed, first_seed + seeds):
            image = render(scene, spp=count, seed=seed, **options)
            difference = np.asarray(image, dtype=np.float64) - reference
            squares.append(np.mean(difference**2))
            biases.append(difference.mean())
            estimates.append(image.error)
            # Only arrays that are made from an image have none.
            if image.statistics is not None and image.samples_per_pixel is not None:
                seconds.append(image.statistics["render_seconds"])
                counts.append(image.samples_per_pixel)
        known = [error for error in estimates if error is not None]
        rows.append(
            ConvergenceRow(
                float(np.mean(counts)),
                float(np.mean(seconds)),
                float(np.sqrt(np.mean(squares)) / scale),
                float(np.mean(known)) if known else None,
                float(np.mean(biases) / scale),
            )
        )
    return rows
