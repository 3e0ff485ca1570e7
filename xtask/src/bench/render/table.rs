//! The figures as Markdown.

use super::{Figure, Figures, peers::Peer};
use crate::{
    bench::spread::Spread,
    number::{grouped, three_digits},
};

/// A row for each scene.
pub(super) fn markdown(figures: &Figures) -> String {
    let mut text = String::from(
        "| scene | pixels, samples | camera + shadow rays | processor s | wall s | peak MiB | 8×8: wall ms | fastest peer, \
         processor s | peer : ours |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    text.extend(figures.scenes.iter().map(row));
    text.push_str(&format!(
        "\nMedian (least..greatest) of the whole process. A run that does nothing has a peak of {} MiB. Shadow rays \
         count as the report counts them, also those that need not be traced. {}\n",
        mebibytes(figures.least_bytes),
        figures.peers,
    ));
    text
}

fn row(figure: &Figure) -> String {
    let Figure { scene, size: (width, height), spp, .. } = figure;
    let Spread { median, min, max } = figure.cpu_seconds;
    let (peer, ratio) = match figure.fastest_peer {
        Some(Peer { renderer, cpu_seconds, .. }) => {
            (format!("[{renderer} {cpu_seconds:.2}]"), three_digits(cpu_seconds / median))
        }
        None => Default::default(),
    };
    format!(
        "| {scene} | {width}×{height}, {spp} | {} + {} | {median:.3} ({min:.3}..{max:.3}) | {:.3} | {} | {:.1} | {peer} | \
         {ratio} |\n",
        grouped(figure.primary_rays),
        grouped(figure.shadow_rays),
        figure.wall_seconds.median,
        mebibytes(figure.peak_bytes),
        figure.small_wall_seconds.median * 1e3,
    )
}

fn mebibytes(bytes: u64) -> String {
    three_digits(bytes as f64 / f64::from(1 << 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_compares_processor_seconds() {
        let spread = |median| Spread { median, min: 0.4, max: 0.6 };
        let peer = Peer { scene: "s", renderer: "Other", cpu_seconds: 1.0 };
        let figure = Figure {
            scene: "s".into(),
            size: (4, 3),
            spp: 2,
            threads: 1,
            primary_rays: 24,
            shadow_rays: 1000,
            all_rays: 1024,
            cpu_seconds: spread(0.5),
            wall_seconds: spread(0.55),
            peak_bytes: 3 << 19,
            small_wall_seconds: spread(0.5),
            fastest_peer: Some(peer),
            picture: "s.png".into(),
        };
        let row = row(&figure);
        assert_eq!(
            row,
            "| s | 4×3, 2 | 24 + 1,000 | 0.500 (0.400..0.600) | 0.550 | 1.50 | 500.0 | [Other 1.00] | 2.00 |\n"
        );
    }
}
