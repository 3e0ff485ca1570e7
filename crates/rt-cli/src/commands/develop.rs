//! `develop`: tone-maps a linear image.

use std::slice;

use rt_image::{Development, Encoding, ImageFormat, write_image};

use crate::args::DevelopArgs;
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::image_file::ImageInput;
use crate::output_file::OutputFile;
use crate::{image_file, memory, settings};

pub(super) fn run(args: &DevelopArgs) -> Result<(), CliError> {
    let format = image_file::chosen_format(&args.output, args.output_format)?;
    if !image_file::is_developed(format) {
        return usage(format!("--output {} must be .png or .jpg", args.output.display()));
    }
    let encoding = args.gamma.map_or(Encoding::Srgb, Encoding::Power);
    let development = Development { encoding, ..settings::development(&args.development) };
    let input = ImageInput::new(&args.image, args.memory.limit())?;
    let header = input.header()?;
    // The decoded file is freed before the display bytes are allocated.
    let transient = header.decoded_bytes.max(4 * header.pixels());
    let needs = [("the image".to_owned(), header.film_bytes), ("the decoded image".to_owned(), transient)];
    memory::check(args.memory.limit(), input.name(), &needs)?;
    let film = input.read()?;
    let is_transparent = film.alpha().is_some_and(|alpha| alpha.iter().any(|alpha| *alpha != 1.0));
    if is_transparent && format == ImageFormat::Jpeg {
        let file = args.output.display();
        return usage(format!("{file}: an image with transparent pixels requires a .png file; choose another name"));
    }
    image_file::check(&args.output, format, [film.width(), film.height()], is_transparent)?;
    let output = OutputFile::prepare(&args.output, slice::from_ref(&args.image))?;
    output.write(|file| write_image(&film, &development, format, file))?;
    if output.is_stdout() {
        return Ok(());
    }
    let (width, height) = (film.width(), film.height());
    Console { quiet: args.quiet }.println(format_args!("wrote {} ({width}x{height})", output.path().display()))
}
