//! Classical recursive ray tracing.

mod view;

use crate::{
    Appearance, Interior, Material, Needs, Phong, Seen, SurfaceHit, Tracer,
    interior::{Crossing, InteriorStack},
    optics,
};
use rt_math::{Interval, Ray, RayKind, Rgb, transcendental::exp};
use view::{View, is_inside};

/// So many surfaces that do nothing to a ray may stand one behind the other in its way; each further one costs a bounce,
/// so that paths end.
const FREE_PASSAGES: u32 = 1024;

/// Work of shading, for statistics and to prove that what is left out is really absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadingCounts {
    /// Shadow rays that were not traced, because the light could not contribute: it stands behind the surface, or the
    /// surface reflects none of it.
    pub shadow_rays_spared: u64,
    /// Highlights evaluated.
    pub highlights: u64,
    /// Mirror directions considered.
    pub mirrors: u64,
    /// Refractions considered.
    pub refractions: u64,
    /// Evaluations of Fresnel's equations.
    pub fresnel: u64,
    /// Evaluations of Beer's law.
    pub absorption: u64,
    /// Surfaces that did nothing to a ray: the same was on both sides of them.
    pub passages: u64,
    /// Paths that ended at a mirror or at glass because there were as many bounces as allowed.
    pub depth_limited: u64,
    /// Surfaces of transparent bodies that were ignored, because the ray was inside of too many others.
    pub interior_overflows: u64,
}

impl core::ops::AddAssign for ShadingCounts {
    fn add_assign(&mut self, o: Self) {
        self.shadow_rays_spared += o.shadow_rays_spared;
        self.highlights += o.highlights;
        self.mirrors += o.mirrors;
        self.refractions += o.refractions;
        self.fresnel += o.fresnel;
        self.absorption += o.absorption;
        self.passages += o.passages;
        self.depth_limited += o.depth_limited;
        self.interior_overflows += o.interior_overflows;
    }
}

/// A ray still to be followed.
#[derive(Clone, Copy, Debug)]
struct Pending {
    ray: Ray,
    kind: RayKind,
    /// Bounces so far.
    depth: u32,
    /// Part of its radiance that reaches the camera.
    weight: Rgb,
    /// Length of its list of the bodies that it is inside of.
    bodies: u32,
}

/// Whitted's integrator (1980): local Phong shading with shadow rays, mirror reflection and refraction.
///
/// The tree of rays is walked with a stack of its own, so depth is limited by `max_depth` and not by the machine's
/// stack. Keep one instance per thread: the stack is reused from ray to ray.
///
/// Rays know which transparent bodies they are inside of ([`Interior`]). Where the index of refraction is the same on both
/// sides of a surface, nothing is mirrored by Fresnel's equations and light goes straight on; where nothing else shows the
/// surface either ([`Phong::is_clear`]), the very same ray goes on, and no bounce is counted.
#[derive(Clone, Debug)]
pub struct Whitted {
    max_depth: u32,
    min_contribution: f64,
    needs: Needs,
    pending: Vec<Pending>,
    /// What the paths in `pending` are inside of.
    interiors: InteriorStack,
    /// What camera rays start inside of.
    surroundings: Interior,
    /// What the path at hand is inside of.
    interior: Interior,
    counts: ShadingCounts,
}

/// What a surface is to a ray that meets it.
enum Meeting {
    Opaque,
    /// There is another medium behind it, or it is visible for another reason.
    Transparent(Crossing),
    /// Nothing, but something to note if there is a crossing.
    Nothing(Option<Crossing>),
}

impl Whitted {
    /// Follows up to `max_depth` bounces after the first hit, and none whose weight in the pixel is below
    /// `min_contribution` in all components. Computes only what `needs` names.
    pub fn new(max_depth: u32, min_contribution: f64, needs: Needs) -> Self {
        Self {
            max_depth,
            min_contribution,
            needs,
            pending: Vec::new(),
            interiors: InteriorStack::default(),
            surroundings: Interior::default(),
            interior: Interior::default(),
            counts: ShadingCounts::default(),
        }
    }

    /// Says what camera rays start inside of, from now on; air unless something else is said.
    pub fn set_surroundings(&mut self, surroundings: &Interior) {
        self.surroundings.clone_from(surroundings);
    }

