//! Passes compiler and flags to the program, for the reports of measured times.

use std::env;
use std::process::Command;

fn main() {
    let variable = |name: &str| env::var(name).unwrap_or_default();
    let compiler = Command::new(variable("RUSTC")).arg("--version").output();
    let compiler = compiler.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default();
    let flags =
        format!("opt-level {}, target features {}", variable("OPT_LEVEL"), variable("CARGO_CFG_TARGET_FEATURE"));
    println!("cargo::rustc-env=RT_CLI_COMPILER={compiler}");
    println!("cargo::rustc-env=RT_CLI_FLAGS={flags}");
    println!("cargo::rustc-env=RT_CLI_TARGET={}", variable("TARGET"));
    println!("cargo::rerun-if-changed=build.rs");
}
