//! The program as its users meet it: the real binary, run in a folder of its own.

mod animating;
mod bad_input;
mod checking;
mod comparing;
mod converging;
mod converting;
mod determinism;
mod documentation;
mod interruption;
mod long_renders;
mod program;
mod rendering;
mod shards;
mod statistics;
mod stopping;
#[cfg(all(feature = "view", target_os = "linux"))]
mod viewing;
#[cfg(feature = "display")]
mod watching;
#[cfg(all(feature = "view", target_os = "linux"))]
mod x_screen;
