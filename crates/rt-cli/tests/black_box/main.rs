//! The program as its users meet it: the real binary, run in a folder of its own.

mod animating;
mod backdrops;
mod bad_input;
mod checking;
mod comparing;
mod completing;
mod converging;
mod converting;
mod determinism;
mod dithering;
mod documentation;
mod empty_images;
#[cfg(unix)]
mod hostile_files;
mod layers;
mod lighting;
mod long_renders;
mod piping;
mod program;
mod rendering;
mod shards;
mod statistics;
mod stopping;
#[cfg(feature = "view")]
mod view_browser;
#[cfg(feature = "view")]
mod view_server;
#[cfg(feature = "view")]
mod viewing;
#[cfg(feature = "display")]
mod watching;
