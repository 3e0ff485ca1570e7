//! Image files to films.

use std::{
    fs::File,
    io::{BufRead, BufReader, Cursor},
    path::Path,
};

use image::{DynamicImage, ImageDecoder, ImageError};

use crate::{
    Encoding, Image, ImageFileError, ImageFormat, MAX_READ_PIXELS,
    image_decoder::{ExrParts, ImageSource, decode_pixels, exr_parts, guess_format, image_decoder},
    pfm::{self, PfmError, PfmHeader},
};

/// Bytes that a decoder may allocate: four channels of `f32`.
const MAX_DECODER_BYTES: u64 = 16 * MAX_READ_PIXELS;

/// A file that expands further is damaged. The densest compression, that of PNG and ZIP, reaches 1032 : 1, and
/// 16-bit floats double when they are read. Without this limit, a few damaged bytes take gigabytes and seconds.
const MAX_EXPANSION: u64 = 4096;

/// Reads an image as linear radiance. The content of the file determines the format, not its name.
///
/// PNG and JPEG are decoded as sRGB; embedded profiles are ignored. Their coverage is multiplied into the
/// radiance. EXR and PFM are not converted. HDR is divided by the exposures and colour corrections of its header.
///
/// # Errors
/// [`ImageFileError`] with the path, for a file that is missing, not a regular file, damaged, in another format, larger
/// than [`MAX_READ_PIXELS`], or larger than its bytes can fill (such as an EXR that shows a few pixels of a huge
/// window).
pub fn read_image(path: &Path) -> Result<Image, ImageFileError> {
    let (reader, length) = open(path)?;
    read_stream(path, reader, length)
}

/// The image of a file whose content is in memory, as [`read_image`] reads it; `name` is for messages.
///
/// # Errors
/// [`ImageFileError`] with the name, as of [`read_image`].
pub fn decode_image(bytes: &[u8], name: &Path) -> Result<Image, ImageFileError> {
    read_stream(name, Box::new(Cursor::new(bytes)), bytes.len() as u64)
}

/// Size of an image and its memory, by its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Bytes of the film that [`read_image`] returns.
    pub film_bytes: u64,
    /// Bytes of the decoded pixels that [`read_image`] holds in addition to the image until it returns.
    pub decoded_bytes: u64,
}

impl ImageHeader {
    /// Number of pixels.
    pub const fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }
}

/// Reads the header of an image, to predict the memory of [`read_image`].
///
/// # Errors
/// Those of [`read_image`], as far as the header shows them.
pub fn image_header(path: &Path) -> Result<ImageHeader, ImageFileError> {
    let (reader, length) = open(path)?;
    header_of_stream(path, reader, length)
}

/// Reads the header of an image whose content is in memory, as [`image_header`]; `name` is for messages.
///
/// # Errors
/// Those of [`decode_image`], as far as the header shows them.
pub fn header_of_bytes(bytes: &[u8], name: &Path) -> Result<ImageHeader, ImageFileError> {
    header_of_stream(name, Box::new(Cursor::new(bytes)), bytes.len() as u64)
}

/// Header of an image of `length` bytes; the path is for messages.
fn header_of_stream(
    path: &Path,
    mut reader: Box<dyn ImageSource + '_>,
    length: u64,
) -> Result<ImageHeader, ImageFileError> {
    if is_pfm(path, &mut reader)? {
        let PfmHeader { width, height, .. } = pfm::read_header(reader).map_err(|error| pfm_error(path, error))?;
        let film_bytes = 12 * u64::from(width) * u64::from(height);
        return Ok(ImageHeader { width, height, film_bytes, decoded_bytes: 0 });
    }
    let (decoder, block_bytes) = decoder(path, reader, length)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    let color = decoder.color_type();
    let film_bytes = pixels * if color.has_alpha() { 16 } else { 12 };
    // Numbers of 8 and 16 bits are spread to four channels before they become light.
    let spread_bytes = match color.bytes_per_pixel() / color.channel_count() {
        1 => 4 * pixels,
        2 => 8 * pixels,
        _ => 0,
    };
    let decoded_bytes = (decoder.total_bytes() + spread_bytes).max(3 * block_bytes);
    Ok(ImageHeader { width, height, film_bytes, decoded_bytes })
}

