//! The world that rays are traced against, in one of two forms.

use rt_accel::AnyAccelerator;
use rt_geometry::{BatchKernel, Hit, InteractionFlags, PrimitiveGeometry, Primitives, Shape, Spheres};
use rt_math::{Aabb, Interval, Ray};
use rt_shading::{SphereHit, SurfaceHit, TriangleHit, light::LightId};

use crate::{
    instance::{Aggregate, BottomLevel, Instance, InstanceGeometry, Instances},
    primitive_form::{HasForm, PrimitiveForm},
};

/// World in one of two forms.
#[derive(Debug)]
pub(crate) enum World {
    Spheres(SphereWorld, AnyAccelerator),
    Instances(Aggregate, BottomLevel),
}

impl World {
    /// Chooses the compact form for a world of spheres only.
    pub(crate) fn specialise(top: Aggregate, levels: BottomLevel) -> Self {
        let sphere = |instance: &Instance| match instance.geometry {
            InstanceGeometry::Shape(Shape::Sphere(sphere)) => Some(sphere),
            _ => None,
        };
        match top.instances.iter().map(sphere).collect::<Option<Vec<_>>>() {
            Some(spheres) => {
                let materials = top.instances.iter().map(|instance| instance.material).collect();
                let textured = top.instances.iter().map(|instance| instance.textured).collect();
                let some_cast_no_shadow = top.instances.iter().any(|instance| !instance.casts_shadow);
                let switches = top.instances.iter().map(|instance| instance.casts_shadow);
                let casts_shadow = if some_cast_no_shadow { switches.collect() } else { Vec::new() };
                let has_lights = top.instances.iter().any(|instance| instance.light.is_some());
                let lights = top.instances.iter().map(|instance| instance.light);
                let lights = if has_lights { lights.collect() } else { Vec::new() };
                let spheres = Spheres::new(spheres);
                Self::Spheres(SphereWorld { spheres, materials, textured, casts_shadow, lights }, top.structure)
            }
            None => Self::Instances(top, levels),
        }
    }

    /// True if an object moves.
    pub(crate) fn has_motion(&self) -> bool {
        match self {
            Self::Spheres(..) => false,
            Self::Instances(top, levels) => top.all_instances(levels).any(Instance::has_motion),
        }
    }

    /// Box around all bounded objects.
    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Spheres(world, _) => {
                world.spheres.as_slice().iter().fold(Aabb::EMPTY, |sum, sphere| sum.union(sphere.bounds()))
            }
            Self::Instances(top, _) => {
                top.instances.iter().filter_map(|instance| instance.bounds).fold(Aabb::EMPTY, Aabb::union)
            }
        }
    }
}

/// Primitives with surface attributes and materials.
pub(crate) trait ShadedPrimitives: HasForm {
    /// Surface at a hit; `None` for a hit outside of this set. Object indices are those of the instances of the top level.
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit>;

    /// Hit on a sphere whose surface [`SphereHit`] describes fully; `None` for all other hits.
    fn sphere_at(&self, hit: &Hit, needs: InteractionFlags) -> Option<SphereHit>;

    /// Hit on a triangle whose surface [`TriangleHit`] describes fully; `None` for all other hits.
    fn triangle_at(&self, hit: &Hit, needs: InteractionFlags) -> Option<TriangleHit>;

    /// Numbers of the hit object, and of its shape, mesh or group of the top level; `None` for a hit outside of this set.
    fn ids_at(&self, hit: &Hit) -> Option<[u32; 2]>;
}

impl ShadedPrimitives for Instances<'_> {
    #[inline]
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.surface(ray, hit, needs)
    }

    #[inline]
    fn sphere_at(&self, hit: &Hit, needs: InteractionFlags) -> Option<SphereHit> {
        self.sphere(hit, needs)
    }

    #[inline]
    fn triangle_at(&self, hit: &Hit, needs: InteractionFlags) -> Option<TriangleHit> {
        self.triangle(hit, needs)
    }

    fn ids_at(&self, hit: &Hit) -> Option<[u32; 2]> {
        self.ids(hit)
    }
}

