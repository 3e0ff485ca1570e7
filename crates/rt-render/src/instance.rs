//! Instances on two levels, with their acceleration structures.
//!
//! The top level holds instances in world space. An instance is a shape, a transformed mesh, or a group: an aggregate of
//! instances in a space of its own, shared by all uses. Groups do not contain groups, because flattening inlines these.

use std::sync::Arc;

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{
    Hit, HitStream, InteractionFlags, PacketKernel, PrimitiveGeometry, Primitives, Probe, RayStream, Shape, ShapeHit,
    SurfaceInteraction, TransformedShape, TriangleMesh,
};
use rt_math::{Aabb, AnimatedTransformChain, DVec3, Interval, Ray, Transform};
use rt_shading::{NormalMap, StreamPrimitive, StreamShape, SurfaceHit, Texture, light::LightId};

use crate::{inlined_triangle::InlinedTriangle, mesh_blas::MeshBlas, work_probe::WorkProbe};

/// A placed object, in the space of its aggregate.
#[derive(Debug)]
pub(crate) struct Instance {
    pub(crate) geometry: InstanceGeometry,
    /// Index of the material; unused for a group, whose instances have their own.
    pub(crate) material: u32,
    pub(crate) casts_shadow: bool,
    pub(crate) bounds: Option<Aabb>,
    /// Index of the object: of its first instance, if it has several.
    pub(crate) object: u32,
    /// Number of its shape or mesh among those of all nodes, also in groups; unused for a group.
    pub(crate) object_id: u32,
    /// Number of the placed shape, mesh or group in its aggregate.
    pub(crate) instance_id: u32,
    /// Index of its first primitive within its group; 0 on the top level.
    pub(crate) first_primitive: u32,
    /// Index of its light, if it is sampled. For a group, index of its first light; instances in the group count relative to it.
    pub(crate) light: Option<u32>,
    /// True if its texture coordinates are used.
    pub(crate) textured: bool,
    /// Normal map of its material; `None` for a group.
    pub(crate) normal_map: Option<NormalMap>,
    /// Name of its node, for messages.
    pub(crate) name: Arc<str>,
}

impl Instance {
    /// True if it moves in its aggregate.
    pub(crate) const fn has_motion(&self) -> bool {
        matches!(self.geometry, InstanceGeometry::Animated(_))
    }

    /// Required attributes of its surface.
    #[inline]
    fn needs(&self, needs: InteractionFlags) -> InteractionFlags {
        InteractionFlags { uv: needs.uv && self.textured, ..needs }
    }

    /// Surface hit at `t`. `triangle` is the index of the hit triangle of a mesh.
    #[inline]
    fn surface_hit(&self, t: f64, interaction: SurfaceInteraction, triangle: Option<u32>) -> SurfaceHit {
        let Self { object, material, casts_shadow, .. } = *self;
        SurfaceHit { t, interaction, object, material, light: self.light_id(triangle), casts_shadow }
    }

    /// Light of a hit on it, on a triangle if it is a mesh.
    #[inline(always)]
    fn light_id(&self, triangle: Option<u32>) -> Option<LightId> {
        self.light.map(|index| LightId { index, triangle })
    }

    #[inline]
    fn triangle_surface(
        &self,
        (mesh, triangle, unit_normal): (&TriangleMesh, u32, Option<DVec3>),
        ray: &Ray,
        hit: &Hit,
        needs: InteractionFlags,
    ) -> Option<SurfaceHit> {
        let hit = &Hit { primitive: triangle, ..*hit };
        let surface = mesh.surface_with_normal(ray, hit, self.needs(needs), unit_normal)?;
        Some(self.surface_hit(hit.t, surface, Some(triangle)))
    }

    #[inline]
    fn shape_surface(&self, shape: &Shape, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> SurfaceHit {
        self.surface_hit(hit.t, shape.surface(ray, &ShapeHit { t: hit.t, uv: hit.uv }, self.needs(needs)), None)
    }
}

#[derive(Debug)]
pub(crate) enum InstanceGeometry {
    Shape(Shape),
    TransformedShape(Box<TransformedShape>),
    /// Index of a [`MeshBlas`]; no transform means the identity.
    Mesh(u32, Option<Box<Transform>>),
    Triangle(Box<InlinedTriangle>),
    /// Index of an [`Aggregate`].
    Group(u32, Option<Box<Transform>>),
    Animated(Box<Animated>),
}

impl InstanceGeometry {
    /// Geometry without animation, in its own space.
    pub(crate) fn static_geometry(&self) -> &Self {
        if let Self::Animated(animated) = self { &animated.geometry } else { self }
    }