/// Format of an image file by its first bytes, as in [`read_image`], and not by its name: it holds
/// linear light, or bytes for display.
///
/// # Errors
/// [`ImageFileError`] with the path, for a file that is missing, not a regular file, or in no known format.
pub fn image_format(path: &Path) -> Result<ImageFormat, ImageFileError> {
    format_of_stream(path, open(path)?.0)
}

/// Format of an image file whose content is in memory, as [`image_format`]. `name` is for messages.
///
/// # Errors
/// [`ImageFileError::UnknownFormat`] with the name.
pub fn format_of_bytes(bytes: &[u8], name: &Path) -> Result<ImageFormat, ImageFileError> {
    format_of_stream(name, Box::new(Cursor::new(bytes)))
}

/// Format of the next bytes of a reader.
fn format_of_stream(path: &Path, mut reader: Box<dyn ImageSource + '_>) -> Result<ImageFormat, ImageFileError> {
    let unreadable = |source| ImageFileError::Read { path: path.to_owned(), source };
    if is_pfm(path, &mut reader)? {
        return Ok(ImageFormat::Pfm);
    }
    match guess_format(reader.fill_buf().map_err(unreadable)?) {
        Some(image::ImageFormat::Png) => Ok(ImageFormat::Png),
        Some(image::ImageFormat::Jpeg) => Ok(ImageFormat::Jpeg),
        Some(image::ImageFormat::OpenExr) => Ok(ImageFormat::Exr),
        Some(image::ImageFormat::Hdr) => Ok(ImageFormat::Hdr),
        _ => Err(ImageFileError::UnknownFormat(path.to_owned())),
    }
}

/// Opens a regular file and returns its length in bytes.
fn open(path: &Path) -> Result<(Box<dyn ImageSource>, u64), ImageFileError> {
    let unreadable = |source| ImageFileError::Read { path: path.to_owned(), source };
    // Check before opening, which would wait for the other end of a pipe.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(ImageFileError::NotAFile(path.to_owned()));
    }
    let file = File::open(path).map_err(unreadable)?;
    Ok((Box::new(BufReader::new(file)), metadata.len()))
}

/// Reads an image of `length` bytes; the path is for messages.
fn read_stream(path: &Path, mut reader: Box<dyn ImageSource + '_>, length: u64) -> Result<Image, ImageFileError> {
    if is_pfm(path, &mut reader)? {
        return pfm::read(reader, length).map_err(|error| pfm_error(path, error));
    }
    let image = decode_pixels(decoder(path, reader, length)?.0).map_err(|error| undecodable(path, error))?;
    Ok(film_of(&image))
}

fn is_pfm(path: &Path, reader: &mut impl BufRead) -> Result<bool, ImageFileError> {
    match reader.fill_buf() {
        Ok([]) => Err(ImageFileError::Empty(path.to_owned())),
        Ok(bytes) => Ok(matches!(bytes, [b'P', b'F' | b'f', ..])),
        Err(source) => Err(ImageFileError::Read { path: path.to_owned(), source }),
    }
}

fn pfm_error(path: &Path, error: PfmError) -> ImageFileError {
    match error {
        PfmError::Io(source) => ImageFileError::Read { path: path.to_owned(), source },
        PfmError::TooLarge(width, height) => ImageFileError::TooLarge { path: path.to_owned(), width, height },
        damaged => ImageFileError::Decode { path: path.to_owned(), reason: damaged.to_string() },
    }
}

fn undecodable(path: &Path, error: ImageError) -> ImageFileError {
    match error {
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            ImageFileError::Read { path: path.to_owned(), source }
        }
        other => ImageFileError::Decode { path: path.to_owned(), reason: other.to_string() },
    }
}

