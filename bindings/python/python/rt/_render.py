"""Images of scene files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from . import _arrays, _rt


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
    scene: str | os.PathLike[str],
    *,
    spp: int | None = None,
    size: tuple[int, int] | None = None,
    seed: int | None = None,
    integrator: str | None = None,
    depth: int | None = None,
    time: float | None = None,
    target_error: float | None = None,
    threads: int | None = None,
) -> Image:
    """Renders a scene file or a model.

    Parameters
    ----------
    scene : str or path
        A scene in ``.ron`` or ``.json``, or a model in glTF, OBJ, PLY, STL, NFF or pbrt format.
    spp : int, optional
        Samples per pixel, by default those of the scene. With `time` or `target_error`, the largest number.
    size : tuple of int, optional
        Width and height.
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
    rendering = _rt.render(
        os.fspath(scene), spp=spp, size=size, seed=seed, integrator=integrator, depth=depth, time=time,
        target_error=target_error, threads=_arrays.thread_count(threads),
    )
    image = rendering.pixels().reshape(rendering.height, rendering.width, 3).view(Image)
    image.statistics = dict(rendering.statistics)
    image.error, image.error_interval = rendering.error or (None, None)
    image.samples_per_pixel = rendering.samples_per_pixel[1]
    image.stopped = rendering.stopped
    return image


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
    scene: str | os.PathLike[str],
    *,
    spp: Sequence[int] = (1, 4, 16, 64),
    reference_spp: int | None = None,
    seeds: int = 4,
    **options: Any,
) -> list[ConvergenceRow]:
    """Error against run time: renders with rising numbers of samples and compares with a reference.

    Parameters
    ----------
    scene : str or path
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
