//! Planes and lines.

use pocketnerf_core::encoding::planes::{ACROSS, FEATURES};

use super::text::{Number, Text, line};
use crate::pack::{PackedPlanes, QUAD};

/// Quads of an entry.
const QUADS: usize = FEATURES / QUAD;

/// `encode`: the products of all pairs, one after another.
pub(super) fn encode(planes: &PackedPlanes, text: &mut Text) {
    text.whole("PLANE_SIDE", planes.resolution);
    text.whole("N_VALUES_OF_ENTRY", FEATURES as u32);
    text.file(wgsl!("planes"));
    let quads = QUADS * planes.pairs.len();
    line!(text, "fn encode(u: vec3f) -> array<vec4f, {quads}> {{");
    line!(text, "let at = cell_of(u);");
    for (axis, [first, second]) in ACROSS.into_iter().enumerate() {
        line!(text, "let across{axis} = across(at, {first}u, {second}u);");
    }
    line!(text, "var encoded: array<vec4f, {quads}>;");
    for (number, pair) in planes.pairs.iter().enumerate() {
        let ([plane, line], axis, factor) = (pair.first, pair.axis, Number(pair.factor));
        for q in 0..QUADS {
            let (to, value) = (QUADS * number + q, QUAD * q);
            line!(text, "encoded[{to}] = {factor} * on_plane(across{axis}, {}u)", plane + value);
            line!(text, "* on_line(at, {axis}u, {}u);", line + value);
        }
    }
    line!(text, "return encoded;\n}}");
}