/// Decoder of a file of `length` bytes in a format of the `image` crate, whose image is within the limits. The second number is
/// the bytes of the largest block of an EXR file.
fn decoder<'r>(
    path: &Path,
    mut source: Box<dyn ImageSource + 'r>,
    length: u64,
) -> Result<(Box<dyn ImageDecoder + 'r>, u64), ImageFileError> {
    let unreadable = |source| ImageFileError::Read { path: path.to_owned(), source };
    let damaged = |reason| ImageFileError::Decode { path: path.to_owned(), reason };
    let exr = exr_parts(&mut *source).map_err(unreadable)?;
    if let Some(ExrParts { window_pixels, block_bytes }) = exr {
        if window_pixels > MAX_READ_PIXELS {
            return Err(damaged(format!("its data window has {window_pixels} pixels, more than {MAX_READ_PIXELS}")));
        }
        if block_bytes / MAX_EXPANSION > length {
            return Err(damaged(format!("a block of {block_bytes} bytes cannot come from {length} bytes")));
        }
    }
    let format = guess_format(source.fill_buf().map_err(unreadable)?).filter(image::ImageFormat::reading_enabled);
    let Some(format) = format else { return Err(ImageFileError::UnknownFormat(path.to_owned())) };
    let decoder = image_decoder(source, format, MAX_DECODER_BYTES).map_err(|error| undecodable(path, error))?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(damaged(format!("it has {width}x{height} pixels")));
    }
    if u64::from(width) * u64::from(height) > MAX_READ_PIXELS {
        return Err(ImageFileError::TooLarge { path: path.to_owned(), width, height });
    }
    if decoder.total_bytes() / MAX_EXPANSION > length {
        return Err(damaged(format!("{width}x{height} pixels cannot come from {length} bytes")));
    }
    Ok((decoder, exr.map_or(0, |parts| parts.block_bytes)))
}

/// Linear radiance and coverage of a decoded image.
fn film_of(image: &DynamicImage) -> Image {
    let mut film = Image::new(image.width(), image.height(), image.color().has_alpha());
    match image {
        DynamicImage::ImageRgb32F(pixels) => film.pixels_mut().as_flattened_mut().copy_from_slice(pixels),
        DynamicImage::ImageRgba32F(pixels) => fill(&mut film, pixels.pixels().map(|pixel| pixel.0)),
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => {
            let light = light_of_signals(usize::from(u8::MAX));
            let pixels = image.to_rgba8();
            fill(&mut film, pixels.pixels().map(|pixel| premultiply(pixel.0.map(usize::from), &light)));
        }
        // What remains has 16 bits a channel.
        _ => {
            let light = light_of_signals(usize::from(u16::MAX));
            let pixels = image.to_rgba16();
            fill(&mut film, pixels.pixels().map(|pixel| premultiply(pixel.0.map(usize::from), &light)));
        }
    }
    film
}

/// Stores premultiplied radiance and coverage, pixel by pixel.
fn fill(film: &mut Image, values: impl Iterator<Item = [f32; 4]> + Clone) {
    for (pixel, [r, g, b, _]) in film.pixels_mut().iter_mut().zip(values.clone()) {
        *pixel = [r, g, b];
    }
    if let Some(alpha) = film.alpha_mut() {
        for (alpha, [.., a]) in alpha.iter_mut().zip(values) {
            *alpha = a;
        }
    }
}

/// Linear light of each level of an sRGB signal, from 0 to `max`.
fn light_of_signals(max: usize) -> Vec<f32> {
    (0..=max).map(|level| Encoding::Srgb.decode_signal(level as f64 / max as f64) as f32).collect()
}

