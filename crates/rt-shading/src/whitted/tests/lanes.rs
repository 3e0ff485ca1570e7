//! Tests of shading in SIMD lanes: radiance, counts and shadow rays have the bits of hits that are shaded one by one.

use super::super::*;
use crate::{
    Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, Highlight, InteriorMedium, LazyHit, LazyPlane,
    LightUnits, Material, Phong, SurfaceHit, Texture, TextureId, Transmission, TrianglePoint, lanes::LANES,
};
use rt_geometry::{InteractionFlags, Plane, Sphere};
use rt_math::{DVec3, random};

/// Position of the first light.
const LIGHT: DVec3 = DVec3::new(0.7, 1.9, -0.4);

/// A world in which each ray hits a shape that is made of random numbers from the bits of the ray.
#[derive(Default)]
struct RandomShapes {
    n_materials: u32,
    /// Bits of all shadow rays and their intervals, in an order of their own.
    shadow_rays: Vec<[u64; 9]>,
}

/// A hit on a shape of any kind.
enum RandomHit {
    Sphere(LazyHit<Sphere>),
    Triangle(LazyHit<TrianglePoint>),
    Plane(LazyHit<LazyPlane>),
}

impl RandomHit {
    fn surface(&self, ray: &Ray) -> SurfaceHit {
        match self {
            Self::Sphere(hit) => hit.surface(ray),
            Self::Triangle(hit) => hit.surface(ray),
            Self::Plane(hit) => hit.surface(ray),
        }
    }

    fn closest(&self) -> ClosestHit<'_> {
        match self {
            Self::Sphere(hit) => ClosestHit::Sphere(hit),
            Self::Triangle(hit) => ClosestHit::Triangle(hit),
            Self::Plane(hit) => ClosestHit::Plane(hit),
        }
    }
}

fn bits_of(ray: &Ray, span: Interval) -> [u64; 9] {
    let [[a, b, c], [d, e, f]] = [ray.origin, ray.direction].map(|v| v.to_array());
    [a, b, c, d, e, f, ray.time, span.min, span.max].map(f64::to_bits)
}

/// Triangle around a point, with a unit normal that is perpendicular to it.
fn triangle_around(point: DVec3, normal: DVec3, vector: impl Fn(u64) -> DVec3) -> TrianglePoint {
    let across = |v: DVec3| v - normal * v.dot(normal);
    let (b, c) = (across(vector(10)), across(vector(13)));
    let v = 0.5 + 0.5 * vector(16).x;
    let w = (1.0 - v) * (0.5 + 0.5 * vector(16).y);
    let a = point - b * v - c * w;
    let uv = |at: u64| {
        let uv = vector(at) * 3.0;
        // One of 64 is not finite.
        let u = if vector(at + 3).x > 0.96875 { f64::INFINITY } else { uv.x };
        [u as f32, uv.y as f32]
    };
    TrianglePoint { vertices: [a, a + b, a + c], uv: [v, w], normal, vertex_uvs: [uv(20), uv(30), uv(40)] }
}

impl RandomShapes {
    fn hit(&self, ray: &Ray, span: Interval) -> Option<RandomHit> {
        let key = random::hash(&bits_of(ray, span));
        let number = |at: u64| random::unit(random::hash(&[key, at]));
        let vector = |at: u64| DVec3::new(number(at), number(at + 1), number(at + 2)) * 2.0 - 1.0;
        let (t, radius) = (0.5 + number(0), 0.2 + number(1));
        let point = ray.at(t);
        let (point, outside) = match (number(2) * 12.0) as u32 {
            0 => return None,
            // The ray is perpendicular to the surface.
            1 => (point, -ray.direction),
            // The surface is where x = 0, as some rays are.
            2 => (DVec3::new(0.0, point.y, point.z), if number(7) < 0.5 { DVec3::X } else { DVec3::NEG_Y }),
            // The light is on the tangent plane, up to rounding.
            3 => {
                let to_light = (LIGHT - point).normalize();
                let aside = vector(4);
                (point, aside - to_light * aside.dot(to_light))
            }
            _ => (point, vector(4)),
        };
        let material = (number(3) * f64::from(self.n_materials + 1)) as u32;
        let normal = outside.normalize();
        Some(match (number(8) * 3.0) as u32 {
            0 => {
                let shape = Sphere::new(point - normal * radius, radius).ok()?;
                RandomHit::Sphere(LazyHit { t, shape, object: material, material, light: None })
            }
            1 => {
                let shape = triangle_around(point, normal, vector);
                RandomHit::Triangle(LazyHit { t, shape, object: material, material, light: None })
            }
            _ => {
                let aside = vector(10) - normal * vector(10).dot(normal);
                let plane = Plane::new(point + aside, normal).ok()?;
                let shape = LazyPlane { plane, needs_uv: number(9) < 0.9 };
                RandomHit::Plane(LazyHit { t, shape, object: material, material, light: None })
            }
        })
    }
}

