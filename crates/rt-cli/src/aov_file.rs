//! Per-pixel outputs other than radiance.

use std::path::PathBuf;

use rt_image::{Development, Image, ImageFormat, write_image};
use rt_render::Rendering;

use crate::args::{Aov, AovArg};
use crate::error::CliError;
use crate::image_file;
use crate::output::OutputFile;
use crate::output_error::OutputError;

#[derive(Debug)]
pub(crate) struct AovFile {
    aov: Aov,
    format: ImageFormat,
    output: OutputFile,
}

impl AovFile {
    fn prepare(arg: &AovArg, inputs: &[PathBuf]) -> Result<Self, CliError> {
        let format = image_file::format_of(&arg.file)?;
        Ok(Self { aov: arg.aov, format, output: OutputFile::prepare(&arg.file, inputs)? })
    }

    /// Prepares all files, which must differ from each other and from `others`.
    pub(crate) fn prepare_all(
        args: &[AovArg],
        inputs: &[PathBuf],
        others: &[&OutputFile],
    ) -> Result<Vec<Self>, CliError> {
        let mut aovs: Vec<Self> = Vec::with_capacity(args.len());
        for arg in args {
            let aov = Self::prepare(arg, inputs)?;
            if aovs.iter().map(Self::output).chain(others.iter().copied()).any(|other| other.is_same_file(&aov.output))
            {
                return Err(CliError::Usage(format!("two outputs would go to {}", arg.file.display())));
            }
            aovs.push(aov);
        }
        Ok(aovs)
    }

    const fn output(&self) -> &OutputFile {
        &self.output
    }

    /// Refuses outputs that cannot be estimated or stored.
    pub(crate) fn check(&self, size: [u32; 2], several_passes: bool) -> Result<(), CliError> {
        if self.aov == Aov::Stderr && !several_passes {
            let message = "--aov stderr needs at least two passes: add --passes 4";
            return Err(CliError::Usage(message.to_owned()));
        }
        image_file::check(self.format, size, false)
    }

    /// Writes the file, if need be to a fallback directory.
    pub(crate) fn write(&self, rendering: &Rendering, fallback_dirs: &[PathBuf]) -> Result<(), OutputError> {
        let film = match self.aov {
            Aov::Stderr => &rendering.standard_error,
            Aov::Samples => &rendering.sample_counts,
        };
        let Some(film) = film else { return Ok(()) };
        let shown;
        let film = if image_file::is_developed(self.format) {
            shown = relative_to_largest(film);
            &shown
        } else {
            film
        };
        self.output
            .write_with_fallback(fallback_dirs, |file| write_image(film, &Development::default(), self.format, file))
    }
}

/// Values relative to the largest finite one.
fn relative_to_largest(film: &Image) -> Image {
    let finite = film.pixels().as_flattened().iter().copied().filter(|value| value.is_finite());
    let largest = finite.fold(f32::MIN_POSITIVE, f32::max);
    let mut shown = film.clone();
    for value in shown.pixels_mut().as_flattened_mut() {
        *value /= largest;
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_relative_to_the_largest() {
        let mut film = Image::new(2, 2, false);
        film.pixels_mut().copy_from_slice(&[[64.0; 3], [256.0; 3], [f32::INFINITY; 3], [0.0; 3]]);
        let shown = relative_to_largest(&film);
        assert_eq!(shown.pixels(), [[0.25; 3], [1.0; 3], [f32::INFINITY; 3], [0.0; 3]]);
        assert_eq!(relative_to_largest(&Image::new(1, 1, false)), Image::new(1, 1, false));
    }
}
