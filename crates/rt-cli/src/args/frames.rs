//! Frames of an animation.

use std::fmt;
use std::ops::RangeInclusive;

use clap::Args;

use super::values;

/// Which frames to render.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "What")]
pub(crate) struct FramesArgs {
    /// Render these frames of an animation, from A to B, both included; or the single frame N; or all
    #[arg(long, value_name = "A..B|N|all", value_parser = choice, conflicts_with = "at_time", long_help = FRAMES_HELP)]
    pub(crate) frames: Option<FrameChoice>,
}

/// The frames that are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameChoice {
    /// Those of the animation.
    All,
    /// These.
    Some(Frames),
}

const FRAMES_HELP: &str = "\
Render these frames of an animation, from A to B, both included; or the single frame N; or all

Frame N shows the moment N / FPS, as --at-time does with the same --fps, and is a render of its own. `all` are the frames whose moments \
lie before the last key of all animations: 48 of one that takes 2 s, at 24 frames a second. In the names of all files \
that are written, the last run of # stands for the number of the frame, with zeros before it: frame 7 of -o out-####.png goes \
to out-0007.png. By default, that is the scene's name with -####.png, in the current folder.";

/// Frames in a row, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frames {
    first: u32,
    last: u32,
}

impl Frames {
    /// True if there is but one.
    pub(crate) const fn is_single(self) -> bool {
        self.first == self.last
    }

    /// True if that is one of them.
    pub(crate) fn contains(self, frame: u32) -> bool {
        self.numbers().contains(&frame)
    }

    /// Their numbers.
    pub(crate) const fn numbers(self) -> RangeInclusive<u32> {
        self.first..=self.last
    }
}

impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, last } = self;
        if self.is_single() { write!(f, "{first}") } else { write!(f, "{first}..{last}") }
    }
}

impl Frames {
    /// All frames of an animation that takes so many seconds, at least one; `None` if there are too many to be numbered.
    pub(crate) fn of_animation(seconds: f64, fps: f64) -> Option<Self> {
        // The product may be off a whole number by rounding.
        let count = (seconds * fps * (1.0 - 1e-9)).ceil().max(1.0);
        (count <= f64::from(u32::MAX)).then(|| Self { first: 0, last: count as u32 - 1 })
    }
}

/// `A..B`, `N` or `all`.
fn choice(text: &str) -> Result<FrameChoice, String> {
    if text == "all" { Ok(FrameChoice::All) } else { frames(text).map(FrameChoice::Some) }
}

/// `A..B` or `N`.
fn frames(text: &str) -> Result<Frames, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let rule = "write the first and the last frame as 0..47, or the number of a single one, up to 4294967295, or all";
    let number = |text: &str| text.parse().ok().filter(|_| !text.starts_with('+')).ok_or_else(|| rule.to_owned());
    let frames = Frames { first: number(first)?, last: number(last)? };
    if frames.first > frames.last {
        return Err(format!("the first frame comes after the last; write {}..{}", frames.last, frames.first));
    }
    Ok(frames)
}

/// The pace of an animation, and what of it is seen at once.
#[derive(Clone, Debug, Args)]
pub(crate) struct PaceArgs {
    /// Frames of a second, for --frames; and for the blur of what moves, with --at-time
    #[arg(long, value_name = "F", value_parser = values::positive, default_value = "24")]
    pub(crate) fps: f64,

    /// When the shutters of all cameras open and close: 0,0.5 blurs what moves in the first half of a frame
    ///
    /// From 0, the moment of a frame, to 1, that of the next. By default as the scene says: an animation is sharp without.
    #[arg(long, value_name = "OPENS,CLOSES", value_parser = shutter)]
    pub(crate) shutter: Option<[f64; 2]>,
}

impl PaceArgs {
    /// The moment of a frame, in seconds.
    pub(crate) fn moment(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }
}

/// `OPENS,CLOSES`.
fn shutter(text: &str) -> Result<[f64; 2], String> {
    let parsed = text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    let sound = parsed.filter(|&[opens, closes]: &[f64; 2]| 0.0 <= opens && opens <= closes && closes <= 1.0);
    sound.ok_or_else(|| "write two numbers from 0 to 1, the smaller first, as 0,0.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_frames_are_included() {
        let numbers = |text: &str| frames(text).expect("frames").numbers().collect::<Vec<_>>();
        assert_eq!(numbers("3..5"), [3, 4, 5]);
        assert_eq!((numbers("7"), numbers("0..0")), (vec![7], vec![0]));
        for bad in ["", "..", "1..", "..2", "5..3", "-1..2", "1..+2", "1..2..3", "a", "1.5", "1-3", "0..4294967296"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn all_frames_lie_before_the_end() {
        let count = |seconds, fps| Frames::of_animation(seconds, fps).map(|frames| frames.numbers().count());
        for (seconds, fps, expected) in
            [(2.0, 24.0, 48), (0.5, 8.0, 4), (0.55, 10.0, 6), (0.1, 30.0, 3), (0.0, 24.0, 1), (-3.0, 24.0, 1)]
        {
            assert_eq!(count(seconds, fps), Some(expected), "{seconds} s, {fps}");
        }
        // Thirds of a second are no binary fractions.
        assert_eq!(count(f64::from(10.0f32 / 3.0), 30.0), Some(100));
        assert_eq!(count(1e60, 24.0), None);
        assert_eq!((choice("all"), choice("3").is_ok()), (Ok(FrameChoice::All), true));
    }

    #[test]
    fn shutters_open_before_they_close() {
        assert_eq!((shutter("0,0.5"), shutter("1, 1")), (Ok([0.0, 0.5]), Ok([1.0, 1.0])));
        for bad in ["", "0.5", "0.5,0", "-0.1,1", "0,1.1", "nan,1", "0,nan", "0,0.5,1"] {
            assert!(shutter(bad).is_err(), "{bad}");
        }
    }
}
