//! Decoder of OpenEXR files without colours, such as masks. The `image` crate reads colours only.

use std::io::{BufRead, Seek};

use exr::block::{self, reader::Reader};
use exr::meta::{MetaData, header::Header};
use exr::prelude::{ReadChannels as _, ReadLayers as _, ReadSpecificChannel as _, Vec2, read};
use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat};

/// Channel of coverage.
const ALPHA: &str = "A";

/// Channel of gray pixels with coverage.
const GRAY: &str = "Y";

/// OpenEXR file of one channel, or of the channels `Y` and `A`, whose header is read. Its pixels are gray.
pub(crate) struct GrayExrDecoder<R> {
    reader: Reader<R>,
    size: (u32, u32),
    has_alpha: bool,
}

impl<R: BufRead + Seek> GrayExrDecoder<R> {
    /// True for a file of one part with one channel, or with `Y` and `A`. Leaves `source` at its start.
    pub(crate) fn accepts(source: &mut R) -> std::io::Result<bool> {
        let metadata = MetaData::read_from_buffered(&mut *source, false);
        source.rewind()?;
        Ok(metadata.is_ok_and(|metadata| match &metadata.headers[..] {
            [Header { channels, deep: false, .. }] => {
                let is_gray = match &channels.list[..] {
                    [_] => true,
                    [alpha, gray] => alpha.name.eq(ALPHA) && gray.name.eq(GRAY),
                    _ => false,
                };
                is_gray && channels.list.iter().all(|channel| channel.sampling == Vec2(1, 1))
            }
            _ => false,
        }))
    }

    /// Reads the header of an accepted file whose pixels take at most `max_bytes`.
    pub(crate) fn new(source: R, max_bytes: u64) -> Result<Self, ImageError> {
        let reader = block::read(source, false).map_err(damaged)?;
        let header = reader.headers().first();
        let Vec2(width, height) = header.map(|header| header.shared_attributes.display_window.size).unwrap_or_default();
        let has_alpha = header.is_some_and(|header| header.channels.list.len() == 2);
        let this = Self { reader, size: (width as u32, height as u32), has_alpha };
        if this.total_bytes() > max_bytes {
            return Err(ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory)));
        }
        Ok(this)
    }
}

/// The channels that are missing for colours, and those of the file, in a sentence. `None` for a file with colours or a damaged
/// header. Leaves `source` at its start.
pub(crate) fn missing_colors(source: &mut (impl BufRead + Seek)) -> std::io::Result<Option<String>> {
    const MAX_NAMES: usize = 16;
    let metadata = MetaData::read_from_buffered(&mut *source, false);
    source.rewind()?;
    let Ok(metadata) = metadata else { return Ok(None) };
    let channels = || metadata.headers.iter().flat_map(|header| &header.channels.list);
    let missing: Vec<_> =
        ["R", "G", "B"].into_iter().filter(|name| channels().all(|channel| !channel.name.eq(name))).collect();
    let mut names: Vec<_> = channels().take(MAX_NAMES).map(|channel| channel.name.to_string()).collect();
    if channels().nth(MAX_NAMES).is_some() {
        names.push("…".to_owned());
    }
    let is = if missing.len() == 1 { "channel is" } else { "channels are" };
    let sentence = format!("{is} missing: {}; the file has {}", missing.join(", "), names.join(", ").escape_debug());
    Ok((!missing.is_empty()).then_some(sentence))
}

fn damaged(error: exr::error::Error) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormat::OpenExr.into(), error))
}

impl<R: BufRead + Seek> ImageDecoder for GrayExrDecoder<R> {
    fn dimensions(&self) -> (u32, u32) {
        self.size
    }

    fn color_type(&self) -> ColorType {
        if self.has_alpha { ColorType::Rgba32F } else { ColorType::Rgb32F }
    }

