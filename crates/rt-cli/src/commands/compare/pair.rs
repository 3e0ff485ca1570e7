//! The two images of a comparison.

use rt_image::{Development, Encoding, Image, ImageFormat, metrics::ImagePair};

use crate::args::CompareArgs;
use crate::error::{CliError, usage};
use crate::image_file::ImageInput;
use crate::stdin::is_dash;
use crate::{image_file, memory, settings};

#[derive(Debug)]
pub(super) struct LoadedImage {
    pub(super) film: Image,
    pub(super) format: ImageFormat,
    /// True for radiance that was tone-mapped to match the other image.
    pub(super) developed: bool,
}

/// Both images, either linear or tone-mapped.
#[derive(Debug)]
pub(super) struct Images {
    pub(super) test: LoadedImage,
    pub(super) reference: LoadedImage,
    /// Tone mapping for display.
    pub(super) development: Development,
}

impl Images {
    /// Reads both images. If only one holds bytes, the other one is tone-mapped as well.
    pub(super) fn read(args: &CompareArgs) -> Result<Self, CliError> {
        if is_dash(&args.test) && is_dash(&args.reference) {
            return usage("standard input cannot be both images: name a file for one");
        }
        let development = settings::development(&args.development);
        let memory = args.memory.limit();
        let inputs = [ImageInput::new(&args.test, memory)?, ImageInput::new(&args.reference, memory)?];
        check_memory(args, &inputs)?;
        let [mut test, mut reference] = [LoadedImage::read(&inputs[0])?, LoadedImage::read(&inputs[1])?];
        if test.holds_bytes() == reference.holds_bytes() {
            return Ok(Self { test, reference, development });
        }
        for image in [&mut test, &mut reference] {
            if !image.holds_bytes() {
                image.film = development.develop(&image.film).decode(Encoding::Srgb);
                image.developed = true;
            }
        }
        // Both are tone-mapped now.
        Ok(Self { test, reference, development: Development::default() })
    }

    pub(super) fn are_radiance(&self) -> bool {
        !self.test.holds_bytes() && !self.reference.holds_bytes()
    }

    pub(super) fn pair(&self, args: &CompareArgs) -> Result<ImagePair<'_>, CliError> {
        ImagePair::new(&self.test.film, &self.reference.film).map_err(|source| CliError::Pair {
            test: args.test.clone(),
            reference: args.reference.clone(),
            source,
        })
    }
}

/// Memory of the metrics, and of a heat map, in bytes per pixel (`docs/MEMORY.md`).
const MEASURE_BYTES: u64 = 16;

/// Predicts the memory from the headers.
fn check_memory(args: &CompareArgs, inputs: &[ImageInput<'_>; 2]) -> Result<(), CliError> {
    let [test, reference] = [inputs[0].header()?, inputs[1].header()?];
    let maps = if args.heat_map.file.is_some() { 2 } else { 1 };
    let pixels = test.pixels().max(reference.pixels());
    let decoded = test.decoded_bytes.max(reference.decoded_bytes);
    let needs = [
        (format!("the image {}", inputs[0].name().display()), test.film_bytes),
        (format!("the image {}", inputs[1].name().display()), reference.film_bytes),
        ("the metrics".to_owned(), decoded.max(maps * MEASURE_BYTES * pixels)),
    ];
    memory::check(args.memory.limit(), inputs[0].name(), &needs)
}

impl LoadedImage {
    fn read(input: &ImageInput<'_>) -> Result<Self, CliError> {
        Ok(Self { film: input.read()?, format: input.format()?, developed: false })
    }

    const fn holds_bytes(&self) -> bool {
        image_file::is_developed(self.format)
    }

    pub(super) fn description(&self) -> &'static str {
        match (self.holds_bytes(), self.developed) {
            (true, _) => "bytes for display",
            (false, true) => "linear radiance, tone-mapped to match the other image",
            (false, false) => "linear radiance",
        }
    }
}
