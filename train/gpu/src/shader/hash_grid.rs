//! The hash grid and its networks.

use pocketnerf_core::field::MAX_SIGMA;

use super::network::{channels, function};
use super::text::{Number, Text, line};
#[cfg(feature = "wgpu")]
use super::together;
use crate::pack::{PackedGrid, PackedLevel, QUAD, reader};

/// What stored values are multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Factors {
    /// What the model says.
    Constant,
    /// What a buffer says, a number a level: they change while a field learns.
    #[cfg(feature = "wgpu")]
    Buffer,
}

impl Factors {
    fn is_training(self) -> bool {
        self != Self::Constant
    }
}

/// Adds what evaluates the field.
pub(super) fn write(grid: &PackedGrid, factors: Factors, is_hierarchical: bool, text: &mut Text) {
    text.number("MAX_SIGMA", MAX_SIGMA);
    text.number("LOG_DENSITY_BIAS", grid.log_density_bias);
    text.flag("BY_CORNER", grid.by_corner);
    for (name, value) in [
        ("N_FEATURES", grid.n_features_per_level),
        ("N_FEATURE_QUADS", grid.n_feature_quads),
        ("N_HARMONICS", grid.n_harmonics),
    ] {
        text.whole(name, value as u32);
    }
    if let Some(reader) = grid.dtype.and_then(reader) {
        text.file(reader);
    }
    text.file(wgsl!("hash_grid"));
    text.file(wgsl!("decoder"));
    let n_features = grid.n_feature_quads;
    line!(text, "fn features_of(all: array<vec4f, {}>) -> Features {{", n_features + 1);
    line!(text, "return Features(");
    (0..n_features).for_each(|i| line!(text, "all[{i}],"));
    line!(text, ");\n}}");
    channels(text, if grid.per_ray { n_features } else { 1 });
    text.file(match grid.per_ray {
        true => wgsl!("decoded_per_ray"),
        false => wgsl!("decoded_per_sample"),
    });
    if factors.is_training() {
        // Its kernels have the colour network.
    } else if is_shaded(grid) {
        #[cfg(feature = "wgpu")]
        together::write(text, n_features, &grid.color);
    } else {
        text.file(wgsl!("decoded_color"));
        function(text, "color_network", &grid.color);
        text.file(wgsl!("shaded"));
        if grid.per_ray {
            text.file(wgsl!("color_of_mean"));
        }
    }
    if is_hierarchical {
        text.file(wgsl!("decoded_coarse"));
    }
    encode(grid, factors, text);
    function(text, "density_network", &grid.density);
}

/// Whether colours are computed by a program of their own.
#[cfg(feature = "wgpu")]
pub(super) fn is_shaded(grid: &PackedGrid) -> bool {
    grid.per_ray && together::fits(&grid.color)
}

/// Never, where programs are to be short.
#[cfg(not(feature = "wgpu"))]
pub(super) const fn is_shaded(_: &PackedGrid) -> bool {
    false
}

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
fn encode(grid: &PackedGrid, factors: Factors, text: &mut Text) {
    let n = grid.n_features_per_level;
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
