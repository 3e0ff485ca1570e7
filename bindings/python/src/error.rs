//! Exceptions of Python.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A `ValueError`.
pub(crate) fn value_error(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}
