//! Media on both sides of the hits of a group.

use super::{
    hit_group::{HitGroup, HitSurfaces},
    inputs::RayTreeInputs,
    streams::RayTreeStream,
    wave::SpawnedRays,
};
use crate::{
    RadianceSample, SurfaceHit,
    hit_context::SurfaceTransmission,
    interior_list::{MediumEntry, MediumInterface, medium},
    lane_set::{Element, LaneSet, set_color},
    lanes::each_lane,
    medium::Medium,
};
use rt_math::Vector3;

impl<E: Element> SpawnedRays<E> {
    /// Finds the media on both sides of hits, and applies absorption. At invisible interfaces, paths go on behind the surface.
    #[inline(always)]
    pub(super) fn find_interfaces<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        group: &mut HitGroup<'_, L>,
        paths: &RayTreeStream<E>,
        radiances: &mut [RadianceSample],
    ) {
        let &RayTreeInputs { settings, appearance, .. } = inputs;
        for lane in each_lane(group.mask) {
            self.sides[lane & 7] = [paths.media.get(group.at + lane).interior; 2];
        }
        let transmission = group.phong.interface;
        if transmission == SurfaceTransmission::None && !settings.features.absorption {
            return;
        }
        let (materials, surfaces) = (&appearance.materials, group.surfaces);
        let HitSurfaces { points, surface, .. } = surfaces;
        let Some(material) = materials.get(surfaces.material as usize) else { return };
        let (mut t, mut length) = ([0.0; 8], [0.0; 8]);
        lanes.store_f64(points.t, &mut t);
        lanes.store_f64(surface.length, &mut length);
        let (mut eta, mut throughput) = ([E::rounded(1.0); 8], [[E::default(); 8]; 3]);
        let mut is_absorbed = false;
        let solid = medium(Some(surfaces.material), materials);
        let is_refractive_solid = transmission == SurfaceTransmission::Solid && solid.ior != Medium::AIR.ior;
        let absorbs_within = settings.features.absorption && !solid.absorption.is_black();
        for lane in each_lane(group.mask) {
            let at = group.at + lane;
            let [before, behind] = &mut self.sides[lane & 7];
            if transmission == SurfaceTransmission::None && before.is_empty() {
                continue;
            }
            let is_inside = surface.inside >> lane & 1 == 1;
            // The usual case.
            if is_refractive_solid
                && !(is_inside && absorbs_within)
                && let entry = surfaces.medium_entry(lane)
                && let Some(list) = self.lists.push_behind_solid_in_air(*before, entry, is_inside)
            {
                if group.phong.transmission.is_some() {
                    *behind = list;
                    let air = Medium::AIR.ior;
                    eta[lane] = E::rounded(if is_inside { solid.ior / air } else { air / solid.ior });
                    group.transmits |= 1 << lane;
                }
                continue;
            }
            let media = &mut self.media;
            media.resume(&self.lists, paths.media.get(at));
            let interface =
                transmission.interface(&mut media.interior, materials, surfaces.medium_entry(lane), is_inside);
            let interface = interface.as_ref();
            if !transmission.is_visible(material, interface) {
                group.mask &= !(1 << lane);
                let MediumEntry { object, material } = surfaces.medium_entry(lane);
                let hit = SurfaceHit::new(t[lane], points.surface(lanes, lane), object, material);
                self.skip_interface_of_ray(inputs, (paths, at), &hit, (interface, length[lane]), radiances);
                continue;
            }
            *before = self.lists.push_changed(&media.interior, *before);
            if settings.features.absorption {
                let mut absorbed = paths.throughput(at);
                let absorption = media.absorb(materials, interface, t[lane], length[lane], &mut absorbed);
                if !absorption.is_black() {
                    self.counts.absorption += 1;
                    self.absorption[lane] = absorption;
                    group.absorbed |= 1 << lane;
                    if !core::mem::replace(&mut is_absorbed, true) {
                        throughput = lanes.store_vector(group.throughput);
                    }
                    set_color(&mut throughput, lane, absorbed);
                }
            }
            if let Some(interface) = interface.filter(|_| group.phong.transmission.is_some()) {
                *behind = self.lists.push_behind(&media.interior, interface.event);
                eta[lane] = E::rounded(interface.before.ior / interface.after.ior);
                group.transmits |= 1 << lane;
            }
        }
        group.eta = lanes.load(&eta);
        if is_absorbed {
            let [r, g, b] = &throughput;
            group.throughput = Vector3::new(lanes.load(r), lanes.load(g), lanes.load(b));
        }
    }

    /// Continues a ray of a stream behind a null interface.
    #[inline(never)]
    fn skip_interface_of_ray(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        (paths, at): (&RayTreeStream<E>, usize),
        hit: &SurfaceHit,
        interface: (Option<&MediumInterface>, f64),
        radiances: &mut [RadianceSample],
    ) {
        let (path, (ray, _)) = (paths.get(at), paths.rays.get(at));
        let radiance_sample = &mut radiances[path.branch as usize];
        self.skip_interface(inputs, (&ray, path), hit, interface, radiance_sample);
    }
}
