//! Nested dielectrics: media around a point, and their priorities.

use crate::{InteriorMedium, Material, SceneQueries, SurfaceHit, medium::Medium};
use rt_geometry::{InteractionFlags, RayKind};
use rt_math::{Aabb, Interval, Ray};

/// Maximum number of dielectrics around a point; further ones are ignored, and counted in
/// [`interior_overflows`](crate::ShadingCounts::interior_overflows).
pub const MAX_DIELECTRICS: usize = 32;

/// A dielectric: its object, and its material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MediumEntry {
    pub(crate) object: u32,
    pub(crate) material: u32,
}

impl SurfaceHit {
    #[inline]
    pub(crate) const fn medium_entry(&self) -> MediumEntry {
        MediumEntry { object: self.object, material: self.material }
    }
}

/// Dielectrics around a point, in the order in which they were entered.
///
/// This is the interior list of Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics
/// Tools 7(2), 2002.
///
/// ```text
///    air │glass▒▒▒▒│▒▒▒ both ▒▒▒│~~~~ water        glass 1, water 0: where they overlap, glass counts
///        entered   water:       glass: left,
///        glass     ignored      now in water
/// ```
///
/// Among overlapping dielectrics, the one of the highest [`priority`](InteriorMedium::priority) counts, among equals the one
/// entered last. Surfaces of the others are ignored. Of coincident surfaces, a ray hits the one of the lower index only:
/// touching dielectrics should overlap instead.
///
/// A dielectric that is left without having been entered counts as present from the start: the ray started inside, or the
/// surface has a hole. Several objects of one material may enclose one dielectric, which may be left through any of them.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct InteriorList {
    entries: Vec<MediumEntry>,
}

impl Clone for InteriorList {
    fn clone(&self) -> Self {
        Self { entries: self.entries.clone() }
    }

    /// Keeps the allocation, as each camera ray starts with this.
    fn clone_from(&mut self, other: &Self) {
        self.entries.clone_from(&other.entries);
    }
}

/// Media on both sides of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MediumInterface {
    pub(crate) event: InterfaceEvent,
    /// The medium on the near side.
    pub(crate) before: Medium,
    /// The medium on the far side.
    pub(crate) after: Medium,
    /// False if the same material is on both sides: the surface is ignored.
    pub(crate) is_boundary: bool,
}

impl MediumInterface {
    /// True if the media have the same index: light passes straight, without reflection.
    pub(crate) fn is_null(&self) -> bool {
        self.before.ior == self.after.ior
    }
}

/// Change of the list where a ray crosses an interface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InterfaceEvent {
    Enter(MediumEntry),
    /// Index of the dielectric that is left.
    Leave(usize),
    /// Thin surface: no change.
    Stay,
}

impl InteriorList {
    /// Media around a point in an unbounded medium of this material.
    pub fn filled_with(material: u32) -> Self {
        // No object has this index: the medium is left through any surface of the material.
        Self { entries: vec![MediumEntry { object: u32::MAX, material }] }
    }

    /// True for a point in air.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// True if a surface of a solid is certainly visible: the point is in air, or in this solid alone, and the ray leaves it.
    pub(crate) fn is_surface_visible(&self, material: u32, leaves: impl FnOnce() -> bool) -> bool {
        match self.entries.as_slice() {
            [] => true,
            [only] => only.material == material && leaves(),
            _ => false,
        }
    }

    /// Sets the medium to air.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Finds the dielectrics around the origin of a ray: those that the ray leaves, up to infinity, without having entered
    /// them. Replaces the list.
    pub fn find_enclosing_media(&mut self, world: &mut dyn SceneQueries, materials: &[Material], ray: &Ray) {
        self.entries.clear();
        // Dielectrics around the origin come first in the list, then those that the ray entered.
        let mut around = 0;
        let mut span = Interval::FORWARD;
        let needs = InteractionFlags::NONE;
        while let Some(hit) = world.closest(ray, span, RayKind::Refraction, needs) {
            span = hit.span_after(ray);
            if interior(materials, hit.material).is_none() {
                continue;
            }
            let entry = hit.medium_entry();
            if ray.direction.dot(hit.interaction.geometric_normal) <= 0.0 {
                self.push(entry);
            } else if let Some(at) = find(&self.entries[around..], entry) {
                self.entries.remove(around + at);
            } else if self.entries.len() < MAX_DIELECTRICS {
                // A dielectric that is left later was entered earlier.
                self.entries.insert(0, entry);
                around += 1;
            }
        }
        self.entries.truncate(around);
    }

