//! Rows of elements, straight into the arrays that are kept.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

use rt_geometry::strip;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Columns of a vertex, each by its names.
pub(super) const COLUMNS: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["s", "u", "texture_u", "texture_s", "texcoord_u"],
    &["t", "v", "texture_v", "texture_t", "texcoord_v"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a"],
];

/// Number of columns before the colours.
const PLACED: usize = 8;

/// Columns of the position, the normal, the texture coordinates, and the three colours. After them comes alpha.
pub(super) const POSITION: Range<usize> = 0..3;
pub(super) const NORMAL: Range<usize> = 3..6;
pub(super) const UV: Range<usize> = 6..8;
pub(super) const COLOR: Range<usize> = 8..11;
pub(super) const ALPHA: Range<usize> = 11..12;

/// The column of this name.
pub(super) fn column(name: &[u8]) -> Option<usize> {
    COLUMNS.iter().position(|names| names.iter().any(|known| known.as_bytes() == name))
}

/// The element of triangle strips.
pub(super) const STRIPS: &str = "tristrips";

/// Names of the list of corners of a face.
pub(super) const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// All vertices: the first of [`COLUMNS`] of each, 0 where the file has no such column.
#[derive(Debug, Default)]
pub(super) struct PlyVertices {
    pub(super) rows: Vec<[f32; PLACED]>,
    /// The other columns, in the order of the file; empty without any.
    pub(super) colors: Vec<[f32; 4]>,
}

/// The numbers of a vertex.
#[derive(Default)]
pub(super) struct Vertex {
    placed: [f32; PLACED],
    color: Option<[f32; 4]>,
}

/// The corners of all faces.
#[derive(Debug, Default)]
pub(super) struct FaceCorners {
    indices: Vec<u32>,
    ends: Vec<usize>,
    /// Faces with fewer than three corners, which are not kept.
    pub(super) short: usize,
}

impl FaceCorners {
    pub(super) const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The corners of each face.
    pub(super) fn faces(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.indices[start..end])
    }
}

/// Triangle strips: lists of corners, in which a negative number begins another strip.
#[derive(Debug, Default)]
pub(super) struct TriangleStrips(Vec<i64>);

impl TriangleStrips {
    /// Adds the triangles to those of faces. Where a strip names a vertex twice it is stitched, and there is none.
    pub(super) fn add_to(&self, corners: &mut FaceCorners) {
        for order in self.0.split(|corner| *corner < 0) {
            // A number beyond all vertices is refused with the others.
            let order: Vec<u32> = order.iter().map(|corner| u32::try_from(*corner).unwrap_or(u32::MAX)).collect();
            for triangle in strip(&order).filter(|[a, b, c]| a != b && b != c && c != a) {
                corners.add(triangle.to_vec());
            }
        }
    }
}

/// An element that is passed over.
#[derive(Debug, Default)]
pub(super) struct Skipped;

/// Takes one row: whatever is at its keys.
pub(super) trait Row: Sized {
    fn read<'de, A: MapAccess<'de>>(cells: A) -> Result<Self, A::Error>;
}

/// A row is a map to the reader, whatever it holds.
struct Cells<R>(R);

impl<'de, R: Row> Deserialize<'de> for Cells<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Map<R>(PhantomData<R>);

        impl<'de, R: Row> Visitor<'de> for Map<R> {
            type Value = Cells<R>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a row of an element")
            }

            fn visit_map<A: MapAccess<'de>>(self, cells: A) -> Result<Self::Value, A::Error> {
                R::read(cells).map(Cells)
            }
        }

        deserializer.deserialize_map(Map(PhantomData))
    }
}

/// A property, by its name.
enum PlyProperty {
    Column(usize),
    /// The list of corners.
    Corners,
    Other,
}

impl<'de> Deserialize<'de> for PlyProperty {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Name;

        impl Visitor<'_> for Name {
            type Value = PlyProperty;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a property")
            }

            fn visit_bytes<E: Error>(self, name: &[u8]) -> Result<PlyProperty, E> {
                let is_corners = CORNERS.iter().any(|known| known.as_bytes() == name);
                let other = if is_corners { PlyProperty::Corners } else { PlyProperty::Other };
                Ok(column(name).map_or(other, PlyProperty::Column))
            }
        }

        deserializer.deserialize_identifier(Name)
    }
}

impl Row for Vertex {
    fn read<'de, A: MapAccess<'de>>(mut cells: A) -> Result<Self, A::Error> {
        let mut row = Self::default();
        while let Some(property) = cells.next_key()? {
            match property {
                PlyProperty::Column(column @ PLACED..) => {
                    row.color.get_or_insert_default()[column - PLACED] = cells.next_value()?;
                }
                PlyProperty::Column(column) => row.placed[column] = cells.next_value()?,
                PlyProperty::Corners | PlyProperty::Other => drop(cells.next_value::<IgnoredAny>()?),
            }
        }
        Ok(row)
    }
}

/// The list of corners of a row.
impl<T: DeserializeOwned> Row for Vec<T> {
    fn read<'de, A: MapAccess<'de>>(mut cells: A) -> Result<Self, A::Error> {
        let mut corners = Self::new();
        while let Some(property) = cells.next_key()? {
            match property {
                PlyProperty::Corners => corners = cells.next_value()?,
                PlyProperty::Column(_) | PlyProperty::Other => drop(cells.next_value::<IgnoredAny>()?),
            }
        }
        Ok(corners)
    }
}

impl Row for Skipped {
    fn read<'de, A: MapAccess<'de>>(mut cells: A) -> Result<Self, A::Error> {
        while cells.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Self)
    }
}

/// Array that rows are appended to. The row count of the header reserves no memory.
pub(super) trait Collects: Default {
    type Row: Row;
    fn add(&mut self, row: Self::Row);
}

impl Collects for PlyVertices {
    type Row = Vertex;

    fn add(&mut self, row: Vertex) {
        self.rows.push(row.placed);
        // A file has them in every row or in none.
        self.colors.extend(row.color);
    }
}

impl Collects for FaceCorners {
    type Row = Vec<u32>;

    fn add(&mut self, row: Vec<u32>) {
        if row.len() < 3 {
            self.short += 1;
        } else {
            self.indices.extend(row);
            self.ends.push(self.indices.len());
        }
    }
}

impl Collects for TriangleStrips {
    type Row = Vec<i64>;

    fn add(&mut self, row: Vec<i64>) {
        self.0.extend(row);
        self.0.push(-1);
    }
}

impl Collects for Skipped {
    type Row = Self;

    fn add(&mut self, _: Self) {}
}

/// All rows of an element.
pub(super) struct Rows<T>(pub(super) T);

impl<'de, T: Collects> Deserialize<'de> for Rows<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Collector<T>(PhantomData<T>);

        impl<'de, T: Collects> Visitor<'de> for Collector<T> {
            type Value = Rows<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the rows of an element")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Self::Value, A::Error> {
                let mut all = T::default();
                while let Some(Cells(row)) = rows.next_element()? {
                    all.add(row);
                }
                Ok(Rows(all))
            }
        }

        deserializer.deserialize_seq(Collector(PhantomData))
    }
}
