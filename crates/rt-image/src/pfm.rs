//! Portable float maps (Debevec 2001): a header of three lines, then the rows from the bottom up, as `f32`.
//!
//! ```text
//! PF              Pf: one channel instead of three
//! width height
//! -1.0            negative: little-endian; the absolute value scales the samples
//! ```

use std::io::{self, BufRead, Read, Write};

use crate::{Image, MAX_READ_PIXELS};

/// A word of the header is refused beyond this length.
const MAX_WORD: usize = 64;

/// Error of [`read`]: a file that is no portable float map.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PfmError {
    #[error("{0}")]
    Io(#[from] io::Error),
    #[error("its header is invalid")]
    Header,
    #[error("{0}x{1} pixels exceed the largest possible file")]
    TooLarge(u32, u32),
    #[error("it is truncated: the pixels need {expected} bytes and {found} follow the header")]
    Truncated { expected: u64, found: u64 },
}

/// Writes radiance, little-endian.
pub(crate) fn write(film: &Image, mut writer: impl Write) -> io::Result<()> {
    write!(writer, "PF\n{} {}\n-1.0\n", film.width(), film.height())?;
    let row_length = film.width() as usize;
    let mut bytes = Vec::with_capacity(12 * row_length);
    for row in film.pixels().rchunks_exact(row_length) {
        bytes.clear();
        bytes.extend(row.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
        writer.write_all(&bytes)?;
    }
    Ok(())
}

pub(crate) struct PfmHeader {
    pub(crate) width: u32,
    pub(crate) height: u32,
    channels: u64,
    scale: f32,
    /// Bytes up to the first sample.
    length: u64,
    /// True if a carriage return is before the first sample. A line feed behind it may be part of the header.
    ends_with_return: bool,
}

/// Reads the header of a map, and checks that its pixels are not too many.
pub(crate) fn read_header(mut reader: impl BufRead) -> Result<PfmHeader, PfmError> {
    let (mut length, mut ends_with_return) = (0, false);
    let mut word = || -> Result<String, PfmError> {
        let (word, consumed, end) = read_word(&mut reader)?;
        length += consumed;
        ends_with_return = end == b'\r';
        Ok(word)
    };
    let channels: u64 = match word()?.as_str() {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(PfmError::Header),
    };
    let width: u32 = word()?.parse().map_err(|_| PfmError::Header)?;
    let height: u32 = word()?.parse().map_err(|_| PfmError::Header)?;
    let scale: f32 = word()?.parse().map_err(|_| PfmError::Header)?;
    if width == 0 || height == 0 || !scale.is_finite() || scale == 0.0 {
        return Err(PfmError::Header);
    }
    if u64::from(width) * u64::from(height) > MAX_READ_PIXELS {
        return Err(PfmError::TooLarge(width, height));
    }
    Ok(PfmHeader { width, height, channels, scale, length, ends_with_return })
}

/// Reads a map from a file of `length` bytes in all.
pub(crate) fn read(mut reader: impl BufRead, length: u64) -> Result<Image, PfmError> {
    let PfmHeader { width, height, channels, scale, length: header_length, ends_with_return } =
        read_header(&mut reader)?;
    let count = u64::from(width) * u64::from(height);
    // Checked before the film is allocated: a short file must not cost much memory.
    let (expected, found) = (4 * channels * count, length.saturating_sub(header_length));
    if found < expected {
        return Err(PfmError::Truncated { expected, found });
    }
    if ends_with_return && found == expected + 1 && reader.fill_buf()?.first() == Some(&b'\n') {
        reader.consume(1);
    }
    let decode = |bytes: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) };
        // A product would change the bits of a signalling NaN.
        if scale.abs() == 1.0 { value } else { value * scale.abs() }
    };
    let mut film = Image::new(width, height, false);
    let mut bytes = vec![0; 4 * channels as usize * width as usize];
    for row in film.pixels_mut().rchunks_exact_mut(width as usize) {
        reader.read_exact(&mut bytes)?;
        let (values, _) = bytes.as_chunks::<4>();
        for (pixel, values) in row.iter_mut().zip(values.chunks_exact(channels as usize)) {
            // One channel is repeated three times.
            *pixel = core::array::from_fn(|component| decode(&values[component % channels as usize]));
        }
    }
    Ok(film)
}

