//! Material objects of the specification with their extensions, as parsed.

use gltf::json;
use serde::Deserialize;

/// A reference to a texture, with the properties of its parent objects.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: usize,
    #[serde(default)]
    pub(super) tex_coord: u32,
    /// Used by normal maps.
    #[serde(default = "one")]
    pub(super) scale: f32,
    /// Used by occlusion.
    #[serde(default = "one")]
    pub(super) strength: f32,
    #[serde(default)]
    pub(super) extensions: TextureExtensions,
}

const fn one() -> f32 {
    1.0
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum AlphaMode {
    Opaque,
    Mask,
    Blend,
}

/// Defines a struct of the specification, with its defaults for missing properties.
macro_rules! objects {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty = $default:expr,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Deserialize)]
            #[serde(default, rename_all = "camelCase")]
            pub(super) struct $name {
                $(pub(super) $field: $type,)*
            }

            impl Default for $name {
                fn default() -> Self {
                    Self { $($field: $default,)* }
                }
            }
        )*
    };
}

objects! {
    /// A material (glTF 2.0, section 5.19).
    MaterialJson {
        pbr_metallic_roughness: MetallicRoughness = MetallicRoughness::default(),
        normal_texture: Option<TextureInfo> = None,
        occlusion_texture: Option<TextureInfo> = None,
        emissive_texture: Option<TextureInfo> = None,
        emissive_factor: [f32; 3] = [0.0; 3],
        alpha_mode: AlphaMode = AlphaMode::Opaque,
        alpha_cutoff: f32 = 0.5,
        double_sided: bool = false,
        extensions: Extensions = Extensions::default(),
    }
    TextureTransform {
        offset: [f32; 2] = [0.0; 2],
        rotation: f32 = 0.0,
        scale: [f32; 2] = [1.0; 2],
        tex_coord: Option<u32> = None,
    }
    MetallicRoughness {
        base_color_factor: [f32; 4] = [1.0; 4],
        base_color_texture: Option<TextureInfo> = None,
        metallic_factor: f32 = 1.0,
        roughness_factor: f32 = 1.0,
        metallic_roughness_texture: Option<TextureInfo> = None,
    }
    SpecularGlossiness {
        diffuse_factor: [f32; 4] = [1.0; 4],
        diffuse_texture: Option<TextureInfo> = None,
        specular_factor: [f32; 3] = [1.0; 3],
        glossiness_factor: f32 = 1.0,
        specular_glossiness_texture: Option<TextureInfo> = None,
    }
    Anisotropy {
        anisotropy_strength: f32 = 0.0,
        anisotropy_rotation: f32 = 0.0,
        anisotropy_texture: Option<TextureInfo> = None,
    }
    Clearcoat {
        clearcoat_factor: f32 = 0.0,
        clearcoat_texture: Option<TextureInfo> = None,
        clearcoat_roughness_factor: f32 = 0.0,
        clearcoat_roughness_texture: Option<TextureInfo> = None,
        clearcoat_normal_texture: Option<TextureInfo> = None,
    }
    Sheen {
        sheen_color_factor: [f32; 3] = [0.0; 3],
        sheen_color_texture: Option<TextureInfo> = None,
        sheen_roughness_factor: f32 = 0.0,
        sheen_roughness_texture: Option<TextureInfo> = None,
    }
    Specular {
        specular_factor: f32 = 1.0,
        specular_texture: Option<TextureInfo> = None,
        specular_color_factor: [f32; 3] = [1.0; 3],
        specular_color_texture: Option<TextureInfo> = None,
    }
    Transmission {
        transmission_factor: f32 = 0.0,
        transmission_texture: Option<TextureInfo> = None,
    }
    Volume {
        thickness_factor: f32 = 0.0,
        attenuation_distance: f32 = f32::INFINITY,
        attenuation_color: [f32; 3] = [1.0; 3],
    }
    Ior {
        ior: f32 = 1.5,
    }
    Dispersion {
        dispersion: f32 = 0.0,
    }
    EmissiveStrength {
        emissive_strength: f32 = 1.0,
    }
    Unlit {
    }
}

