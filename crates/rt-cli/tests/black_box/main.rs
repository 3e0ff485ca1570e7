//! The program as its users meet it: the real binary, run in a folder of its own.

mod bad_input;
mod checking;
mod comparing;
mod converging;
mod converting;
mod determinism;
mod documentation;
mod interruption;
mod program;
mod rendering;
mod statistics;
mod stopping;