impl SceneQueries for RandomShapes {
    fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, _: InteractionFlags) -> Option<SurfaceHit> {
        Some(self.hit(ray, span)?.surface(ray))
    }

    fn closest_hits(
        &mut self,
        rays: &[(Ray, Interval)],
        _: RayKind,
        _: (InteractionFlags, LazyShapes),
        mut met: impl FnMut(usize, Option<ClosestHit<'_>>),
    ) {
        for (at, (ray, span)) in rays.iter().enumerate() {
            let hit = self.hit(ray, *span);
            match (hit, at % 7) {
                (Some(hit), 6) => met(at, Some(ClosestHit::Surface(&mut hit.surface(ray)))),
                (hit, _) => met(at, hit.as_ref().map(RandomHit::closest)),
            }
        }
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        self.shadow_rays.push(bits_of(ray, span));
        random::hash(&bits_of(ray, span)).is_multiple_of(3)
    }
}

fn lights() -> Vec<DeltaLight> {
    let kinds = [
        DeltaLightKind::Point { position: LIGHT, falloff: Falloff::InverseSquare, shadow_near: 0.0 },
        DeltaLightKind::Point { position: DVec3::new(-5.0, 4.0, 3.0), falloff: Falloff::None, shadow_near: 0.3 },
        DeltaLightKind::Directional { direction: DVec3::new(0.48, -0.6, 0.64) },
        DeltaLightKind::Spot {
            position: DVec3::new(2.0, 5.0, 1.0),
            direction: DVec3::NEG_Y,
            cos_inner: 0.9,
            cos_outer: 0.7,
            falloff: Falloff::InverseSquare,
        },
        DeltaLightKind::Spot {
            position: DVec3::new(0.0, 0.0, 6.0),
            direction: DVec3::NEG_Z,
            cos_inner: 0.8,
            cos_outer: -0.5,
            falloff: Falloff::None,
        },
    ];
    let light = |(at, kind): (usize, DeltaLightKind)| DeltaLight {
        name: String::new(),
        kind,
        intensity: Rgb::new(0.9, 0.3 * at as f64, 0.7),
        units: if at % 2 == 0 { LightUnits::Classical } else { LightUnits::Physical },
        casts_shadows: at != 4,
    };
    let mut lights: Vec<_> = kinds.into_iter().enumerate().map(light).collect();
    let dark = DeltaLight { intensity: Rgb::BLACK, ..lights[0].clone() };
    lights.push(dark);
    lights
}

