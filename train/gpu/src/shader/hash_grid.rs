//! The hash grid and its networks.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use pocketnerf_core::field::MAX_SIGMA;

use super::constants::{Constants, number};
use super::network::{function, write_line};
use crate::pack::{PackedGrid, PackedLevel, QUAD, reader};

/// Adds what evaluates the field.
pub(super) fn write(
    grid: &PackedGrid,
    is_hierarchical: bool,
    constants: &mut Constants,
    files: &mut Vec<&str>,
    generated: &mut String,
) {
    let n_color_input = grid.n_feature_quads + grid.n_harmonics;
    constants.number("MAX_SIGMA", MAX_SIGMA);
    constants.number("LOG_DENSITY_BIAS", grid.log_density_bias);
    constants.flag("BY_CORNER", grid.by_corner);
    for (name, value) in [
        ("N_FEATURES", grid.n_features_per_level),
        ("N_FEATURE_QUADS", grid.n_feature_quads),
        ("N_HARMONICS", grid.n_harmonics),
        ("N_COLOR_INPUT", n_color_input),
        ("N_CHANNELS", if grid.per_ray { grid.n_feature_quads } else { 1 }),
    ] {
        constants.whole(name, value as u32);
    }
    files.extend(grid.dtype.and_then(reader));
    files.push(include_str!("wgsl/hash_grid.wgsl"));
    files.push(include_str!("wgsl/decoder.wgsl"));
    files.push(match grid.per_ray {
        true => include_str!("wgsl/decoded_per_ray.wgsl"),
        false => include_str!("wgsl/decoded_per_sample.wgsl"),
    });
    if is_hierarchical {
        files.push(include_str!("wgsl/decoded_coarse.wgsl"));
    }
    encode(grid, generated);
    function(generated, "density_network", &grid.density);
    function(generated, "color_network", &grid.color);
}

/// `encode`: the features of all levels, one after another.
fn encode(grid: &PackedGrid, text: &mut String) {
    let n = grid.n_features_per_level;
    let quads = (n * grid.levels.len()).div_ceil(QUAD);
    write_line(text, &format!("fn encode(u: vec3f) -> array<vec4f, {quads}> {{"));
    write_line(text, &format!("    var encoded: array<vec4f, {quads}>;"));
    for (l, level) in grid.levels.iter().enumerate() {
        write_line(text, &format!("    let level{l} = {};", declared(level)));
        write_line(text, &format!("    let at{l} = position(level{l}, u);"));
        for f in (0..n).step_by(QUAD.min(n)) {
            let to = l * n + f;
            let (quad, place) = (to / QUAD, ["x", "y", "z", "w"][to % QUAD]);
            let line = match n {
                QUAD.. => format!("    encoded[{quad}] = quad(level{l}, at{l}, {f}u);"),
                _ => singles(l, n, quad, place),
            };
            write_line(text, &line);
        }
    }
    write_line(text, "    return encoded;\n}");
}

/// The one or two values of an entry.
fn singles(l: usize, n: usize, quad: usize, place: &str) -> String {
    let places = match place {
        "x" => ["x", "y"],
        "y" => ["y", "z"],
        "z" => ["z", "w"],
        _ => ["w", "w"],
    };
    let line =
        |f: usize| format!("    encoded[{quad}].{} = single(level{l}, at{l}, {f}u);", places[f]);
    (0..n).map(line).collect::<Vec<_>>().join("\n")
}

fn declared(packed: &PackedLevel) -> String {
    let PackedLevel { level, first, factor } = packed;
    let [scale, shift, factor] = [level.scale, level.shift(), *factor].map(number);
    let (side, entries) = (level.dense_side, level.entries);
    format!("Level({scale}, {shift}, {side}u, {entries}u, {first}u, {factor})")
}
