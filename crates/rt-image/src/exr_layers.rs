//! Multi-layer OpenEXR files.
//!
//! All channels are in one part and have names like `normal.X`, as Blender, Nuke and OpenImageIO expect; those of the image
//! itself have no prefix. All are 32-bit floats, also numbers of objects, because Blender and Nuke show no others. The data
//! are compressed without loss.

use std::io::{Cursor, Write};
use std::ops::Range;

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::{ChunksWriter as _, write_chunks_with};
use exr::compression::Compression;
use exr::meta::BlockDescription;
use exr::meta::attribute::{AttributeValue, ChannelDescription, LineOrder, SampleType};
use exr::meta::header::Header;
use exr::prelude::{LayerAttributes, SmallVec, Text, Vec2};

use crate::{Image, ImageFileError, ImageFormat};

/// Lines of a block that is compressed as a whole.
const BLOCK_LINES: usize = 16;

/// Level of the compression: higher ones take three times as long, for files that are 3 % smaller.
const ZLIB_LEVEL: u8 = 1;

/// Values per pixel under one name.
pub struct Layer<'a> {
    /// Name, such as `normal`.
    pub name: &'a str,
    /// Channels with their names, such as `X`.
    pub channels: Vec<(&'a str, ChannelRows<'a>)>,
}

/// Reads a row of a channel, counted from the top: fills a slice of the width of the image. Channels need no memory of their own.
pub type ChannelRows<'a> = Box<dyn Fn(u32, &mut [f32]) + 'a>;

/// Bytes of the longest name of a channel or an attribute.
const MAX_NAME: usize = 255;

/// Full name of a channel, with its rows.
type NamedChannel<'a> = (String, ChannelRows<'a>);

/// Writes an image with layers, and texts such as the name of the program as attributes, to an OpenEXR file.
///
/// # Errors
/// [`ImageFileError::Encode`] if the image has no pixels, or if a name is empty, longer than 255 bytes or has a zero byte.
/// [`ImageFileError::Write`] if the writer fails.
pub fn write_layers<'a>(
    image: &'a Image,
    layers: Vec<Layer<'a>>,
    attributes: &[(&str, String)],
    mut writer: impl Write,
) -> Result<(), ImageFileError> {
    let refused = |reason: String| ImageFileError::Encode { format: ImageFormat::Exr, reason };
    if image.pixels().is_empty() {
        return Err(refused("it has no pixels".to_owned()));
    }
    let check = |name: &str| {
        let is_name = !name.is_empty() && name.len() <= MAX_NAME && !name.contains('\0');
        let reason = || format!("{name:?} is no name: it needs 1 to {MAX_NAME} bytes, and none of them zero");
        if is_name { Ok(()) } else { Err(refused(reason())) }
    };
    let mut channels = channels_of(image);
    for Layer { name, channels: of_layer } in layers {
        check(name)?;
        for (component, rows) in of_layer {
            let full_name = format!("{name}.{component}");
            check(component)?;
            check(&full_name)?;
            channels.push((full_name, rows));
        }
    }
    attributes.iter().try_for_each(|(name, _)| check(name))?;
    let bytes = encode([image.width(), image.height()], channels, attributes);
    let bytes = bytes.map_err(|error| refused(error.to_string()))?;
    writer.write_all(&bytes).and_then(|()| writer.flush()).map_err(ImageFileError::Write)
}

/// Bytes of a file of this image alone.
pub(crate) fn encode_image(image: &Image) -> exr::error::Result<Vec<u8>> {
    encode([image.width(), image.height()], channels_of(image), &[])
}

/// Channels of an image.
fn channels_of<'a>(image: &'a Image) -> Vec<NamedChannel<'a>> {
    let color = |at| color_rows(image, at);
    let mut channels: Vec<NamedChannel<'_>> =
        ["R", "G", "B"].iter().enumerate().map(|(at, name)| ((*name).to_owned(), color(at))).collect();
    let alpha_rows = |alpha: &'a [f32]| -> ChannelRows<'a> {
        Box::new(move |y, row| row.copy_from_slice(&alpha[y as usize * row.len()..][..row.len()]))
    };
    channels.extend(image.alpha().map(|alpha| ("A".to_owned(), alpha_rows(alpha))));
    channels
}

/// Rows of the color component with this index, up to 2.
pub fn color_rows(image: &Image, component: usize) -> ChannelRows<'_> {
    Box::new(move |y, row| {
        let pixels = image.pixels().iter().skip(y as usize * image.width() as usize);
        row.iter_mut().zip(pixels).for_each(|(value, pixel)| *value = pixel[component % 3]);
    })
}

