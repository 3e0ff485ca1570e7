//! Part of a smooth surface in a pyramid, and the variation of light on it.

use rt_geometry::{Hit, InteractionFlags};
use rt_math::{DVec3, Ray, transcendental::pow};
use rt_shading::{Appearance, ColorTexture, Light, LightKind, Material, Phong};

use crate::{primitive_form::PrimitiveForm, world::ShadedPrimitives};

/// Greatest angle in radians by which the directions that shading depends on may turn within a patch, times √n for a highlight
/// of exponent n. As cosⁿ a ≈ exp(−n a²/2), whose slope is at most √(n/e), the highlight changes by less than 16 % of its
/// peak.
const MOST_TURN: f64 = 0.25;

/// A highlight below this radiance is none.
const FAINTEST: f64 = 1.0 / 512.0;

/// Part of a surface in a pyramid whose corner rays all hit the same smooth, convex surface from the outside.
///
/// All rays between them then meet it as well, since a convex body looks convex.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePatch {
    pub(super) index: u32,
    form: PrimitiveForm,
    /// Index of the material.
    material: u32,
    /// The middle of the ball that the patch lies in.
    pub(super) centre: DVec3,
    /// The radius of that ball.
    pub(super) radius: f64,
    /// The greatest depth. The inverse of depth is concave over the image where a convex body is seen from outside, and so
    /// least at a corner.
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
    /// `None` where the surface may have an edge between the corner rays, or turns far.
    pub(super) fn new<W: ShadedPrimitives>(
        world: &W,
        index: u32,
        rays: &[Ray; 4],
        hits: &[Option<Hit>; 4],
    ) -> Option<Self> {
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
            let surface = world.surface_at(&rays[at], &hits[at], needs)?;
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
        let (centre, radius) = enclosing_ball(&form, &corners)?;
        let turn = 2.0 * splat(&corners.map(|corner| corner.normal)) + splat(&corners.map(|corner| corner.to_viewer));
        let farthest = hits.iter().map(|hit| hit.t).fold(0.0, f64::max);
        Some(Self { index, form, material: material?, centre, radius, farthest, corners, turn })
    }

    /// The material, if four samples of it tell as much as many: it sends no rays on and has no texture.
    pub(super) fn plain_material<'a>(&self, appearance: &'a Appearance) -> Option<&'a Material> {
        let material = appearance.materials.get(self.material as usize)?;
        let phong = material.to_phong();
        let is_plain = phong.mirror.is_zero() && phong.transmission.is_none() && !material.is_textured();
        is_plain.then_some(material)
    }

    /// True if the light, blocked by nothing, does not reach any point of the patch.
    pub(super) fn turns_away_from(&self, light: &Light) -> bool {
        let (place, away) = match light.kind {
            LightKind::Directional { direction } => (None, direction),
            LightKind::Point { position, .. } => (Some(position), DVec3::ZERO),
            LightKind::Spot { position, direction, cos_outer, .. } => {
                let axis = self.cosine_with(position, direction);
                if axis.is_some_and(|[_, greatest]| greatest <= cos_outer) {
                    return true;
                }
                (Some(position), DVec3::ZERO)
            }
        };
        if let PrimitiveForm::Sphere { centre, radius } = self.form {
            // (p − c)·(l − p) = (p − c)·(l − c) − r² is at most this anywhere in the ball around the patch.
            let middle = self.centre - centre;
            return match place {
                Some(place) => {
                    let light = place - centre;
                    middle.dot(light) + self.radius * light.length() <= radius * radius
                }
                None => self.radius - middle.dot(away) <= 0.0,
            };
        }
        self.corners.iter().all(|corner| corner.normal.dot(place.map_or(-away, |place| place - corner.point)) <= 0.0)
    }

    /// True if an unblocked light of full strength changes so little over the patch that a few samples show it.
    pub(super) fn is_even_under(&self, light: &Light, phong: &Phong) -> bool {
        let turn_of_light = match light.kind {
            LightKind::Directional { .. } => Some(0.0),
            LightKind::Point { position, .. } => self.angle_from(position),
            LightKind::Spot { position, direction, cos_inner, .. } => {
                let axis = self.cosine_with(position, direction);
                self.angle_from(position).filter(|_| axis.is_some_and(|[least, _]| least >= cos_inner))
            }
        };
        let Some(turn_of_light) = turn_of_light else { return false };
        let turn = self.turn + turn_of_light;
        turn <= MOST_TURN && (phong.specular.is_zero() || self.has_even_highlight(light, phong, turn))
    }

    /// True if the highlight is wide, or elsewhere.
    fn has_even_highlight(&self, light: &Light, phong: &Phong, turn: f64) -> bool {
        if turn * phong.exponent.max(1.0).sqrt() <= MOST_TURN {
            return true;
        }
        let ColorTexture::Constant(specular) = phong.specular else { return false };
        let brightest = |corner: &Corner| {
            let lit = light.illuminate(corner.point)?;
            let cosine = phong.highlight.strength(corner.normal, corner.to_viewer, lit.direction, 1.0);
            Some(pow((cosine + turn).min(1.0), phong.exponent) * lit.strength.max_component())
        };
        let peak = self.corners.iter().filter_map(brightest).fold(0.0, f64::max);
        peak * specular.max_component() <= FAINTEST
    }

    /// Bound on the angle between directions to a light from two points of the patch; `None` if the light is near. Twice
    /// the arcsine of r/d, and also more than the share by which the strength of the light changes.
    fn angle_from(&self, place: DVec3) -> Option<f64> {
        let gap = (place - self.centre).length() - self.radius;
        (gap > self.radius).then(|| 4.0 * self.radius / gap)
    }

    /// Bounds on the cosine of the angle at a light between an axis and the way to the patch; `None` if the light is near.
    fn cosine_with(&self, place: DVec3, axis: DVec3) -> Option<[f64; 2]> {
        let angle = 0.5 * self.angle_from(place)?;
        let cosine = (self.centre - place).normalize_or_zero().dot(axis);
        Some([cosine - angle, cosine + angle])
    }
}

/// A ball that the patch lies in.
///
/// A flat patch lies between its corners. On a sphere, its edges are less than half circles, each of which lies within the ball
/// over its chord; and what they enclose lies in any ball around them that holds less than half of the sphere.
fn enclosing_ball(form: &PrimitiveForm, corners: &[Corner; 4]) -> Option<(DVec3, f64)> {
    let points = corners.map(|corner| corner.point);
    let centre = points.iter().sum::<DVec3>() * 0.25;
    let farthest = points.iter().map(|point| (*point - centre).length()).fold(0.0, f64::max);
    let PrimitiveForm::Sphere { radius, .. } = form else { return Some((centre, farthest)) };
    let longest = (0..4).map(|at| (points[at] - points[(at + 1) % 4]).length()).fold(0.0, f64::max);
    let reach = farthest + 0.5 * longest;
    (reach < 0.5 * radius).then_some((centre, reach))
}

/// The longest difference of unit vectors: at least 2/π of the angle between them.
fn splat(vectors: &[DVec3; 4]) -> f64 {
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (vectors[i] - vectors[j]).length()));
    pairs.fold(0.0, f64::max)
}