/// Linear radiance times coverage, and coverage, from the levels of a pixel.
fn premultiply([r, g, b, a]: [usize; 4], light: &[f32]) -> [f32; 4] {
    let coverage = a as f32 / (light.len() - 1) as f32;
    [light[r] * coverage, light[g] * coverage, light[b] * coverage, coverage]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{film_by_index, written};
    use crate::{Development, image_decoder::png_bytes, write_layers};
    use proptest::prelude::*;

    fn read_bytes(bytes: &[u8]) -> Result<Image, ImageFileError> {
        read_stream(Path::new("test"), Box::new(Cursor::new(bytes)), bytes.len() as u64)
    }

    fn encoded(format: ImageFormat) -> Vec<u8> {
        let mut film = film_by_index(12, 7, true, |index| [index as f32 / 84.0, 0.5, 0.1]);
        film.alpha_mut().expect("asked for").fill(0.75);
        written(&film, &Development::default(), format)
    }

    fn encoded_by_image(image: &DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
        bytes.into_inner()
    }

    /// Regression: Mitsuba and others write this header; the file was called "not an image".
    #[test]
    fn radiance_files_with_the_older_header_are_read() {
        let bytes = encoded(ImageFormat::Hdr);
        let rest = bytes.strip_prefix(b"#?RADIANCE").expect("the header");
        let older = [b"#?RGBE", rest].concat();
        assert_eq!(read_bytes(&older).expect("readable"), read_bytes(&bytes).expect("readable"));
        assert_eq!(format_of_bytes(&older, Path::new("older.hdr")).expect("known"), ImageFormat::Hdr);
    }

    #[test]
    fn png_is_linearised_and_multiplied_by_its_coverage() {
        let eight = image::RgbaImage::from_raw(1, 1, vec![188, 0, 255, 51]).expect("four bytes");
        let film = read_bytes(&encoded_by_image(&DynamicImage::ImageRgba8(eight))).expect("readable");
        assert_eq!(film.alpha(), Some([0.2f32].as_slice()));
        assert_eq!(film.pixels(), [[Encoding::Srgb.decode(188) * 0.2, 0.0, 0.2]]);

        let sixteen = image::ImageBuffer::from_raw(1, 1, vec![188 * 257]).expect("one value");
        let film = read_bytes(&encoded_by_image(&DynamicImage::ImageLuma16(sixteen))).expect("readable");
        assert_eq!(film.alpha(), None);
        assert_eq!(film.pixels(), [[Encoding::Srgb.decode(188); 3]]);
    }

    #[test]
    fn an_image_without_pixels_cannot_be_decoded() {
        let empty = read_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 24 +X 0\n");
        assert!(matches!(empty, Err(ImageFileError::Decode { .. })), "{empty:?}");
    }

    #[test]
    fn developing_what_was_read_gives_the_same_bytes() {
        let bytes = encoded(ImageFormat::Png);
        let film = read_bytes(&bytes).expect("readable");
        assert_eq!(written(&film, &Development::default(), ImageFormat::Png), bytes);
    }

    #[test]
    fn decoding_a_bitmap_gives_what_is_read_from_its_file() {
        let bytes = encoded(ImageFormat::Png);
        let film = read_bytes(&bytes).expect("readable");
        let decoded = Development::default().develop(&film).decode(Encoding::Srgb);
        assert_eq!(decoded.checksum(), film.checksum());
        let opaque = Development::default().develop_over_black(&film).decode(Encoding::Srgb);
        assert_eq!((opaque.alpha(), opaque.pixels()[0][1]), (None, Encoding::Srgb.decode(187)));
    }

    #[test]
    fn the_content_determines_the_format_and_not_the_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("image.png");
        std::fs::write(&path, encoded(ImageFormat::Exr)).expect("written");
        assert_eq!(read_image(&path).expect("readable").width(), 12);
        for format in ImageFormat::ALL {
            std::fs::write(&path, encoded(format)).expect("written");
            assert_eq!(image_format(&path).expect("known"), format);
        }
        std::fs::write(&path, b"GIF89a").expect("written");
        assert!(matches!(image_format(&path), Err(ImageFileError::UnknownFormat(_))));
        std::fs::write(&path, b"").expect("written");
        assert!(matches!(image_format(&path), Err(ImageFileError::Empty(_))));
        assert!(matches!(image_format(folder.path()), Err(ImageFileError::NotAFile(_))));
        assert!(matches!(image_format(&folder.path().join("missing")), Err(ImageFileError::Read { .. })));
    }

    #[test]
    fn what_is_not_an_image_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(matches!(read_image(folder.path()), Err(ImageFileError::NotAFile(_))));
        let missing = folder.path().join("missing.png");
        let message = read_image(&missing).expect_err("missing").to_string();
        assert!(message.contains("missing.png"), "{message}");
        assert!(matches!(read_bytes(b""), Err(ImageFileError::Empty(_))));
        for bytes in [b"P".as_slice(), b"hello, this is no image", b"GIF89a"] {
            assert!(matches!(read_bytes(bytes), Err(ImageFileError::UnknownFormat(_))), "{bytes:?}");
        }
    }

    #[test]
    fn huge_claims_are_refused() {
        // A Radiance header without pixels.
        let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        assert!(matches!(read_bytes(hdr), Err(ImageFileError::TooLarge { width: 60_000, .. })));
        let pfm = b"PF 60000 60000 -1.0 ";
        assert!(matches!(read_bytes(pfm), Err(ImageFileError::TooLarge { width: 60_000, .. })));
    }

    /// It was decoded to 117 million black pixels.
    #[test]
    fn an_exr_of_few_bytes_with_a_huge_window_is_refused() {
        let mut bytes = encoded(ImageFormat::Exr);
        let name = b"displayWindow\0box2i\0";
        let window = bytes.windows(name.len()).position(|part| part == name).expect("every EXR has one");
        // The attribute's length, then x and y of the first pixel, then x of the last one.
        let last_x = window + name.len() + 12;
        bytes[last_x..last_x + 4].copy_from_slice(&16_000_000u32.to_le_bytes());
        let message = read_bytes(&bytes).expect_err("refused").to_string();
        assert!(message.contains("16000001x7 pixels cannot come from"), "{message}");
    }

    /// Regression: 1.1 MB with such a window took 2.4 GB, and 3 kB ended the program. The decoder unpacks the data window in
    /// blocks, whatever the size of the image.
    #[test]
    fn an_exr_of_few_bytes_with_a_huge_data_window_is_refused() {
        let mut bytes = Vec::new();
        write_layers(&Image::new(12, 7, false), Vec::new(), &[], &mut bytes).expect("written, in rows");
        let name = b"dataWindow\0box2i\0";
        let window = bytes.windows(name.len()).position(|part| part == name).expect("every EXR has one");
        let last_x = window + name.len() + 12;
        for (x, message) in [
            (1_000_000, "a block of "),
            (600_000_000, "its data window has 4200000007 pixels"),
            (-600_000_000, "its data window has 4200000007 pixels"),
        ] {
            bytes[last_x..last_x + 4].copy_from_slice(&i32::to_le_bytes(x));
            let error = read_bytes(&bytes).expect_err("refused").to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    /// Kinds and data of the chunks of a PNG file.
    fn chunks(png: &[u8]) -> impl Iterator<Item = ([u8; 4], &[u8])> {
        let mut rest = &png[8..];
        core::iter::from_fn(move || {
            let (length, chunk) = rest.split_first_chunk()?;
            let (kind, data) = chunk.split_first_chunk()?;
            let (data, after) = data.split_at(u32::from_be_bytes(*length) as usize);
            rest = &after[4..];
            Some((*kind, data))
        })
    }

    /// Regression: the colour profile of a PNG file, which nothing uses, was unpacked to any size.
    #[test]
    fn a_colour_profile_that_expands_a_thousandfold_is_left_out() {
        let png = encoded(ImageFormat::Png);
        // The pixels of another file are packed as a profile is.
        let zeros = encoded_by_image(&image::GrayImage::new(1 << 12, 1 << 14).into());
        let profile: Vec<u8> =
            chunks(&zeros).filter(|(kind, _)| kind == b"IDAT").flat_map(|(_, data)| data).copied().collect();
        let chunk = [b"iCCPp\0\0".as_slice(), &profile].concat();
        let (header, rest) = png.split_at(33);
        let length = (chunk.len() as u32 - 4).to_be_bytes();
        let checksum = crc32fast::hash(&chunk).to_be_bytes();
        let bomb = [header, &length, &chunk, &checksum, rest].concat();
        assert!(png_bytes(&mut Cursor::new(&bomb)).expect("readable") < 2 << 20);
        assert_eq!(read_bytes(&bomb).expect("readable"), read_bytes(&png).expect("readable"));
    }

    #[test]
    fn a_file_cut_anywhere_does_not_panic() {
        for format in ImageFormat::ALL {
            let bytes = encoded(format);
            for length in 0..bytes.len() {
                // Some decoders make do with missing trailing bytes, such as checksums.
                if let Ok(film) = read_bytes(&bytes[..length]) {
                    assert_eq!((film.width(), film.height()), (12, 7), "{format:?}, {length} bytes");
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        #[test]
        fn a_damaged_file_does_not_panic(format in 0usize..5, at in any::<prop::sample::Index>(), byte in any::<u8>()) {
            let mut bytes = encoded(ImageFormat::ALL[format]);
            let position = at.index(bytes.len());
            bytes[position] = byte;
            if let Ok(film) = read_bytes(&bytes) {
                prop_assert!(u64::from(film.width()) * u64::from(film.height()) <= MAX_READ_PIXELS);
            }
        }
    }
}
