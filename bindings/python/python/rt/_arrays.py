"""Arrays of the caller in the shapes that the extension module takes."""

from __future__ import annotations

import operator
from numbers import Integral, Real
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

_ONE_OR_EACH = "must be a number, or an array of one for each"

#: Numbers of any type.
Array = NDArray[Any]
Shape = tuple[int, ...]


def numbers(what: str, values: object, expected: str = "must be numbers") -> Array:
    """Array of real numbers of any type and shape."""
    if np.ma.is_masked(values):
        raise ValueError(f"{what} has masked numbers: fill or remove them")
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O" and all(isinstance(value, Real) for value in array.flat):
            array = _of_objects(array)
    except (OverflowError, ValueError) as error:
        raise ValueError(f"{what} {expected}: {error}") from error
    if array.dtype.kind == "c":
        raise ValueError(f"{what} must be real numbers, not {array.dtype}")
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{what} {expected}, not {array.dtype if array.ndim else repr(values)}")
    return array


def _of_objects(array: Array) -> Array:
    """Real numbers of an array of objects: integers if 64 bits hold all of them."""
    if array.size and all(isinstance(value, Integral) for value in array.flat):
        try:
            return array.astype(np.int64)
        except OverflowError:
            pass
    return array.astype(np.float64)


def aligned(array: Array) -> Array:
    """The array, or a copy if its numbers lie at addresses that are no multiples of their size."""
    return array if array.flags.aligned else array.copy()


def vectors(what: str, values: object) -> Array:
    """Array of shape (..., 3) in single or double precision, without a copy if it has one of them and is aligned."""
    array = numbers(what, values)
    if array.dtype != np.float32 and array.dtype != np.float64:
        array = array.astype(np.float64)
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    if array.shape == (0,):
        array = array.reshape(0, 3)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{what} must have the shape (..., 3), not {array.shape}")
    return aligned(array)


def rays(origins: object, directions: object) -> tuple[Array, Array, Shape]:
    """Origins and directions of shape (n, 3), with n = 1 for one that serves all rays, and the shape of the results."""
    starts, along = vectors("origins", origins), vectors("directions", directions)
    try:
        shape = np.broadcast_shapes(starts.shape[:-1], along.shape[:-1])
    except ValueError as error:
        message = f"origins of shape {starts.shape} and directions of shape {along.shape} do not fit together"
        raise ValueError(message) from error
    return _rows(starts, shape), _rows(along, shape), shape


def _rows(array: Array, shape: Shape) -> Array:
    if array.size == 3:
        return array.reshape(1, 3)
    if array.shape[:-1] != shape:
        array = np.broadcast_to(array, (*shape, 3))
    return array.reshape(-1, 3)


def parameters(what: str, values: object, shape: Shape) -> float | Array:
    """One number for all rays, or a contiguous, aligned array of one for each."""
    array = numbers(what, values, _ONE_OR_EACH)
    return number(what, array) if array.ndim == 0 else one_for_each(what, array, shape)


def one_for_each(what: str, values: object, shape: Shape) -> Array:
    """A contiguous, aligned array of one number for each; a single number serves all."""
    array = np.atleast_1d(numbers(what, values, _ONE_OR_EACH))
    try:
        each = np.broadcast_to(array.astype(np.float64, copy=False), shape).reshape(-1)
        return np.require(each, requirements=["C", "A"])
    except ValueError as error:
        raise ValueError(f"{what} of shape {array.shape} does not fit the shape {shape}: one number each is needed") from error


def number(what: str, value: object) -> float:
    """A number that is not NaN."""
    array = numbers(what, value, "must be a number")
    if array.ndim != 0 or np.isnan(array):
        raise ValueError(f"{what} must be a number, not {value}")
    return float(array)


def positive(what: str, value: object, below: float = np.inf) -> float:
    """A number between zero and a bound, both exclusive."""
    result = number(what, value)
    if not 0 < result < below:
        rule = "positive and finite" if below == np.inf else f"between 0 and {below}"
        raise ValueError(f"{what} must be {rule}, not {value}")
    return result


def integer(what: str, value: SupportsIndex, least: int, most: int) -> int:
    """An integer in a range."""
    message = f"{what} must be an integer from {least} to {most}, not {value!r}"
    try:
        result = operator.index(value)
    except TypeError:
        raise ValueError(message) from None
    if not least <= result <= most:
        raise ValueError(message)
    return result


def faces(values: object) -> Array:
    """Triangles of shape (n, 3) as indices of 32 bits."""
    array = numbers("faces", values)
    if array.size == 0:
        return np.empty((0, 3), dtype=np.uint32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces must have the shape (n, 3), not {array.shape}")
    if not np.issubdtype(array.dtype, np.integer):
        # Objects: numbers that are no integers, or that 64 bits do not hold.
        of_values = np.asarray(values).dtype
        rule = "integers from 0 to 4294967295" if of_values.kind == "O" else "integers"
        raise ValueError(f"faces must be {rule}, not {of_values}")
    if array.dtype != np.uint32:
        bad = np.flatnonzero(((array < 0) | (array > 0xFFFF_FFFF)).any(axis=1))
        if bad.size:
            raise ValueError(f"row {bad[0]} of faces is {array[bad[0]].tolist()}, which are not indices of vertices")
    return aligned(array.astype(np.uint32, copy=False))


# That of `rt-cli --threads`. Thousands of threads stall a machine.
MAX_THREADS = 1024


def thread_count(threads: SupportsIndex | None) -> int:
    """0 for all processors."""
    return 0 if threads is None else integer("threads", threads, 1, MAX_THREADS)


def ids(array: Array, shape: Shape) -> NDArray[np.int32]:
    """Numbers of 32 bits with -1 for nothing, in the same memory."""
    return array.view(np.int32).reshape(shape)