pub(in crate::whitted) fn appearance() -> Appearance {
    let color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let textured = |id| ColorTexture::Textured(TextureId(id), Rgb::new(0.9, 0.8, 0.7));
    let checker = textured(0);
    let matte = Phong { diffuse: color(0.5, 0.6, 0.2), ambient: color(0.2, 0.1, 0.3), ..Phong::default() };
    let shiny = |highlight, exponent| Phong { specular: color(0.3, 0.2, 0.5), highlight, exponent, ..matte };
    let mut phongs = vec![matte, Phong { mirror: color(0.5, 0.4, 0.3), ..shiny(Highlight::Phong, 3.0) }, Phong::BLACK];
    for highlight in [Highlight::Phong, Highlight::Blinn] {
        phongs.extend([0.0, 1.0, 40.0, 2.5, 2000.0].map(|exponent| shiny(highlight, exponent)));
    }
    phongs.push(Phong { diffuse: checker, specular: checker, ..shiny(Highlight::Phong, 7.0) });
    phongs.push(Phong { ambient: checker, mirror: textured(1), ..shiny(Highlight::Blinn, 7.0) });
    // Squares of two sizes, and a texture that lanes do not evaluate.
    phongs.push(Phong { diffuse: checker, specular: textured(2), ..shiny(Highlight::Phong, 2.0) });
    phongs.push(Phong { diffuse: checker, specular: textured(3), ..shiny(Highlight::Phong, 2.0) });
    phongs.push(Phong { diffuse: ColorTexture::ZERO, mirror: color(0.0, 0.1, 0.2), ..shiny(Highlight::Blinn, 9.0) });
    let mut materials: Vec<_> = phongs.into_iter().map(|phong| Material::new(String::new(), phong)).collect();
    materials[0].emission = color(0.1, 0.2, 0.3);
    materials[1].emission = checker;
    let transmission = |fresnel| Some(Transmission { coefficient: color(0.9, 0.8, 0.9), fresnel });
    let glass = |fresnel| Phong { transmission: transmission(fresnel), mirror: color(1.0, 0.9, 1.0), ..matte };
    let tinted = Phong { transmission: Some(Transmission { coefficient: checker, fresnel: false }), ..glass(true) };
    let clear = Transmission { coefficient: color(1.0, 1.0, 1.0), fresnel: true };
    let clear = Phong { transmission: Some(clear), mirror: color(1.0, 1.0, 1.0), ..Phong::BLACK };
    let absorbing = InteriorMedium { absorption: Rgb::new(0.1, 0.0, 0.2), ..InteriorMedium::clear(1.5) };
    for (phong, interior) in [
        (glass(true), Some(absorbing)),
        (glass(true), Some(InteriorMedium::clear(1.5))),
        (glass(false), Some(InteriorMedium::clear(2.4))),
        (glass(true), None),
        (tinted, Some(absorbing)),
        (clear, Some(InteriorMedium::clear(1.0))),
        (clear, Some(InteriorMedium { priority: 3, ..InteriorMedium::clear(1.3) })),
    ] {
        materials.push(Material { interior, ..Material::new(String::new(), phong) });
    }
    Appearance {
        materials,
        textures: vec![
            Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 0.6 },
            Texture::Checker { even: Rgb::new(0.1, 0.2, 0.3), odd: Rgb::new(0.9, 0.0, 0.5), size: 0.6 },
            Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 1.7 },
            Texture::VertexColor(None),
        ],
        lights: lights(),
        ambient: Rgb::new(0.1, 0.2, 0.1),
        background: Background::Constant(Rgb::new(0.2, 0.3, 0.5)),
    }
}

/// Bits of the radiance of camera rays, with the counts but those of lanes, and the bits of shadow rays.
type LaneOutcome = (Vec<([u64; 3], bool)>, ShadingCounts, Vec<[u64; 9]>);

fn outcome(mut whitted: Whitted, appearance: &Appearance, n_rays: u32) -> LaneOutcome {
    let number = |at: u32, k: u64| random::unit(random::hash(&[u64::from(n_rays), u64::from(at), k])) - 0.5;
    // Some rays stay where x = 0, as do the shadow rays from there.
    let across = |at: u32| if at.is_multiple_of(5) { DVec3::new(0.0, 1.0, 1.0) } else { DVec3::ONE };
    let vector = |at, k| DVec3::new(number(at, k), number(at, k + 1), number(at, k + 2)) * across(at);
    let ray = |at| Ray { time: number(at, 6), ..Ray::new(vector(at, 0), vector(at, 3)) };
    let rays: Vec<_> = (0..n_rays).map(|at| (ray(at), Interval::FORWARD)).collect();
    let mut seen = vec![RadianceSample::MISS; rays.len()];
    let n_materials = appearance.materials.len() as u32;
    let mut world = RandomShapes { n_materials, ..RandomShapes::default() };
    whitted.radiance_of(&mut world, appearance, &rays, &mut seen);
    let counts = whitted.take_counts();
    if whitted.lanes.is_none() {
        assert_eq!([counts.lanes, counts.lanes_used], [0; 2]);
    } else if n_rays == 1 {
        // One hit at most in each wave.
        assert!(counts.lanes_used * LANES as u64 <= counts.lanes, "{counts:?}");
    } else if n_rays > 1000 {
        // Few lanes are empty, and few hits are shaded by themselves.
        assert!((counts.lanes / 2..=counts.lanes).contains(&counts.lanes_used), "{counts:?}");
    }
    world.shadow_rays.sort_unstable();
    let seen = seen.iter().map(|seen| (seen.radiance.to_array().map(f64::to_bits), seen.hit)).collect();
    (seen, counts.without_lanes(), world.shadow_rays)
}

