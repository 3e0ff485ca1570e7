//! Nested dielectrics.

use crate::{Material, SurfaceHit, Tracer, Transmission};
use rt_geometry::{InteractionFlags, RayKind};
use rt_math::{Aabb, Interval, Ray, Rgb, transcendental::exp};

/// Most bodies that a point may lie inside of at once; further ones are not noticed, and counted.
const CAPACITY: usize = 32;

/// A body that was entered: the object whose surface was met, and the material that fills it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MediumEntry {
    object: u32,
    material: u32,
}

/// The transparent bodies around a point, in the order in which they were entered: the interior list of Schmidt and
/// Budge, "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2), 2002.
///
/// ```text
///    air │glass▒▒▒▒│▒▒▒ both ▒▒▒│~~~~ water        glass 1, water 0: where they overlap there is glass
///        entered   water: not   glass: left,
///        glass     noticed      now in water
/// ```
///
/// Where bodies overlap, the one of highest [`priority`](Transmission::priority) is there, among equals the one that
/// was entered last. The surface of a body that is not there is not noticed. Of surfaces that coincide, a ray meets the
/// one of the lower number only: bodies that touch should overlap instead.
///
/// A body that is left without having been entered (the ray started inside, or the surface has a hole) counts as having
/// been around from the start. A body may be closed by several objects of one material: what was entered through one of
/// them is left through any other.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Interior {
    bodies: Vec<MediumEntry>,
}

impl Clone for Interior {
    fn clone(&self) -> Self {
        Self { bodies: self.bodies.clone() }
    }

    /// Keeps its memory, as each camera ray begins with this.
    fn clone_from(&mut self, other: &Self) {
        self.bodies.clone_from(&other.bodies);
    }
}

/// Optical properties of a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// Index of refraction.
    pub(crate) ior: f64,
    /// Absorption per world unit.
    pub(crate) absorption: Rgb,
}

impl Medium {
    const AIR: Self = Self { ior: 1.0, absorption: Rgb::BLACK };

    /// Part of the light that a way in world units, possibly infinite, leaves (Beer's law).
    pub(crate) fn transmittance(&self, way: f64) -> Rgb {
        // 0 · ∞ is not a number.
        self.absorption.map(|per_unit| if per_unit == 0.0 { 1.0 } else { exp(-per_unit * way) })
    }
}

/// Beer's law along a way in world units; whether it took anything.
pub(crate) fn absorb(weight: &mut Rgb, absorption: Rgb, way: f64) -> bool {
    if absorption.is_black() {
        return false;
    }
    *weight *= absorption.map(|per_unit| exp(-per_unit * way));
    true
}

/// Media on both sides of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MediumInterface {
    event: InterfaceEvent,
    /// The medium on the near side.
    pub(crate) before: Medium,
    /// The medium on the far side.
    pub(crate) after: Medium,
    /// False if the same material is on both sides: the surface is not there.
    pub(crate) is_boundary: bool,
}

impl MediumInterface {
    /// Light goes straight on, and nothing of it is mirrored.
    pub(crate) fn is_null(&self) -> bool {
        self.before.ior == self.after.ior
    }
}

/// Change of the list; a medium that is left is given by its index.
#[derive(Clone, Copy, Debug)]
enum InterfaceEvent {
    Enter(MediumEntry),
    Leave(usize),
    /// Through something that has the same on both sides.
    Stay,
}

impl Interior {
    /// Inside of something unbounded of the material with this index.
    pub fn filled_with(material: u32) -> Self {
        // The number of no object: it is left through any surface of the material.
        Self { bodies: vec![MediumEntry { object: u32::MAX, material }] }
    }

    /// True outside of everything, in air.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Back outside of everything.
    pub fn clear(&mut self) {
        self.bodies.clear();
    }

    /// Finds out what the origin of a ray lies inside of: the bodies that the ray leaves, on its way to infinity, without
    /// having entered them. Replaces what was known before.
    pub fn find_enclosing_media(&mut self, world: &mut impl Tracer, materials: &[Material], ray: &Ray) {
        self.bodies.clear();
        // Bodies around the origin come first in the list; behind them, bodies that were entered on the way.
        let mut around = 0;
        let mut span = Interval::FORWARD;
        let needs = InteractionFlags::NONE;
        while let Some(hit) = world.closest(ray, span, RayKind::Refraction, needs) {
            span = hit.span_after(ray);
            if transmission(materials, hit.material).is_none() {
                continue;
            }
            let body = MediumEntry { object: hit.object, material: hit.material };
            if ray.direction.dot(hit.interaction.geometric_normal) <= 0.0 {
                self.push(body);
            } else if let Some(at) = find(&self.bodies[around..], body) {
                self.bodies.remove(around + at);
            } else if self.bodies.len() < CAPACITY {
                // A solid that is left later was entered earlier.
                self.bodies.insert(0, body);
                around += 1;
            }
        }
        self.bodies.truncate(around);
    }

    /// Version of [`find_enclosing_media`](Self::find_enclosing_media) for solids that all lie within a box.
    pub fn find_enclosing_media_within(
        &mut self,
        reach: Aabb,
        world: &mut impl Tracer,
        materials: &[Material],
        ray: &Ray,
    ) {
        self.bodies.clear();
        if reach.contains(ray.origin) {
            self.find_enclosing_media(world, materials, ray);
        }
    }

