//! Exceptions of Python.

use std::collections::TryReserveError;

use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use rt_accel::BatchError;

/// A `ValueError`.
pub(crate) fn value_error(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A `MemoryError`.
pub(crate) fn memory_error(error: TryReserveError) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

/// The exception of a batch of rays: a `MemoryError` without memory for its results, else a `ValueError`.
pub(crate) fn batch_error(error: BatchError) -> PyErr {
    match error {
        BatchError::Memory => PyMemoryError::new_err(error.to_string()),
        _ => value_error(error),
    }
}