    /// Version of [`find_enclosing_media`](Self::find_enclosing_media) for dielectrics that all lie within a box.
    pub fn find_enclosing_media_within(
        &mut self,
        reach: Aabb,
        world: &mut dyn SceneQueries,
        materials: &[Material],
        ray: &Ray,
    ) {
        self.entries.clear();
        if reach.contains(ray.origin) {
            self.find_enclosing_media(world, materials, ray);
        }
    }

    pub(crate) fn medium(&self, materials: &[Material]) -> Medium {
        medium(self.top(materials), materials)
    }

    /// Media on both sides of the surface of a solid. `None` if the list is full, so that the surface is ignored.
    #[inline(always)]
    pub(crate) fn interface(
        &mut self,
        materials: &[Material],
        entry: MediumEntry,
        leaving: bool,
    ) -> Option<MediumInterface> {
        let inside = || medium(Some(entry.material), materials);
        // The usual cases, a dielectric in air, are inlined: a result in memory would be read before it is stored.
        match (self.entries.as_slice(), leaving) {
            ([], false) => Some(MediumInterface {
                event: InterfaceEvent::Enter(entry),
                before: Medium::AIR,
                after: inside(),
                is_boundary: true,
            }),
            (&[left], true) if left.material == entry.material => Some(MediumInterface {
                event: InterfaceEvent::Leave(0),
                before: inside(),
                after: Medium::AIR,
                is_boundary: true,
            }),
            _ => self.nested_interface(materials, entry, leaving),
        }
    }

    /// Version of [`interface`](Self::interface) for any list.
    fn nested_interface(
        &mut self,
        materials: &[Material],
        entry: MediumEntry,
        leaving: bool,
    ) -> Option<MediumInterface> {
        let event = self.event(entry, leaving)?;
        let (before, after) = (self.top(materials), top(self.entries_after(event), materials));
        Some(MediumInterface {
            event,
            before: medium(before, materials),
            after: medium(after, materials),
            is_boundary: before != after,
        })
    }

    /// Change of the list at the surface of a solid. `None` if the list is full.
    #[inline]
    pub(crate) fn event(&mut self, entry: MediumEntry, leaving: bool) -> Option<InterfaceEvent> {
        if leaving {
            find(&self.entries, entry).or_else(|| self.push_outermost(entry)).map(InterfaceEvent::Leave)
        } else {
            (self.entries.len() < MAX_DIELECTRICS).then_some(InterfaceEvent::Enter(entry))
        }
    }

    /// Interface of a thin dielectric: visible, with the same medium on both sides.
    pub(crate) fn thin_interface(&self, materials: &[Material]) -> MediumInterface {
        let here = self.medium(materials);
        MediumInterface { event: InterfaceEvent::Stay, before: here, after: here, is_boundary: true }
    }

    /// Updates the list for a ray that crosses an interface.
    pub(crate) fn cross(&mut self, interface: &MediumInterface) {
        self.apply(interface.event);
    }

    /// Applies the change of an interface of this list.
    pub(crate) fn apply(&mut self, event: InterfaceEvent) {
        match event {
            InterfaceEvent::Enter(entry) => self.push(entry),
            InterfaceEvent::Leave(at) => {
                self.entries.remove(at);
            }
            InterfaceEvent::Stay => {}
        }
    }

    fn push(&mut self, entry: MediumEntry) {
        if self.entries.len() < MAX_DIELECTRICS {
            self.entries.push(entry);
        }
    }

    /// Adds a dielectric that was never entered as the outermost one. Returns its index.
    fn push_outermost(&mut self, entry: MediumEntry) -> Option<usize> {
        (self.entries.len() < MAX_DIELECTRICS).then(|| {
            self.entries.insert(0, entry);
            0
        })
    }

    fn entries_after(&self, event: InterfaceEvent) -> impl Iterator<Item = MediumEntry> {
        let (left, entered) = match event {
            InterfaceEvent::Enter(entry) => (None, Some(entry)),
            InterfaceEvent::Leave(at) => (Some(at), None),
            InterfaceEvent::Stay => (None, None),
        };
        let stays = move |(at, entry): (usize, &MediumEntry)| (Some(at) != left).then_some(*entry);
        self.entries.iter().enumerate().filter_map(stays).chain(entered)
    }

    /// Material of the medium at the point.
    fn top(&self, materials: &[Material]) -> Option<u32> {
        top(self.entries.iter().copied(), materials)
    }
}

/// Lists of the rays of streams, one behind the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct InteriorLists {
    entries: Vec<MediumEntry>,
}

