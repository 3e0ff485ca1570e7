//! Files of `--aov`.

use std::path::PathBuf;

use rt_image::{Development, Image, ImageFormat, Layer, color_rows, write_image, write_layers};
use rt_render::{FilmLayers, FirstHitLayer, Rendering};

use crate::args::{Aov, AovArg, AovContent, LayerList};
use crate::error::{CliError, usage};
use crate::image_file;
use crate::output_error::OutputError;
use crate::output_file::OutputFile;

/// File of `--aov`: either a map, of standard errors or sample counts, or the image and its layers in one OpenEXR file.
#[derive(Debug)]
pub(crate) struct AovFile {
    content: AovContent,
    format: ImageFormat,
    output: OutputFile,
}

impl AovFile {
    fn prepare(arg: &AovArg, inputs: &[PathBuf]) -> Result<Self, CliError> {
        let format = image_file::format_of(&arg.file)?;
        Ok(Self { content: arg.content.clone(), format, output: OutputFile::prepare(&arg.file, inputs)? })
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
                return usage(format!(
                    "two outputs have the same file {}; choose another name for one",
                    arg.file.display()
                ));
            }
            aovs.push(aov);
        }
        Ok(aovs)
    }

    pub(crate) const fn output(&self) -> &OutputFile {
        &self.output
    }

    /// True if it needs the sums of all passes.
    pub(crate) const fn needs_maps(&self) -> bool {
        self.content.needs_maps()
    }

    /// Layers of first hits in the file.
    pub(crate) fn first_hit_layers(&self) -> &[FirstHitLayer] {
        match &self.content {
            AovContent::Map(_) => &[],
            AovContent::Layers(list) => &list.first_hit,
        }
    }

    /// Refuses outputs that cannot be estimated or stored.
    pub(crate) fn check(&self, size: [u32; 2], several_passes: bool) -> Result<(), CliError> {
        let needs_passes = match &self.content {
            AovContent::Map(map) => *map == Aov::Stderr,
            AovContent::Layers(list) => list.stderr,
        };
        if needs_passes && !several_passes {
            return usage("--aov stderr needs at least two passes; render with --passes 4");
        }
        image_file::check(self.output.path(), self.format, size, false)
    }

    /// Bytes of the image and its layers for this number of pixels. The file is at most as large.
    pub(crate) fn layer_bytes(&self, pixels: u64) -> u64 {
        let AovContent::Layers(list) = &self.content else { return 0 };
        let of_hits: usize = list.first_hit.iter().map(|layer| layer.channels().len()).sum();
        let of_maps = 3 * (usize::from(list.samples) + usize::from(list.stderr || list.is_all));
        pixels.saturating_mul(4 * (of_hits + of_maps + 4) as u64)
    }

    /// Writes the file, if need be to a fallback directory. `attributes` describe the render.
    pub(crate) fn write(
        &self,
        rendering: &Rendering,
        attributes: &[(&str, String)],
        fallback_dirs: &[PathBuf],
    ) -> Result<(), OutputError> {
        match &self.content {
            AovContent::Map(map) => self.write_map(*map, rendering, fallback_dirs),
            AovContent::Layers(list) => self.output.write_with_fallback(fallback_dirs, |file| {
                write_layers(&rendering.film, layers(list, rendering), attributes, file)
            }),
        }
    }

    fn write_map(&self, map: Aov, rendering: &Rendering, fallback_dirs: &[PathBuf]) -> Result<(), OutputError> {
        let film = match map {
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

/// All layers of a file with the names of their channels.
fn layers<'a>(list: &LayerList, rendering: &'a Rendering) -> Vec<Layer<'a>> {
    let of_film = |film: &'a FilmLayers, layer: FirstHitLayer| Layer {
        name: layer.name(),
        channels: (layer.channels().iter().enumerate())
            .map(|(at, name)| (*name, Box::new(move |y, row: &mut [f32]| film.read_row(layer, at, y, row)) as _))
            .collect(),
    };
    let mut layers: Vec<Layer<'_>> = match &rendering.layers {
        Some(film) => list.first_hit.iter().map(|&layer| of_film(film, layer)).collect(),
        None => Vec::new(),
    };
    if let Some(counts) = rendering.sample_counts.as_ref().filter(|_| list.samples) {
        layers.push(Layer { name: "samples", channels: vec![("V", color_rows(counts, 0))] });
    }
    // A single pass has no standard error.
    let has_errors = list.stderr || (list.is_all && rendering.statistics.passes > 1);
    if let Some(errors) = rendering.standard_error.as_ref().filter(|_| has_errors) {
        let channels = ["R", "G", "B"].into_iter().enumerate().map(|(at, name)| (name, color_rows(errors, at)));
        layers.push(Layer { name: "stderr", channels: channels.collect() });
    }
    layers
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