/// The extensions of materials that are followed.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Extensions {
    #[serde(rename = "KHR_materials_anisotropy")]
    pub(super) anisotropy: Option<Anisotropy>,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(super) clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_dispersion")]
    pub(super) dispersion: Option<Dispersion>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(super) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(super) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_sheen")]
    pub(super) sheen: Option<Sheen>,
    #[serde(rename = "KHR_materials_specular")]
    pub(super) specular: Option<Specular>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_unlit")]
    pub(super) unlit: Option<Unlit>,
    #[serde(rename = "KHR_materials_volume")]
    pub(super) volume: Option<Volume>,
}

impl MaterialJson {
    /// Reads it from a material of the document.
    pub(super) fn of(material: &json::Material) -> Result<Self, serde_json::Error> {
        serde_json::from_value(serde_json::to_value(material)?)
    }

    /// All references to textures, for their sets of coordinates; that of the base colour comes first.
    pub(super) fn textures(&self) -> impl Iterator<Item = &TextureInfo> {
        let (pbr, all) = (&self.pbr_metallic_roughness, &self.extensions);
        let gloss = all.specular_glossiness.as_ref();
        let (coat, sheen) = (all.clearcoat.as_ref(), all.sheen.as_ref());
        let specular = all.specular.as_ref();
        [
            gloss.and_then(|other| other.diffuse_texture.as_ref()),
            pbr.base_color_texture.as_ref(),
            self.normal_texture.as_ref(),
            pbr.metallic_roughness_texture.as_ref(),
            self.emissive_texture.as_ref(),
            self.occlusion_texture.as_ref(),
            gloss.and_then(|other| other.specular_glossiness_texture.as_ref()),
            all.transmission.as_ref().and_then(|transmission| transmission.transmission_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_roughness_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_normal_texture.as_ref()),
            sheen.and_then(|sheen| sheen.sheen_color_texture.as_ref()),
            sheen.and_then(|sheen| sheen.sheen_roughness_texture.as_ref()),
            specular.and_then(|specular| specular.specular_texture.as_ref()),
            specular.and_then(|specular| specular.specular_color_texture.as_ref()),
            all.anisotropy.as_ref().and_then(|anisotropy| anisotropy.anisotropy_texture.as_ref()),
        ]
        .into_iter()
        .flatten()
    }

    /// The map along whose coordinates tangents are laid: that of the base, or else of its coat.
    pub(super) fn normals(&self) -> Option<&TextureInfo> {
        let coat = self.extensions.clearcoat.as_ref();
        self.normal_texture.as_ref().or_else(|| coat.and_then(|coat| coat.clearcoat_normal_texture.as_ref()))
    }
}

impl TextureInfo {
    /// The set of texture coordinates that it is read at.
    pub(super) fn uv_set(&self) -> u32 {
        self.extensions.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_what_the_specification_says() {
        let material: json::Material = serde_json::from_str("{}").expect("a material");
        let description = MaterialJson::of(&material).expect("a description");
        assert_eq!(description.pbr_metallic_roughness.metallic_factor, 1.0);
        assert_eq!((description.alpha_mode, description.alpha_cutoff), (AlphaMode::Opaque, 0.5));
        assert!(description.extensions.clearcoat.is_none() && !description.double_sided);
    }

    #[test]
    fn extensions_and_their_textures_are_found() {
        let text = r#"{"alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
            "normalTexture": {"index": 3, "scale": 2, "extensions": {"KHR_texture_transform": {"texCoord": 1}}},
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 7}},
                "KHR_materials_ior": {"ior": 1.25}, "KHR_materials_unlit": {}, "KHR_materials_volume": {}}}"#;
        let material: json::Material = serde_json::from_str(text).expect("a material");
        let MaterialJson { alpha_mode, alpha_cutoff, double_sided, normal_texture, extensions, .. } =
            MaterialJson::of(&material).expect("a description");
        assert_eq!((alpha_mode, alpha_cutoff, double_sided), (AlphaMode::Mask, 0.25, true));
        let normal = normal_texture.expect("a normal map");
        assert_eq!((normal.index, normal.scale, normal.uv_set()), (3, 2.0, 1));
        let coat = extensions.clearcoat.expect("a coat");
        assert_eq!((coat.clearcoat_factor, coat.clearcoat_texture.expect("a texture").index), (0.5, 7));
        assert_eq!(extensions.ior.map(|ior| ior.ior), Some(1.25));
        assert!(extensions.unlit.is_some() && extensions.volume.is_some_and(|v| v.attenuation_distance.is_infinite()));
    }
}
