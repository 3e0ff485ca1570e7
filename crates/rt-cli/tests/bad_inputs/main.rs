//! Kinds of bad input, each through the real binary. Each gives one clear message and the right exit code, and leaves no file.
//! It takes less than a second and 64 MiB.
//!
//! `WRITE_TABLE=1 cargo test -p rt-cli --test bad_inputs` writes `docs/BAD-INPUTS.md` from what the program says.

#![cfg(target_os = "linux")]

mod gltf;
mod input;
mod model;
mod scene;
mod storage;

use std::{env, fmt::Write, fs, path::Path};

use input::{Input, Run};

/// Makes the list of all kinds, and a test of each.
macro_rules! kinds {
    ($($number:literal $module:ident::$name:ident $title:literal)*) => {
        /// Number, name, what is wrong, and examples.
        const KINDS: &[(u8, &str, &str, fn() -> Vec<Input>)] =
            &[$(($number, stringify!($name), $title, || $module::$name().into())),*];

        mod each {
            $(
                #[test]
                fn $name() {
                    for input in Vec::from(crate::$module::$name()) {
                        input.check(stringify!($name));
                    }
                }
            )*
        }
    };
}

kinds! {
    1 storage::missing_file "a missing file"
    2 storage::directory "a directory"
    3 storage::unreadable_file "a file that cannot be read"
    4 storage::empty_file "an empty file"
    5 storage::truncated_at_every_byte "a scene truncated at every byte"
    6 storage::not_utf8 "bytes that are not UTF-8"
    7 storage::nul_bytes "NUL bytes"
    8 storage::byte_order_mark "a byte order mark"
    9 storage::windows_line_ends "Windows line ends"
    10 storage::single_line_of_5_mb "a single line of 5 MB"
    11 storage::pipe_or_device "a pipe or a device"
    12 scene::nan_coordinate "a coordinate that is NaN"
    13 scene::infinite_coordinate "a coordinate that is infinite"
    14 scene::overflowing_number "1e400"
    15 scene::coordinate_beyond_1e60 "a coordinate beyond 1e60"
    16 scene::comma_decimals "a comma for the decimal point"
    17 model::face_index_zero "face index 0"
    18 model::face_index_beyond_count "a face index beyond the last vertex"
    19 model::negative_face_index_beyond_start "a negative face index beyond the first vertex"
    20 model::face_index_overflow "a face index that overflows 64 bits"
    21 model::face_with_two_vertices "a face with fewer than three vertices"
    22 model::face_with_repeated_vertex "a face with a repeated vertex"
    23 model::million_sided_polygon "a face with a million vertices"
    24 model::bent_or_crossed_polygon "a polygon that is not flat, or self-intersecting"
    25 model::zero_or_missing_normals "zero or missing normals"
    26 scene::unknown_material "an unknown material"
    27 model::missing_material_library "a missing material library"
    28 scene::duplicate_names "two entries of the same name"
    29 scene::unknown_field "an unknown field"
    30 scene::wrong_type "a value of the wrong type"
    31 scene::nesting_of_100_000 "brackets nested 100,000 deep"
    32 scene::include_cycle "groups that contain each other, a scene that contains itself"
    33 scene::include_depth "scenes within scenes"
    34 gltf::node_cycle_or_two_parents "glTF nodes in a cycle, or with two parents"
    35 gltf::node_depth_50_000 "glTF nodes 50,000 deep"
    36 gltf::child_index_out_of_range "a glTF child index out of range"
    37 gltf::accessor_count_zero "an accessor of no elements"
    38 gltf::count_times_stride_overflow "an accessor whose size overflows"
    39 gltf::buffer_view_past_buffer "a view beyond the end of its buffer"
    40 gltf::byte_length_of_a_terabyte "a buffer of 10^12 bytes that has 4"
    41 gltf::float_indices "indices that are floating-point numbers"
    42 gltf::missing_position "a primitive without positions"
    43 gltf::sparse_accessor_out_of_range "a sparse accessor beyond its base"
    44 gltf::container_length_lies "a GLB with a wrong length"
    45 gltf::chunk_order_wrong "a GLB with chunks in the wrong order"
    46 gltf::bad_base64 "bad base64"
    47 storage::references_that_leave_the_folder "references that leave the directory of the scene"
    48 gltf::unknown_required_extension "a required extension that is unknown"
    49 gltf::version_9 "version 9.0"
    50 scene::singular_matrix "a singular matrix"
    51 scene::nan_matrix "a matrix with NaN"
    52 scene::projective_matrix "a matrix whose last row is not 0 0 0 1"
    53 scene::zero_or_negative_size "a radius or height that is zero or negative"
    54 scene::too_wide_cone "a cone of infinite or zero slope"
    55 scene::box_min_beyond_max "a box whose minimum exceeds its maximum"
    56 scene::zero_scale "a scale of zero"
    57 scene::impossible_camera "a camera without view direction"
    58 scene::impossible_lens "an invalid lens radius or focus distance"
    59 scene::image_of_no_or_too_many_pixels "an image of no pixels, or of too many"
    60 scene::no_or_too_many_samples "no samples, or too many"
    61 scene::negative_depth "a depth below 0"
    62 scene::impossible_index_of_refraction "an index of refraction of 0 or NaN"
    63 scene::albedo_beyond_1 "an albedo outside of 0 to 1"
    64 scene::impossible_exponent "an exponent below 0 or beyond 1e7"
    65 scene::impossible_light "a light of NaN power, or without direction"
    66 storage::texture_bomb "a small file of 60000x60000 pixels"
    67 storage::texture_without_pixels "an image of 0x0 pixels"
    68 storage::truncated_texture "a truncated image"
    69 scene::billion_instances "10^9 instances"
    70 scene::no_camera_and_no_lights "a scene without camera and lights"
    71 scene::first_mistakes "terms and brackets of other programs"
    72 scene::colour_with_alpha "a colour with alpha, or by its name"
    73 storage::utf_16 "text in UTF-16"
    74 model::surplus_of_models "statements and rows outside of the format"
    75 model::absolute_texture_of_mtl "an image of a material library by an absolute path"
    76 gltf::scene_without_nodes "a glTF scene without nodes"
}