    fn read_image(self, pixels: &mut [u8]) -> Result<(), ImageError> {
        let Some(header) = self.reader.headers().first() else { return Ok(()) };
        // `Y` is the last of two: channels are sorted by name.
        let Some(channel) = header.channels.list.last() else { return Ok(()) };
        let name = channel.name.clone();
        // A single channel may be that of coverage, which is then read as gray.
        let other = if name.eq(ALPHA) { GRAY } else { ALPHA };
        let window = header.shared_attributes.display_window;
        let offset = header.own_attributes.layer_position - window.position;
        let (width, count) = (window.size.width(), window.size.area());
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required(name)
            .optional(other, 1.0)
            .collect_pixels(
                move |_, _| vec![[0.0_f32; 2]; count],
                move |values: &mut Vec<[f32; 2]>, at: Vec2<usize>, (value, alpha): (f32, f32)| {
                    // Pixels of the data window outside the display window are left out.
                    let Vec2(x, y) = at.to_i32() + offset;
                    if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
                        && x < width
                        && let Some(pixel) = values.get_mut(y * width + x)
                    {
                        *pixel = [value, alpha];
                    }
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_chunks(self.reader)
            .map_err(damaged)?;
        let (components, _) = pixels.as_chunks_mut::<4>();
        let per_pixel = if self.has_alpha { 4 } else { 3 };
        for (pixel, [value, alpha]) in components.chunks_exact_mut(per_pixel).zip(image.layer_data.channel_data.pixels)
        {
            // The last is overwritten without coverage.
            pixel[per_pixel - 1] = alpha.to_ne_bytes();
            pixel[..3].fill(value.to_ne_bytes());
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, pixels: &mut [u8]) -> Result<(), ImageError> {
        (*self).read_image(pixels)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use exr::prelude::{SpecificChannels, WritableImage as _};

    use crate::{ImageFileError, decode_image, header_of_bytes};

    /// A file of 3 × 2 numbers in one channel.
    fn encoded(name: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        let value = |at: exr::prelude::Vec2<usize>| (at.x() as f32 + 10.0 * at.y() as f32,);
        let channels = SpecificChannels::build().with_channel(name).with_pixel_fn(value);
        let image = exr::prelude::Image::from_channels((3, 2), channels);
        image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).expect("written");
        bytes
    }

    /// Such files were refused: "image does not contain non-deep rgb channels".
    #[test]
    fn exr_files_of_one_channel_are_gray() {
        for name in ["Y", "mask"] {
            let image = decode_image(&encoded(name), Path::new("y.exr")).expect("readable");
            assert_eq!((image.width(), image.height(), image.alpha()), (3, 2, None));
            let values = [0.0, 1.0, 2.0, 10.0, 11.0, 12.0];
            assert_eq!(image.pixels(), values.map(|value| [value; 3]));
        }
        assert_eq!(header_of_bytes(&encoded("Y"), Path::new("y.exr")).expect("readable").film_bytes, 6 * 12);
    }

    /// A file of one pixel with these channels.
    fn with_two(names: [&str; 2], values: (f32, f32)) -> Vec<u8> {
        let mut bytes = Vec::new();
        let channels =
            SpecificChannels::build().with_channel(names[0]).with_channel(names[1]).with_pixel_fn(|_| values);
        let image = exr::prelude::Image::from_channels((1, 1), channels);
        image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).expect("written");
        bytes
    }

    /// Such files were refused.
    #[test]
    fn gray_files_with_coverage_are_read() {
        let image = decode_image(&with_two(["A", "Y"], (0.5, 0.25)), Path::new("ya.exr")).expect("readable");
        assert_eq!((image.pixels(), image.alpha()), (&[[0.25; 3]][..], Some(&[0.5][..])));
        assert_eq!(decode_image(&encoded("A"), Path::new("a.exr")).expect("readable").pixels()[1], [1.0; 3]);
    }

    /// The message did not name the channels of the file.
    #[test]
    fn files_without_colours_are_refused_with_their_channels() {
        let message = |names: [&str; 2]| {
            decode_image(&with_two(names, (0.5, 0.25)), Path::new("a.exr")).expect_err("no colours").to_string()
        };
        let two = message(["G", "R"]);
        assert!(two.ends_with("channel is missing: B; the file has G, R"), "{two}");
        let none = message(["A", "Z\n"]);
        assert!(none.ends_with("channels are missing: R, G, B; the file has A, Z\\n"), "{none}");
    }

    #[test]
    fn pixels_outside_the_display_window_are_left_out() {
        let mut bytes = encoded("Y");
        let name = b"displayWindow\0box2i\0";
        let window = bytes.windows(name.len()).position(|part| part == name).expect("every EXR has one") + name.len();
        // The attribute's length, then the first and the last pixel: columns 1 to 3, one row more.
        for (index, value) in [1, 0, 3, 2].into_iter().enumerate() {
            let at = window + 4 + 4 * index;
            bytes[at..at + 4].copy_from_slice(&i32::to_le_bytes(value));
        }
        let image = decode_image(&bytes, Path::new("y.exr")).expect("readable");
        let values = [1.0, 2.0, 0.0, 11.0, 12.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(image.pixels(), values.map(|value| [value; 3]));
    }

    #[test]
    fn a_cut_file_of_one_channel_is_refused() {
        let bytes = encoded("Y");
        for length in 1..bytes.len() {
            let read = decode_image(&bytes[..length], Path::new("y.exr"));
            assert!(matches!(read, Err(ImageFileError::Decode { .. } | ImageFileError::UnknownFormat(_))), "{length}");
        }
    }
}
