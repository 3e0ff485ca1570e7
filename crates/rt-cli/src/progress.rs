//! Progress of a render: a bar on a terminal, or a line every few seconds.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use rt_render::{ErrorProgress, PassProgress, Progress};

use crate::report::shown_percent;

const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Maximum remaining time that is shown, in seconds: 30 years.
const MAX_REMAINING: f64 = 1e9;

/// Progress on standard error.
#[derive(Debug)]
pub(crate) struct ProgressDisplay {
    started: Instant,
    /// Samples and rays of earlier runs.
    earlier: (u64, u64),
    form: Form,
}

#[derive(Debug)]
enum Form {
    Bar(ProgressBar),
    Lines { next: Instant },
    Quiet,
}

impl ProgressDisplay {
    pub(crate) fn new(quiet: bool, earlier_samples: u64, earlier_rays: u64) -> Self {
        let started = Instant::now();
        let form = if quiet {
            Form::Quiet
        } else if io::stderr().is_terminal() {
            Form::Bar(ProgressBar::no_length().with_style(bar_style()))
        } else {
            Form::Lines { next: started + LINE_INTERVAL }
        };
        Self { started, earlier: (earlier_samples, earlier_rays), form }
    }

    pub(crate) fn update(&mut self, progress: Progress) {
        let progress = capped(progress);
        match &mut self.form {
            Form::Bar(bar) => {
                bar.set_length(progress.total_samples);
                bar.set_message(status(progress, self.earlier, self.started.elapsed()));
                bar.set_position(progress.samples);
            }
            Form::Lines { next } => {
                let now = Instant::now();
                if now >= *next && progress.samples < progress.total_samples {
                    *next = now + LINE_INTERVAL;
                    let percent = progress.samples * 100 / progress.total_samples;
                    let status = status(progress, self.earlier, self.started.elapsed());
                    // A closed standard error does not stop the render.
                    let _ = writeln!(io::stderr().lock(), "{percent} %, {status}");
                }
            }
            Form::Quiet => {}
        }
    }

    pub(crate) fn finish(&self) {
        if let Form::Bar(bar) = &self.form {
            bar.finish_and_clear();
        }
    }
}

/// Shows at most 99 % until a target error is reached: the total is a forecast, and may be too low.
fn capped(progress: Progress) -> Progress {
    let is_reached = match progress.pass.and_then(|pass| pass.error_progress) {
        None => true,
        Some(ErrorProgress::Image { error, target }) => error <= target,
        Some(ErrorProgress::Pixels { share, target }) => share >= target,
    };
    let min_total = progress.samples.saturating_add((progress.samples / 99).max(1));
    let total_samples = if is_reached { progress.total_samples } else { progress.total_samples.max(min_total) };
    Progress { total_samples, ..progress }
}

