//! Surface patch: the part of a smooth surface in a pyramid, and the variation of light over it.

use rt_geometry::{Hit, InteractionFlags};
use rt_math::{DVec3, Ray, transcendental::pow};
use rt_shading::{Appearance, ColorTexture, DeltaLight, Material, Phong};

use crate::{instance::Instances, primitive_form::PrimitiveForm};

/// Maximum variation of the directions of shading within a patch, in radians; times √n for a highlight of exponent n.
///
/// The slope of cosⁿ a ≈ exp(−n a²/2) is at most √(n/e). The highlight changes by less than 16 % of its peak.
const MAX_TURN: f64 = 0.25;

/// Highlights below this radiance are ignored.
const MIN_HIGHLIGHT: f64 = 1.0 / 512.0;

/// Part of a surface in a pyramid whose corner rays all hit the same smooth, convex surface from the outside.
///
/// All rays between them hit it as well: the projection of a convex solid is convex.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePatch {
    pub(super) index: u32,
    form: PrimitiveForm,
    material: u32,
    /// Centre of the bounding sphere.
    pub(super) centre: DVec3,
    /// Radius of the bounding sphere.
    pub(super) radius: f64,
    /// Maximum depth, which is that of a corner: over the image, the inverse depth of a convex solid is concave.
    pub(super) farthest: f64,
    corners: [Corner; 4],
    /// Sum of the angles by which normal (twice, as in a mirrored direction) and view turn.
    turn: f64,
}

/// Hit of a corner ray.
#[derive(Clone, Copy, Debug)]
struct Corner {
    point: DVec3,
    /// Unit normal on the viewer's side.
    normal: DVec3,
    /// Unit vector to the viewer.
    to_viewer: DVec3,
}

impl SurfacePatch {
    /// Patch of the corner hits; `None` if the surface can have an edge between them, or if the bounding sphere is too large.
    pub(super) fn new(world: &Instances<'_>, index: u32, rays: &[Ray; 4], hits: &[Option<Hit>; 4]) -> Option<Self> {
        let form = world.form(index);
        let [Some(a), Some(b), Some(c), Some(d)] = *hits else { return None };
        let hits = [a, b, c, d];
        let is_smooth = match form {
            PrimitiveForm::Sphere { .. } | PrimitiveForm::Plane { .. } | PrimitiveForm::Flat => true,
            PrimitiveForm::Faces => hits.iter().all(|hit| hit.uv[0] == hits[0].uv[0]),
            PrimitiveForm::Other => false,
        };
        if !is_smooth {
            return None;
        }
        let is_closed = matches!(form, PrimitiveForm::Sphere { .. } | PrimitiveForm::Faces);
        let needs = InteractionFlags::NONE;
        let mut material = None;
        let mut corner = |at: usize| {
            let surface = world.surface(&rays[at], &hits[at], needs)?;
            material = Some(surface.material);
            let to_viewer = -rays[at].direction.normalize_or_zero();
            let normal = surface.interaction.geometric_normal;
            let facing = normal.dot(to_viewer);
            if is_closed && facing <= 0.0 {
                return None;
            }
            let normal = if facing < 0.0 { -normal } else { normal };
            Some(Corner { point: surface.interaction.point, normal, to_viewer })
        };
        let corners = [corner(0)?, corner(1)?, corner(2)?, corner(3)?];
        let (centre, radius) = enclosing_sphere(&form, &corners)?;
        let turn = 2.0 * max_difference(&corners.map(|corner| corner.normal))
            + max_difference(&corners.map(|corner| corner.to_viewer));
        let farthest = hits.iter().map(|hit| hit.t).fold(0.0, f64::max);
        Some(Self { index, form, material: material?, centre, radius, farthest, corners, turn })
    }