    /// True if it has its own acceleration structure.
    pub(crate) fn is_accelerator(&self) -> bool {
        matches!(self.static_geometry(), Self::Mesh(..) | Self::Group(..))
    }

    /// Index of the [`Aggregate`] that it places.
    pub(crate) fn group(&self) -> Option<u32> {
        if let Self::Group(level, _) = self.static_geometry() { Some(*level) } else { None }
    }
}

/// Animated geometry. The bounds of its instance contain it at all times.
#[derive(Debug)]
pub(crate) struct Animated {
    pub(crate) aggregate_from_local: AnimatedTransformChain,
    /// A shape, or a mesh or group without a transform.
    pub(crate) geometry: InstanceGeometry,
}

/// Instances with their accelerator.
#[derive(Debug)]
pub(crate) struct Aggregate {
    pub(crate) instances: Vec<Instance>,
    pub(crate) accelerator: AnyAccelerator,
    /// True if each instance is one primitive and its index identifies a hit. The accelerator can then intersect its own
    /// copies of triangles.
    pub(crate) is_flat: bool,
    /// True if all instances are primitives of streams, and textured ones have texture coordinates there.
    pub(crate) has_only_primitives: bool,
}

impl Aggregate {
    pub(crate) fn set<'w>(&'w self, levels: &'w BottomLevel) -> Instances<'w> {
        let &Self { ref instances, is_flat, has_only_primitives, .. } = self;
        Instances { instances, levels, is_flat, has_only_primitives }
    }

    /// Instance of a consecutive index of a primitive of the group; `None` without any instance.
    fn hit_instance(&self, primitive: u32) -> Option<&Instance> {
        let at = self.instances.partition_point(|instance| instance.first_primitive <= primitive).checked_sub(1)?;
        self.instances.get(at)
    }

    /// Converts a hit within the group to a hit on the group instance, by the consecutive index of the primitive.
    pub(crate) fn with_instance(&self, hit: Hit, instance: u32) -> Hit {
        let first = self.instances[hit.instance as usize].first_primitive;
        Hit { instance, primitive: first + hit.primitive, ..hit }
    }

    /// All instances, those of each group once.
    pub(crate) fn all_instances<'w>(&'w self, levels: &'w BottomLevel) -> impl Iterator<Item = &'w Instance> {
        self.instances.iter().chain(levels.groups.iter().flat_map(|group| &group.instances))
    }
}

/// Bottom level: meshes and groups with their acceleration structures.
#[derive(Debug, Default)]
pub(crate) struct BottomLevel {
    pub(crate) meshes: Vec<MeshBlas>,
    pub(crate) groups: Vec<Aggregate>,
    /// Textures of the scene, if an alpha test or a normal map uses them.
    pub(crate) textures: Vec<Texture>,
}

/// Instances of an aggregate as a set of primitives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instances<'w> {
    pub(crate) instances: &'w [Instance],
    pub(crate) levels: &'w BottomLevel,
    pub(crate) is_flat: bool,
    /// See [`Aggregate::has_only_primitives`].
    pub(crate) has_only_primitives: bool,
}

/// Ray in the space below a transform.
fn to_local(ray: &Ray, parent_from_local: Option<&Transform>) -> Ray {
    parent_from_local.map_or(*ray, |transform| transform.inverse_ray(ray))
}

