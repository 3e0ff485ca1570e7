"""Arrays of the caller in the shapes that the extension module takes."""

from __future__ import annotations

import numpy as np


def vectors(what, values):
    """Array of shape (..., 3) in single or double precision, without a copy if it has one of them."""
    array = np.asarray(values)
    if array.dtype != np.float32 and array.dtype != np.float64:
        if np.issubdtype(array.dtype, np.complexfloating):
            raise ValueError(f"{what} must be real numbers, not {array.dtype}")
        try:
            array = array.astype(np.float64)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{what} must be numbers, not {array.dtype}") from error
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{what} must have the shape (..., 3), not {array.shape}")
    return array


def rays(origins, directions):
    """Origins and directions of shape (n, 3), with n = 1 for one that serves all rays, and the shape of the results."""
    origins = vectors("origins", origins)
    directions = vectors("directions", directions)
    try:
        shape = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1])
    except ValueError as error:
        message = f"origins of shape {origins.shape} and directions of shape {directions.shape} do not fit together"
        raise ValueError(message) from error
    return _rows(origins, shape), _rows(directions, shape), shape


def _rows(array, shape):
    if array.size == 3:
        return array.reshape(1, 3)
    if array.shape[:-1] != shape:
        array = np.broadcast_to(array, (*shape, 3))
    return array.reshape(-1, 3)


def parameters(what, values, shape):
    """One number for all rays, or a contiguous array of one for each."""
    if np.ndim(values) == 0:
        try:
            return float(values)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{what} must be a number, or an array of one for each, not {values!r}") from error
    try:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=np.float64), shape).reshape(-1))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{what} of shape {np.shape(values)} does not fit the shape {shape}: one number each is needed") from error


def faces(values):
    """Triangles of shape (n, 3) as indices of 32 bits."""
    array = np.asarray(values)
    if array.size == 0:
        return np.empty((0, 3), dtype=np.uint32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces must have the shape (n, 3), not {array.shape}")
    if not np.issubdtype(array.dtype, np.integer):
        raise ValueError(f"faces must be integers, not {array.dtype}")
    if array.dtype != np.uint32:
        bad = np.flatnonzero(((array < 0) | (array > 0xFFFF_FFFF)).any(axis=1))
        if bad.size:
            raise ValueError(f"row {bad[0]} of faces is {array[bad[0]].tolist()}, which are not indices of vertices")
    return array.astype(np.uint32, copy=False)


# That of `rt-cli --threads`. Thousands of threads stall a machine.
MAX_THREADS = 1024


def thread_count(threads):
    """0 for all processors."""
    if threads is None:
        return 0
    count = int(threads)
    if count != threads or not 1 <= count <= MAX_THREADS:
        raise ValueError(f"threads must be an integer from 1 to {MAX_THREADS} or None, not {threads!r}")
    return count


def ids(array, shape):
    """Numbers of 32 bits with -1 for nothing, in the same memory."""
    return array.view(np.int32).reshape(shape)