/// Outcomes in lanes, the same at all levels, and one by one; both one by one without AVX2.
fn both(depth: u32, features: ShadingFeatures, appearance: &Appearance, n_rays: u32) -> [LaneOutcome; 2] {
    let [avx2, best, by_itself] = [LaneLevel::avx2(), LaneLevel::best(), None].map(|level| {
        let mut whitted = Whitted::new(depth, 0.01, features);
        if let Some(level) = level {
            whitted.shade_in_lanes(level, appearance);
        }
        outcome(whitted, appearance, n_rays)
    });
    if LaneLevel::best().is_none() {
        println!("skipped: this processor lacks AVX2");
    }
    assert!(avx2 == best, "AVX2 differs from the best level");
    [best, by_itself]
}

#[test]
fn lanes_have_the_bits_of_scalars() {
    let appearance = appearance();
    for features in [
        ShadingFeatures::ALL,
        ShadingFeatures { shadows: false, ambient: false, ..ShadingFeatures::ALL },
        ShadingFeatures { highlights: false, fresnel: false, ..ShadingFeatures::ALL },
        ShadingFeatures { reflection: false, absorption: false, ..ShadingFeatures::ALL },
        ShadingFeatures { refraction: false, ..ShadingFeatures::ALL },
    ] {
        for n_rays in [1, 2, 3, 4, 5, 63, 64, 65, 130, 6001] {
            let [in_lanes, by_itself] = both(3, features, &appearance, n_rays);
            assert_eq!(in_lanes.0, by_itself.0, "radiance of {n_rays} rays, {features:?}");
            assert_eq!(in_lanes.1, by_itself.1, "counts of {n_rays} rays, {features:?}");
            assert!(in_lanes.2 == by_itself.2, "shadow rays of {n_rays} rays, {features:?}");
        }
    }
}

#[test]
fn the_shapes_of_these_tests_have_all_cases() {
    let (seen, counts, shadow_rays) = both(3, ShadingFeatures::ALL, &appearance(), 6001)[0].clone();
    assert!(counts.highlights > 5000 && counts.shadow_rays_skipped > 5000 && counts.refractions > 1000, "{counts:?}");
    assert!(counts.passages > 100 && counts.absorption > 100 && counts.fresnel > 500, "{counts:?}");
    let n =
        |test: &dyn Fn(&[f64; 9]) -> bool| shadow_rays.iter().filter(|bits| test(&bits.map(f64::from_bits))).count();
    let [at_zero, endless, near] =
        [n(&|ray| ray[0].abs() < 1e-280), n(&|ray| ray[8] == f64::INFINITY), n(&|ray| ray[8] < 1.0)];
    assert!(at_zero > 0 && endless > 1000 && near > 1000, "{at_zero}, {endless}, {near}");
    assert!(seen.iter().any(|(_, hit)| !hit));
}

#[test]
fn scenes_without_lights_have_the_bits_of_scalars() {
    let appearance = Appearance { lights: Vec::new(), ..appearance() };
    let [in_lanes, by_itself] = both(2, ShadingFeatures::ALL, &appearance, 101);
    assert!(in_lanes == by_itself && in_lanes.2.is_empty());
}

#[test]
fn weights_beyond_numbers_have_the_results_of_scalars() {
    let color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let transmission = Some(Transmission { coefficient: color(1e300, 0.0, 0.5), fresnel: true });
    let endless = Phong { mirror: color(1e200, 0.5, f64::INFINITY), transmission, ..Phong::BLACK };
    let nothing = Phong { mirror: color(0.0, 0.0, 0.0), ..Phong::BLACK };
    let negative = Phong { mirror: color(-1.0, -0.5, f64::NEG_INFINITY), ..Phong::BLACK };
    let mut appearance = appearance();
    appearance.materials.truncate(2);
    for (phong, interior) in [(endless, Some(InteriorMedium::clear(1.5))), (nothing, None), (negative, None)] {
        appearance.materials.push(Material { interior, ..Material::new(String::new(), phong) });
    }
    let [in_lanes, by_itself] = both(4, ShadingFeatures::ALL, &appearance, 3001).map(|(seen, counts, shadow_rays)| {
        // The bits of a NaN may differ.
        let is_nan = |bits: &u64| f64::from_bits(*bits).is_nan();
        let seen: Vec<_> =
            seen.iter().map(|(bits, hit)| (bits.map(|b| if is_nan(&b) { u64::MAX } else { b }), *hit)).collect();
        let n_nan = seen.iter().flat_map(|(bits, _)| bits).filter(|bits| **bits == u64::MAX).count();
        (seen, counts, shadow_rays, n_nan)
    });
    assert!(in_lanes.3 > 100, "{} radiances are not numbers", in_lanes.3);
    assert_eq!(in_lanes.1, by_itself.1);
    assert!(in_lanes == by_itself);
}