    /// The medium here.
    pub(crate) fn medium(&self, materials: &[Material]) -> Medium {
        medium(self.top(materials), materials)
    }

    /// Media on both sides of the surface of a solid. `None` if the list is full: the surface is to be
    /// ignored.
    pub(crate) fn interface(
        &mut self,
        materials: &[Material],
        hit: &SurfaceHit,
        leaving: bool,
    ) -> Option<MediumInterface> {
        let body = MediumEntry { object: hit.object, material: hit.material };
        let event = if leaving {
            InterfaceEvent::Leave(find(&self.bodies, body).or_else(|| self.push_outermost(body))?)
        } else {
            (self.bodies.len() < CAPACITY).then_some(InterfaceEvent::Enter(body))?
        };
        let (before, after) = match (self.bodies.as_slice(), event) {
            // The usual cases: a body in air.
            ([], InterfaceEvent::Enter(entered)) => (None, Some(entered.material)),
            (&[left], InterfaceEvent::Leave(_)) => (Some(left.material), None),
            _ => (self.top(materials), top(self.bodies_after(event), materials)),
        };
        Some(MediumInterface {
            event,
            before: medium(before, materials),
            after: medium(after, materials),
            is_boundary: before != after,
        })
    }

    /// Interface of a thin dielectric: visible, with the same medium on both sides.
    pub(crate) fn thin_interface(&self, materials: &[Material]) -> MediumInterface {
        let here = self.medium(materials);
        MediumInterface { event: InterfaceEvent::Stay, before: here, after: here, is_boundary: true }
    }

    /// Updates the list for a ray that passes an interface.
    pub(crate) fn cross(&mut self, interface: &MediumInterface) {
        match interface.event {
            InterfaceEvent::Enter(body) => self.push(body),
            InterfaceEvent::Leave(at) => {
                self.bodies.remove(at);
            }
            InterfaceEvent::Stay => {}
        }
    }

    fn push(&mut self, body: MediumEntry) {
        if self.bodies.len() < CAPACITY {
            self.bodies.push(body);
        }
    }

    /// Adds a solid that was never entered as the outermost one; returns its index.
    fn push_outermost(&mut self, body: MediumEntry) -> Option<usize> {
        (self.bodies.len() < CAPACITY).then(|| {
            self.bodies.insert(0, body);
            0
        })
    }

    fn bodies_after(&self, event: InterfaceEvent) -> impl Iterator<Item = MediumEntry> {
        let (left, entered) = match event {
            InterfaceEvent::Enter(body) => (None, Some(body)),
            InterfaceEvent::Leave(at) => (Some(at), None),
            InterfaceEvent::Stay => (None, None),
        };
        let stays = move |(at, body): (usize, &MediumEntry)| (Some(at) != left).then_some(*body);
        self.bodies.iter().enumerate().filter_map(stays).chain(entered)
    }

    /// The material that is here.
    fn top(&self, materials: &[Material]) -> Option<u32> {
        top(self.bodies.iter().copied(), materials)
    }
}

/// Lists of paths that wait, one behind the other: what is put on last is taken off first.
#[derive(Clone, Debug, Default)]
pub(crate) struct InteriorListStack {
    bodies: Vec<MediumEntry>,
}

impl InteriorListStack {
    /// Puts a list on the stack as it will be beyond a surface; its length.
    pub(crate) fn push(&mut self, interior: &Interior, interface: &MediumInterface) -> u32 {
        let length = self.bodies.len();
        self.bodies.extend(interior.bodies_after(interface.event));
        (self.bodies.len() - length) as u32
    }

    /// Takes the list of this length off the stack.
    pub(crate) fn pop(&mut self, interior: &mut Interior, length: u32) {
        let start = self.bodies.len().saturating_sub(length as usize);
        interior.bodies.clear();
        interior.bodies.extend(self.bodies.drain(start..));
    }
}

/// The place of a body, or else of another one of its material: the one that was entered last.
fn find(bodies: &[MediumEntry], body: MediumEntry) -> Option<usize> {
    let last = |matches: &dyn Fn(&MediumEntry) -> bool| bodies.iter().rposition(matches);
    last(&|other| *other == body).or_else(|| last(&|other| other.material == body.material))
}

/// The material of highest priority, of equals the last.
fn top(bodies: impl Iterator<Item = MediumEntry>, materials: &[Material]) -> Option<u32> {
    let priority = |body: &MediumEntry| transmission(materials, body.material).map(|t| t.priority);
    bodies.max_by_key(priority).map(|body| body.material)
}

fn medium(material: Option<u32>, materials: &[Material]) -> Medium {
    material
        .and_then(|material| transmission(materials, material))
        .map_or(Medium::AIR, |transmission| Medium { ior: transmission.ior, absorption: transmission.absorption })
}

fn transmission(materials: &[Material], material: u32) -> Option<&Transmission> {
    materials.get(material as usize)?.body()
}

#[cfg(test)]
mod tests;
