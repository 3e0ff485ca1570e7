//! The two images, as they are compared.

use std::path::Path;

use rt_image::{Development, Dither, Encoding, Image, ImageFormat, image_header, metrics::ImagePair};

use crate::args::CompareArgs;
use crate::error::Failure;
use crate::stdin::is_dash;
use crate::{memory, picture_file};

/// An image that was read.
#[derive(Debug)]
pub(super) struct LoadedImage {
    pub(super) film: Image,
    pub(super) format: ImageFormat,
    /// It was radiance, and became light of bytes.
    pub(super) developed: bool,
}

/// Both images, in the same kind of light.
#[derive(Debug)]
pub(super) struct Images {
    pub(super) test: LoadedImage,
    pub(super) reference: LoadedImage,
    /// What shows them to a viewer.
    pub(super) development: Development,
}

impl Images {
    /// Reads both images. Where one holds bytes and the other one radiance, the latter is developed to bytes as well.
    pub(super) fn read(args: &CompareArgs) -> Result<Self, Failure> {
        if is_dash(&args.test) && is_dash(&args.reference) {
            return Err(Failure::Usage("standard input is one image, and two are compared: name the other".to_owned()));
        }
        let standard = Development::default();
        let development = Development {
            exposure: args.development.exposure.unwrap_or(standard.exposure),
            tone: args.development.tone.unwrap_or(standard.tone),
            dither: args.development.dither.unwrap_or(true).then(Dither::default),
            ..standard
        };
        check_memory(args)?;
        let [mut test, mut reference] = [LoadedImage::read(&args.test)?, LoadedImage::read(&args.reference)?];
        if test.holds_bytes() == reference.holds_bytes() {
            return Ok(Self { test, reference, development });
        }
        for image in [&mut test, &mut reference] {
            if !image.holds_bytes() {
                image.film = development.develop(&image.film).decode(Encoding::Srgb);
                image.developed = true;
            }
        }
        // Both are now as they are shown.
        Ok(Self { test, reference, development: standard })
    }

    /// True if both hold linear radiance, and neither was developed.
    pub(super) fn are_radiance(&self) -> bool {
        !self.test.holds_bytes() && !self.reference.holds_bytes()
    }

    pub(super) fn pair(&self, args: &CompareArgs) -> Result<ImagePair<'_>, Failure> {
        ImagePair::new(&self.test.film, &self.reference.film).map_err(|source| Failure::Pair {
            test: args.test.clone(),
            reference: args.reference.clone(),
            source,
        })
    }
}

/// Bytes per pixel of what is measured beside the images, and of a heat map (`docs/MEMORY.md`).
const MEASURE_BYTES: u64 = 16;

/// Refuses images that need too much memory, by their headers.
fn check_memory(args: &CompareArgs) -> Result<(), Failure> {
    if is_dash(&args.test) || is_dash(&args.reference) {
        // What comes from a pipe has no header to look at before it is read.
        return Ok(());
    }
    let headers = [image_header(&args.test)?, image_header(&args.reference)?];
    let [test, reference] = headers;
    let maps = if args.heat_map.file.is_some() { 2 } else { 1 };
    let pixels = test.pixels().max(reference.pixels());
    let decoded = test.decoded_bytes.max(reference.decoded_bytes);
    let needs = [
        (format!("the image {}", args.test.display()), test.film_bytes),
        (format!("the image {}", args.reference.display()), reference.film_bytes),
        ("what is measured".to_owned(), decoded.max(maps * MEASURE_BYTES * pixels)),
    ];
    memory::check(args.memory.limit(), &args.test, &needs)
}

impl LoadedImage {
    fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self { film: picture_file::read(path)?, format: picture_file::format_by_content(path)?, developed: false })
    }

    const fn holds_bytes(&self) -> bool {
        picture_file::is_developed(self.format)
    }

    /// What kind of numbers the file holds.
    pub(super) fn description(&self) -> &'static str {
        match (self.holds_bytes(), self.developed) {
            (true, _) => "bytes for display",
            (false, true) => "linear radiance, developed to bytes to match the other",
            (false, false) => "linear radiance",
        }
    }
}
