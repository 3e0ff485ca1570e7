//! Parts that a plan leaves out cost no work, as counters show.

use rt_geometry::RayKind;
use rt_math::Rgb;
use rt_render::{PlanOptions, RunOptions, ShardSpec, Statistics};
use rt_scene_io::{Accel, Scene};
use rt_shading::{ColorTexture, ShadingCounts};

use crate::support::{compile, compile_with, everything, full, node, render, sphere, spheres};

const COUNT: RunOptions<'_> =
    RunOptions { threads: 1, count: true, maps: false, shard: ShardSpec::ALL, interrupt: None, layers: &[] };

fn statistics(scene: &Scene) -> Statistics {
    render(scene, PlanOptions::default(), COUNT).statistics
}

fn rays(statistics: &Statistics, kind: RayKind) -> u64 {
    statistics.counters.of(kind).rays
}

#[test]
fn brute_force_tests_each_sphere_once_per_primary_ray() {
    let mut scene = spheres();
    scene.settings.accel = Accel::Linear;
    let statistics = statistics(&scene);
    let primary = statistics.counters.of(RayKind::Primary);
    assert_eq!(primary.rays, 61 * 43 * 4);
    assert_eq!(primary.tests, primary.rays * 27);
}

#[test]
fn diffuse_spheres_need_no_secondary_rays_and_no_optics() {
    let statistics = statistics(&spheres());
    for kind in [RayKind::Reflection, RayKind::Refraction, RayKind::Diffuse] {
        assert_eq!(rays(&statistics, kind), 0);
    }
    let skipped = statistics.shading.shadow_rays_skipped;
    assert_eq!(
        statistics.shading.without_lanes(),
        ShadingCounts { shadow_rays_skipped: skipped, ..ShadingCounts::default() }
    );
    let hits = (rays(&statistics, RayKind::Shadow) + skipped) / 2;
    assert!(skipped > 0 && hits > 1000, "two shadow rays are traced or skipped for each of {hits} hits");
}

#[test]
fn the_full_scene_uses_everything() {
    let statistics = statistics(&everything());
    for kind in [RayKind::Primary, RayKind::Shadow, RayKind::Reflection, RayKind::Refraction] {
        assert!(rays(&statistics, kind) > 0, "{kind:?}");
    }
    let ShadingCounts { highlights, mirrors, refractions, fresnel, absorption, .. } = statistics.shading;
    assert!(highlights > 0 && mirrors > 0 && refractions > fresnel && fresnel > 0 && absorption > 0);
}

#[test]
fn no_shadow_rays_where_nothing_casts_shadows() {
    let mut by_light = spheres();
    by_light.appearance.lights.iter_mut().for_each(|light| light.casts_shadows = false);
    let mut by_object = spheres();
    by_object.nodes.iter_mut().for_each(|node| node.casts_shadow = false);
    for scene in [by_light, by_object] {
        let statistics = statistics(&scene);
        assert_eq!((rays(&statistics, RayKind::Shadow), statistics.shading.shadow_rays_skipped), (0, 0));
    }
}

#[test]
fn unused_materials_cost_nothing() {
    let mut scene = everything();
    scene.nodes = vec![node(sphere(0.0, 0.0, 0.0, 1.0), 5)];
    let statistics = statistics(&scene);
    let ShadingCounts { highlights, mirrors, refractions, .. } = statistics.shading;
    assert_eq!((highlights, mirrors, refractions), (0, 0, 0));
}

#[test]
fn invalid_samples_are_counted_and_black() {
    for bad in [f64::NAN, f64::INFINITY, -1e3, 1e39] {
        let mut scene = spheres();
        scene.appearance.materials[0].emission = ColorTexture::Constant(Rgb::new(bad, 0.0, 0.0));
        let rendering = render(&scene, PlanOptions::default(), COUNT);
        assert!(rendering.statistics.bad_samples > 0, "{bad}");
        assert!(rendering.film.pixels().iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{bad}");
    }
}

#[test]
fn explanations_name_what_is_left_out() {
    let scene = spheres();
    let left_out: Vec<_> = compile(&scene).explain().left_out.iter().map(|left| left.what).collect();
    for what in ["triangles", "texture coordinates", "textures", "reflection", "refraction", "highlights", "ray tree"] {
        assert!(left_out.contains(&what), "{what} in {left_out:?}");
    }
    let scene = everything();
    let left_out: Vec<_> = compile(&scene).explain().left_out.iter().map(|left| left.what).collect();
    assert_eq!(left_out, ["alpha channel", "motion blur", "lens", "texture coordinates of some surfaces"]);
    assert!(compile_with(&scene, full()).explain().left_out.is_empty());
}
