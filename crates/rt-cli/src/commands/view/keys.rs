//! What keys mean.

use rt_math::DVec3;
use winit::keyboard::{Key, KeyCode, NamedKey};

/// What is printed for `H`.
pub(super) const HELP: &str = "\
left button      drag: orbit around the target; click: what is there
right button     drag: look around
middle button    drag: shift the view
wheel            nearer to the target, and away from it
arrows           orbit by 5 degrees
W A S D E Q      fly forward, left, back, right, up, down; with Shift four times as fast
F                look at the point that was clicked last: it is the target from now on
R                back to where the camera was at first
P                print the camera, to be pasted into the scene file
H                print this
Esc              quit";

/// Angle of an arrow key in radians.
const STEP: f64 = 5.0 * core::f64::consts::PI / 180.0;

/// What a key does when it is pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Press {
    /// End the program.
    Quit,
    /// Print the keys.
    Help,
    /// Print the camera.
    PrintCamera,
    /// Back to the camera of the scene.
    Reset,
    /// Look at what was picked last.
    LookAtPicked,
    /// Go around the target, by radians to the right and up.
    Orbit(f64, f64),
}

/// What a key does when it is pressed, by what is printed on it.
pub(super) fn press(key: &Key) -> Option<Press> {
    Some(match key {
        Key::Named(NamedKey::Escape) => Press::Quit,
        Key::Named(NamedKey::ArrowLeft) => Press::Orbit(-STEP, 0.0),
        Key::Named(NamedKey::ArrowRight) => Press::Orbit(STEP, 0.0),
        Key::Named(NamedKey::ArrowUp) => Press::Orbit(0.0, STEP),
        Key::Named(NamedKey::ArrowDown) => Press::Orbit(0.0, -STEP),
        Key::Character(letter) => match letter.to_lowercase().as_str() {
            "h" => Press::Help,
            "p" => Press::PrintCamera,
            "r" => Press::Reset,
            "f" => Press::LookAtPicked,
            _ => return None,
        },
        _ => return None,
    })
}

/// Which way a key flies as long as it is held, by its place on the keyboard: along the camera's axes, to the right, up and
/// backward.
pub(super) fn flight(key: KeyCode) -> Option<DVec3> {
    Some(match key {
        KeyCode::KeyW => DVec3::NEG_Z,
        KeyCode::KeyS => DVec3::Z,
        KeyCode::KeyA => DVec3::NEG_X,
        KeyCode::KeyD => DVec3::X,
        KeyCode::KeyE => DVec3::Y,
        KeyCode::KeyQ => DVec3::NEG_Y,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn character(letter: &str) -> Option<Press> {
        press(&Key::Character(letter.into()))
    }

    #[test]
    fn letters_mean_the_same_in_both_cases() {
        for (small, large, meaning) in [
            ("h", "H", Press::Help),
            ("p", "P", Press::PrintCamera),
            ("r", "R", Press::Reset),
            ("f", "F", Press::LookAtPicked),
        ] {
            assert_eq!((character(small), character(large)), (Some(meaning), Some(meaning)));
        }
        assert_eq!((character("x"), character("")), (None, None));
        assert_eq!(press(&Key::Named(NamedKey::Escape)), Some(Press::Quit));
    }

    #[test]
    fn opposite_keys_undo_each_other() {
        let orbit = |key| match press(&Key::Named(key)) {
            Some(Press::Orbit(right, up)) => [right, up],
            other => panic!("{other:?}"),
        };
        for (key, opposite) in [(NamedKey::ArrowLeft, NamedKey::ArrowRight), (NamedKey::ArrowUp, NamedKey::ArrowDown)] {
            assert_eq!(orbit(key), orbit(opposite).map(|angle| -angle));
        }
        for (key, opposite) in
            [(KeyCode::KeyW, KeyCode::KeyS), (KeyCode::KeyA, KeyCode::KeyD), (KeyCode::KeyE, KeyCode::KeyQ)]
        {
            assert_eq!(flight(key), flight(opposite).map(|way| -way));
        }
        assert_eq!(flight(KeyCode::KeyP), None);
    }

    #[test]
    fn help_names_every_key_that_does_something() {
        for key in ["W A S D E Q", "\nF ", "\nR ", "\nP ", "\nH ", "\nEsc ", "\narrows "] {
            assert!(HELP.contains(key), "{key}");
        }
    }
}