    /// Work done so far.
    pub const fn counts(&self) -> ShadingCounts {
        self.counts
    }

    /// Radiance that a camera ray sees. Infinite or NaN if the scene is; the caller decides about such samples.
    pub fn radiance(&mut self, world: &mut impl Tracer, appearance: &Appearance, ray: &Ray) -> Seen {
        let mut seen = Seen { radiance: Rgb::BLACK, hit: false };
        let mut path = Pending { ray: *ray, kind: RayKind::Primary, depth: 0, weight: Rgb::WHITE, bodies: 0 };
        if self.needs.refraction {
            self.interior.clone_from(&self.surroundings);
        }
        loop {
            self.follow(world, appearance, &mut path, &mut seen);
            match self.pending.pop() {
                Some(next) => path = next,
                None => return seen,
            }
            if self.needs.refraction {
                self.interiors.pop(&mut self.interior, path.bodies);
            }
        }
    }

    /// Follows a path to the first surface that shows: adds what is seen there, puts the rays that it depends on aside.
    fn follow(&mut self, world: &mut impl Tracer, appearance: &Appearance, path: &mut Pending, seen: &mut Seen) {
        let mut span = if path.kind == RayKind::Primary { Interval::FORWARD } else { Interval::SPAWNED };
        // Absorption is accounted for up to this parameter of the ray.
        let mut start = 0.0;
        let mut passages = 0;
        while let Some(mut hit) = world.closest(&path.ray, span, path.kind, self.needs.surface()) {
            let Some(Material { phong, .. }) = appearance.materials.get(hit.material as usize) else {
                seen.hit = true;
                return;
            };
            let length = path.ray.direction.length();
            let direction = path.ray.direction / length;
            let inside = is_inside(direction, &hit.interaction);
            let meeting = self.meet(appearance, phong, &hit, inside);
            let way = (hit.t - start) * length;
            if let Meeting::Nothing(crossing) = meeting {
                if let Some(crossing) = &crossing {
                    if crossing.before.absorption != crossing.after.absorption {
                        seen.hit |= self.absorb(&mut path.weight, crossing.before.absorption, way);
                        start = hit.t;
                    }
                    self.interior.cross(crossing);
                }
                self.counts.passages += 1;
                passages += 1;
                path.depth += u32::from(passages > FREE_PASSAGES);
                if path.depth > self.max_depth {
                    self.counts.depth_limited += 1;
                    return;
                }
                span = hit.beyond(&path.ray);
                path.kind = RayKind::Refraction;
                continue;
            }
            seen.hit = true;
            let crossing = if let Meeting::Transparent(crossing) = &meeting { Some(crossing) } else { None };
            if self.needs.absorption {
                let medium = crossing.map_or_else(|| self.interior.medium(&appearance.materials), |c| c.before);
                self.absorb(&mut path.weight, medium.absorption, way);
            }
            let view = View::new(direction, inside, &mut hit.interaction);
            seen.radiance += path.weight * self.emitted_and_reflected(world, appearance, phong, &view, path.ray.time);
            self.send_on(appearance, phong, &view, crossing, path);
            return;
        }
        seen.radiance += path.weight * appearance.background.radiance(path.ray.direction);
    }

    fn meet(&mut self, appearance: &Appearance, phong: &Phong, hit: &SurfaceHit, inside: bool) -> Meeting {
        if !(self.needs.refraction && phong.transmission.is_some()) {
            return Meeting::Opaque;
        }
        match self.interior.crossing(&appearance.materials, hit, inside) {
            None => {
                self.counts.interior_overflows += 1;
                Meeting::Nothing(None)
            }
            Some(crossing) if crossing.is_boundary && !(crossing.is_null() && phong.is_clear()) => {
                Meeting::Transparent(crossing)
            }
            unseen => Meeting::Nothing(unseen),
        }
    }

    /// Beer's law along a way in world units; whether it took anything.
    fn absorb(&mut self, weight: &mut Rgb, absorption: Rgb, way: f64) -> bool {
        if absorption.is_black() {
            return false;
        }
        self.counts.absorption += 1;
        *weight *= absorption.map(|per_unit| exp(-per_unit * way));
        true
    }

