//! Media on both sides of glass, in lanes.

use super::{
    inputs::PathInputs,
    shade::HitPath,
    wave::{PathWave, SpawnedPaths},
};
use crate::{
    RadianceSample, SurfaceHit,
    hit_context::SurfaceTransmission,
    interior_list::MediumEntry,
    lane_set::{Element, LaneSet, set_color},
    lanes::{LaneArray, each_lane},
    wavefront::hit_points::HitPoints,
};

impl<E: Element> SpawnedPaths<E> {
    /// Finds the media on both sides of glass, and the throughput after absorption. Returns the lanes of visible surfaces; in all others,
    /// which rounding has caused, the path goes on behind the surface.
    #[inline(never)]
    pub(super) fn find_interfaces<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        wave: &PathWave<'_, E>,
        (first, glass, inside): (usize, u8, u8),
        (points, t, length): (&HitPoints<L>, &LaneArray, &LaneArray),
        radiances: &mut [RadianceSample],
    ) -> u8 {
        let materials = &inputs.lighting.appearance.materials;
        let mut visible = 0;
        self.gathered.absorbed = 0;
        for lane in each_lane(glass) {
            let (at, entry) = (first + lane, self.gathered.medium_entries[lane]);
            let (sample, light) = (wave.paths.sample.get(at), wave.paths.throughput(at));
            let Some(material) = materials.get(entry.material as usize) else { continue };
            let tracker = &mut self.states[sample as usize].medium_tracker;
            let (solid, is_inside) = (SurfaceTransmission::Solid, inside >> lane & 1 == 1);
            let interface = solid.interface(&mut tracker.interior, materials, entry, is_inside);
            let interface = interface.as_ref();
            let Some(interface) = interface.filter(|_| solid.is_visible(material, interface)) else {
                let MediumEntry { object, material } = entry;
                let hit = SurfaceHit::new(t[lane], points.surface(lanes, lane), object, material);
                let path = HitPath { wave, at, sample, throughput: light, interface, is_passed_by_light: false };
                self.skip_interface(inputs, path, &hit, length[lane], &mut radiances[sample as usize]);
                continue;
            };
            visible |= 1 << lane;
            if inputs.features.absorption && !interface.before.absorption.is_black() {
                let mut light = light;
                tracker.absorb(materials, Some(interface), t[lane], length[lane], &mut light);
                self.gathered.absorbed |= 1 << lane;
                set_color(&mut self.gathered.dimmed, lane, light);
            }
            self.gathered.bsdfs.glass.set_eta(lane, interface.after.ior / interface.before.ior);
            self.gathered.interfaces[lane] = Some(*interface);
        }
        visible
    }
}
