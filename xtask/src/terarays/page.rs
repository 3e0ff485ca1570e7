//! Results as a Markdown page.

use super::{
    estimate::{Quantity, best_seconds, best_spp, exponent, jackknife, rays, seconds},
    lecture_numbers::{PRIMARY_RAYS, RAYS, SECONDS, SIZE, STRATA, TILE_PIXELS, TILES},
    tile_job::{BEST, BEST_SPP, TileResult},
};
use crate::{
    number::{grouped, three_digits},
    table::Table,
};

/// Estimates for the whole image from at least one tile.
pub(super) fn table(tiles: &[TileResult]) -> Table {
    let done = tiles.len() as f64 / f64::from(TILES);
    let pixels = tiles.len() as u64 * u64::from(TILE_PIXELS);
    let mut table = Table::new(1, ["quantity", "estimate", "95 % interval"]);
    let all = grouped(u64::from(SIZE) * u64::from(SIZE));
    let part = format!("{} %: {} of {all} pixels", three_digits(100.0 * done), grouped(pixels));
    table.push(["part of the image that was rendered", &part, ""]);
    let mut row = |name: &str, of: Quantity<'_>, show: fn(f64) -> String| {
        let estimate = jackknife(tiles, of);
        let value = estimate.map_or_else(|| "the error does not fall".to_owned(), |estimate| show(estimate.value));
        let interval = estimate.and_then(|estimate| estimate.interval);
        let interval = interval.map(|[low, high]| format!("{} to {}", show(low), show(high)));
        table.push([name.to_owned(), value, interval.unwrap_or_default()]);
    };
    let rate = |means: &TileResult| rays(means) / seconds(means);
    row("rays of all kinds, traced in one processor second", &rate, three_digits);
    row("rays of all kinds that the whole image takes", &rays, power_of_ten);
    row("**processor time of the whole image**", &seconds, span);
    row("two years / that time", &|means| SECONDS / seconds(means), three_digits);
    row(&format!("processor time of {} rays of all kinds", power_of_ten(RAYS)), &|means| RAYS / rate(means), span);
    row("two years / that time", &|means| SECONDS / (RAYS / rate(means)), three_digits);
    row("RMSE of the whole image", &|means| means.jittered.mse.sqrt(), power_of_ten);
    for (index, spp) in BEST_SPP.into_iter().enumerate() {
        let name = format!("RMSE by `{BEST}`, {} samples per pixel", grouped(u64::from(spp)));
        row(&name, &|means| means.best[index].mse.sqrt(), power_of_ten);
    }
    row(&format!("k of RMSE ~ N⁻ᵏ by `{BEST}`"), &exponent, three_digits);
    row(&format!("samples per pixel for the RMSE of the whole image by `{BEST}`"), &best_spp, three_digits);
    row(&format!("**processor time of these by `{BEST}`**"), &best_seconds, span);
    row("two years / that time", &|means| SECONDS / best_seconds(means), three_digits);
    table
}

/// The whole page `docs/TERARAYS.md`.
pub(super) fn markdown(tiles: &[TileResult], processor: &str, commit: &str) -> String {
    format!(
        "# 10¹² rays\n\n\
         After reading this page you know how long the lecture's Cornell box of a trillion rays takes in rt, \
         and how to repeat the estimate.\n\n\
         The lecture shows a Cornell box of {SIZE}×{SIZE} pixels with {STRATA}×{STRATA} jittered primary rays per pixel. It \
         states a trillion rays and two years of processor time in all. The pixels and samples make {} primary rays. The \
         table is extrapolated from a random part of the image.\n\n\
         Written by `cargo xtask terarays --write` on one {processor}, with one thread, at commit {commit}. The command \
         stops after the time of `--budget` and continues in the next run. `cargo xtask terarays --budget 8h --write` makes \
         the intervals narrower.\n\n{}\n\
         ## Method\n\n\
         The scene is `scenes/lecture/cornell.ron`: the published geometry, reflectances and light, one shadow ray per hit, \
         at most 14 bounces, and Russian roulette. The lecture states neither the length of its paths nor which rays it \
         counts. Here \"rays of all kinds\" are all traced primary, secondary and shadow rays.\n\n\
         The image is divided into {} tiles of {TILE_PIXELS} pixels. They are rendered in random order, each with all \
         {STRATA}×{STRATA} strata, by the installed program. Times are processor times of the whole program, with \
         its start. Each tile is rendered twice with different seeds: half of the mean squared difference is the mean squared \
         error of one render. The time of one render counts. A third render counts the rays.\n\n\
         Intervals are those of the logarithm, by the jackknife over tiles and Student's t. They include the variation between \
         tiles, but not that of machine and load.\n\n\
         The same tiles are rendered with `{BEST}`, the sampler that reaches a given error in the minimum time. A line through the \
         logarithms of its errors and sample counts extrapolates to the error of the whole image.\n",
        grouped(PRIMARY_RAYS),
        table(tiles),
        grouped(u64::from(TILES)),
    )
}

/// A time in the unit that suits it.
fn span(seconds: f64) -> String {
    const UNITS: [(&str, f64); 4] =
        [("years", 365.25 * 86_400.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0)];
    match UNITS.into_iter().find(|(_, length)| seconds >= *length) {
        Some((name, length)) => format!("{} {name}", three_digits(seconds / length)),
        None => format!("{} s", three_digits(seconds)),
    }
}

/// A number with three digits and a power of ten, unless that is 1.
fn power_of_ten(number: f64) -> String {
    // Rust's own notation rounds to the nearest, and carries into the exponent.
    let text = format!("{number:.2e}");
    match text.split_once('e') {
        Some((digits, "0")) => digits.to_owned(),
        Some((digits, exponent)) => format!("{digits} · 10{}", superscript(exponent)),
        None => text,
    }
}

fn superscript(exponent: &str) -> String {
    let raise = |c: char| match c {
        '-' => '⁻',
        _ => c.to_digit(10).and_then(|digit| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize)).unwrap_or(c),
    };
    exponent.chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::{
        super::{lecture_numbers::Tile, tile_job::Measured},
        *,
    };

    #[test]
    fn numbers_read_well() {
        assert_eq!(
            [30.0, 90.0, 7200.0, 86_400.0 * 3.0, SECONDS].map(span),
            ["30.0 s", "1.50 minutes", "2.00 hours", "3.00 days", "2.00 years"]
        );
        assert_eq!(
            [1e12, 0.000_191, 9.999, 2.5].map(power_of_ten),
            ["1.00 · 10¹²", "1.91 · 10⁻⁴", "1.00 · 10¹", "2.50"]
        );
    }

    #[test]
    fn the_table_has_estimates_and_intervals() {
        let units = [0.9, 1.1].map(|seconds| {
            let measured = |spp: u32| Measured { cpu_seconds: seconds, mse: 1.0 / f64::from(spp) };
            TileResult {
                tile: Tile::nth(0).unwrap(),
                rays_per_sample: 10.0,
                jittered: measured(STRATA * STRATA),
                best: BEST_SPP.map(measured),
            }
        });
        let text = table(&units).to_string();
        let rows = text.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>().join("|") + "\n");
        let rows: String = rows.collect();
        // A million tiles of one second, and two years by that.
        assert!(rows.contains("image**|12.1 days|"), "{text}");
        assert!(rows.contains("|two years / that time|60.2|"), "{text}");
        assert!(rows.contains("RMSE of the whole image|3.15 · 10⁻³|3.15 · 10⁻³ to 3.15 · 10⁻³|"), "{text}");
        assert!(markdown(&units, "processor", "commit").contains(&text));
    }
}
