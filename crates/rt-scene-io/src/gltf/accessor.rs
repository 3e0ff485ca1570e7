//! Typed views of bytes, checked against the length of their buffer before memory is taken.
//!
//! The iterators of the `gltf` crate panic on bad counts and end silently on bad lengths; here both are errors.

use gltf::{
    Accessor,
    accessor::{DataType, sparse::IndexType},
    buffer::View,
};

use super::buffers::Buffers;
use crate::{LoadError, LoadErrorKind, limits};

/// Reads vectors of `N` components. Normalised integers become numbers in [0, 1] or [−1, 1], others keep their value.
pub(super) fn read_vectors<const N: usize>(
    accessor: &Accessor<'_>,
    buffers: &Buffers<'_>,
) -> Result<Vec<[f32; N]>, LoadError> {
    read_some_vectors(accessor, None, buffers)
}

/// Version of [`read_vectors`] for elements at ascending indices, which must be less than the count; `None` for all.
pub(super) fn read_some_vectors<const N: usize>(
    accessor: &Accessor<'_>,
    selected: Option<&[u32]>,
    buffers: &Buffers<'_>,
) -> Result<Vec<[f32; N]>, LoadError> {
    let components = accessor.dimensions().multiplicity();
    if components != N {
        let message = format!("has {components} components, where {N} are needed");
        return Err(fail(accessor, buffers, LoadErrorKind::Syntax(message)));
    }
    let (kind, normalized) = (accessor.data_type(), accessor.normalized());
    read(accessor, selected, buffers, [0.0; N], |bytes| {
        let mut parts = bytes.chunks_exact(kind.size());
        std::array::from_fn(|_| parts.next().map_or(0.0, |part| number(part, kind, normalized)))
    })
}

pub(super) fn read_indices(accessor: &Accessor<'_>, buffers: &Buffers<'_>) -> Result<Vec<u32>, LoadError> {
    let kind = accessor.data_type();
    let scalar = accessor.dimensions().multiplicity() == 1;
    if !(scalar && matches!(kind, DataType::U8 | DataType::U16 | DataType::U32)) {
        let message = format!("indices must be unsigned scalars, not {:?} of {kind:?}", accessor.dimensions());
        return Err(fail(accessor, buffers, LoadErrorKind::Syntax(message)));
    }
    read(accessor, None, buffers, 0, unsigned)
}

fn read<T: Copy>(
    accessor: &Accessor<'_>,
    selected: Option<&[u32]>,
    buffers: &Buffers<'_>,
    zero: T,
    decode: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, LoadError> {
    let (count, size) = (accessor.count(), accessor.size());
    if count == 0 {
        return Err(fail(accessor, buffers, LoadErrorKind::Syntax("the count must be at least 1".to_owned())));
    }
    let mut elements = match accessor.view() {
        Some(view) => {
            let items = Items::new(&view, accessor.offset(), count, size, buffers)?;
            match selected {
                Some(selected) => items.decode(selected.iter().map(|i| *i as usize), &decode),
                None => items.decode_all(&decode),
            }
        }
        None => {
            let (what, limit) = ("the count without a bufferView", limits::GLTF_ZEROS as u64);
            LoadErrorKind::check_limit(what, count as u64, limit)
                .and_then(|()| buffers.count_zeros(count as u64))
                .map_err(|reason| fail(accessor, buffers, reason))?;
            vec![zero; selected.map_or(count, <[u32]>::len)]
        }
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let index_size = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let places =
            Items::new(&indices.view(), indices.offset(), sparse.count(), index_size, buffers)?.decode_all(unsigned);
        let values = Items::new(&values.view(), values.offset(), sparse.count(), size, buffers)?.decode_all(&decode);
        for (place, value) in places.into_iter().zip(values) {
            if place as usize >= count {
                let rule = format!("is a sparse index, but there are {count} elements");
                return Err(fail(accessor, buffers, LoadErrorKind::invalid(place, rule)));
            }
            let index = selected.map_or(Ok(place as usize), |selected| selected.binary_search(&place));
            if let Some(element) = index.ok().and_then(|index| elements.get_mut(index)) {
                *element = value;
            }
        }
    }
    Ok(elements)
}

/// Equally spaced items in a buffer view.
struct Items<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Items<'a> {
    fn new(
        view: &View<'_>,
        offset: usize,
        count: usize,
        size: usize,
        buffers: &'a Buffers<'_>,
    ) -> Result<Self, LoadError> {
        let bytes = buffers.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let fail = |reason: LoadErrorKind| reason.at(buffers.path(), format!("bufferViews[{}]", view.index()));
        if stride < size {
            return Err(fail(LoadErrorKind::invalid(
                stride,
                format!("is a stride shorter than an element of {size} bytes"),
            )));
        }
        let length = count.checked_sub(1).and_then(|last| last.checked_mul(stride)?.checked_add(size));
        let end = length.and_then(|length| length.checked_add(offset));
        match end.and_then(|end| bytes.get(offset..end)) {
            Some(bytes) => Ok(Self { bytes, stride, size, count }),
            None => {
                let message = format!(
                    "{count} elements of {size} bytes with stride {stride} at offset {offset} exceed its {} bytes",
                    bytes.len()
                );
                Err(fail(LoadErrorKind::Syntax(message)))
            }
        }
    }

    fn decode_all<T>(&self, decode: impl Fn(&[u8]) -> T) -> Vec<T> {
        self.decode(0..self.count, decode)
    }

    /// Decodes the items at these indices, which must be less than the count.
    fn decode<T>(&self, indices: impl Iterator<Item = usize>, decode: impl Fn(&[u8]) -> T) -> Vec<T> {
        indices.map(|i| decode(&self.bytes[i * self.stride..][..self.size])).collect()
    }
}

