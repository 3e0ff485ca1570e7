//! `compare`: difference of an image from a reference.

mod measures;
mod pair;
mod report;
mod verdict;

use rt_image::metrics::{ColourScale, heat_map};
use rt_image::{Development, write_image};

use self::measures::Measures;
use self::pair::Images;
use self::report::{Comparison, HeatMap};
use self::verdict::verdict;
use crate::args::{CompareArgs, HeatMapOf, Metric};
use crate::console::{print, show};
use crate::error::{CliError, usage};
use crate::image_file;
use crate::output_file::OutputFile;
use crate::stdin::is_dash;

/// Quantile of the errors at the end of the default color scale. The few larger ones would hide all others.
const SHOWN_ERRORS: f64 = 0.999;

pub(super) fn run(args: &CompareArgs) -> Result<(), CliError> {
    let output = args.heat_map.file.as_ref().map(|file| {
        if is_dash(file) && args.json {
            return usage("the heat map and the report cannot both go to standard output; name a file for one");
        }
        if !image_file::is_developed(image_file::chosen_format(file, None)?) {
            return usage(format!("--heat-map {} must be .png or .jpg", file.display()));
        }
        Ok(OutputFile::prepare(file, &[args.test.clone(), args.reference.clone()])?)
    });
    let output = output.transpose()?;
    let images = Images::read(args)?;
    if let Some(option) = needs_radiance(args).filter(|_| !images.are_radiance()) {
        return usage(format!("{option} hdr-flip requires linear images: .exr, .hdr or .pfm"));
    }
    let pair = images.pair(args)?;
    let measures = Measures::new(&pair, &images, args)?;
    let verdict = verdict(args, &measures)?;
    let heat_map = output.map(|output| draw(args, &measures, &output)).transpose()?;
    let comparison = Comparison { args, images: &images, pair: &pair, measures: &measures, heat_map, verdict };
    if args.json {
        print(comparison.json())?;
    } else {
        show(comparison.text())?;
    }
    comparison.failure().map_or(Ok(()), Err)
}

/// Option that requires HDR-FLIP.
fn needs_radiance(args: &CompareArgs) -> Option<&'static str> {
    if args.metric == Metric::HdrFlip {
        Some("--metric")
    } else if args.heat_map.shows == HeatMapOf::HdrFlip {
        Some("--heat-map-of")
    } else {
        None
    }
}

fn draw(args: &CompareArgs, measures: &Measures, output: &OutputFile) -> Result<HeatMap, CliError> {
    let shows = args.heat_map.shows;
    let (map, scale, limit) = match shows {
        HeatMapOf::Error => {
            let map = &measures.signed_error;
            let common = map.magnitude_quantile(SHOWN_ERRORS);
            (Some(map), ColourScale::Signed, if common > 0.0 { common } else { map.magnitude_quantile(1.0) })
        }
        HeatMapOf::Flip => (Some(&measures.flip), ColourScale::Magnitude, 1.0),
        HeatMapOf::HdrFlip => (measures.hdr_flip.as_ref().map(|(map, _)| map), ColourScale::Magnitude, 1.0),
    };
    let limit = args.heat_map.scale.unwrap_or(limit);
    if let Some(map) = map {
        let format = image_file::chosen_format(args.heat_map.file.as_deref().unwrap_or(output.path()), None)?;
        let image = heat_map(map, scale, limit);
        image_file::check(output.path(), format, [image.width(), image.height()], false)?;
        output.write(|file| write_image(&image, &Development::default(), format, file))?;
    }
    Ok(HeatMap { file: output.path().to_owned(), shows, limit })
}
