//! Numbers and vectors of many rays, as the caller has them in memory.

use glam::DVec3;

/// One number for each ray, or the same for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scalars<'a> {
    /// One value for all rays.
    Same(f64),
    /// In single precision.
    F32(&'a [f32]),
    /// In double precision.
    F64(&'a [f64]),
}

impl Scalars<'_> {
    /// Number of values; `None` if there is one for any number of rays.
    pub(super) const fn len(&self) -> Option<usize> {
        match self {
            Self::Same(_) => None,
            Self::F32(values) => Some(values.len()),
            Self::F64(values) => Some(values.len()),
        }
    }

    /// The value of ray `index`; NaN beyond the end.
    #[inline]
    pub(super) fn get(&self, index: usize) -> f64 {
        match self {
            Self::Same(value) => *value,
            Self::F32(values) => values.get(index).copied().map_or(f64::NAN, f64::from),
            Self::F64(values) => values.get(index).copied().unwrap_or(f64::NAN),
        }
    }
}

impl From<f64> for Scalars<'_> {
    fn from(value: f64) -> Self {
        Self::Same(value)
    }
}

impl<'a> From<&'a [f32]> for Scalars<'a> {
    fn from(values: &'a [f32]) -> Self {
        Self::F32(values)
    }
}

impl<'a> From<&'a [f64]> for Scalars<'a> {
    fn from(values: &'a [f64]) -> Self {
        Self::F64(values)
    }
}

/// Components of all vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Components<'a> {
    F32(&'a [f32]),
    F64(&'a [f64]),
}

/// One vector for each ray: a view of the caller's memory in single or double precision.
///
/// Component `k` of vector `i` is number `i * stride + k * component_stride`. Examples:
///
/// | memory | stride | component stride |
/// |---|---|---|
/// | rows of three numbers | 3 | 1 |
/// | records of m numbers | m | 1 |
/// | three arrays of n numbers, one after the other | 1 | n |
/// | one vector for all rays | 0 | 1 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vectors<'a> {
    components: Components<'a>,
    len: usize,
    stride: usize,
    component_stride: usize,
}

impl<'a> Vectors<'a> {
    const EMPTY: Self = Self { components: Components::F64(&[]), len: 0, stride: 0, component_stride: 0 };

    /// View of single precision with strides; `None` if the last vector lies beyond the end.
    pub fn strided_f32(components: &'a [f32], len: usize, stride: usize, component_stride: usize) -> Option<Self> {
        if len == 0 {
            return Some(Self::EMPTY);
        }
        is_within(components.len(), len, stride, component_stride).then_some(Self {
            components: Components::F32(components),
            len,
            stride,
            component_stride,
        })
    }

    /// View of double precision with strides; `None` if the last vector lies beyond the end.
    pub fn strided_f64(components: &'a [f64], len: usize, stride: usize, component_stride: usize) -> Option<Self> {
        if len == 0 {
            return Some(Self::EMPTY);
        }
        is_within(components.len(), len, stride, component_stride).then_some(Self {
            components: Components::F64(components),
            len,
            stride,
            component_stride,
        })
    }

    /// Number of vectors.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True if there are none.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Vector `index`, or the last one beyond the end; NaN if there are none.
    #[inline]
    pub(super) fn get(&self, index: usize) -> DVec3 {
        let first = index.min(self.len.saturating_sub(1)) * self.stride;
        let at = [first, first + self.component_stride, first + 2 * self.component_stride];
        DVec3::from(match self.components {
            Components::F32(numbers) => at.map(|i| numbers.get(i).copied().map_or(f64::NAN, f64::from)),
            Components::F64(numbers) => at.map(|i| numbers.get(i).copied().unwrap_or(f64::NAN)),
        })
    }
}

/// True if the last component of the last vector is one of `available` numbers; `len` is not 0.
fn is_within(available: usize, len: usize, stride: usize, component_stride: usize) -> bool {
    let last = (len - 1).checked_mul(stride).zip(component_stride.checked_mul(2)).and_then(|(a, b)| a.checked_add(b));
    last.is_some_and(|last| last < available)
}

impl<'a> From<&'a [[f32; 3]]> for Vectors<'a> {
    fn from(vectors: &'a [[f32; 3]]) -> Self {
        Self { components: Components::F32(vectors.as_flattened()), len: vectors.len(), stride: 3, component_stride: 1 }
    }
}

impl<'a> From<&'a [[f64; 3]]> for Vectors<'a> {
    fn from(vectors: &'a [[f64; 3]]) -> Self {
        Self { components: Components::F64(vectors.as_flattened()), len: vectors.len(), stride: 3, component_stride: 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strides_address_rows_columns_and_records() {
        let numbers: Vec<f64> = (0..12).map(f64::from).collect();
        let view = |len, stride, component| Vectors::strided_f64(&numbers, len, stride, component);
        let second = |view: Option<Vectors<'_>>| view.map(|view| view.get(1).to_array());
        assert_eq!(second(view(4, 3, 1)), Some([3.0, 4.0, 5.0]), "rows");
        assert_eq!(second(view(3, 4, 1)), Some([4.0, 5.0, 6.0]), "records of four");
        assert_eq!(second(view(4, 1, 4)), Some([1.0, 5.0, 9.0]), "three arrays");
        assert_eq!(second(view(9, 0, 1)), Some([0.0, 1.0, 2.0]), "one for all");
        assert_eq!((view(5, 3, 1), view(usize::MAX, 3, 1), view(2, 1, usize::MAX)), (None, None, None));
        assert!(view(0, usize::MAX, usize::MAX).is_some_and(|view| view.is_empty() && view.get(0).is_nan()));
        let single: Vec<f32> = vec![0.5; 3];
        assert_eq!(Vectors::strided_f32(&single, 1, 3, 1).map(|view| view.get(7)), Some(DVec3::splat(0.5)));
    }
}
