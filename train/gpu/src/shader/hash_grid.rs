//! The hash grid.

use super::encoded::Factors;
use super::text::{Number, Text, line};
use crate::pack::{PackedGrid, PackedLevel, QUAD};

/// `level_quad`: the features of a level, where there are four.
#[cfg(feature = "wgpu")]
pub(super) fn write_levels(grid: &PackedGrid, text: &mut Text) {
    line!(text, "fn level_quad(l: u32, u: vec3f) -> vec4f {{\nswitch l {{");
    for (l, packed) in grid.levels.iter().enumerate() {
        match l + 1 == grid.levels.len() {
            true => line!(text, "default: {{"),
            false => line!(text, "case {l}u: {{"),
        }
        level(l, packed, Factors::Buffer, text);
        line!(text, "return quad(level{l}, position(level{l}, u), 0u);\n}}");
    }
    line!(text, "}}\n}}");
}

/// The constants of a level.
fn level(l: usize, packed: &PackedLevel, factors: Factors, text: &mut Text) {
    let PackedLevel { level, first, factor } = packed;
    let [scale, shift, factor] = [level.scale, level.shift(), *factor].map(Number);
    let (side, entries) = (level.dense_side, level.entries);
    line!(text, "let level{l} = Level({scale}, {shift}, {side}u, {entries}u, {first}u,");
    match factors {
        Factors::Constant => line!(text, "{factor});"),
        #[cfg(feature = "wgpu")]
        Factors::Buffer => line!(text, "factors[{l}]);"),
    }
}

/// `encode`: the features of all levels, one after another.
pub(super) fn encode(grid: &PackedGrid, factors: Factors, text: &mut Text) {
    let n = grid.n_features_per_level;
    text.flag("BY_CORNER", grid.by_corner);
    text.whole("N_FEATURES", n as u32);
    text.file(wgsl!("hash_grid"));
    let quads = (n * grid.levels.len()).div_ceil(QUAD);
    line!(text, "fn encode(u: vec3f) -> array<vec4f, {quads}> {{");
    line!(text, "var encoded: array<vec4f, {quads}>;");
    // Entries of one or two values lie in a part of a quad.
    let whole = n >= QUAD;
    for (l, packed) in grid.levels.iter().enumerate() {
        level(l, packed, factors, text);
        line!(text, "let at{l} = position(level{l}, u);");
        for f in (0..n).step_by(if whole { QUAD } else { 1 }) {
            let (quad, place) = ((l * n + f) / QUAD, (l * n + f) % QUAD);
            if whole {
                line!(text, "encoded[{quad}] = quad(level{l}, at{l}, {f}u);");
            } else {
                line!(text, "encoded[{quad}][{place}] = single(level{l}, at{l}, {f}u);");
            }
        }
    }
    line!(text, "return encoded;\n}}");
}
