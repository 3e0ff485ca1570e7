//! Scenes to measure with, of any size, and rays through them: even and uneven, spheres, solids and triangles.

pub(crate) mod gears;
mod model;
mod mound;
pub(crate) mod rays;
mod rock;
mod scene;
mod sphereflake;
mod stadium;
mod tree;

pub(crate) use model::model;
pub(crate) use mound::mound;
pub(crate) use rock::{data as rock_data, rock};
pub(crate) use scene::{Scene, Surfaces};
use scene::{mesh, nearest};
pub(crate) use sphereflake::sphereflake;
pub(crate) use stadium::stadium;
pub(crate) use tree::tree;

#[cfg(test)]
mod tests {
    use rt_geometry::Primitives as _;

    use super::*;

    #[test]
    fn scenes_have_the_member_of_their_series_next_to_the_wanted_size() {
        let sizes = |wanted: usize| {
            [
                mound(wanted).unwrap().primitives.len(),
                sphereflake(wanted).unwrap().primitives.len(),
                tree(wanted).unwrap().primitives.len(),
                gears::gears(wanted).unwrap().primitives.len(),
                rock(wanted).unwrap().primitives.len(),
                stadium(wanted).unwrap().primitives.len(),
            ]
        };
        let stands = 16 * (1 + 2 * 11);
        assert_eq!(sizes(1_000), [1_000, 820, 1_022, 576, 1_280, 1_280 + stands]);
        assert_eq!(sizes(10_000), [10_000, 7_381, 8_190, 15_552, 5_120, 5_120 + stands]);
    }

    #[test]
    fn every_scene_is_seen_and_has_surfaces_to_go_on_from() {
        fn seen(scene: &Scene<impl Surfaces>) {
            let linear = rt_accel::Linear::build(&scene.primitives).unwrap();
            let primary = rays::primary(&scene.view, 400);
            let surfaces = rays::surfaces(&scene.primitives, &linear, &primary);
            assert!(surfaces.len() > 10, "{}: {} hits", scene.name, surfaces.len());
        }
        seen(&mound(500).unwrap());
        seen(&sphereflake(500).unwrap());
        seen(&tree(500).unwrap());
        seen(&gears::gears(500).unwrap());
        seen(&rock(500).unwrap());
        seen(&stadium(500).unwrap());
    }
}