fn fail(accessor: &Accessor<'_>, buffers: &Buffers<'_>, reason: LoadErrorKind) -> LoadError {
    reason.at(buffers.path(), format!("accessors[{}]", accessor.index()))
}

/// A little-endian unsigned number of up to four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |sum, &byte| (sum << 8) | u32::from(byte))
}

fn number(bytes: &[u8], kind: DataType, normalized: bool) -> f32 {
    let bits = unsigned(bytes);
    let value = match kind {
        DataType::F32 => f32::from_bits(bits),
        DataType::I8 => f32::from(bits as u8 as i8),
        DataType::I16 => f32::from(bits as u16 as i16),
        DataType::U8 | DataType::U16 | DataType::U32 => bits as f32,
    };
    unit_integer(kind).filter(|_| normalized).map_or(value, |unit| normalised(value, unit))
}

/// Maximum of a normalised integer, which represents 1; `None` for floating-point numbers.
pub(super) const fn unit_integer(kind: DataType) -> Option<f32> {
    match kind {
        DataType::F32 => None,
        DataType::I8 => Some(127.0),
        DataType::I16 => Some(32767.0),
        DataType::U8 => Some(255.0),
        DataType::U16 => Some(65535.0),
        DataType::U32 => Some(u32::MAX as f32),
    }
}

