//! Default values of fields, and conditions for leaving fields out, as serde calls them.

#![expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]

pub(super) fn one() -> f64 {
    1.0
}

pub(super) fn half() -> f64 {
    0.5
}

pub(super) fn yes() -> bool {
    true
}

pub(super) fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

pub(super) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

pub(super) fn is_yes(value: &bool) -> bool {
    *value
}
