//! Unsafe code: allowed in one module of one crate.

/// Crate that denies unsafe code without forbidding it, because of one module.
const CRATE: &str = "crates/rt-accel/src/lib.rs";
const MODULE: &str = "crates/rt-accel/src/wide/mod.rs";

pub(super) fn breaches(path: &str, source: &str) -> Vec<String> {
    breach(path, source).map(|what| format!("{path}: {what}")).into_iter().collect()
}

fn breach(path: &str, source: &str) -> Option<&'static str> {
    let has_line = |start: &str| source.lines().any(|line| line.starts_with(start));
    let is_root = path.starts_with("crates/") && (path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs"));
    if path == CRATE && !has_line("#![deny(unsafe_code)]") {
        Some("unsafe code is not denied")
    } else if is_root && path != CRATE && !has_line("#![forbid(unsafe_code)]") {
        Some("unsafe code is not forbidden")
    } else if path != MODULE && (has_line("#![allow(unsafe_code") || has_line("#[allow(unsafe_code")) {
        Some("unsafe code is allowed outside of the module that is for it")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_module_may_be_unsafe() {
        let root = "crates/rt-math/src/lib.rs";
        assert_eq!(breach(root, "#![forbid(unsafe_code)]\n"), None);
        assert_eq!(breach(root, "#![deny(unsafe_code)]\n"), Some("unsafe code is not forbidden"));
        assert_eq!(breach(CRATE, "#![deny(unsafe_code)]\n"), None);
        assert_eq!(breach(CRATE, ""), Some("unsafe code is not denied"));
        let allowing = "#![allow(unsafe_code, reason = \"speed\")]\n";
        assert_eq!(breach(MODULE, allowing), None);
        assert!(breach("crates/rt-accel/src/bvh/mod.rs", allowing).is_some());
        assert_eq!(breach("crates/rt-accel/src/bvh/mod.rs", ""), None);
    }
}
