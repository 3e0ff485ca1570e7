//! The figures as Markdown.

use super::{Figure, Figures, peers::PEERS};
use crate::number::three_digits;

/// A row for each number of threads and samples.
pub(super) fn markdown(figures: &Figures) -> String {
    let mut text =
        String::from("| threads | samples | processor s | wall s | RMSE | relMSE | mean : reference | 1 / (MSE · s)");
    text.extend(PEERS.map(|peer| format!(" | [{}] | ours : that", peer.name)));
    text.push_str(" |\n|--:|--:|--:|--:|--:|--:|--:|--:");
    text.push_str(&"|--:|--:".repeat(PEERS.len()));
    text.push_str("|\n");
    text.extend(figures.figures.iter().map(row));
    text.push_str(&format!(
        "\nMeans of {} renders with different seeds, sampler `{}`, of the whole process from start to written picture. \
         [{}]\n",
        figures.seeds, figures.sampler, figures.peers_source,
    ));
    text
}

fn row(figure: &Figure) -> String {
    let threads = figure.threads.map_or_else(|| "all".to_owned(), |threads| threads.to_string());
    let mut text = format!(
        "| {threads} | {} | {:.3} | {:.3} | {:.5} | {:.5} | {:.4} | {}",
        figure.spp,
        figure.cpu_seconds,
        figure.wall_seconds,
        figure.rmse,
        figure.relative_mse,
        figure.mean_ratio,
        three_digits(figure.efficiency),
    );
    text.extend(PEERS.iter().map(|peer| match peer.at(figure.spp) {
        Some(point) => {
            format!(" | {} | {}", three_digits(point.efficiency), three_digits(figure.efficiency / point.efficiency))
        }
        None => " | | ".to_owned(),
    }));
    text.push_str(" |\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_compares_efficiency_at_equal_samples() {
        let figure = Figure {
            threads: Some(1),
            spp: 16,
            cpu_seconds: 0.5,
            wall_seconds: 0.6,
            rmse: 0.01,
            relative_mse: 0.005,
            mean_ratio: 1.0,
            efficiency: 20_000.0,
        };
        let expected =
            "| 1 | 16 | 0.500 | 0.600 | 0.01000 | 0.00500 | 1.0000 | 20,000 | 7,629 | 2.62 | 1,906 | 10.5 |\n";
        assert_eq!(row(&figure), expected);
        let other = row(&Figure { threads: None, spp: 17, ..figure });
        assert!(other.starts_with("| all | 17 ") && other.ends_with("| 20,000 | |  | |  |\n"), "{other}");
    }
}
