//! All models behind a shading normal that was turned towards the viewer: the view is at grazing angles, on the
//! viewer's side.

use super::{
    chi_square::{chi_square, ior, threshold},
    furnace::energy,
    sphere::Sphere,
    *,
};
use crate::{
    vertex::Vertex,
    viewed_surface::{ViewedSurface, is_inside},
};
use rt_geometry::SurfaceInteraction;

/// A surface with the outside above y = 0 and a shading normal that faces away from the viewer.
struct AwayFacing {
    wo: DVec3,
    surface: SurfaceInteraction,
}

fn away_facing(index: u64) -> Option<AwayFacing> {
    let number = |dimension| random::unit(random::hash(&[97, index, dimension]));
    let unit = |dimension| {
        let y = 0.02 + 0.7 * number(dimension);
        let (sin, cos) = transcendental::sincos(core::f64::consts::TAU * number(dimension + 1));
        let across = (1.0 - y * y).sqrt();
        DVec3::new(across * cos, y, across * sin)
    };
    let (wo, normal) = (unit(0), unit(2));
    // From the inside as well: a point mirrored in the floor.
    let wo = if index.is_multiple_of(2) { wo } else { DVec3 { y: -wo.y, ..wo } };
    let side = wo.y.signum();
    let surface = SurfaceInteraction {
        shading_normal: normal,
        ..SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y, [0.0; 2])
    };
    (side * normal.dot(wo) < -0.01).then_some(AwayFacing { wo, surface })
}

fn away_facing_views(count: usize) -> impl Iterator<Item = AwayFacing> {
    (0..).filter_map(away_facing).take(count)
}

fn vertex<'a>(away: &AwayFacing, surface: &'a mut SurfaceInteraction, bsdf: &'a Bsdf) -> Vertex<'a> {
    let inside = is_inside(-away.wo, surface);
    Vertex::new(ViewedSurface::new(-away.wo, inside, surface), bsdf, 0.0)
}

/// Rounding chose the side, and with it reflection, transmission, and the index of refraction.
#[test]
fn the_geometric_normal_decides_about_the_viewers_side() {
    let bsdf = Lambert { albedo: Rgb::WHITE }.into();
    for away in away_facing_views(5000) {
        let mut surface = away.surface;
        let seen = vertex(&away, &mut surface, &bsdf).wo;
        assert!(seen.z * away.wo.y.signum() > 1e-9 && seen.z.abs() < 1e-7, "{} is seen as {seen}", away.wo);
        assert!((seen.length() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn no_surface_whose_shading_normal_faces_away_is_brighter_than_the_furnace() {
    const SAMPLES: u64 = 4000;
    for (at, Surface { name, bsdf }) in surfaces().iter().chain(&leaning()).enumerate() {
        for (view, away) in away_facing_views(8).enumerate() {
            if disperses(bsdf) {
                continue;
            }
            let mut surface = away.surface;
            let vertex = vertex(&away, &mut surface, bsdf);
            let (mut sum, mut squares) = (0.0, 0.0);
            for index in 0..SAMPLES {
                let sample = bsdf.sample(vertex.wo, numbers((at * 100 + view) as u64, index));
                let kept = sample.and_then(|sample| Some((vertex.continued(&sample, true)?, sample)));
                let Some((wi, sample)) = kept else { continue };
                // Light stays on its side of the actual surface, or passes to the other.
                let stays = (wi.y > 0.0) == (away.wo.y > 0.0);
                assert_eq!(stays, sample.kind == Scattering::Reflection, "{name}: {wi}");
                let x = energy(&sample);
                assert!(x.is_finite() && x >= 0.0, "{name}: {x}");
                sum += x;
                squares += x * x;
            }
            let n = SAMPLES as f64;
            let mean = sum / n;
            let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
            assert!(mean <= 1.0 + 5.0 * error + 1e-9, "{name}, view {view}: {mean} ± {error}");
        }
    }
}

#[test]
fn samples_at_shading_normals_that_face_away_follow_their_density() {
    let all = surfaces().into_iter().chain(leaning());
    let surfaces: Vec<Surface> = all.filter(|surface| !surface.bsdf.is_delta()).collect();
    let limit = threshold(surfaces.len() * 2);
    for (at, Surface { name, bsdf }) in surfaces.iter().enumerate() {
        for (view, away) in away_facing_views(2).enumerate() {
            let mut surface = away.surface;
            let wo = vertex(&away, &mut surface, bsdf).wo;
            let seed = 30_000 + (at * 2 + view) as u64;
            let outcome =
                chi_square(&Sphere::around(wo, ior(bsdf)), seed, |wi| bsdf.pdf(wo, wi), |u| bsdf.sample(wo, u));
            println!("{name} from {wo}: z = {:.2}, ∫ pdf = {:.6}", outcome.z, outcome.total);
            assert!(outcome.z < limit && outcome.total < 1.001, "{name} from {wo}: {:.2} {}", outcome.z, outcome.total);
        }
    }
}
