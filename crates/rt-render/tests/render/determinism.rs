//! Determinism: the image is a function of scene, settings and seed, bit for bit.

use rt_camera::{Filter, SamplerKind};
use rt_image::Image;
use rt_math::Rgb;
use rt_render::{Crop, FirstHitLayer, PlanOptions, RunOptions};
use rt_scene_io::{Accel, Integrator, MaterialId, RenderSettings, Scene};
use rt_shading::{Background, ColorTexture, Material, MaterialModel, bsdf::ComplexIor};

use crate::support::{compile, compile_with, diffuse_shapes, everything, film, film_with, full, render, spheres};
use crate::{caustics, culling, lens, motion, nested};

/// Asserts that the image has more than this number of different pixels.
fn assert_interesting(film: &Image, count: usize) {
    let distinct: std::collections::HashSet<_> = film.pixels().iter().map(|p| p.map(f32::to_bits)).collect();
    assert!(distinct.len() > count, "only {} different pixels", distinct.len());
}

/// Spheres of surfaces that no other scene has, lit by a sky as well.
fn surfaces() -> Scene {
    let color = ColorTexture::Constant(Rgb::new(0.8, 0.7, 0.6));
    let models = [
        MaterialModel::Diffuse { albedo: color, roughness: 0.5 },
        MaterialModel::Conductor { ior: ComplexIor::GOLD, roughness: 0.2 },
        MaterialModel::MetallicRoughness { base_color: color, metallic: 0.3, roughness: 0.3 },
        MaterialModel::ThinGlass { ior: 1.5, transmittance: color },
    ];
    let mut scene = spheres();
    scene.appearance.materials = models.map(|model| Material::new("surface".into(), model)).into();
    scene.appearance.background = Background::Gradient { bottom: Rgb::gray(0.1), top: Rgb::new(0.2, 0.3, 0.5) };
    for (index, node) in (0..).zip(&mut scene.nodes) {
        node.material = MaterialId(index % 4);
    }
    scene
}

/// Scenes with all features, in images of four tiles.
fn scenes() -> [Scene; 10] {
    let scenes = [
        spheres(),
        surfaces(),
        everything(),
        diffuse_shapes(),
        lens::through_a_lens(everything()),
        motion::everything_moves(),
        motion::camera_moves(motion::everything_moves()),
        nested::drink(),
        caustics::comparable(),
        culling::surrounded(),
    ];
    scenes.map(|mut scene| {
        (scene.film.width, scene.film.height) = (18, 17);
        (scene.settings.spp, scene.settings.passes) = (4, Some(2));
        scene
    })
}

/// Each scene and each integrator meets all accelerators and all patterns, but not in all combinations.
#[test]
fn threads_accelerators_counters_and_plans_do_not_change_the_image() {
    for (row, mut scene) in scenes().into_iter().enumerate() {
        // The cost of accelerators is not that of other accelerators.
        let integrators = Integrator::ALL.into_iter().filter(|&integrator| integrator != Integrator::Cost);
        for (column, integrator) in integrators.enumerate() {
            let pattern = SamplerKind::ALL[(row + column) % SamplerKind::ALL.len()];
            scene.settings = RenderSettings { integrator, pattern, ..scene.settings };
            let render = |accel, options, threads, count| {
                let settings = RenderSettings { accel, ..scene.settings };
                let run = RunOptions { threads, count, maps: true, ..RunOptions::default() };
                render(&Scene { settings, ..scene.clone() }, options, run)
            };
            let one = render(Accel::Auto, PlanOptions::default(), 1, true);
            // Occlusion by four samples has at most five values.
            assert_interesting(&one.film, if integrator == Integrator::AmbientOcclusion { 1 } else { 16 });
            assert!(one.standard_error.is_some());
            assert_eq!((one.statistics.bad_samples, one.statistics.shading.interior_overflows), (0, 0));
            let many = render(Accel::Auto, PlanOptions::default(), [2, 3, 8][column % 3], true);
            assert_eq!(one.statistics.counters, many.statistics.counters, "{}: {integrator:?}", scene.name);
            let accel = |offset| Accel::ALL[(10 * row + column + offset) % Accel::ALL.len()];
            let others = [many, render(accel(0), full(), 2, false), render(accel(5), PlanOptions::default(), 1, false)];
            for (variant, other) in others.iter().enumerate() {
                let what =
                    format!("{}: {integrator:?}, {pattern:?}, {variant} of {:?}", scene.name, [accel(0), accel(5)]);
                assert_eq!(one.film, other.film, "{what}");
                assert_eq!(one.standard_error, other.standard_error, "{what}");
            }
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
fn crops_and_pixels_are_parts_of_the_whole() {
    let mut caustics = caustics::comparable();
    (caustics.settings.spp, caustics.settings.passes) = (8, Some(2));
    for (mut scene, [x, y, width, height]) in [(everything(), [17, 5, 30, 21]), (caustics, [5, 3, 12, 9])] {
        for (filter, transparent) in [(Filter::Box, false), (Filter::Mitchell, false), (Filter::Mitchell, true)] {
            scene.film.filter = filter;
            let options = PlanOptions { transparent, ..PlanOptions::default() };
            let whole = film_with(&scene, options, 0);
            let plan = compile_with(&scene, PlanOptions { crop: Some(Crop { x, y, width, height }), ..options });
            let part = plan.render(&RunOptions::default(), |_| {}).expect("threads start").film;
            assert_eq!((part.width(), part.height(), part.alpha().is_some()), (width, height, transparent));
            for (i, pixel) in part.pixels().iter().enumerate() {
                let [column, row] = [x + i as u32 % width, y + i as u32 / width];
                let place = (row * whole.width() + column) as usize;
                let what = format!("{}, {filter:?}: pixel {column}, {row}", scene.name);
                assert_eq!(*pixel, whole.pixels()[place], "{what}");
                assert_eq!(part.alpha().map(|alpha| alpha[i]), whole.alpha().map(|alpha| alpha[place]), "{what}");
                // One pixel takes all light paths.
                if i % 29 == 0 {
                    let exact = plan.pixel(column, row).expect("within the crop");
                    assert_eq!(exact.to_array().map(|c| c as f32), *pixel, "{what}");
                }
            }
            for (column, row) in [(x - 1, y), (x + width, y), (x, y - 1), (x, y + height)] {
                assert_eq!(plan.pixel(column, row), None, "{column} {row}");
            }
        }
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
