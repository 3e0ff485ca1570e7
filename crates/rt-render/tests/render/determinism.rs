//! Determinism: the image is a function of scene, settings and seed, bit for bit.

use rt_camera::{Filter, SamplerKind};
use rt_image::Image;
use rt_math::Rgb;
use rt_render::{Crop, FirstHitLayer, PlanOptions, Precision, Quality, RunOptions, SimdLevel};
use rt_scene_io::{Accel, Integrator};
use rt_shading::ColorTexture;

use crate::support::{compile, diffuse_shapes, everything, film, full, render, spheres};

/// Asserts that the image is neither black nor constant.
fn assert_interesting(film: &Image) {
    let distinct: std::collections::HashSet<_> = film.pixels().iter().map(|p| p.map(f32::to_bits)).collect();
    assert!(distinct.len() > film.pixels().len() / 10, "only {} different pixels", distinct.len());
}

#[test]
fn threads_do_not_change_the_image() {
    for scene in [spheres(), everything(), diffuse_shapes()] {
        let one =
            render(&scene, PlanOptions::default(), RunOptions { threads: 1, count: true, ..RunOptions::default() });
        assert_interesting(&one.film);
        for threads in [2, 3, 8] {
            let many =
                render(&scene, PlanOptions::default(), RunOptions { threads, count: true, ..RunOptions::default() });
            assert_eq!(one.film, many.film, "{}: {threads} threads", scene.name);
            assert_eq!(one.statistics.counters, many.statistics.counters, "{}: {threads} threads", scene.name);
        }
    }
}

/// A render that waits for its threads must not start another render of the caller's pool on the same stack: stacks would overflow.
#[test]
fn renders_on_threads_of_a_pool_do_not_nest() {
    use rayon::prelude::*;
    thread_local!(static RENDERS: core::cell::Cell<u32> = const { core::cell::Cell::new(0) });
    let scene = spheres();
    let plan = compile(&scene);
    let run = RunOptions { threads: 2, ..RunOptions::default() };
    let deepest = |render: &(dyn Fn() + Sync)| {
        let depth = |_| {
            let depth = RENDERS.get() + 1;
            RENDERS.set(depth);
            render();
            RENDERS.set(depth - 1);
            depth
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
        pool.install(|| (0..200).into_par_iter().map(depth).max())
    };
    assert_eq!(deepest(&|| drop(plan.render(&run, |_| {}))), Some(1), "images");
    let layers = [FirstHitLayer::Depth];
    assert_eq!(deepest(&|| drop(plan.first_hit_layers(&layers, 1, 2))), Some(1), "layers");
}

#[test]
fn structures_do_not_change_the_image() {
    for mut scene in [spheres(), everything(), diffuse_shapes()] {
        let auto = film(&scene);
        for accel in Accel::ALL {
            scene.settings.accel = accel;
            assert_eq!(auto, film(&scene), "{}: {accel:?}", scene.name);
        }
    }
}

#[test]
fn instructions_and_qualities_do_not_change_the_image() {
    for mut scene in [spheres(), everything(), diffuse_shapes()] {
        let auto = film(&scene);
        scene.settings.accel = Accel::Wide;
        for &simd in SimdLevel::ALL.iter().filter(|level| level.is_available()) {
            for &quality in Quality::ALL {
                let options = PlanOptions { simd: Some(simd), quality, ..PlanOptions::default() };
                let film = render(&scene, options, RunOptions::default()).film;
                assert_eq!(auto, film, "{}: {simd:?}, {quality:?}", scene.name);
            }
        }
    }
}

#[test]
fn trimming_does_not_change_the_image() {
    for mut scene in [spheres(), everything()] {
        for integrator in [Integrator::Whitted, Integrator::Normals, Integrator::Depth, Integrator::Uv] {
            scene.settings.integrator = integrator;
            let full = render(&scene, full(), RunOptions::default());
            assert_eq!(film(&scene), full.film, "{}: {integrator:?}", scene.name);
        }
    }
}

/// Path tracing shades this scene in `f32`, and all others in `f64`.
#[test]
fn trimming_does_not_change_paths_in_streams() {
    let mut scene = diffuse_shapes();
    for integrator in [Integrator::Path, Integrator::Direct, Integrator::Caustics] {
        scene.settings.integrator = integrator;
        let rendered = |options| render(&scene, options, RunOptions::default()).film;
        let trimmed = film(&scene);
        assert_interesting(&trimmed);
        assert_eq!(trimmed, rendered(full()), "{integrator:?}");
        let exact = rendered(PlanOptions { precision: Precision::F64, ..PlanOptions::default() });
        let differ = trimmed.pixels().iter().flatten().zip(exact.pixels().iter().flatten());
        let differ = differ.map(|(a, b)| (a - b).abs() / b.max(1e-3)).fold(0.0, f32::max);
        assert!((1e-9..1e-3).contains(&differ), "{integrator:?}: {differ:e}");
    }
}

#[test]
fn counting_does_not_change_the_image() {
    let scene = everything();
    let counted = render(&scene, PlanOptions::default(), RunOptions { count: true, ..RunOptions::default() });
    assert_eq!(film(&scene), counted.film);
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let mut scene = everything();
    scene.film.filter = Filter::Mitchell;
    let whole = film(&scene);
    let crop = Crop { x: 17, y: 5, width: 30, height: 21 };
    let shard = render(&scene, PlanOptions { crop: Some(crop), ..PlanOptions::default() }, RunOptions::default()).film;
    for y in 0..crop.height {
        for x in 0..crop.width {
            let inside = shard.pixels()[(y * crop.width + x) as usize];
            let outside = whole.pixels()[((y + crop.y) * whole.width() + x + crop.x) as usize];
            assert_eq!(inside, outside, "pixel {x}, {y} of the crop");
        }
    }
}

#[test]
fn seeds_and_patterns_do_change_the_image() {
    let mut scene = spheres();
    let mut films = vec![];
    for pattern in SamplerKind::ALL {
        scene.settings.pattern = pattern;
        films.push(film(&scene));
    }
    scene.settings.seed = 1;
    films.push(film(&scene));
    for (i, a) in films.iter().enumerate() {
        for b in &films[..i] {
            assert_ne!(a, b);
        }
    }
}

#[test]
fn images_of_any_shape_are_covered() {
    let mut scene = spheres();
    scene.appearance.materials[0].emission = ColorTexture::Constant(Rgb::gray(0.01));
    for (width, height) in [(1, 1), (1, 300), (300, 1), (16, 16), (17, 15)] {
        (scene.film.width, scene.film.height) = (width, height);
        let film = film(&scene);
        assert!(film.pixels().iter().all(|p| p.iter().all(|c| *c > 0.0)), "{width}×{height}");
    }
}

#[test]
fn filters_keep_flat_areas_flat() {
    let mut scene = spheres();
    scene.nodes.clear();
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { sigma: 0.7 }, Filter::Mitchell] {
        for spp in [1, 2, 4, 16] {
            (scene.film.filter, scene.settings.spp) = (filter, spp);
            let film = film(&scene);
            assert!(film.pixels().iter().all(|p| (p[2] - 0.3).abs() < 1e-6), "{filter:?}, {spp} samples");
        }
    }
}