/// An integer as a number in [0, 1] or [−1, 1] (glTF 2.0, section 3.11).
pub(super) fn normalised(value: f32, unit_integer: f32) -> f32 {
    (value / unit_integer).max(-1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf::Document;
    use std::path::Path;

    /// Reads the first accessor of a document with one buffer of these bytes.
    fn with<T>(bytes: &[u8], views: &str, accessor: &str, read: impl Fn(&Accessor<'_>, &Buffers<'_>) -> T) -> T {
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {}}}], "bufferViews": [{views}],
                "accessors": [{{{accessor}}}]}}"#,
            bytes.len()
        );
        let root = gltf::json::Root::from_str(&json).expect("good JSON");
        let document = Document::from_json_without_validation(root);
        let buffers = Buffers::load(&document, Some(bytes), Path::new("m.glb"), &crate::LoadOptions::default())
            .expect("a buffer");
        read(&document.accessors().next().expect("an accessor"), &buffers)
    }

    fn indices(bytes: &[u8], views: &str, accessor: &str) -> Result<Vec<u32>, String> {
        with(bytes, views, accessor, read_indices).map_err(|e| e.to_string())
    }

    #[test]
    fn interleaved_and_offset_elements() {
        let bytes: Vec<u8> = (0..20).collect();
        let views = r#"{"buffer": 0, "byteOffset": 2, "byteLength": 18, "byteStride": 8}"#;
        let accessor = r#""bufferView": 0, "byteOffset": 1, "componentType": 5123, "count": 2, "type": "SCALAR""#;
        assert_eq!(indices(&bytes, views, accessor), Ok(vec![0x0403, 0x0c0b]));
    }

    #[test]
    fn normalised_integers() {
        let views = r#"{"buffer": 0, "byteLength": 4}"#;
        let read = |kind: u32, normalized: bool| {
            let accessor = format!(
                r#""bufferView": 0, "componentType": {kind}, "count": 1, "type": "VEC2", "normalized": {normalized}"#
            );
            with(&[255, 128, 0, 128], views, &accessor, read_vectors::<2>).expect("a vector")[0]
        };
        assert_eq!(read(5121, true), [1.0, 128.0 / 255.0]);
        assert_eq!(read(5121, false), [255.0, 128.0]);
        assert_eq!(read(5120, true), [-1.0 / 127.0, -1.0]);
        assert_eq!(read(5123, true), [33023.0 / 65535.0, 32768.0 / 65535.0]);
        assert_eq!(read(5122, true)[1], -1.0);
    }

    #[test]
    fn sparse_elements_replace_those_of_the_base_or_zeros() {
        let bytes = [10, 11, 12, 13, 1, 3, 20, 21];
        let views = r#"{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 4}"#;
        let sparse = r#""componentType": 5121, "count": 4, "type": "SCALAR", "sparse": {"count": 2,
            "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 1, "byteOffset": 2}}"#;
        assert_eq!(indices(&bytes, views, &format!(r#""bufferView": 0, {sparse}"#)), Ok(vec![10, 20, 12, 21]));
        assert_eq!(indices(&bytes, views, sparse), Ok(vec![0, 20, 0, 21]));
        let out = sparse.replace("\"count\": 4", "\"count\": 3");
        let expected = "m.glb: accessors[0]: 3 is a sparse index, but there are 3 elements";
        assert_eq!(indices(&bytes, views, &out), Err(expected.to_owned()));
        let bomb = sparse.replace("\"count\": 4", "\"count\": 4000000000");
        let expected = "m.glb: accessors[0]: the count without a bufferView is 4000000000, above the limit of 4194304";
        assert_eq!(indices(&bytes, views, &bomb), Err(expected.to_owned()));
    }

    #[test]
    fn accessors_that_lie_are_refused() {
        let view = |rest: &str| format!(r#"{{"buffer": 0, {rest}}}"#);
        let whole = view(r#""byteLength": 8"#);
        let accessor = |rest: &str| format!(r#""bufferView": 0, "type": "SCALAR", {rest}"#);
        let refused = |views: &str, rest: &str| indices(&[0; 8], views, &accessor(rest)).expect_err("a lie");
        let fine = r#""componentType": 5121, "count": 8"#;
        assert_eq!(
            refused(&whole, r#""componentType": 5121, "count": 0"#),
            "m.glb: accessors[0]: the count must be at least 1"
        );
        assert!(refused(&whole, r#""componentType": 5121, "count": 9"#).contains("exceed its 8 bytes"));
        assert!(
            refused(&whole, r#""componentType": 5125, "count": 4611686018427387905"#).contains("exceed its 8 bytes")
        );
        assert!(
            refused(&whole, &format!(r#"{fine}, "byteOffset": 18446744073709551615"#)).contains("exceed its 8 bytes")
        );
        assert!(
            refused(&view(r#""byteLength": 9"#), fine).contains("9 bytes at offset 0 exceed the buffer 0 of 8 bytes")
        );
        let overflow = view(r#""byteOffset": 18446744073709551615, "byteLength": 8"#);
        assert!(refused(&overflow, fine).contains("exceed the buffer 0 of 8 bytes"));
        assert!(refused(&whole, r#""componentType": 5126, "count": 2"#).contains("must be unsigned scalars"));
        let narrow = view(r#""byteLength": 8, "byteStride": 2"#);
        assert!(refused(&narrow, r#""componentType": 5125, "count": 2"#).contains("2 is a stride shorter"));
        let vector = with(&[0; 8], &whole, &accessor(fine), read_vectors::<3>).expect_err("a scalar").to_string();
        assert_eq!(vector, "m.glb: accessors[0]: has 1 components, where 3 are needed");
    }
}
