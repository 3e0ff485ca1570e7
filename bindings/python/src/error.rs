//! Exceptions of Python.

use std::collections::TryReserveError;

use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;

/// A `ValueError`.
pub(crate) fn value_error(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A `MemoryError`.
pub(crate) fn memory_error(error: TryReserveError) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}
