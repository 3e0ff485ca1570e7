//! Terms of other programs, with those of the format.

/// Meaning of an unknown word.
pub(super) enum Meant {
    /// Another word.
    Word(&'static str),
    /// More than a word: how it is written.
    Written(&'static str),
}

use Meant::{Word, Written};

const TRANSLATE: Meant = Written("`transform: [translate(x, y, z)]`");
const ROTATE: Meant = Written("`transform: [rotate_y(degrees)]`");
const SCALE: Meant = Written("`transform: [scale(factor)]`");
const SHADE: Meant = Written("`material: diffuse(albedo: ...)`");
const SIZE: Meant = Written("`size: (width, height)`");

/// Meaning of `found` among the fields or choices of a context: a type such as `Camera`, or a choice such as `sphere`.
pub(super) fn meant(context: &str, found: &str) -> Option<Meant> {
    let found = found.to_ascii_lowercase();
    let found = found.as_str();
    let meant = match context {
        "Camera" | "CameraKey" => match found {
            "position" | "eye" | "origin" | "from" | "location" | "lookfrom" | "pos" => Word("look_from"),
            "target" | "at" | "center" | "centre" | "lookat" | "look" | "interest" => Word("look_at"),
            "vup" | "up_vector" | "upvector" => Word("up"),
            "vfov" | "yfov" | "fovy" | "field_of_view" | "angle" => Word("fov"),
            "direction" | "forward" => Written("`look_at: (x, y, z)`, a point in that direction"),
            "aperture" => Written("`lens: (radius: ...)`"),
            "f_stop" | "fstop" => Written("`lens: (f_stop: ..., focal_length: ...)`"),
            "focus" | "focus_distance" | "focal_distance" => Written("`lens: (radius: ..., focus: ...)`"),
            "translate" => TRANSLATE,
            "resolution" | "size" | "width" | "height" => Written("`film: (size: (width, height))` next to the camera"),
            _ => return None,
        },
        "Lens" => match found {
            "aperture" => Word("radius"),
            "focus_distance" | "focal_distance" | "distance" => Word("focus"),
            "fstop" | "f_number" => Word("f_stop"),
            _ => return None,
        },
        "Scene" => match found {
            "objects" | "shapes" | "primitives" | "world" | "geometry" | "scene" | "meshes" => Word("nodes"),
            "image" | "output" | "resolution" => Word("film"),
            "render" | "renderer" | "options" | "integrator" => Word("settings"),
            "sky" | "environment" | "env" => Word("background"),
            "instances" => Word("groups"),
            "light" => Word("lights"),
            "material" => Word("materials"),
            _ => return None,
        },
        "Film" => match found {
            "width" | "height" | "resolution" => SIZE,
            "tonemap" | "tone_mapping" | "tone_map" => Word("tone"),
            "gamma" => Written("`encoding: gamma(2.2)`"),
            "samples" | "spp" => Written("`settings: (spp: ...)` next to the film"),
            _ => return None,
        },
        "Settings" => match found {
            "samples" | "samples_per_pixel" | "sample_count" => Word("spp"),
            "bounces" | "max_bounces" | "maxdepth" => Word("max_depth"),
            "accelerator" | "acceleration" => Word("accel"),
            "pattern" => Word("sampler"),
            "size" | "width" | "height" | "resolution" => {
                Written("`film: (size: (width, height))` next to the settings")
            }
            _ => return None,
        },
        "Node" => match found {
            "translate" | "translation" | "position" | "location" => TRANSLATE,
            "rotate" | "rotation" => ROTATE,
            "scale" => SCALE,
            "color" | "colour" | "albedo" | "diffuse" => SHADE,
            "emission" | "emissive" => Written("`material: light(radiance: ...)`"),
            "geometry" | "mesh" | "primitive" | "object" => Word("shape"),
            "file" | "path" => Word("model"),
            "group" => Word("instance"),
            "nodes" => Word("children"),
            "matrix" => Written("`transform: [matrix(...)]`"),
            "sphere" | "box" | "plane" | "cylinder" | "cone" | "torus" | "disk" => {
                Written("`shape: sphere(...)` and the like")
            }
            _ => return None,
        },
        "Color" | "ColorTexture" => match found {
            "texture" | "file" | "bitmap" | "imagemap" | "tex" => Written("`image(file: \"...\")`"),
            "gradient" | "constant" | "solid" | "color" | "colour" => Written("a number, (r, g, b) or \"#rrggbb\""),
            _ => return None,
        },
        "Step" => match found {
            "translation" | "move" => Word("translate"),
            "rotation" => Word("rotate"),
            "scale_xyz" | "scaling" => Word("stretch"),
            "lookat" => Word("look_at"),
            _ => return None,
        },
        "rotate" => match found {
            "angle" => Word("degrees"),
            _ => return None,
        },
        "Shape" => match found {
            "cube" | "cuboid" | "block" | "aabb" => Word("box"),
            "ball" => Word("sphere"),
            "quad_light" | "square" => Word("rectangle"),
            "circle" | "disc" | "annulus" | "ring" => Word("disk"),
            "floor" | "ground" => Word("plane"),
            "tube" => Word("cylinder"),
            "donut" | "doughnut" => Word("torus"),
            "triangles" | "trimesh" | "triangle_mesh" => Word("mesh"),
            "model" | "obj" | "gltf" | "file" => Written("`model: \"file.obj\"` in place of `shape`"),
            _ => return None,
        },
        "sphere" | "disk" | "cylinder" | "cone" | "torus" | "frustum" => match found {
            "position" | "origin" | "location" | "pos" if context == "sphere" => Word("center"),
            "position" | "origin" | "location" | "pos" | "center" | "centre" | "base" => {
                Written("`transform: [translate(x, y, z)]` next to `shape`")
            }
            "r" | "size" => Word("radius"),
            "height" if context == "cylinder" => Word("top"),
            "minor_radius" | "minor" | "tube" if context == "torus" => Word("tube_radius"),
            "major_radius" | "major" if context == "torus" => Word("radius"),
            "color" | "colour" => Written("`material: diffuse(albedo: ...)` next to `shape`"),
            _ => return None,
        },
        "box" => match found {
            "size" | "center" | "centre" | "position" => Written("`min: (x, y, z), max: (x, y, z)`"),
            "from" | "p0" => Word("min"),
            "to" | "p1" => Word("max"),
            _ => return None,
        },
        "mesh" => match found {
            "vertices" | "points" => Word("positions"),
            "indices" | "index" => Word("triangles"),
            "uv" | "texcoords" => Word("uvs"),
            _ => return None,
        },
        "plane" => match found {
            "position" | "origin" | "center" => Word("point"),
            "up" | "direction" => Word("normal"),
            _ => return None,
        },
        "Light" => match found {
            "sun" | "distant" | "parallel" => Word("directional"),
            "area" | "rectangle" | "rect" => Word("quad"),
            "omni" | "lamp" => Word("point"),
            "spotlight" => Word("spot"),
            "environment" | "envmap" | "sky" | "infinite" => {
                Written("`background: image(file: ...)` next to the lights")
            }
            _ => return None,
        },
        "point" | "spot" | "directional" => match found {
            "location" | "pos" | "origin" | "from" => Word("position"),
            "power" | "energy" | "brightness" | "strength" | "emission" | "radiance" => Word("intensity"),
            "target" | "look_at" | "to" | "at" => Word("direction"),
            "angle" | "cutoff" | "outer_angle" => Word("outer"),
            "inner_angle" => Word("inner"),
            "attenuation" => Word("falloff"),
            "radius" if context == "point" => Word("shadow_near"),
            _ => return None,
        },
        "quad" | "light" => match found {
            "power" | "intensity" | "energy" | "brightness" | "strength" | "emissive" => Word("radiance"),
            "position" | "origin" => Word("corner"),
            _ => return None,
        },
        "Material" | "NodeMaterial" => match found {
            "lambert" | "lambertian" | "matte" => Word("diffuse"),
            "plastic" | "ggx" | "blinn" => Word("glossy"),
            "dielectric" | "transparent" => Word("glass"),
            "conductor" => Word("metal"),
            "emissive" | "emission" | "emitter" | "diffuse_light" => Word("light"),
            "pbr" | "principled" | "disney" | "standard" => Word("metallic_roughness"),
            "specular" | "perfect_mirror" => Word("mirror"),
            _ => return None,
        },
        _ => match found {
            "color" | "colour" | "diffuse" | "basecolor" | "base_color" if context == "diffuse" => Word("albedo"),
            "albedo" | "basecolor" if context == "metallic_roughness" => Word("base_color"),
            "albedo" if context == "phong" => Word("color"),
            "albedo" | "basecolor" | "base_color" if context == "mirror" => Word("reflectance"),
            "albedo" | "color" | "colour" if context == "glossy" => Word("diffuse"),
            "color" | "colour" | "albedo" if matches!(context, "glass" | "thin_glass") => Word("transmittance"),
            "metalness" => Word("metallic"),
            "emissive" | "emit" | "light" => Word("emission"),
            "alpha" | "rough" if !matches!(context, "phong" | "glossy") => Word("roughness"),
            "shininess" | "roughness" | "rough" if matches!(context, "phong" | "glossy") => Word("exponent"),
            "eta" | "index" | "refraction" | "refractive_index" | "index_of_refraction" => Word("ior"),
            "path" | "filename" | "texture" | "url" => Word("file"),
            _ => return None,
        },
    };
    Some(meant)
}
