//! Detail of a surface that its geometry leaves out.

use crate::{Texture, TextureId, TexturePoint};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Vec3};

/// A normal map in tangent space: red, green and blue from 0 to 1 are the normal's parts from −1 to 1 along the tangent, the
/// bitangent and the normal of the surface (glTF 2.0, section 3.9.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// The map, with its numbers as they are.
    pub texture: TextureId,
    /// Factor of the parts along tangent and bitangent.
    pub scale: f64,
}

impl Relief {
    /// Turns the shading normal as the map says, and keeps what it was. Where the surface has no tangent, or the map no
    /// direction, it stays.
    pub fn shape(&self, textures: &[Texture], surface: &mut SurfaceInteraction) {
        if let Some(shaped) = self.turned(textures, surface, surface.shading_normal) {
            surface.detail.smooth_normal = surface.shading_normal.as_vec3();
            surface.shading_normal = shaped;
        }
    }

    /// A unit normal of the surface turned as the map says; `None` where the surface has no tangent, the map has no direction, or
    /// the result would look into the surface.
    pub(crate) fn turned(&self, textures: &[Texture], surface: &SurfaceInteraction, normal: DVec3) -> Option<DVec3> {
        let texture = textures.get(self.texture.0 as usize)?;
        let along = surface.detail.tangent.as_dvec3();
        if surface.detail.tangent == Vec3::ZERO {
            return None;
        }
        let tangent = (along - normal * normal.dot(along)).try_normalize()?;
        let bitangent = normal.cross(tangent) * if surface.detail.is_mirrored { -1.0 } else { 1.0 };
        let map = texture.at(&TexturePoint::from(surface));
        let [x, y, z] = [map.r, map.g, map.b].map(|part| 2.0 * part - 1.0);
        let shaped = tangent * (x * self.scale) + bitangent * (y * self.scale) + normal * z;
        shaped.try_normalize().filter(|shaped| shaped.dot(surface.geometric_normal) > 0.0)
    }
}
