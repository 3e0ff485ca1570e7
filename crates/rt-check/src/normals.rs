//! Lints of vertex normals and texture coordinates of meshes.

use rt_math::transcendental::acos;
use rt_scene_io::NamedMesh;

use crate::finding::{Finding, Findings, Kind};
use crate::welded::corners;

pub(crate) fn check(named: &NamedMesh, is_textured: bool, findings: &mut Findings) {
    opposed_normals(named, findings);
    if is_textured {
        uvs(named, findings);
    }
}

fn opposed_normals(named: &NamedMesh, findings: &mut Findings) {
    let data = named.mesh.data();
    if data.normals.is_empty() {
        return;
    }
    let (mut count, mut min_cosine) = (0u64, 0.0f64);
    for &triangle in &data.triangles {
        let [a, b, c] = corners(&named.mesh, triangle);
        let front = rt_math::float::cross(b - a, c - a).normalize_or_zero();
        let cosine = triangle.map(|i| data.normals[i as usize].as_dvec3().dot(front));
        let cosine = cosine.into_iter().fold(1.0, f64::min);
        count += u64::from(cosine < 0.0);
        min_cosine = min_cosine.min(cosine);
    }
    if count > 0 {
        let worst = acos(min_cosine.clamp(-1.0, 1.0)).to_degrees();
        findings.add(Finding::new(
            Kind::OpposedNormals,
            &named.name,
            &[("count", count as f64), ("worst_angle", worst)],
            format!(
                "{count} of {} triangles have a vertex normal that faces away from the front (up to {worst:.1} degrees from the geometric normal)",
                data.triangles.len()
            ),
        ));
    }
}

fn uvs(named: &NamedMesh, findings: &mut Findings) {
    let data = named.mesh.data();
    if data.uvs.is_empty() {
        findings.add(Finding::new(
            Kind::MissingUvs,
            &named.name,
            &[],
            "has a textured material but no texture coordinates: the texture is read at (0, 0)",
        ));
        return;
    }
    let flat = |triangle: &&[u32; 3]| {
        let [a, b, c] = triangle.map(|i| data.uvs[i as usize].map(f64::from));
        let (e, f) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        rt_math::float::difference_of_products(e[0], f[1], e[1], f[0]) == 0.0
    };
    let count = data.triangles.iter().filter(flat).count();
    if count > 0 {
        findings.add(Finding::new(
            Kind::DegenerateUvs,
            &named.name,
            &[("count", count as f64)],
            format!("{count} of {} triangles have no area in the texture", data.triangles.len()),
        ));
    }
}

#[cfg(test)]
mod tests {
    use rt_math::Rgb;
    use rt_shading::{ColorTexture, Phong, Texture, TextureId};

    use super::*;
    use crate::fixture::*;

    #[test]
    fn normals_to_the_back_are_counted() {
        let mut data = cube_data();
        data.smooth_normals();
        data.triangles[3].swap(1, 2);
        let scene = scene_of_mesh(data);
        let finding = only(&scene, Kind::OpposedNormals);
        // Corners of a cube have their normals along the diagonals: 54.7356 degrees off each face.
        assert_eq!(finding.values[0], value("count", 1.0));
        assert!((finding.values[1].value - (180.0 - 54.735_610_3)).abs() < 1e-4, "{finding:?}");
    }

    #[test]
    fn textures_want_coordinates() {
        let mut scene = scene_of_mesh(cube_data());
        scene.nodes[0].material = CHECKER;
        assert_eq!(only(&scene, Kind::MissingUvs).object, "cube");

        // Colours of vertices are no such texture.
        let colours = TextureId(scene.appearance.textures.len() as u32);
        scene.appearance.textures.push(Texture::VertexColor(None));
        let diffuse = ColorTexture::Textured(colours, Rgb::WHITE);
        scene.appearance.materials[CHECKER.0 as usize].model = Phong { diffuse, ..Phong::default() }.into();
        assert_eq!(of_kind(&scene, Kind::MissingUvs), []);

        let mut data = cube_data();
        // Seen along z, four faces of the cube are lines.
        data.uvs = data.positions.iter().map(|p| [p.x, p.y]).collect();
        let mut scene = scene_of_mesh(data);
        scene.nodes[0].material = CHECKER;
        assert_eq!(only(&scene, Kind::DegenerateUvs).values, [value("count", 8.0)]);
        scene.nodes[0].material = GREY;
        assert_eq!(of_kind(&scene, Kind::DegenerateUvs), []);
    }
}
