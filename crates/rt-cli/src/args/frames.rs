//! Frames of an animation.

use std::fmt;
use std::ops::RangeInclusive;

use clap::Args;

use super::values;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera and scene")]
pub(crate) struct FramesArgs {
    /// Render the frames A to B of an animation (inclusive), the single frame N, or all
    #[arg(long, value_name = "A..B|N|all", value_parser = choice, allow_hyphen_values = true, conflicts_with = "at_time", group = "time_of_animation", long_help = FRAMES_HELP)]
    pub(crate) frames: Option<FrameChoice>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameChoice {
    All,
    Some(Frames),
}

const FRAMES_HELP: &str = "\
Render the frames A to B of an animation (inclusive), the single frame N, or all

Frame N is at N / FPS seconds, and is rendered as by --at-time. `all` selects the frames before the last key of all animations: 48 \
frames for 2 s at 24 frames per second. In all output names, the last run of # is replaced by the frame number, padded with zeros: -o \
out-####.png writes frame 7 to out-0007.png [default of -o: SCENE-####.png].";

/// Range of frame indices, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frames {
    first: u32,
    last: u32,
}

impl Frames {
    pub(crate) const fn is_single(self) -> bool {
        self.first == self.last
    }

    pub(crate) fn contains(self, frame: u32) -> bool {
        self.indices().contains(&frame)
    }

    pub(crate) const fn indices(self) -> RangeInclusive<u32> {
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
    /// All frames of an animation of this length, at least one; `None` if there are too many to number.
    pub(crate) fn of_animation(seconds: f64, fps: f64) -> Option<Self> {
        // Times of glTF keys are `f32`, with a relative error of up to 2^-24.
        let count = (seconds * fps * (1.0 - f64::from(f32::EPSILON))).ceil().max(1.0);
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
    let rule = "expected the first and last frame, such as 0..47, a single frame, such as 7, or all; frames are at most 4294967295";
    let number = |text: &str| text.parse().ok().filter(|_| !text.starts_with('+')).ok_or_else(|| rule.to_owned());
    let frames = Frames { first: number(first)?, last: number(last)? };
    if frames.first > frames.last {
        return Err(format!("the first frame comes after the last; write {}..{}", frames.last, frames.first));
    }
    Ok(frames)
}

#[derive(Clone, Debug, Args)]
pub(crate) struct TimingArgs {
    /// Set the frames per second, for --shutter
    #[arg(long, value_name = "F", value_parser = values::positive, allow_negative_numbers = true, default_value = "24")]
    pub(crate) fps: f64,

    /// Set the shutter interval of all cameras as fractions of a frame, such as 0,0.5 [default: as in the scene]
    ///
    /// 0 is the time of the frame and 1 that of the next frame. Motion is blurred between the two; an interval of length 0 has no
    /// motion blur.
    #[arg(long, value_name = "OPENS,CLOSES", value_parser = shutter, allow_hyphen_values = true)]
    pub(crate) shutter: Option<[f64; 2]>,
}

impl TimingArgs {
    /// Time of a frame in seconds.
    pub(crate) fn time_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }
}

/// `OPENS,CLOSES`.
fn shutter(text: &str) -> Result<[f64; 2], String> {
    let parsed = text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    let sound = parsed.filter(|&[opens, closes]: &[f64; 2]| 0.0 <= opens && opens <= closes && closes <= 1.0);
    sound.ok_or_else(|| "expected two numbers from 0 to 1, the smaller first, such as 0,0.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_frames_are_included() {
        let numbers = |text: &str| frames(text).expect("frames").indices().collect::<Vec<_>>();
        assert_eq!(numbers("3..5"), [3, 4, 5]);
        assert_eq!((numbers("7"), numbers("0..0")), (vec![7], vec![0]));
        for bad in ["", "..", "1..", "..2", "5..3", "-1..2", "1..+2", "1..2..3", "a", "1.5", "1-3", "0..4294967296"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn all_frames_lie_before_the_end_also_of_keys_in_single_precision() {
        let count = |seconds, fps| Frames::of_animation(seconds, fps).map(|frames| frames.indices().count());
        for (seconds, fps, expected) in
            [(2.0, 24.0, 48), (0.5, 8.0, 4), (0.55, 10.0, 6), (0.1, 30.0, 3), (0.0, 24.0, 1), (-3.0, 24.0, 1)]
        {
            assert_eq!(count(seconds, fps), Some(expected), "{seconds} s, {fps}");
        }
        // Rounding to `f32` made the end of these later than their last frame, and one frame too many was rendered.
        for length in 1..10_000_u16 {
            for fps in [10.0, 24.0, 30.0, 60.0] {
                assert_eq!(
                    count(f64::from((f64::from(length) / fps) as f32), fps),
                    Some(length.into()),
                    "{length} at {fps}"
                );
            }
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
