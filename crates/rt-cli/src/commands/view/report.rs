//! What was picked, in words.

use rt_math::DVec3;
use rt_render::PickResult;

/// One line on what was picked; nothing stands for the background.
pub(super) fn picked_text(picked: Option<&PickResult>) -> String {
    let Some(PickResult { object, material, distance, point: DVec3 { x, y, z }, .. }) = picked else {
        return "picked the background".to_owned();
    };
    let named: Vec<_> = object.iter().filter(|name| !name.is_empty()).map(|name| format!("'{name}'")).collect();
    let object = if named.is_empty() { "an object without a name".to_owned() } else { named.join(" > ") };
    format!("picked {object}, material '{material}', distance {distance:.6}, point ({x:.6}, {y:.6}, {z:.6})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_picked_is_said_in_a_line() {
        let mut picked = PickResult {
            object: vec!["tree".to_owned(), "leaf".to_owned()],
            material: "green".to_owned(),
            distance: 2.5,
            point: DVec3::new(1.0, -0.25, 1e-9),
            normal: DVec3::Y,
        };
        let place = "material 'green', distance 2.500000, point (1.000000, -0.250000, 0.000000)";
        assert_eq!(picked_text(Some(&picked)), format!("picked 'tree' > 'leaf', {place}"));
        picked.object = vec![String::new()];
        assert_eq!(picked_text(Some(&picked)), format!("picked an object without a name, {place}"));
        assert_eq!(picked_text(None), "picked the background");
    }
}