    fn emitted_and_reflected(
        &mut self,
        world: &mut impl Tracer,
        appearance: &Appearance,
        phong: &Phong,
        view: &View,
        time: f64,
    ) -> Rgb {
        let surface = view.surface;
        let textures = &appearance.textures;
        let mut sum = Rgb::BLACK;
        if self.needs.emission {
            sum += phong.emission.at(textures, surface.uv);
        }
        if self.needs.ambient {
            sum += phong.ambient.at(textures, surface.uv) * appearance.ambient;
        }
        let diffuse = phong.diffuse.at(textures, surface.uv);
        let specular = if self.needs.highlights { phong.specular.at(textures, surface.uv) } else { Rgb::BLACK };
        for light in &appearance.lights {
            let lit = light.illuminate(surface.point).filter(|lit| view.normal.dot(lit.direction) > 0.0);
            let reflected = lit.map_or(Rgb::BLACK, |lit| {
                let mut reflectance = diffuse * view.normal.dot(lit.direction);
                if self.needs.highlights && !specular.is_black() {
                    self.counts.highlights += 1;
                    let strength =
                        phong.highlight.strength(view.normal, -view.direction, lit.direction, phong.exponent);
                    reflectance += specular * strength;
                }
                reflectance * lit.strength
            });
            let shadowed = self.needs.shadows && light.casts_shadows;
            match lit {
                Some(lit) if !reflected.is_black() => {
                    let (ray, span) = light.shadow_ray(surface, &lit, time);
                    if !(shadowed && world.occluded(&ray, span)) {
                        sum += reflected;
                    }
                }
                _ => self.counts.shadow_rays_spared += u64::from(shadowed),
            }
        }
        sum
    }

    /// Puts the mirrored and the refracted ray aside, the mirrored one on top.
    fn send_on(
        &mut self,
        appearance: &Appearance,
        phong: &Phong,
        view: &View,
        crossing: Option<&Crossing>,
        path: &Pending,
    ) {
        if path.depth >= self.max_depth {
            self.counts.depth_limited += u64::from(crossing.is_some() || !phong.mirror.is_zero());
            return;
        }
        let surface = view.surface;
        let mut reflected_part = 1.0;
        if let (Some(crossing), Some(transmission)) = (crossing, &phong.transmission) {
            self.counts.refractions += 1;
            let eta = crossing.before.ior / crossing.after.ior;
            if self.needs.fresnel && transmission.fresnel {
                self.counts.fresnel += 1;
                reflected_part =
                    if crossing.is_null() { 0.0 } else { optics::fresnel(-view.direction.dot(view.normal), eta) };
            }
            let passed_part = if transmission.fresnel { 1.0 - reflected_part } else { 1.0 };
            let weight = path.weight * transmission.coefficient.at(&appearance.textures, surface.uv) * passed_part;
            let refracted = if crossing.is_null() { Some(view.direction) } else { view.refracted(eta) };
            if let Some(direction) = refracted {
                let ray = || surface.spawn_ray(direction, path.ray.time);
                self.put_aside(path, weight, RayKind::Refraction, Some(crossing), ray);
            }
        }
        if self.needs.reflection {
            self.counts.mirrors += 1;
            let weight = path.weight * phong.mirror.at(&appearance.textures, surface.uv) * reflected_part;
            let ray = || surface.spawn_ray(view.mirrored(), path.ray.time);
            self.put_aside(path, weight, RayKind::Reflection, None, ray);
        }
    }

    /// Puts aside what goes on from `path` along `ray`, through a surface if there is a crossing, if its weight matters.
    fn put_aside(
        &mut self,
        path: &Pending,
        weight: Rgb,
        kind: RayKind,
        crossing: Option<&Crossing>,
        ray: impl FnOnce() -> Ray,
    ) {
        if weight.is_black() || weight.max_component() < self.min_contribution {
            return;
        }
        let bodies = if self.needs.refraction { self.interiors.push(&self.interior, crossing) } else { 0 };
        self.pending.push(Pending { ray: ray(), kind, depth: path.depth + 1, weight, bodies });
    }
}

#[cfg(test)]
mod interpolated;

#[cfg(test)]
mod nested;

#[cfg(test)]
mod tests;
