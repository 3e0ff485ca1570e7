"""Images of scene files and geometry."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _rt, _scene_file
from ._scene import Scene, Spheres, TriangleMesh


class Image(np.ndarray):
    """Linear radiance of shape (height, width, 3) in single precision, with what is known about it.

    Attributes
    ----------
    statistics : dict
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
    """

    statistics: dict
    error: float | None
    error_interval: tuple[float, float] | None
    samples_per_pixel: float
    stopped: str

    def __array_finalize__(self, source):
        for name in ("statistics", "error", "error_interval", "samples_per_pixel", "stopped"):
            setattr(self, name, getattr(source, name, None))


def render(
    scene: str | os.PathLike[str] | Scene | TriangleMesh | Spheres,
    *,
    spp: int | None = None,
    size: tuple[int, int] | None = None,
    look_from: ArrayLike | None = None,
    look_at: ArrayLike | None = None,
    fov: float | None = None,
    seed: int | None = None,
    integrator: str | None = None,
    depth: int | None = None,
    time: float | None = None,
    target_error: float | None = None,
    threads: int | None = None,
) -> Image:
    """Renders a scene.

    Parameters
    ----------
    scene : str or path, Scene, TriangleMesh or Spheres
        A file: a scene in ``.ron`` or ``.json``, or a model in glTF, OBJ, PLY, STL, NFF or pbrt format. Or geometry, which
        is gray, lit by studio lights, and has its vertices rounded to single precision.
    spp : int, optional
        Samples per pixel, by default those of the scene. With `time` or `target_error`, the largest number.
    size : tuple of int, optional
        Width and height.
    look_from, look_at : array_like, optional
        Position of the camera and its target, for geometry; by default the whole object is shown.
    fov : float, optional
        Vertical opening angle of the camera in degrees, for geometry.
    seed : int, optional
        Seed of all random numbers. Equal seeds give equal images, on any number of threads.
    integrator : str, optional
        Such as ``'path'`` or ``'whitted'``.
    depth : int, optional
        Largest number of bounces.
    time : float, optional
        Seconds after which the render ends.
    target_error : float, optional
        Estimated relative error at which the render ends, such as 0.02.
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
    """
    if size is not None:
        width, height = size
        size = (int(width), int(height))
    options = dict(
        spp=spp, size=size, seed=seed, integrator=integrator, depth=depth, time=time, target_error=target_error,
        threads=_arrays.thread_count(threads),
    )
    camera = _camera(look_from, look_at, fov)
    if isinstance(scene, (Scene, TriangleMesh, Spheres)):
        with tempfile.TemporaryDirectory() as folder:
            rendering = _rt.render(os.fspath(_scene_file.write(Path(folder), scene, camera)), **options)
    elif camera:
        raise ValueError("look_from, look_at and fov are for geometry; a scene file has cameras of its own")
    else:
        rendering = _rt.render(os.fspath(scene), **options)
    image = rendering.pixels().reshape(rendering.height, rendering.width, 3).view(Image)
    image.statistics = dict(rendering.statistics)
    image.error, image.error_interval = rendering.error or (None, None)
    image.samples_per_pixel = rendering.samples_per_pixel[1]
    image.stopped = rendering.stopped
    return image


def _camera(look_from: ArrayLike | None, look_at: ArrayLike | None, fov: float | None) -> dict[str, object]:
    camera: dict[str, object] = {}
    for name, value in [("look_from", look_from), ("look_at", look_at)]:
        if value is not None:
            point = _arrays.vectors(name, value)
            if point.shape != (3,):
                raise ValueError(f"{name} must be one point, not an array of shape {point.shape}")
            camera[name] = point.astype(np.float64).tolist()
    if look_at is not None and look_from is None:
        raise ValueError("look_at needs look_from")
    if fov is not None:
        camera["fov"] = float(fov)
    return camera


class ConvergenceRow(NamedTuple):
    """One line of the table of `converge`.

    Attributes
    ----------
    spp : int
        Samples per pixel.
    seconds : float
        Mean wall-clock time to render, without loading and building.
    relative_rmse : float
        Root mean square error against the reference, over the mean radiance of the reference.
    estimated : float or None
        The mean of the errors that the images themselves estimate.
    bias : float
        Mean difference from the reference, over the mean radiance of the reference.
    """

    spp: int
    seconds: float
    relative_rmse: float
    estimated: float | None
    bias: float


def converge(
    scene: str | os.PathLike[str] | Scene | TriangleMesh | Spheres,
    *,
    spp: Sequence[int] = (1, 4, 16, 64),
    reference_spp: int | None = None,
    seeds: int = 4,
    **options: Any,
) -> list[ConvergenceRow]:
    """Error against run time: renders with rising numbers of samples and compares with a reference.

    Parameters
    ----------
    scene : str or path, Scene, TriangleMesh or Spheres
    spp : sequence of int
        Samples per pixel of each line of the table.
    reference_spp : int, optional
        Samples per pixel of the reference, by default 16 times the largest of `spp`. Its own error is part of the
        result: it adds about 3 % to the error of the last line.
    seeds : int
        Images for each line; their squared errors are averaged.
    options
        Further options of `render`, such as `size` and `integrator`.

    Returns
    -------
    list of ConvergenceRow
    """
    spp = [int(count) for count in spp]
    if not spp or min(spp) < 1 or seeds < 1:
        raise ValueError("spp and seeds must be positive")
    first_seed = options.pop("seed", None) or 0
    reference_spp = reference_spp or 16 * max(spp)
    # A seed of its own: a reference from the same samples would look closer than it is.
    reference = np.asarray(render(scene, spp=reference_spp, seed=first_seed + seeds, **options), dtype=np.float64)
    mean = reference.mean()
    scale = mean if mean > 0 else np.nan
    rows = []
    for count in spp:
        squares, biases, seconds, estimates = [], [], [], []
        for seed in range(first_seed, first_seed + seeds):
            image = render(scene, spp=count, seed=seed, **options)
            difference = np.asarray(image, dtype=np.float64) - reference
            squares.append(np.mean(difference**2))
            biases.append(difference.mean())
            seconds.append(image.statistics["render_seconds"])
            estimates.append(image.error)
        known = [error for error in estimates if error is not None]
        rows.append(
            ConvergenceRow(
                count,
                float(np.mean(seconds)),
                float(np.sqrt(np.mean(squares)) / scale),
                float(np.mean(known)) if known else None,
                float(np.mean(biases) / scale),
            )
        )
    return rows
