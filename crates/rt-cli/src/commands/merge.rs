//! `merge`: combines the shards of an image.

use std::path::{Path, PathBuf};

use indicatif::{HumanCount, HumanDuration};
use rt_image::write_image;
use rt_render::{MergeError, Rendering, Shard};

use crate::aov_file::AovFile;
use crate::args::MergeArgs;
use crate::artifact_error::{ArtifactError, ArtifactKind};
use crate::checkpoint_format::{self, Label};
use crate::console::Console;
use crate::error::CliError;
use crate::output_file::{OutputFile, fallback_dirs, write_all};
use crate::{image_file, memory, report, settings};

pub(super) fn run(args: &MergeArgs) -> Result<(), CliError> {
    let console = Console { quiet: args.quiet };
    let format = image_file::chosen_format(&args.output, args.output_format)?;
    let output = OutputFile::prepare(&args.output, &args.shards)?.with_extension(image_file::extension_of(format));
    let aovs = AovFile::prepare_all(&args.aov, &args.shards, &[&output])?;

    let (label, shards) = read(&args.shards, args.memory.limit())?;
    let count = shards.len();
    let rendering = Shard::merge(shards).map_err(|error| named(&args.shards, error))?.into_rendering();
    let Rendering { film, statistics, .. } = &rendering;
    let size = [film.width(), film.height()];
    image_file::check(&args.output, format, size, film.alpha().is_some())?;
    for aov in &aovs {
        aov.check(size, statistics.passes > 1)?;
    }
    let mut development = label.development();
    settings::apply_development(&args.development, &mut development);
    let fallback_dirs = fallback_dirs(args.fallback.dir.as_deref())?;
    write_all(
        core::iter::once(
            output.write_with_fallback(&fallback_dirs, |file| write_image(film, &development, format, file)),
        )
        .chain(aovs.iter().map(|aov| aov.write(&rendering, &[], &fallback_dirs))),
    )?;
    console.println(format_args!(
        "merged {count} shards: {} samples, {} rays, {} of rendering",
        HumanCount(statistics.samples),
        HumanCount(statistics.counters.total().rays),
        HumanDuration(std::time::Duration::try_from_secs_f64(statistics.render_seconds).unwrap_or_default()),
    ))?;
    if let Some(error) = &rendering.error {
        console.println(report::relative_error(error))?;
    }
    console.println(format_args!("wrote {} ({}x{})", image_file::written(&output, format), size[0], size[1]))
}

/// Reads all shards, and the label of the one with the lowest number. Predicts the memory of the shards from the file sizes, and
/// that of the image from the first shard.
fn read(files: &[PathBuf], memory: Option<u64>) -> Result<(Label, Vec<Shard>), CliError> {
    let lengths = files.iter().map(|file| checkpoint_format::length(file)).collect::<Result<Vec<_>, _>>()?;
    if let Some((file, _)) = files.iter().zip(&lengths).find(|(_, length)| **length == 0) {
        return Err(ArtifactError::Empty(file.clone()).into());
    }
    let decoded =
        lengths.iter().fold(0_u64, |sum, &length| sum.saturating_add(checkpoint_format::decoded_bytes(length)));
    let reading = lengths.iter().copied().max().unwrap_or(0);
    let of_shards =
        [(format!("the content of {} shards", files.len()), decoded), ("the shard being read".to_owned(), reading)];
    let together = match files {
        [file] => file.clone(),
        _ => PathBuf::from(format!("merging {} shards", files.len())),
    };
    let mut label: Option<(u32, Label)> = None;
    let mut shards = Vec::with_capacity(files.len());
    for file in files {
        // Report files that are not shards before the memory limit.
        checkpoint_format::label(file, ArtifactKind::Shard)?;
        if label.is_none() {
            memory::check(memory, &together, &of_shards)?;
        }
        let (of_shard, shard) = checkpoint_format::read::<Shard>(file, ArtifactKind::Shard, memory)?;
        let number = shard.spec().index();
        match &mut label {
            Some((_, label)) if label.identity != of_shard.identity => return Err(foreign(file, of_shard.scene)),
            Some(lowest) if number < lowest.0 => *lowest = (number, of_shard),
            Some(_) => {}
            None => {
                // No shard is read while the image is made. Encoding copies the colors.
                let bytes = shard.rendering_bytes();
                let image = ("the image".to_owned(), bytes.saturating_add(bytes / 2));
                memory::check(memory, &together, &[of_shards[0].clone(), image])?;
                label = Some((number, of_shard));
            }
        }
        shards.push(shard);
    }
    label.map(|(_, label)| (label, shards)).ok_or_else(|| named(files, MergeError::Nothing))
}

const FOREIGN_SHARD: &str =
    " from those of the earlier shards; render it again with the same scene and options; nothing was written";

fn foreign(file: &Path, scene: String) -> CliError {
    ArtifactError::Foreign { file: file.to_owned(), scene, advice: FOREIGN_SHARD }.into()
}

/// Replaces list indices of the error by file names.
fn named(files: &[PathBuf], error: MergeError) -> CliError {
    let name = |number: usize| files.get(number).map(|file| file.display().to_string()).unwrap_or_default();
    CliError::Join(match error {
        MergeError::Damaged(shard, reason) => {
            format!("{}: is not a valid shard, or does not fit the earlier shards: {reason}", name(shard))
        }
        MergeError::Foreign(shard) => {
            format!(
                "{}: has another size, or was made with other options (use --stats for all shards, or for none)",
                name(shard)
            )
        }
        MergeError::ShardCounts { shard, count, expected } => {
            format!(
                "{}: is one of {count} shards, but {} is one of {expected}; merge shards of one render",
                name(shard),
                name(0)
            )
        }
        MergeError::Doubled(one, other) if name(one) == name(other) => {
            format!("{} is given twice; remove one of them", name(one))
        }
        MergeError::Doubled(one, other) => {
            format!("{} and {} are the same shard; remove one of them", name(one), name(other))
        }
        MergeError::Unfinished { shard, missing } => {
            format!("{}: lacks {missing} of its tiles; finish it with --resume", name(shard))
        }
        MergeError::Missing(missing, count) if let [index] = missing[..] => {
            format!("shard {}/{count} is missing; render it", index + 1)
        }
        error => error.to_string(),
    })
}