/// The next word without the white space around it. The others are the number of bytes that it and one white space behind it take,
/// and that white space.
fn read_word(reader: &mut impl BufRead) -> Result<(String, u64, u8), PfmError> {
    let mut word = String::new();
    let mut consumed = 0;
    for byte in reader.by_ref().bytes() {
        let byte = byte?;
        consumed += 1;
        if !byte.is_ascii_whitespace() {
            word.push(char::from(byte));
        } else if !word.is_empty() {
            return Ok((word, consumed, byte));
        }
        if consumed > MAX_WORD as u64 {
            break;
        }
    }
    Err(PfmError::Header)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(bytes: &[u8]) -> Result<Image, PfmError> {
        read(bytes, bytes.len() as u64)
    }

    fn file(header: &str, values: impl IntoIterator<Item = [u8; 4]>) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.extend(values.into_iter().flatten());
        bytes
    }

    #[test]
    fn rows_run_from_the_bottom_up() {
        let bytes = file("PF\n1 2\n-1.0\n", [1f32, 2.0, 3.0, 4.0, 5.0, 6.0].map(f32::to_le_bytes));
        let film = parse(&bytes).expect("sound");
        assert_eq!(film.pixels(), [[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]]);
        let mut written = Vec::new();
        write(&film, &mut written).expect("written");
        assert_eq!(written, bytes);
    }

    /// Their samples were read from one byte too early.
    #[test]
    fn lines_of_the_header_may_end_with_carriage_returns() {
        for (header, first) in
            [("PF\r\n1 1\r\n-1.0\r\n", 1.0_f32), ("PF\r1 1\r-1.0\r", f32::from_le_bytes([b'\n', 0, 0, 63]))]
        {
            let film = parse(&file(header, [first, 2.0, 3.0].map(f32::to_le_bytes))).expect("sound");
            assert_eq!(film.pixels(), [[first, 2.0, 3.0]]);
        }
    }

    #[test]
    fn a_positive_scale_means_big_endian() {
        let film = parse(&file("PF 1 1 1.0\n", [1f32, 2.0, 3.0].map(f32::to_be_bytes))).expect("sound");
        assert_eq!(film.pixels(), [[1.0, 2.0, 3.0]]);
    }

    #[test]
    fn signalling_nans_keep_their_bits() {
        let bytes = file("PF\n1 1\n-1.0\n", [0x7fa0_0001u32, 0xff80_0001, 0].map(u32::to_le_bytes));
        let film = parse(&bytes).expect("sound");
        assert_eq!(film.pixels()[0].map(f32::to_bits), [0x7fa0_0001, 0xff80_0001, 0]);
    }

    #[test]
    fn one_channel_becomes_grey_and_the_scale_multiplies() {
        let film = parse(&file("Pf\n2 1\n-0.5\n", [1f32, 3.0].map(f32::to_le_bytes))).expect("sound");
        assert_eq!(film.pixels(), [[0.5; 3], [1.5; 3]]);
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        let bytes = file("PF\n2 2\n-1.0\n", [0.25f32; 12].map(f32::to_le_bytes));
        assert!(parse(&bytes).is_ok());
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length]).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn damaged_headers_are_refused() {
        for header in [
            "P6 1 1 -1 ",
            "PF 0 1 -1 ",
            "PF 1 -1 -1 ",
            "PF 1 1 0 ",
            "PF 1 1 nan ",
            "PF 1 1 inf ",
            "PF 1 x -1 ",
            "PF 1.5 1 1 ",
        ] {
            assert!(matches!(parse(&file(header, [[0; 4]; 3])), Err(PfmError::Header)), "{header}");
        }
        let endless = [b' '; 1000];
        assert!(matches!(parse(&endless), Err(PfmError::Header)));
    }

    #[test]
    fn huge_claims_are_refused_before_anything_is_allocated() {
        let huge = parse(b"PF 4294967295 4294967295 -1.0 ");
        assert!(matches!(huge, Err(PfmError::TooLarge(u32::MAX, u32::MAX))));
        assert!(matches!(parse(b"PF 8192 8192 -1.0 "), Err(PfmError::Truncated { found: 0, .. })));
    }
}
