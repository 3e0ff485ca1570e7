//! Materials that reflect more light than arrives, and unused parts of the scene.

use std::f64::consts::TAU;

use rt_math::Rgb;
use rt_shading::{ColorTexture, Material, Texture};

use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Geometry, Objects};

pub(crate) fn check(objects: &Objects<'_>, findings: &mut Findings) {
    let textures = &objects.scene.appearance.textures;
    // Readers refuse physically based materials that create energy.
    for material in objects.scene.appearance.materials.iter().filter(|material| !material.is_physically_based()) {
        energy(material, textures, findings);
    }
    unused(objects, findings);
}

/// Checks the albedo at normal incidence of the diffuse part and the highlight, kd + ks·2π / (n + 2). Source: Lewis,
/// "Making shaders more physically plausible", 1994.
fn energy(material: &Material, textures: &[Texture], findings: &mut Findings) {
    let phong = material.to_phong();
    let lobe = TAU / (phong.exponent + 2.0);
    let (kd, ks) = (brightest(&phong.diffuse, textures), brightest(&phong.specular, textures));
    let sums = [kd.r + ks.r * lobe, kd.g + ks.g * lobe, kd.b + ks.b * lobe];
    let gain = sums.into_iter().fold(0.0, f64::max);
    if gain > 1.0 {
        findings.add(Finding::new(
            Kind::EnergyGain,
            &material.name,
            &[("reflected_share", gain)],
            format!("reflects up to {gain:.3} of the light that arrives (diffuse + specular · 2π / (exponent + 2))"),
        ));
    }
}

/// Upper bound of a coefficient. Textures count as 1, which they seldom exceed.
fn brightest(coefficient: &ColorTexture, textures: &[Texture]) -> Rgb {
    match coefficient {
        ColorTexture::Constant(rgb) => *rgb,
        ColorTexture::Textured(id, rgb) => match textures.get(id.0 as usize) {
            Some(Texture::Checker { even, odd, .. }) => {
                Rgb::new(even.r.max(odd.r), even.g.max(odd.g), even.b.max(odd.b)) * *rgb
            }
            _ => *rgb,
        },
    }
}

fn unused(objects: &Objects<'_>, findings: &mut Findings) {
    if objects.truncated {
        return;
    }
    let scene = objects.scene;
    let mut materials = vec![false; scene.appearance.materials.len()];
    let mut meshes = vec![false; scene.meshes.len()];
    for object in &objects.list {
        if let Some(used) = materials.get_mut(object.material) {
            *used = true;
        }
        if let Geometry::Mesh(index, _) = object.geometry {
            meshes[index] = true;
        }
    }
    let mut note = |what: &str, name: &str| {
        findings.add(Finding::new(Kind::Unused, name, &[], format!("is a {what} that the scene does not use")));
    };
    let names = scene.appearance.materials.iter().map(|material| material.name.as_str());
    names.zip(&materials).filter(|(_, used)| !**used).for_each(|(name, _)| note("material", name));
    let named = objects.meshes().zip(&meshes);
    named.filter(|(_, used)| !**used).for_each(|(mesh, _)| note("mesh", &mesh.name));
    let names = scene.groups.iter().map(|group| group.name.as_str());
    names.zip(&objects.group_used).filter(|(_, used)| !**used).for_each(|(name, _)| note("group", name));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_math::DVec3;
    use rt_scene_io::Group;
    use rt_shading::{FloatTexture, LayeredBase, LayeredSurface, MaterialModel, Phong};

    #[test]
    fn too_bright_highlights_are_noted() {
        let mut scene = scene_with(vec![sphere(DVec3::ZERO, 1.0)]);
        let (diffuse, specular) = (Rgb::gray(0.25), Rgb::new(0.5, 2.0, 0.5));
        let (diffuse, specular) = (ColorTexture::Constant(diffuse), ColorTexture::Constant(specular));
        scene.appearance.materials[0].model = Phong { diffuse, specular, exponent: 6.0, ..Phong::default() }.into();
        let finding = only(&scene, Kind::EnergyGain);
        assert!((finding.values[0].value - (0.25 + 2.0 * TAU / 8.0)).abs() < 1e-15, "{finding:?}");
        assert_eq!(finding.object, "grey");
    }

    #[test]
    fn physically_based_materials_have_no_energy_gain() {
        let mut scene = scene_with(vec![sphere(DVec3::ZERO, 1.0)]);
        let (metallic, roughness) = (FloatTexture::Constant(0.0), FloatTexture::Constant(0.5));
        let base_color = ColorTexture::Constant(Rgb::WHITE);
        let layered = LayeredSurface::new(LayeredBase::MetallicRoughness { base_color, metallic, roughness });
        scene.appearance.materials[0].model = MaterialModel::Layered(Box::new(layered));
        let phong = scene.appearance.materials[0].to_phong();
        let gain = brightest(&phong.diffuse, &[]).r + brightest(&phong.specular, &[]).r * TAU / (phong.exponent + 2.0);
        assert!(gain > 1.0, "its Phong surface gains energy: {gain}");
        assert_eq!(of_kind(&scene, Kind::EnergyGain), []);
    }

    #[test]
    fn unused_things_are_named() {
        let mut scene = empty();
        let _ = add_mesh(&mut scene, cube_data());
        scene.groups = vec![Group { name: "spare".into(), nodes: vec![sphere(DVec3::ZERO, 1.0)] }];
        scene.nodes = vec![sphere(DVec3::ZERO, 1.0)];
        let names: Vec<_> = of_kind(&scene, Kind::Unused).into_iter().map(|finding| finding.object).collect();
        assert_eq!(names, ["glass", "checker", "cube", "spare"]);
    }
}