impl Instances<'_> {
    pub(crate) fn instance_index(&self, hit: &Hit) -> u32 {
        if self.is_flat { hit.primitive } else { hit.instance }
    }

    /// Numbers of the hit object, and of its shape, mesh or group of the top level; `None` for a hit outside of this set.
    pub(crate) fn ids(&self, hit: &Hit) -> Option<[u32; 2]> {
        let instance = self.instances.get(self.instance_index(hit) as usize)?;
        let object = match instance.geometry.group() {
            Some(level) => self.levels.groups[level as usize].hit_instance(hit.primitive)?,
            None => instance,
        };
        Some([object.object_id, instance.instance_id])
    }

    /// Hit on an instance that is one primitive.
    fn hit_of(&self, index: u32, t: f64, uv: [f64; 2]) -> Hit {
        let [instance, primitive] = self.hit_ids(index);
        Hit { t, instance, primitive, uv }
    }

    /// Surface at a hit of [`Primitives::intersect`].
    #[inline]
    pub(crate) fn surface(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit> {
        let instance = self.instances.get(self.instance_index(hit) as usize)?;
        // The common kinds come first, so that their results are constructed in place.
        match &instance.geometry {
            InstanceGeometry::Triangle(triangle) => instance.triangle_surface(
                (&triangle.mesh, triangle.index, Some(triangle.shape.normal)),
                ray,
                hit,
                needs,
            ),
            InstanceGeometry::Mesh(level, None) if instance.normal_map.is_none() => {
                let mesh = &self.levels.meshes[*level as usize].mesh;
                instance.triangle_surface((mesh, hit.primitive, None), ray, hit, needs)
            }
            InstanceGeometry::Shape(shape) => Some(instance.shape_surface(shape, ray, hit, needs)),
            geometry => self.surface_of(instance, geometry, ray, hit, needs),
        }
    }

    /// The instance of a hit, given by its instance and primitive. `None` for an index out of range.
    #[inline(always)]
    fn instance_of(&self, [instance, primitive]: [u32; 2]) -> Option<&Instance> {
        self.instances.get(if self.is_flat { primitive } else { instance } as usize)
    }

    /// A hit primitive whose surface is computed in lanes: a sphere, a plane, a polygon or a triangle, without transform and normal map.
    /// `None` for all others.
    #[inline(always)]
    pub(crate) fn stream_primitive(&self, hit: [u32; 2]) -> Option<StreamPrimitive<'_>> {
        let instance = self.instance_of(hit)?;
        let [_, primitive] = hit;
        let mut of_mesh = None;
        let shape = match &instance.geometry {
            InstanceGeometry::Triangle(triangle) => {
                of_mesh = Some(triangle.index);
                StreamShape::Triangle(&triangle.shape)
            }
            InstanceGeometry::Mesh(level, None) if instance.normal_map.is_none() => {
                of_mesh = Some(primitive);
                StreamShape::MeshTriangle(&self.levels.meshes[*level as usize].mesh, primitive)
            }
            InstanceGeometry::Shape(Shape::Sphere(sphere)) => StreamShape::Sphere(sphere),
            InstanceGeometry::Shape(Shape::Plane(plane)) => StreamShape::Plane(plane),
            InstanceGeometry::Shape(Shape::Polygon(polygon)) => StreamShape::Polygon(polygon.plane()),
            _ => return None,
        };
        let light = instance.light_id(of_mesh);
        let Instance { object, material, casts_shadow, .. } = *instance;
        Some(StreamPrimitive { shape, object, material, light, casts_shadow })
    }

    /// Index of the material of a hit primitive whose texture coordinates are not used. `None` for all others, and for a group.
    #[inline(always)]
    pub(crate) fn untextured_material(&self, hit: [u32; 2]) -> Option<u32> {
        let instance = self.instance_of(hit)?;
        (!instance.textured).then_some(instance.material)
    }

    /// All instances as primitives of streams; `None` for those that are none. A mesh is one of its triangles.
    pub(crate) fn stream_primitives(&self) -> impl Iterator<Item = Option<StreamPrimitive<'_>>> {
        (0..self.instances.len() as u32).map(|index| self.stream_primitive([index; 2]))
    }

    /// Texture coordinates of the vertices of a hit triangle; `None` for all other primitives.
    pub(crate) fn vertex_uvs(&self, hit: [u32; 2]) -> Option<[[f32; 2]; 3]> {
        let [_, primitive] = hit;
        match &self.instance_of(hit)?.geometry {
            InstanceGeometry::Triangle(triangle) => triangle.mesh.vertex_uvs(triangle.index),
            InstanceGeometry::Mesh(level, _) => self.levels.meshes[*level as usize].mesh.vertex_uvs(primitive),
            _ => None,
        }
    }

    fn surface_of(
        &self,
        instance: &Instance,
        geometry: &InstanceGeometry,
        ray: &Ray,
        hit: &Hit,
        needs: InteractionFlags,
    ) -> Option<SurfaceHit> {
        let shape_hit = ShapeHit { t: hit.t, uv: hit.uv };
        let needs = instance.needs(needs);
        Some(match geometry {
            InstanceGeometry::Shape(shape) => instance.shape_surface(shape, ray, hit, needs),
            InstanceGeometry::TransformedShape(placed) => {
                instance.surface_hit(hit.t, placed.surface(ray, &shape_hit, needs), None)
            }
            InstanceGeometry::Mesh(level, transform) => {
                let mut surface = self.levels.meshes[*level as usize].mesh.surface(
                    &to_local(ray, transform.as_deref()),
                    hit,
                    needs,
                )?;
                if let Some(map) = &instance.normal_map {
                    map.apply(&self.levels.textures, &mut surface);
                }
                instance.surface_hit(hit.t, to_world(surface, transform.as_deref()), Some(hit.primitive))
            }
            InstanceGeometry::Triangle(triangle) => instance.triangle_surface(
                (&triangle.mesh, triangle.index, Some(triangle.shape.normal)),
                ray,
                hit,
                needs,
            )?,
            InstanceGeometry::Group(level, transform) => {
                let group = &self.levels.groups[*level as usize];
                let inner = group.set(self.levels);
                let inner_instance = group.hit_instance(hit.primitive)?;
                let inner_hit = Hit { primitive: hit.primitive - inner_instance.first_primitive, ..*hit };
                let local = to_local(ray, transform.as_deref());
                let surface = inner.surface_of(inner_instance, &inner_instance.geometry, &local, &inner_hit, needs)?;
                let light = surface.light.zip(instance.light);
                SurfaceHit {
                    interaction: to_world(surface.interaction, transform.as_deref()),
                    object: instance.object,
                    light: light.map(|(light, first)| LightId { index: first + light.index, ..light }),
                    casts_shadow: instance.casts_shadow && surface.casts_shadow,
                    ..surface
                }
            }
            InstanceGeometry::Animated(animated) => {
                let map = animated.aggregate_from_local.at(ray.time);
                let surface = self.surface_of(instance, &animated.geometry, &map.inverse_ray(ray), hit, needs)?;
                SurfaceHit { interaction: surface.interaction.transformed(&map), ..surface }
            }
        })
    }

    /// Closest hit on an instance.
    #[inline]
    pub(crate) fn closest_on<S: Probe>(
        &self,
        (index, geometry): (u32, &InstanceGeometry),
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let hit_of = |hit: ShapeHit| self.hit_of(index, hit.t, hit.uv);
        match geometry {
            InstanceGeometry::Shape(shape) => shape.intersect(ray, span).map(hit_of),
            InstanceGeometry::TransformedShape(placed) => placed.intersect(ray, span).map(hit_of),
            InstanceGeometry::Mesh(level, transform) => {
                let level = &self.levels.meshes[*level as usize];
                let ray = to_local(ray, transform.as_deref());
                let hit = level.closest(&self.levels.textures, &ray, span, probe)?;
                Some(Hit { instance: index, ..hit })
            }
            InstanceGeometry::Triangle(triangle) => {
                let hit = triangle.mesh.intersect(triangle.index, ray, span)?;
                Some(self.hit_of(index, hit.t, hit.uv))
            }
            InstanceGeometry::Group(level, transform) => {
                let group = &self.levels.groups[*level as usize];
                let inner = group.set(self.levels);
                let ray = to_local(ray, transform.as_deref());
                let hit = group.accelerator.closest(&inner, &ray, span, probe)?;
                Some(group.with_instance(hit, index))
            }
            InstanceGeometry::Animated(animated) => self.closest_on_animated((index, animated), ray, span, probe),
        }
    }

    #[inline(never)]
    fn closest_on_animated<S: Probe>(
        &self,
        (index, animated): (u32, &Animated),
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let ray = animated.aggregate_from_local.at(ray.time).inverse_ray(ray);
        self.closest_on((index, &animated.geometry), &ray, span, probe)
    }

    #[inline]
    pub(crate) fn occluded_by<S: Probe>(
        &self,
        geometry: &InstanceGeometry,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> bool {
        match geometry {
            InstanceGeometry::Shape(shape) => shape.intersect(ray, span).is_some(),
            InstanceGeometry::TransformedShape(placed) => placed.intersect(ray, span).is_some(),
            InstanceGeometry::Mesh(level, transform) => {
                let level = &self.levels.meshes[*level as usize];
                level.occluded(&self.levels.textures, &to_local(ray, transform.as_deref()), span, probe)
            }
            InstanceGeometry::Triangle(triangle) => triangle.mesh.intersect(triangle.index, ray, span).is_some(),
            InstanceGeometry::Group(level, transform) => {
                let group = &self.levels.groups[*level as usize];
                let inner = group.set(self.levels);
                group.accelerator.occluded(&inner, &to_local(ray, transform.as_deref()), span, probe)
            }
            InstanceGeometry::Animated(animated) => self.occluded_by_animated(animated, ray, span, probe),
        }
    }

    #[inline(never)]
    fn occluded_by_animated<S: Probe>(&self, animated: &Animated, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let ray = animated.aggregate_from_local.at(ray.time).inverse_ray(ray);
        self.occluded_by(&animated.geometry, &ray, span, probe)
    }
}