#[test]
fn kinds_are_numbered() {
    let numbers: Vec<u8> = KINDS.iter().map(|(number, ..)| *number).collect();
    assert_eq!(numbers, (1..=76).collect::<Vec<u8>>());
}

const HEAD: &str = "# Bad inputs

After reading this page you know how `rt-cli` responds to damaged and malicious files.

Each row is a test of this name in `crates/rt-cli/tests/bad_inputs/`. It runs the real binary on the file with `--memory 4GiB`. The
program must end with the exit code below, within a second of processor time and 64 MiB. If it refuses the file, it must leave no output
file. The last column is the message for the first example of the kind.

Written by `WRITE_TABLE=1 cargo test -p rt-cli --test bad_inputs`.

| number | name | what is wrong | exit code | message |
|---|---|---|---|---|
";

#[test]
fn the_table_in_the_docs_is_up_to_date() {
    let mut table = HEAD.to_owned();
    for (number, name, title, inputs) in KINDS {
        let inputs = inputs();
        let Some(first) = inputs.first() else { panic!("{name} has no example") };
        let Run { code, said, .. } = first.run(name);
        // Without the lines of the file, whose spaces a table does not keep.
        let said = said
            .lines()
            .filter(|line| !line.starts_with(' '))
            .take(3)
            .collect::<Vec<_>>()
            .join("<br>")
            .replace('|', "\\|");
        let code = code.map_or_else(String::new, |code| code.to_string());
        writeln!(table, "| {number} | `{name}` | {title} | {code} | {said} |").expect("memory");
    }
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/BAD-INPUTS.md"));
    if env::var_os("WRITE_TABLE").is_some() {
        fs::write(file, &table).expect("written");
    }
    let written = fs::read_to_string(file).unwrap_or_default();
    assert!(written == table, "run it with WRITE_TABLE=1\n{table}");
}