    /// Material, if a few samples are enough: it is neither specular nor textured.
    pub(super) fn plain_material<'a>(&self, appearance: &'a Appearance) -> Option<&'a Material> {
        let material = appearance.materials.get(self.material as usize)?;
        let phong = material.to_phong();
        let is_plain = phong.mirror.is_zero() && phong.transmission.is_none() && !material.is_textured();
        is_plain.then_some(material)
    }

    /// True if the light would reach no point of the patch, even without occluders.
    pub(super) fn turns_away_from(&self, light: &DeltaLight) -> bool {
        let position = light.kind.position();
        if let (Some(position), Some(cone)) = (position, light.kind.cone()) {
            let axis = self.cosine_with(position, cone.direction);
            if axis.is_some_and(|[_, max]| max <= cone.cos_outer) {
                return true;
            }
        }
        if let PrimitiveForm::Sphere { centre, radius } = self.form {
            // (p − c)·(l − p) = (p − c)·(l − c) − r² is at most this anywhere in the bounding sphere.
            let offset = self.centre - centre;
            return match position {
                Some(position) => {
                    let light = position - centre;
                    offset.dot(light) + self.radius * light.length() <= radius * radius
                }
                None => self.radius + offset.dot(light.kind.offset_from(self.centre)) <= 0.0,
            };
        }
        self.corners.iter().all(|corner| corner.normal.dot(light.kind.offset_from(corner.point)) <= 0.0)
    }

    /// True if an unoccluded light of full strength changes so little over the patch that a few samples show it.
    pub(super) fn is_even_under(&self, light: &DeltaLight, phong: &Phong) -> bool {
        let turn_of_light = match (light.kind.position(), light.kind.cone()) {
            (None, _) => Some(0.0),
            (Some(position), None) => self.angle_from(position),
            (Some(position), Some(cone)) => {
                let axis = self.cosine_with(position, cone.direction);
                self.angle_from(position).filter(|_| axis.is_some_and(|[min, _]| min >= cone.cos_inner))
            }
        };
        let Some(turn_of_light) = turn_of_light else { return false };
        let turn = self.turn + turn_of_light;
        turn <= MAX_TURN && (phong.specular.is_zero() || self.has_even_highlight(light, phong, turn))
    }

    /// True if the highlight is wide, or elsewhere.
    fn has_even_highlight(&self, light: &DeltaLight, phong: &Phong, turn: f64) -> bool {
        if turn * phong.exponent.max(1.0).sqrt() <= MAX_TURN {
            return true;
        }
        let ColorTexture::Constant(specular) = phong.specular else { return false };
        let brightest = |corner: &Corner| {
            let lit = light.sample_li(corner.point)?;
            let cosine = phong.highlight.strength(corner.normal, corner.to_viewer, lit.direction, 1.0);
            Some(pow((cosine + turn).min(1.0), phong.exponent) * lit.strength.max_component())
        };
        let peak = self.corners.iter().filter_map(brightest).fold(0.0, f64::max);
        peak * specular.max_component() <= MIN_HIGHLIGHT
    }

    /// Upper bound on the angle between directions to a light from two points of the patch; `None` if the light is near.
    ///
    /// The angle is at most 2·asin(r/d). The bound also exceeds the relative change of the strength of the light.
    fn angle_from(&self, position: DVec3) -> Option<f64> {
        let gap = (position - self.centre).length() - self.radius;
        (gap > self.radius).then(|| 4.0 * self.radius / gap)
    }

    /// Bounds on the cosine of the angle at a light between an axis and directions to the patch; `None` if the light is near.
    fn cosine_with(&self, position: DVec3, axis: DVec3) -> Option<[f64; 2]> {
        let angle = 0.5 * self.angle_from(position)?;
        let cosine = (self.centre - position).normalize_or_zero().dot(axis);
        Some([cosine - angle, cosine + angle])
    }
}

/// Bounding sphere of the patch: centre and radius.
///
/// A flat patch lies between its corners. On a sphere, each edge of the patch is less than half a circle, and lies within the
/// sphere over its chord. A sphere that contains the edges, and less than half of the surface, contains the patch.
fn enclosing_sphere(form: &PrimitiveForm, corners: &[Corner; 4]) -> Option<(DVec3, f64)> {
    let points = corners.map(|corner| corner.point);
    let centre = points.iter().sum::<DVec3>() * 0.25;
    let farthest = points.iter().map(|point| (*point - centre).length()).fold(0.0, f64::max);
    let PrimitiveForm::Sphere { radius, .. } = form else { return Some((centre, farthest)) };
    let longest = (0..4).map(|at| (points[at] - points[(at + 1) % 4]).length()).fold(0.0, f64::max);
    let reach = farthest + 0.5 * longest;
    (reach < 0.5 * radius).then_some((centre, reach))
}

/// Maximum length of differences of unit vectors: at least 2/π of the angle between them.
fn max_difference(vectors: &[DVec3; 4]) -> f64 {
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (vectors[i] - vectors[j]).length()));
    pairs.fold(0.0, f64::max)
}