/// Bytes of a file with these channels.
fn encode(
    [width, height]: [u32; 2],
    mut channels: Vec<NamedChannel<'_>>,
    attributes: &[(&str, String)],
) -> exr::error::Result<Vec<u8>> {
    // A file has its channels in this order.
    channels.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
    let mut described = LayerAttributes::default();
    for (name, value) in attributes {
        described.other.insert(text(name), AttributeValue::Text(text(value)));
    }
    let described_channels: SmallVec<_> =
        channels.iter().map(|(name, _)| ChannelDescription::named(text(name), SampleType::F32)).collect();
    let header = Header::new(Text::default(), Vec2(width as usize, height as usize), described_channels)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(described);
    let mut bytes = Vec::new();
    write_chunks_with(Cursor::new(&mut bytes), SmallVec::from_iter([header]), true, |_, writer| {
        let mut buffers = BlockBuffers::default();
        for (index, first) in (0..height).step_by(BLOCK_LINES).enumerate() {
            let lines = first..(first + BLOCK_LINES as u32).min(height);
            let compressed_pixels = buffers.compress(&channels, width as usize, lines);
            let block = CompressedScanLineBlock { y_coordinate: first as i32, compressed_pixels };
            writer.write_chunk(index, Chunk { layer_index: 0, compressed_block: CompressedBlock::ScanLine(block) })?;
        }
        Ok(())
    })?;
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Buffers for the lines of a block: their memory is reused, because new memory costs as much as the compression.
#[derive(Default)]
struct BlockBuffers {
    values: Vec<f32>,
    bytes: Vec<u8>,
    differences: Vec<u8>,
}

impl BlockBuffers {
    /// Some lines of all channels, line by line and channel by channel, in OpenEXR's ZIP compression.
    ///
    /// Even bytes come before odd ones. Each byte is stored as its difference to the one before, plus 128. What that makes no smaller is
    /// stored as it is. (Kainz, Bogart, Stanczyk, Hillman, "Technical Introduction to OpenEXR", "File Layout".)
    fn compress(&mut self, channels: &[NamedChannel<'_>], width: usize, lines: Range<u32>) -> Vec<u8> {
        let Self { values, bytes, differences } = self;
        values.resize(width * lines.len() * channels.len(), 0.0);
        let rows = lines.flat_map(|y| channels.iter().map(move |(_, read_row)| (y, read_row)));
        values.chunks_exact_mut(width).zip(rows).for_each(|(row, (y, read_row))| read_row(y, row));
        bytes.resize(4 * values.len(), 0);
        let (even, odd) = bytes.split_at_mut(2 * values.len());
        let pairs = even.chunks_exact_mut(2).zip(odd.chunks_exact_mut(2));
        for (value, (even, odd)) in values.iter().zip(pairs) {
            let [a, b, c, d] = value.to_le_bytes();
            even.copy_from_slice(&[a, c]);
            odd.copy_from_slice(&[b, d]);
        }
        differences.clone_from(bytes);
        for (difference, pair) in differences.iter_mut().skip(1).zip(bytes.windows(2)) {
            *difference = pair[1].wrapping_sub(pair[0]).wrapping_add(128);
        }
        let compressed = miniz_oxide::deflate::compress_to_vec_zlib(differences, ZLIB_LEVEL);
        if compressed.len() < bytes.len() {
            compressed
        } else {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        }
    }
}

/// Sorts the attributes in the header of a file by name: the encoder writes them in an order that varies.
///
/// They follow eight bytes of magic number and version: a name, a type, both ended by 0, the number of bytes, and these. An
/// empty name ends the header. Its length stays, and so do the positions of the data in the file.
fn sort_attributes(bytes: &mut [u8]) {
    let text_end = |from: usize| bytes[from..].iter().position(|&byte| byte == 0).map(|length| from + length + 1);
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = 8;
    while bytes.get(at).is_some_and(|&byte| byte != 0) {
        let Some(size) = text_end(at).and_then(text_end) else { return };
        let Some(&[a, b, c, d]) = bytes.get(size..size + 4) else { return };
        let end = size + 4 + u32::from_le_bytes([a, b, c, d]) as usize;
        let Some(attribute) = bytes.get(at..end) else { return };
        attributes.push(attribute);
        at = end;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes[8..at].copy_from_slice(&sorted);
}

/// UTF-8, as OpenEXR has it since version 2.0. The conversion of the encoder panics beyond Latin-1.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels as _, ReadLayers as _, read};

    use super::*;
    use crate::{read_image, test_images::film_by_index};

    fn film() -> Image {
        film_by_index(3, 2, true, |index| [index as f32, 0.1, -2.5e-20])
    }

    const DEPTHS: [f32; 6] = [1.0, 2.0, 3.5, 1e10, 0.0, 7.0];

    /// Rows of these values.
    fn rows(values: Vec<f32>) -> ChannelRows<'static> {
        Box::new(move |y, row| row.copy_from_slice(&values[y as usize * row.len()..][..row.len()]))
    }

    fn depth() -> Layer<'static> {
        Layer { name: "depth", channels: vec![("Z", rows(DEPTHS.to_vec()))] }
    }

    #[test]
    fn names_that_a_file_cannot_have_are_refused() {
        let long = "n".repeat(300);
        for name in ["", "a\0b", &long] {
            let layer = Layer { name, ..depth() };
            let of_channel = Layer { channels: vec![(name, rows(vec![0.0; 6]))], ..depth() };
            let no_text = String::new();
            for (layers, attributes) in
                [(vec![layer], vec![]), (vec![of_channel], vec![]), (vec![], vec![(name, no_text)])]
            {
                let error = write_layers(&film(), layers, &attributes, Vec::new()).expect_err("refused");
                assert!(
                    matches!(&error, ImageFileError::Encode { reason, .. } if reason.contains("is no name")),
                    "{error}"
                );
            }
        }
    }

    #[test]
    fn names_values_and_attributes_are_read_back() {
        let normal = |at: usize| (0..6).map(|i| (i * 3 + at) as f32 / 7.0).collect::<Vec<f32>>();
        let channels = ["X", "Y", "Z"].into_iter().enumerate().map(|(at, name)| (name, rows(normal(at))));
        let layers = vec![depth(), Layer { name: "normal", channels: channels.collect() }];
        let mut bytes = Vec::new();
        write_layers(&film(), layers, &[("renderer", "rt 1".to_owned())], &mut bytes).expect("written");
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let file = reader.from_buffered(Cursor::new(&bytes)).expect("an EXR file");
        let [layer] = &file.layer_data[..] else { panic!("one layer") };
        let names: Vec<String> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "R", "depth.Z", "normal.X", "normal.Y", "normal.Z"]);
        let values: Vec<f32> = layer.channel_data.list[4].sample_data.values_as_f32().collect();
        assert_eq!(values, DEPTHS);
        let values: Vec<f32> = layer.channel_data.list[6].sample_data.values_as_f32().collect();
        assert_eq!(values, normal(1));
        let attribute = layer.attributes.other.get(&Text::from("renderer"));
        assert_eq!(attribute, Some(&AttributeValue::Text(Text::from("rt 1"))));
    }

    #[test]
    fn the_image_itself_is_read_as_any_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("layers.exr");
        let file = std::fs::File::create(&path).expect("a file");
        write_layers(&film(), vec![depth()], &[], file).expect("written");
        assert_eq!(read_image(&path).expect("an image"), film());
    }

    /// Several blocks of lines: random bits, which no compression makes smaller, and smooth values.
    #[test]
    fn blocks_of_lines_are_read_back() {
        let bits = |index: usize| f32::from_bits((rt_math::random::hash(&[index as u64]) >> 34) as u32);
        for is_smooth in [false, true] {
            for (width, height) in [(1, 1), (5, 16), (7, 17), (64, 50)] {
                let value = |index: usize| if is_smooth { index as f32 * 0.25 } else { bits(index) };
                let film = film_by_index(width, height, true, |index| [0, 1, 2].map(|at| value(3 * index + at)));
                let values: Vec<f32> = (0..(width * height) as usize).map(|index| value(index + 77)).collect();
                let layer = Layer { name: "depth", channels: vec![("Z", rows(values.clone()))] };
                let mut bytes = Vec::new();
                write_layers(&film, vec![layer], &[], &mut bytes).expect("written");
                let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
                let file = reader.all_attributes().from_buffered(Cursor::new(&bytes)).expect("an EXR file");
                let channels = &file.layer_data.channel_data.list;
                let red: Vec<f32> = film.pixels().iter().map(|pixel| pixel[0]).collect();
                for (at, name, expected) in [(3, "R", red), (4, "depth.Z", values)] {
                    assert_eq!(channels[at].name.to_string(), name);
                    let read: Vec<f32> = channels[at].sample_data.values_as_f32().collect();
                    assert!(read == expected, "{name}, {width} × {height}, smooth: {is_smooth}");
                }
            }
        }
    }

    #[test]
    fn equal_layers_make_equal_files() {
        let attributes = ["renderer", "scene", "camera", "integrator", "seed"].map(|name| (name, name.to_uppercase()));
        let file = || {
            let mut bytes = Vec::new();
            write_layers(&film(), vec![depth()], &attributes, &mut bytes).expect("written");
            bytes
        };
        let first = file();
        assert!((0..20).all(|_| file() == first));
    }

    #[test]
    fn names_in_any_script_are_stored_as_utf_8() {
        let layer = Layer { name: "tiefe é 深度", ..depth() };
        let mut bytes = Vec::new();
        write_layers(&film(), vec![layer], &[("scene", "日本 é".to_owned())], &mut bytes).expect("written");
        for name in ["tiefe é 深度.Z", "日本 é"] {
            assert!(bytes.windows(name.len()).any(|part| part == name.as_bytes()), "{name}");
        }
    }

    #[test]
    fn an_image_without_pixels_is_refused() {
        assert!(write_layers(&Image::new(0, 0, false), Vec::new(), &[], Vec::new()).is_err());
    }
}