/// Place of a list in [`InteriorLists`]; by default the empty list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ListRange {
    start: u32,
    len: u32,
}

impl ListRange {
    /// True for a ray in air.
    #[inline(always)]
    pub(crate) const fn is_empty(self) -> bool {
        self.len == 0
    }
}

impl InteriorLists {
    /// Number of entries of all lists.
    pub(crate) const fn len(&self) -> usize {
        self.entries.len()
    }

    /// Removes all lists that were added when there were this many entries, or later.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.entries.truncate(len);
    }

    /// Removes all lists from this entry on but those of the ranges, which are changed.
    pub(crate) fn keep_only<'a>(&mut self, first: usize, ranges: impl Iterator<Item = &'a mut ListRange>) {
        let mut kept = Vec::new();
        for range in ranges.filter(|range| range.start as usize >= first) {
            let start = range.start as usize;
            range.start = (first + kept.len()) as u32;
            kept.extend_from_slice(self.entries.get(start..start + range.len as usize).unwrap_or(&[]));
        }
        self.entries.truncate(first);
        self.entries.append(&mut kept);
    }

    /// Adds a list.
    #[inline]
    pub(crate) fn push(&mut self, interior: &InteriorList) -> ListRange {
        self.push_behind(interior, InterfaceEvent::Stay)
    }

    /// Adds a list as it is behind a surface.
    #[inline]
    pub(crate) fn push_behind(&mut self, interior: &InteriorList, event: InterfaceEvent) -> ListRange {
        let start = self.entries.len();
        match (interior.entries.as_slice(), event) {
            // The usual cases need no iterator.
            ([], InterfaceEvent::Enter(entry)) => self.entries.push(entry),
            ([], InterfaceEvent::Stay) | ([_], InterfaceEvent::Leave(_)) => {}
            _ => self.entries.extend(interior.entries_after(event)),
        }
        match self.entries.len() - start {
            0 => ListRange::default(),
            len => ListRange { start: start as u32, len: len as u32 },
        }
    }

    /// Adds the list behind the surface of a solid that is entered from air, or left into air. `None` for other lists.
    #[inline(always)]
    pub(crate) fn push_behind_solid_in_air(
        &mut self,
        before: ListRange,
        entry: MediumEntry,
        leaving: bool,
    ) -> Option<ListRange> {
        match (before.len, leaving) {
            (0, false) => {
                self.entries.push(entry);
                Some(ListRange { start: self.entries.len() as u32 - 1, len: 1 })
            }
            (1, true) if self.entries.get(before.start as usize)?.material == entry.material => {
                Some(ListRange::default())
            }
            _ => None,
        }
    }

    /// Adds a list that was read from a range, unless it is still the same: lists only grow there.
    #[inline]
    pub(crate) fn push_changed(&mut self, interior: &InteriorList, range: ListRange) -> ListRange {
        if interior.entries.len() == range.len as usize { range } else { self.push(interior) }
    }

    /// Replaces a list by that of a range.
    #[inline]
    pub(crate) fn read(&self, range: ListRange, interior: &mut InteriorList) {
        interior.entries.clear();
        if range.len > 0 {
            let ListRange { start, len } = range;
            let list = self.entries.get(start as usize..).and_then(|rest| rest.get(..len as usize));
            interior.entries.extend_from_slice(list.unwrap_or(&[]));
        }
    }
}

/// Index of a dielectric, or of the one of its material that was entered last.
fn find(entries: &[MediumEntry], entry: MediumEntry) -> Option<usize> {
    if let [only] = entries {
        return (only.material == entry.material).then_some(0);
    }
    let last = |matches: &dyn Fn(&MediumEntry) -> bool| entries.iter().rposition(matches);
    last(&|other| *other == entry).or_else(|| last(&|other| other.material == entry.material))
}

/// Material of the highest priority, among equals the last.
fn top(entries: impl Iterator<Item = MediumEntry>, materials: &[Material]) -> Option<u32> {
    let priority = |entry: &MediumEntry| interior(materials, entry.material).map(|interior| interior.priority);
    entries.max_by_key(priority).map(|entry| entry.material)
}

/// Medium of a solid; air for other materials.
pub(crate) fn medium(material: Option<u32>, materials: &[Material]) -> Medium {
    material
        .and_then(|material| interior(materials, material))
        .map_or(Medium::AIR, |interior| Medium { ior: interior.ior, absorption: interior.absorption })
}

fn interior(materials: &[Material], material: u32) -> Option<&InteriorMedium> {
    materials.get(material as usize)?.interior.as_ref()
}

#[cfg(test)]
mod tests;
