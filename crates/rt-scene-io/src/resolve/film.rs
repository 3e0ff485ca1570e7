//! Settings of the image.

use rt_camera::{FilmSettings, Filter};
use rt_image::{Development, Dither, Encoding};
use rt_math::DVec2;

use super::value::{positive, within};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{LoadErrorKind, limits};

/// The image. A field that is wrong keeps its default after it is reported.
pub(super) fn film(report: &mut Diagnostics, film: &format::Film) -> FilmSettings {
    let default = FilmSettings::default();
    let (width, height) = report.check("film.size", size(film.size)).unwrap_or((default.width, default.height));
    let [x, y] = film.sample_offset;
    report.check("film.sample_offset", within(x, 0.0, 1.0).and(within(y, 0.0, 1.0)));
    report
        .check("film.exposure", within(film.exposure, *Development::EXPOSURES.start(), *Development::EXPOSURES.end()));
    let filter = match film.filter {
        format::Filter::Box => Filter::Box,
        format::Filter::Tent => Filter::Tent,
        format::Filter::Gaussian(sigma) => {
            report.check("film.filter", positive(sigma).and(within(sigma, 0.0, limits::FILTER_SIGMA)));
            Filter::Gaussian { sigma }
        }
        format::Filter::Mitchell => Filter::Mitchell,
    };
    let encoding = match film.encoding {
        format::Encoding::Srgb => Encoding::Srgb,
        format::Encoding::Gamma(gamma) => {
            report.check("film.encoding", within(gamma, *Development::GAMMAS.start(), *Development::GAMMAS.end()));
            Encoding::Power(gamma)
        }
    };
    let development = Development {
        exposure: film.exposure,
        tone: film.tone.into(),
        encoding,
        dither: film.dither.then(Dither::default),
    };
    FilmSettings { width, height, sample_offset: DVec2::new(x, y), filter, development }
}

fn size((width, height): (u64, u64)) -> Result<(u32, u32), LoadErrorKind> {
    let shown = || format!("{width}x{height}");
    if width == 0 || height == 0 {
        return Err(LoadErrorKind::invalid(shown(), "pixels: both sides must be at least 1"));
    }
    if width.saturating_mul(height) > limits::FILM_PIXELS {
        return Err(LoadErrorKind::invalid(shown(), "pixels are more than 2^28: choose a smaller image"));
    }
    // Both fit, because their product does.
    Ok((width as u32, height as u32))
}