fn bar_style() -> ProgressStyle {
    ProgressStyle::with_template("{bar:40} {percent} %, {msg}").unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Rate, and remaining time at the average time per sample so far.
fn status(progress: Progress, (earlier_samples, earlier_rays): (u64, u64), elapsed: Duration) -> String {
    let Progress { samples, total_samples, rays, pass } = progress;
    let done = samples.saturating_sub(earlier_samples);
    let rate = rays.saturating_sub(earlier_rays) as f64 / elapsed.as_secs_f64().max(1e-9) * 1e-6;
    // The total of a render with a target error is a forecast.
    let samples_left = total_samples.saturating_sub(samples).max(pass.map_or(0, |pass| pass.samples_left));
    let left = elapsed.as_secs_f64() * (samples_left as f64 / done.max(1) as f64);
    let left = HumanDuration(Duration::from_secs_f64(left.min(MAX_REMAINING)));
    let pass = match pass {
        Some(PassProgress { finished, spp, rmse: Some(rmse), error_progress, .. }) => {
            let error = match error_progress {
                None => format!("RMSE {rmse:.3e}"),
                Some(ErrorProgress::Image { error, target }) => {
                    format!("error {:.2} %, target {} %", 100.0 * error, shown_percent(target))
                }
                Some(ErrorProgress::Pixels { share, target }) => {
                    format!("{:.1} % of the pixels done, target {} %", 100.0 * share, shown_percent(target))
                }
            };
            format!("pass {}, {spp} spp, {error}, ", finished + 1)
        }
        Some(PassProgress { finished, .. }) => format!("pass {}, ", finished + 1),
        None => String::new(),
    };
    format!("{pass}{rate:.2} Mrays/s, {left} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_and_remaining_time_follow_from_what_is_done() {
        let progress = Progress { samples: 250, total_samples: 1000, rays: 30_000_000, pass: None };
        assert_eq!(status(progress, (0, 0), Duration::from_secs(20)), "1.50 Mrays/s, 60 seconds left");
        // What an earlier run has done took none of this time.
        assert_eq!(status(progress, (150, 10_000_000), Duration::from_secs(20)), "1.00 Mrays/s, 3 minutes left");
    }

    #[test]
    fn passes_tell_the_error_so_far() {
        let pass =
            Some(PassProgress { finished: 6, samples_left: 0, spp: 32, rmse: Some(0.001_234), error_progress: None });
        let progress = Progress { samples: 500, total_samples: 1000, rays: 1_000_000, pass };
        let expected = "pass 7, 32 spp, RMSE 1.234e-3, 1.00 Mrays/s, 1 second left";
        assert_eq!(status(progress, (0, 0), Duration::from_secs(1)), expected);
        let first = Progress {
            pass: Some(PassProgress { finished: 0, samples_left: 0, spp: 0, rmse: None, error_progress: None }),
            ..progress
        };
        assert!(status(first, (0, 0), Duration::from_secs(1)).starts_with("pass 1, 1.00 Mrays/s"));
        let shown = |error_progress| {
            let pass = Some(PassProgress {
                finished: 6,
                samples_left: 0,
                spp: 32,
                rmse: Some(0.1),
                error_progress: Some(error_progress),
            });
            status(Progress { pass, ..progress }, (0, 0), Duration::from_secs(1))
        };
        let image = shown(ErrorProgress::Image { error: 0.071, target: 0.05 });
        assert!(image.starts_with("pass 7, 32 spp, error 7.10 %, target 5 %, "), "{image}");
        let pixels = shown(ErrorProgress::Pixels { share: 0.931, target: 0.99 });
        assert!(pixels.starts_with("pass 7, 32 spp, 93.1 % of the pixels done, target 99 %, "), "{pixels}");
    }

    /// Regression: "0 seconds left" was shown for the last pass, which may be a quarter of the render.
    #[test]
    fn the_remaining_time_includes_the_pass() {
        let error_progress = Some(ErrorProgress::Image { error: 0.0201, target: 0.02 });
        let pass = Some(PassProgress { finished: 15, samples_left: 250, spp: 768, rmse: Some(0.1), error_progress });
        let progress = Progress { samples: 750, total_samples: 750, rays: 1_000_000, pass };
        let shown = status(capped(progress), (0, 0), Duration::from_secs(30));
        assert!(shown.ends_with(", 10 seconds left"), "{shown}");
    }

    #[test]
    fn progress_stays_below_100_percent_until_the_target_is_reached() {
        let percent = |error_progress| {
            let pass = Some(PassProgress { finished: 6, samples_left: 0, spp: 32, rmse: Some(0.1), error_progress });
            let shown = capped(Progress { samples: 5000, total_samples: 5000, rays: 1, pass });
            100 * shown.samples / shown.total_samples
        };
        assert_eq!(percent(Some(ErrorProgress::Pixels { share: 0.98, target: 0.99 })), 99);
        assert_eq!(percent(Some(ErrorProgress::Pixels { share: 0.99, target: 0.99 })), 100);
        assert_eq!(percent(Some(ErrorProgress::Image { error: 0.06, target: 0.05 })), 99);
        assert_eq!((percent(Some(ErrorProgress::Image { error: 0.05, target: 0.05 })), percent(None)), (100, 100));
        let open = Some(ErrorProgress::Pixels { share: 0.1, target: 0.99 });
        let pass = Some(PassProgress { finished: 6, samples_left: 0, spp: 32, rmse: Some(0.1), error_progress: open });
        let early = Progress { samples: 50, total_samples: 5000, rays: 1, pass };
        assert_eq!(capped(early).total_samples, 5000);
    }

    #[test]
    fn the_start_and_the_end_are_no_special_cases() {
        let start = Progress { samples: 0, total_samples: u64::MAX, rays: 0, pass: None };
        assert!(status(start, (0, 0), Duration::ZERO).starts_with("0.00 Mrays/s"));
        let end = Progress { samples: 1000, total_samples: 1000, rays: 2_000_000, pass: None };
        assert_eq!(status(end, (0, 0), Duration::from_secs(1)), "2.00 Mrays/s, 0 seconds left");
    }

    #[test]
    fn the_template_of_the_bar_is_valid() {
        assert!(ProgressStyle::with_template("{bar:40} {percent} %, {msg}").is_ok());
    }
}
