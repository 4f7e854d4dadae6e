//! The networks of a vanilla NeRF.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec;

use pocketnerf_core::field::{Activation, MAX_SIGMA};

use super::network::{Source, chain, channels, layer};
use super::text::{Text, line};
use crate::pack::{PackedFourier, PackedNetwork, PackedVanilla, PackedWaves, QUAD};

/// Adds what evaluates the field.
pub(super) fn write(field: &PackedVanilla, is_hierarchical: bool, text: &mut Text) {
    channels(text, 1);
    text.file(wgsl!("shaded"));
    text.number("MAX_SIGMA", MAX_SIGMA);
    text.number("DENSITY_SCALE", field.density_scale);
    text.point("MAP_SCALE", field.map[0]);
    text.point("MAP_OFFSET", field.map[1]);
    text.file(wgsl!("waves"));
    text.file(wgsl!("vanilla"));
    let activated = match field.activation {
        Activation::Relu => "max(x, 0.0f)",
        Activation::Softplus => "softplus(x)",
        _ => "exp(min(x, 80.0f))",
    };
    line!(text, "fn activated(x: f32) -> f32 {{\n    return {activated};\n}}");
    encode(text, "encode_position", &field.positions);
    if let Some(directions) = &field.directions {
        encode(text, "encode_direction", directions);
    }
    fine(text, field);
    if is_hierarchical {
        coarse(text, field);
    }
}

/// A function that encodes a point.
fn encode(text: &mut Text, name: &str, fourier: &PackedFourier) {
    let quads = fourier.quads();
    line!(text, "fn {name}(p: vec3f) -> array<vec4f, {quads}> {{");
    line!(text, "var encoded: array<vec4f, {quads}>;");
    let mut first = 0;
    if fourier.include_input {
        line!(text, "encoded[0] = vec4f(p, 0.0f);");
        first = 1;
    }
    match fourier.waves {
        PackedWaves::Octaves { n, pi } => {
            let half_turns = if pi { "half_turns_of_pi" } else { "half_turns" };
            line!(text, "let turns = {half_turns}(p);");
            line!(text, "for (var k = 0u; k < times({n}u); k++) {{");
            line!(text, "let x = octave(turns, k);");
            line!(text, "encoded[{first}u + 2u * k] = sin_pi(x);");
            line!(text, "encoded[{first}u + 2u * k + 1u] = cos_pi(x);");
            line!(text, "}}");
        }
        PackedWaves::Gaussian { first: row, n } => {
            let quads = n.div_ceil(QUAD);
            line!(text, "for (var q = 0u; q < times({quads}u); q++) {{");
            line!(text, "var x: vec4f;");
            line!(text, "for (var j = 0u; j < 4u; j++) {{");
            line!(text, "x[j] = 2.0f * dot(p, weight({row}u + 4u * q + j).xyz);");
            line!(text, "}}");
            line!(text, "encoded[{first}u + q] = cos_pi(x);");
            line!(text, "encoded[{first}u + {quads}u + q] = sin_pi(x);");
            line!(text, "}}");
        }
    }
    line!(text, "return encoded;\n}}");
}

/// The trunk of a network; returns what comes out of it.
fn trunk(text: &mut Text, positions: &PackedFourier, network: &PackedNetwork) -> (String, usize) {
    line!(text, "var position = encode_position(u * MAP_SCALE + MAP_OFFSET);");
    let encoded = ("position", positions.quads());
    let (mut last, mut quads) = (String::new(), 0);
    for (i, (packed, skips, relu)) in network.trunk.iter().enumerate() {
        let hidden = (last.as_str(), quads);
        let sources: &[Source<'_>] = match (i, skips) {
            (0, _) => &[encoded],
            (_, true) => &[encoded, hidden],
            (_, false) => &[hidden],
        };
        let to = format!("trunk{i}");
        layer(text, packed, sources, &to, *relu);
        (last, quads) = (to, packed.n_output);
    }
    (last, quads)
}

/// Density and colour, both before their activation.
fn fine(text: &mut Text, field: &PackedVanilla) {
    let network = &field.fine;
    line!(text, "fn fine_network(u: vec3f, d: vec3f) -> array<vec4f, 2> {{");
    let (mut last, mut quads) = trunk(text, &field.positions, network);
    layer(text, &network.density, &[(&last, quads)], "density", false);
    if let Some((feature, relu)) = &network.feature {
        layer(text, feature, &[(&last, quads)], "feature", *relu);
        (last, quads) = ("feature".to_owned(), feature.n_output);
    }
    let mut sources = vec![(last.as_str(), quads)];
    if let Some(directions) = &field.directions {
        line!(text, "var direction = encode_direction(d);");
        sources.push(("direction", directions.quads()));
    }
    let color = chain(text, &network.color, &sources, "color");
    line!(text, "return array<vec4f, 2>(density[0], {color}[0]);\n}}");
}

/// The density that places samples.
fn coarse(text: &mut Text, field: &PackedVanilla) {
    let network = field.coarse.as_ref().unwrap_or(&field.fine);
    line!(text, "fn coarse_sigma(u: vec3f) -> f32 {{");
    let (last, quads) = trunk(text, &field.positions, network);
    layer(text, &network.density, &[(&last, quads)], "density", false);
    line!(text, "return min(activated(density[0].x), MAX_SIGMA) * DENSITY_SCALE;\n}}");
}
