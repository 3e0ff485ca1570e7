//! Normal maps.

use crate::{Texture, TextureId, TexturePoint};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Vec3};

/// Normal map in tangent space (glTF 2.0, section 3.9.3).
///
/// Red, green and blue from 0 to 1 are the components of the normal from −1 to 1 along tangent, bitangent and normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// The map, with linear values.
    pub texture: TextureId,
    /// Factor of the components along tangent and bitangent.
    pub scale: f64,
}

impl NormalMap {
    /// Replaces the shading normal by that of the map, and keeps the old one as `smooth_normal`.
    ///
    /// Without a tangent, or without a direction in the map, the shading normal stays.
    pub fn apply(&self, textures: &[Texture], surface: &mut SurfaceInteraction) {
        if let Some(mapped) = self.mapped(textures, surface, surface.shading_normal) {
            surface.detail.smooth_normal = surface.shading_normal.as_vec3();
            surface.shading_normal = mapped;
        }
    }

    /// Unit normal of the map around a unit `normal` of the surface.
    ///
    /// `None` if the surface has no tangent, the map has no direction, or the result points into the surface.
    pub(crate) fn mapped(&self, textures: &[Texture], surface: &SurfaceInteraction, normal: DVec3) -> Option<DVec3> {
        let texture = textures.get(self.texture.0 as usize)?;
        let along = surface.detail.tangent.as_dvec3();
        if surface.detail.tangent == Vec3::ZERO {
            return None;
        }
        let tangent = (along - normal * normal.dot(along)).try_normalize()?;
        let bitangent = normal.cross(tangent) * if surface.detail.is_mirrored { -1.0 } else { 1.0 };
        let map = texture.at(&TexturePoint::from(surface));
        let [x, y, z] = [map.r, map.g, map.b].map(|channel| 2.0 * channel - 1.0);
        let mapped = tangent * (x * self.scale) + bitangent * (y * self.scale) + normal * z;
        mapped.try_normalize().filter(|mapped| mapped.dot(surface.geometric_normal) > 0.0)
    }
}