fn to_world(surface: SurfaceInteraction, parent_from_local: Option<&Transform>) -> SurfaceInteraction {
    parent_from_local.map_or(surface, |transform| surface.transformed(transform))
}

impl Primitives for Instances<'_> {
    fn len(&self) -> usize {
        self.instances.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.instances[index as usize].bounds
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.intersect_with_stats(index, ray, span, &mut WorkProbe::default())
    }

    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.occludes_with_stats(index, ray, span, &mut WorkProbe::default())
    }

    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        self.closest_on((index, &self.instances[index as usize].geometry), ray, span, probe)
    }

    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let instance = &self.instances[index as usize];
        instance.casts_shadow && self.occluded_by(&instance.geometry, ray, span, probe)
    }

    fn packet_kernel(&self, index: u32) -> PacketKernel {
        match &self.instances[index as usize].geometry {
            InstanceGeometry::Shape(Shape::Sphere(sphere)) => PacketKernel::Sphere(sphere.kernel()),
            InstanceGeometry::Shape(Shape::Plane(plane)) => PacketKernel::Plane(*plane),
            InstanceGeometry::Shape(Shape::Polygon(polygon)) => {
                let corners = polygon.convex_quadrilateral();
                corners.map_or(PacketKernel::Single, |corners| PacketKernel::Quadrilateral(*polygon.plane(), corners))
            }
            InstanceGeometry::Triangle(triangle) => triangle.mesh.packet_kernel(triangle.index),
            geometry if geometry.is_accelerator() => PacketKernel::Instance,
            _ => PacketKernel::Single,
        }
    }

    /// Ids ascend with the index in both forms, so that ties in t resolve equally.
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        if self.is_flat { [0, index] } else { [index, 0] }
    }

    fn casts_shadow(&self, index: u32) -> bool {
        self.instances[index as usize].casts_shadow
    }

    fn intersect_stream<S: Probe>(&self, index: u32, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        self.closest_stream_on((index, &self.instances[index as usize].geometry), rays, hits, probe);
    }

    fn occludes_stream<S: Probe>(&self, index: u32, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        let instance = &self.instances[index as usize];
        if instance.casts_shadow {
            self.occluded_stream_by(&instance.geometry, rays, occluded, probe);
        } else {
            let n = rays.len().min(occluded.len());
            occluded[..n].fill(false);
        }
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        let instance = &self.instances[index as usize];
        match &instance.geometry {
            _ if !instance.casts_shadow => PrimitiveGeometry::Opaque,
            InstanceGeometry::Shape(Shape::Sphere(sphere)) if self.is_flat => {
                PrimitiveGeometry::ExactSphere(sphere.kernel())
            }
            InstanceGeometry::Shape(Shape::Sphere(sphere)) => {
                PrimitiveGeometry::Sphere(sphere.centre(), sphere.radius())
            }
            InstanceGeometry::Shape(Shape::Cuboid(axis_box)) => PrimitiveGeometry::Box(axis_box.bounds()),
            InstanceGeometry::Shape(Shape::Triangle(triangle)) => PrimitiveGeometry::Triangle(triangle.vertices()),
            InstanceGeometry::Triangle(triangle) if self.is_flat => triangle.mesh.geometry(triangle.index),
            InstanceGeometry::Triangle(triangle) => PrimitiveGeometry::Triangle(triangle.shape.vertices),
            _ => PrimitiveGeometry::Opaque,
        }
    }
}

/// True if an instance, or one in its group, has a material that satisfies the condition.
pub(crate) fn uses_material(instance: &Instance, levels: &BottomLevel, is_wanted: &impl Fn(u32) -> bool) -> bool {
    match instance.geometry.static_geometry() {
        InstanceGeometry::Group(level, _) => {
            levels.groups[*level as usize].instances.iter().any(|inner| is_wanted(inner.material))
        }
        _ => is_wanted(instance.material),
    }
}
