//! Area lights of radiance 1 with known irradiance, and their receivers.

use std::f64::consts::PI;

use rt_math::{DVec3, Frame, Rgb, Sampler, transcendental::acos};
use rt_scene_io::Integrator;
use rt_shading::light::{
    DiskLight, Emission, EmissionSides, Light, MeshLight, QuadLight, SphereLight, disk_irradiance, polygon_irradiance,
    sphere_irradiance,
};

use super::{
    Checks, Conditions, Fallible,
    estimate::{hold, mean_of},
    test_image::{DARK, TestImage},
};

/// Part of the light that receivers reflect.
pub(super) const ALBEDO: f64 = 0.5;

/// Integrators that sample area lights.
const DRAWING: [Integrator; 3] = [Integrator::Direct, Integrator::Path, Integrator::Distributed];

/// An area light that emits radiance 1 from its front.
#[derive(Clone, Copy, Debug)]
pub(super) enum AreaLight {
    /// From a corner along two edges; it faces their cross product.
    Quad(DVec3, [DVec3; 2]),
    Disk {
        centre: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// Counter-clockwise seen from the front.
    Triangle([DVec3; 3]),
}

/// An illuminated point, and the distance of its camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    pub point: DVec3,
    pub normal: DVec3,
    /// Distance to the camera plane, nearer than any light.
    pub lift: f64,
}

impl Receiver {
    /// The origin on the ground, looked at from this height.
    pub(super) const fn ground(lift: f64) -> Self {
        Self { point: DVec3::ZERO, normal: DVec3::Z, lift }
    }
}

/// A vector in the format of scene files.
pub(super) fn tuple(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

impl AreaLight {
    /// Unit square that emits downwards at a height above the ground, its centre moved by `aside` along x and y.
    pub(super) fn square(height: f64, aside: f64) -> Self {
        Self::Quad(DVec3::new(aside - 0.5, aside - 0.5, height), [DVec3::Y, DVec3::X])
    }

    /// Disk of this radius that emits downwards from `height`, moved by `aside` along x.
    pub(super) const fn disk(radius: f64, height: f64, aside: f64) -> Self {
        Self::Disk { centre: DVec3::new(aside, 0.0, height), normal: DVec3::NEG_Z, radius }
    }

    pub(super) fn light(&self) -> Fallible<Light> {
        let white = Emission::new(Rgb::WHITE, EmissionSides::Front)?;
        Ok(match *self {
            Self::Quad(corner, edges) => Light::Quad(QuadLight::new(corner, edges, white)?),
            Self::Disk { centre, normal, radius } => Light::Disk(DiskLight::new(centre, normal, radius, 0.0, white)?),
            Self::Sphere { centre, radius } => Light::Sphere(SphereLight::new(centre, radius, white)?),
            Self::Triangle(corners) => Light::Mesh(MeshLight::new([corners], white)?),
        })
    }

    /// Node of a scene file, with an emissive material.
    pub(super) fn node(&self, material: &str) -> String {
        let shape = match *self {
            Self::Quad(corner, [along, across]) => {
                let corners = [corner, corner + along, corner + along + across, corner + across].map(tuple);
                format!("polygon(points: [{}])", corners.join(", "))
            }
            Self::Disk { centre, normal, radius } => {
                // Disks of scene files face +y.
                let turn = if normal.z < 0.0 { -90 } else { 90 };
                let place = tuple(centre);
                let steps = format!("[rotate_x({turn}), translate{place}]");
                return format!("(shape: disk(radius: {radius:?}), transform: {steps}, material: \"{material}\")");
            }
            Self::Sphere { centre, radius } => format!("sphere(center: {}, radius: {radius:?})", tuple(centre)),
            Self::Triangle(corners) => format!("triangle({})", corners.map(tuple).join(", ")),
        };
        format!("(shape: {shape}, material: \"{material}\")")
    }

    /// The irradiance in closed form. Disks must face the receiver's plane from its normal's direction.
    pub(super) fn irradiance(&self, receiver: &Receiver) -> f64 {
        let Receiver { point, normal, .. } = *receiver;
        match *self {
            Self::Quad(corner, [along, across]) => {
                let corners = [corner, corner + along, corner + along + across, corner + across];
                polygon_irradiance(&corners, point, normal)
            }
            Self::Disk { centre, radius, .. } => {
                let height = (centre - point).dot(normal);
                disk_irradiance(radius, height, (centre - point - normal * height).length())
            }
            Self::Sphere { centre, radius } => {
                let offset = centre - point;
                let distance = offset.length();
                sphere_irradiance(radius / distance, acos(offset.dot(normal) / distance))
            }
            Self::Triangle(corners) => polygon_irradiance(&corners, point, normal),
        }
    }

    /// Diffuse plane through the receiver in one very small pixel, with the light and other nodes.
    pub(super) fn scene(&self, receiver: &Receiver, height: f64, others: &str) -> Fallible<TestImage> {
        let Receiver { point, normal, lift } = *receiver;
        let up = if normal.z > 0.9 { DVec3::Y } else { Frame::from_z(normal).y };
        TestImage::of(&format!(
            "camera: (look_from: {}, look_at: {}, up: {}, orthographic: {height:?}),
                settings: (max_depth: 3),
                {DARK},
                materials: {{
                    \"ground\": diffuse(albedo: gray({ALBEDO})),
                    \"black\": diffuse(albedo: gray(0)),
                    \"lamp\": light(radiance: gray(1)),
                }},
                nodes: [
                    (shape: plane(point: {}, normal: {}), material: \"ground\"),
                    {},
                    {others}
                ],",
            tuple(point + normal * lift),
            tuple(point),
            tuple(up),
            tuple(point),
            tuple(normal),
            self.node("lamp"),
        ))
    }
}

/// Width of the pixel relative to the lift, where a closed form is that of a point. Variation within it cancels to
/// first order.
const POINT: f64 = 1e-7;

/// Compares a light with its closed form: samples of the light, and all integrators that sample lights.
pub(super) fn hold_irradiance(
    checks: &mut Checks,
    conditions: &Conditions,
    what: &str,
    area_light: &AreaLight,
    receiver: &Receiver,
) -> Fallible<()> {
    let [seeds, spp] = conditions.effort();
    let truth = area_light.irradiance(receiver);
    let light = area_light.light()?;
    hold(checks, format_args!("{what}, samples of the light"), truth, seeds, |pattern, seed| {
        Ok(mean_of(pattern, spp as u32, seed, |sample| irradiance_from(&light, receiver, sample.next_2d())))
    })?;
    let image = area_light.scene(receiver, POINT * receiver.lift, "")?;
    check_image(checks, what, truth, &image, [seeds, spp])
}

/// Compares images of a diffuse receiver by all integrators that sample lights with its irradiance; `effort` is the
/// number of seeds and of samples.
pub(super) fn check_image(
    checks: &mut Checks,
    what: &str,
    irradiance: f64,
    image: &TestImage,
    effort: [u64; 2],
) -> Fallible<()> {
    image.hold_by(&DRAWING, checks, what, irradiance, PI / ALBEDO, effort)
}

pub(super) fn irradiance_from(light: &Light, receiver: &Receiver, u: [f64; 2]) -> f64 {
    let sample = light.sample_li(receiver.point, u);
    sample.map_or(0.0, |s| s.radiance.g * s.direction.dot(receiver.normal).max(0.0) / s.pdf)
}
