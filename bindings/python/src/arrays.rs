//! Numpy arrays as batches of rays.
//!
//! Contiguous arrays of either precision are read in place. Other arrays are gathered, a slice of rays at a time, so that
//! little memory is needed beyond that of the caller. Results without room in memory raise a `MemoryError`.

use core::ops::Range;

use numpy::{
    Element, PyArray, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods as _, dtype,
    ndarray::{ArrayView2, Dimension},
};
use pyo3::{prelude::*, sync::PyOnceLock};
use rayon::prelude::*;
use rt_accel::{Scalars, Vectors};

use crate::error::{memory_error, value_error};

/// Numbers that are checked at a time.
const NUMBERS_PER_CHECK: usize = 4096;

/// Array of zeros.
pub(crate) fn zeros<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    shape: impl IntoPyObject<'py>,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    // By the function of Python: that of the numpy crate panics without memory.
    static ZEROS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    Ok(ZEROS.import(py, "numpy", "zeros")?.call1((shape, dtype::<T>(py)))?.cast_into()?)
}

/// Vector with room for `n` items, of which only what is written takes memory.
pub(crate) fn with_capacity<T>(n: usize) -> PyResult<Vec<T>> {
    let mut items = Vec::new();
    items.try_reserve_exact(n).map_err(memory_error)?;
    Ok(items)
}

/// Vector of items, the number of which is known.
pub(crate) fn collected<T>(items: impl ExactSizeIterator<Item = T>) -> PyResult<Vec<T>> {
    let mut collected = with_capacity(items.len())?;
    collected.extend(items);
    Ok(collected)
}

/// Vectors in the rows of an array with three columns.
pub(crate) enum Rows<'py> {
    F32(PyReadonlyArray2<'py, f32>),
    F64(PyReadonlyArray2<'py, f64>),
}

impl<'py> Rows<'py> {
    /// Takes an aligned array of single or double precision; `what` names it in messages.
    pub(crate) fn extract(what: &str, array: &Bound<'py, PyAny>) -> PyResult<Self> {
        let rows = if let Ok(rows) = array.extract() {
            Self::F64(rows)
        } else if let Ok(rows) = array.extract() {
            Self::F32(rows)
        } else {
            return Err(value_error(format!("{what} must be an array of floats with three columns")));
        };
        // Before any view: references to misaligned numbers are undefined behaviour.
        if !rows.is_aligned() {
            return Err(value_error(format!("{what} must be aligned in memory")));
        }
        match rows.shape() {
            [_, 3] => Ok(rows),
            [n, columns] => Err(value_error(format!("{what} must have three columns, not the shape ({n}, {columns})"))),
        }
    }

    fn is_aligned(&self) -> bool {
        match self {
            Self::F32(rows) => rows.is_aligned(),
            Self::F64(rows) => rows.is_aligned(),
        }
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        let (n, columns) = match self {
            Self::F32(rows) => rows.as_array().dim(),
            Self::F64(rows) => rows.as_array().dim(),
        };
        [n, columns]
    }

    pub(crate) fn len(&self) -> usize {
        self.shape()[0]
    }

    /// The rows as views that may be sent to other threads.
    pub(crate) fn view(&self) -> RowsView<'_> {
        match self {
            Self::F32(rows) => RowsView::F32(rows.as_array()),
            Self::F64(rows) => RowsView::F64(rows.as_array()),
        }
    }
}

/// View of [`Rows`].
#[derive(Clone, Copy)]
pub(crate) enum RowsView<'a> {
    F32(ArrayView2<'a, f32>),
    F64(ArrayView2<'a, f64>),
}

/// Vectors of a slice of rays, if they had to be gathered.
#[derive(Default)]
pub(crate) struct Gathered {
    f32: Vec<f32>,
    f64: Vec<f64>,
}

impl RowsView<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::F32(rows) => rows.nrows(),
            Self::F64(rows) => rows.nrows(),
        }
    }

    /// True if the array is read in place.
    pub(crate) fn is_contiguous(&self) -> bool {
        match self {
            Self::F32(rows) => rows.is_standard_layout(),
            Self::F64(rows) => rows.is_standard_layout(),
        }
    }

    /// Index of the first row with a number that is NaN or infinite, of `n` from `first` on. A single row serves all.
    pub(crate) fn first_non_finite(&self, first: usize, n: usize, is_parallel: bool) -> Option<usize> {
        let (first, n) = if self.len() == 1 { (0, 1) } else { (first, n) };
        match self {
            Self::F32(rows) => first_bad(rows, first..first + n, is_parallel, f32::is_finite),
            Self::F64(rows) => first_bad(rows, first..first + n, is_parallel, f64::is_finite),
        }
    }

    /// Vectors of the rows from `first` on: in place, or gathered. A single row serves all.
    pub(crate) fn vectors<'v>(&'v self, first: usize, n: usize, gathered: &'v mut Gathered) -> Option<Vectors<'v>> {
        let (first, n) = if self.len() == 1 { (0, 1) } else { (first, n) };
        match self {
            Self::F32(rows) => {
                if let Some(numbers) = rows.as_slice() {
                    return Vectors::strided_f32(numbers.get(3 * first..3 * (first + n))?, n, 3, 1);
                }
                gathered.f32.clear();
                gathered.f32.extend((first..first + n).flat_map(|i| [rows[[i, 0]], rows[[i, 1]], rows[[i, 2]]]));
                Vectors::strided_f32(&gathered.f32, n, 3, 1)
            }
            Self::F64(rows) => {
                if let Some(numbers) = rows.as_slice() {
                    return Vectors::strided_f64(numbers.get(3 * first..3 * (first + n))?, n, 3, 1);
                }
                gathered.f64.clear();
                gathered.f64.extend((first..first + n).flat_map(|i| [rows[[i, 0]], rows[[i, 1]], rows[[i, 2]]]));
                Vectors::strided_f64(&gathered.f64, n, 3, 1)
            }
        }
    }
}