/// World of spheres only: compact arrays, without dispatch on the kind of an instance.
#[derive(Debug)]
pub(crate) struct SphereWorld {
    pub(crate) spheres: Spheres,
    /// Material index by sphere.
    pub(crate) materials: Vec<u32>,
    /// True for spheres whose texture coordinates are used.
    pub(crate) textured: Vec<bool>,
    /// True for spheres that cast shadows; empty if all do.
    pub(crate) casts_shadow: Vec<bool>,
    /// Light index by sphere; empty if none emits.
    pub(crate) lights: Vec<Option<u32>>,
}

impl SphereWorld {
    /// Light of a sphere, if it is sampled.
    #[inline(always)]
    fn light(&self, index: u32) -> Option<LightId> {
        let index = self.lights.get(index as usize).copied().flatten();
        index.map(|index| LightId { index, triangle: None })
    }

    pub(crate) fn casts_shadow(&self, index: u32) -> bool {
        self.casts_shadow.get(index as usize).copied().unwrap_or(true)
    }
}

impl Primitives for SphereWorld {
    fn len(&self) -> usize {
        self.spheres.len()
    }

    #[inline]
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.spheres.bounds(index)
    }

    #[inline(always)]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.spheres.intersect(index, ray, span)
    }

    #[inline(always)]
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.casts_shadow(index) && self.spheres.occludes(index, ray, span)
    }

    #[inline]
    fn batch_kernel(&self, index: u32) -> BatchKernel {
        self.spheres.batch_kernel(index)
    }

    #[inline]
    fn blocks(&self, index: u32) -> bool {
        self.casts_shadow(index)
    }

    #[inline]
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        if self.casts_shadow(index) { self.spheres.geometry(index) } else { PrimitiveGeometry::Opaque }
    }
}

impl ShadedPrimitives for SphereWorld {
    #[inline(always)]
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit> {
        let material = *self.materials.get(hit.primitive as usize)?;
        let uv = needs.uv && *self.textured.get(hit.primitive as usize)?;
        let interaction = self.spheres.surface(ray, hit, InteractionFlags { uv, ..needs })?;
        Some(SurfaceHit { t: hit.t, interaction, object: hit.primitive, material, light: self.light(hit.primitive) })
    }

    #[inline(always)]
    fn sphere_at(&self, hit: &Hit, needs: InteractionFlags) -> Option<SphereHit> {
        let index = hit.primitive as usize;
        let has_uv = needs.uv && *self.textured.get(index)?;
        let (sphere, material) = (*self.spheres.as_slice().get(index)?, *self.materials.get(index)?);
        let hit = SphereHit { t: hit.t, sphere, object: hit.primitive, material, light: self.light(hit.primitive) };
        (!has_uv).then_some(hit)
    }

    fn triangle_at(&self, _: &Hit, _: InteractionFlags) -> Option<TriangleHit> {
        None
    }

    fn ids_at(&self, hit: &Hit) -> Option<[u32; 2]> {
        Some([hit.primitive; 2])
    }
}

impl HasForm for SphereWorld {
    fn form(&self, index: u32) -> PrimitiveForm {
        let sphere = &self.spheres.as_slice()[index as usize];
        PrimitiveForm::Sphere { centre: sphere.centre(), radius: sphere.radius() }
    }

    fn casts_shadow(&self, index: u32) -> bool {
        Self::casts_shadow(self, index)
    }
}

impl HasForm for Instances<'_> {
    fn form(&self, index: u32) -> PrimitiveForm {
        match &self.instances[index as usize].geometry {
            InstanceGeometry::Shape(shape) => PrimitiveForm::of(shape),
            InstanceGeometry::TransformedShape(placed) => PrimitiveForm::of_placed(placed),
            InstanceGeometry::Triangle(mesh, ..) if mesh.data().normals.is_empty() => PrimitiveForm::Flat,
            InstanceGeometry::Triangle(..)
            | InstanceGeometry::Mesh(..)
            | InstanceGeometry::Group(..)
            | InstanceGeometry::Animated(_) => PrimitiveForm::Other,
        }
    }

    fn casts_shadow(&self, index: u32) -> bool {
        let Instance { casts_shadow, .. } = &self.instances[index as usize];
        *casts_shadow
    }
}