/// Index of the first row of `range` with a number that is not good.
fn first_bad<T: Copy + Sync>(
    rows: &ArrayView2<'_, T>,
    range: Range<usize>,
    is_parallel: bool,
    is_good: impl Fn(T) -> bool + Sync,
) -> Option<usize> {
    let Some(numbers) = rows.as_slice().and_then(|numbers| numbers.get(3 * range.start..3 * range.end)) else {
        return range.into_iter().find(|row| !rows.row(*row).iter().all(|number| is_good(*number)));
    };
    // Without a branch for each number: the compiler uses vector instructions.
    let has_bad = |chunk: &[T]| !chunk.iter().fold(true, |good, number| good & is_good(*number));
    let chunk = if is_parallel {
        numbers.par_chunks(NUMBERS_PER_CHECK).position_first(has_bad)
    } else {
        numbers.chunks(NUMBERS_PER_CHECK).position(has_bad)
    }?;
    let first = chunk * NUMBERS_PER_CHECK;
    let bad = numbers.get(first..)?.iter().position(|number| !is_good(*number))?;
    Some(range.start + (first + bad) / 3)
}

/// Ray parameters: one for all rays, or one for each.
pub(crate) enum Parameters<'py> {
    Same(f64),
    Each(PyReadonlyArray1<'py, f64>),
}

impl<'py> Parameters<'py> {
    /// Takes a number or a contiguous array of doubles.
    pub(crate) fn extract(what: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let wrong = || value_error(format!("{what} must be a number, or an array of one number for each ray"));
        // Arrays first: some versions of numpy convert those of one number, with a warning.
        if let Ok(each) = value.extract::<PyReadonlyArray1<'py, f64>>() {
            if !(each.is_c_contiguous() && each.is_aligned()) {
                return Err(value_error(format!("{what} must be contiguous and aligned in memory")));
            }
            return Ok(Self::Each(each));
        }
        match value.extract::<f64>() {
            Ok(same) if !same.is_nan() => Ok(Self::Same(same)),
            _ => Err(wrong()),
        }
    }

    /// The numbers; an array must be contiguous.
    pub(crate) fn view(&self) -> PyResult<ParametersView<'_>> {
        Ok(match self {
            Self::Same(same) => ParametersView::Same(*same),
            Self::Each(array) => ParametersView::Each(array.as_slice()?),
        })
    }
}

/// View of [`Parameters`].
#[derive(Clone, Copy)]
pub(crate) enum ParametersView<'a> {
    Same(f64),
    Each(&'a [f64]),
}

impl<'a> ParametersView<'a> {
    /// Index of the first NaN, of `n` numbers from `first` on.
    pub(crate) fn first_nan(self, first: usize, n: usize) -> Option<usize> {
        let Self::Each(values) = self else { return None };
        let values = values.get(first..first + n)?;
        // Without a branch for each number: the compiler uses vector instructions.
        if !values.iter().fold(false, |found, value| found | value.is_nan()) {
            return None;
        }
        values.iter().position(|value| value.is_nan()).map(|i| first + i)
    }

    /// The numbers of the rays from `first` on; `None` beyond the end.
    pub(crate) fn scalars(self, first: usize, n: usize) -> Option<Scalars<'a>> {
        Some(match self {
            Self::Same(same) => Scalars::Same(same),
            Self::Each(values) => Scalars::F64(values.get(first..first + n)?),
        })
    }
}
