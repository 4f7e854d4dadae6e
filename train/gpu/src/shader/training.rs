//! The program of a training step: what evaluates a field, as pictures have it, and the files of
//! `training/wgsl`, whose kernels share its buffers.

use alloc::string::String;

use pocketnerf_core::tensor::SCALE_LOG2;
use pocketnerf_core::{Model, Space};

use super::encoded::{self, Factors};
use super::text::{Text, line};
use super::{hash_grid, scene};
use crate::pack::{PackedEncoded, PackedGrid};

/// Where the rows of both networks lie that kernels know by name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    /// Features that the colour network reads, and harmonics of the direction behind them.
    pub(crate) color_input: [u32; 2],
    /// First rows of the colour network's output, of the gradient by it, and of that by the input.
    pub(crate) color: [u32; 3],
    /// How many values a point is encoded to.
    pub(crate) n_encoded: u32,
    /// First rows of encoded points, of the gradient by the density network's output, and of that
    /// by encoded points.
    pub(crate) density: [u32; 3],
    /// How samples of a workgroup are evaluated together, where they can be.
    pub(crate) together: Option<Together>,
}

/// Samples of several rays, evaluated together by a workgroup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Together {
    /// Rays of a workgroup.
    pub(crate) slots: u32,
    /// Values of the one hidden layer.
    pub(crate) n_hidden: u32,
    /// Quads that the density network gives.
    pub(crate) n_given: u32,
    /// Of each of its two layers, in quads: where its matrix and its bias begin, and a row.
    pub(crate) layers: [[u32; 3]; 2],
}

/// The program that trains fields like that of `model`, a `grid` whose tables are bytes.
pub(crate) fn source(
    model: &Model<'_>,
    (field, grid): (&PackedEncoded, &PackedGrid),
    rows: &Rows,
) -> String {
    let mut text = Text::default();
    text.file(wgsl!("step"));
    scene(&mut text, model);
    text.file(wgsl!("stride"));
    encoded::write(field, Factors::Buffer, false, &mut text);
    line!(text, "fn local_origin(ray: Ray) -> vec3f {{");
    match model.space {
        Space::Contracted(_) => {
            line!(text, "let walk = to_walk(ray);");
            line!(text, "return image(walk.ray, walk.part, vec2f(0.0f, 1.0f));\n}}");
        }
        _ => line!(text, "return ray.origin;\n}}"),
    }
    for (name, value) in [
        ("N_SHADED", rows.color_input[0]),
        ("N_DIRECTIONS", rows.color_input[1]),
        ("COLOR_OUT", rows.color[0]),
        ("COLOR_BACK", rows.color[1]),
        ("COLOR_IN_BACK", rows.color[2]),
        ("N_ENCODED", rows.n_encoded),
        ("ENCODED", rows.density[0]),
        ("DENSITY_BACK", rows.density[1]),
        ("ENCODED_BACK", rows.density[2]),
    ] {
        text.whole(name, value);
    }
    line!(text, "const COARSEST = {}i;", SCALE_LOG2.end());
    text.whole("N_CHANNELS", field.n_feature_quads as u32);
    write_encoded(rows.n_encoded, &mut text);
    text.file(wgsl!("noted"));
    match &rows.together {
        Some(together) => trace_together(together, grid, &mut text),
        None => text.file(wgsl!("trace")),
    }
    for file in [
        wgsl!("look"),
        wgsl!("directions"),
        wgsl!("inputs"),
        wgsl!("surfaces"),
        wgsl!("loss"),
        wgsl!("back"),
        wgsl!("dense"),
        wgsl!("tables"),
        wgsl!("networks"),
    ] {
        text.file(file);
    }
    text.into_string()
}

fn trace_together(together: &Together, grid: &PackedGrid, text: &mut Text) {
    let [hidden, given] = together.layers;
    for (name, value) in [
        ("SLOTS", together.slots),
        ("N_LEVELS", grid.levels.len() as u32),
        ("N_HIDDEN", together.n_hidden),
        ("N_GIVEN", together.n_given),
        ("HIDDEN_MATRIX", hidden[0]),
        ("HIDDEN_BIAS", hidden[1]),
        ("HIDDEN_ROW", hidden[2]),
        ("GIVEN_MATRIX", given[0]),
        ("GIVEN_BIAS", given[1]),
        ("GIVEN_ROW", given[2]),
    ] {
        text.whole(name, value);
    }
    hash_grid::write_levels(grid, text);
    text.file(wgsl!("trace_together"));
    layers(together, 4 * grid.levels.len() as u32, text);
}

/// Sums of both layers, written out: not all compilers do it, and none needs to check loops.
fn layers(together: &Together, n_encoded: u32, text: &mut Text) {
    line!(text, "fn hidden_sums(quad: u32, first: u32) -> array<vec4f, 4> {{");
    for s in 0..4 {
        line!(text, "var s{s} = matrices[HIDDEN_BIAS + quad];");
    }
    for i in 0..n_encoded {
        let at = i * together.slots;
        line!(text, "let r{i} = matrices[HIDDEN_MATRIX + {i}u * HIDDEN_ROW + quad];");
        for s in 0..4 {
            line!(text, "s{s} += encoded_rows[{}u + first] * r{i};", at + s);
        }
    }
    line!(text, "return array<vec4f, 4>(s0, s1, s2, s3);\n}}");
    line!(text, "fn given_sum(quad: u32, slot: u32) -> vec4f {{");
    line!(text, "var sum = matrices[GIVEN_BIAS + quad];");
    for h in 0..together.n_hidden {
        let at = h * together.slots;
        let row = format_args!("matrices[GIVEN_MATRIX + {h}u * GIVEN_ROW + quad]");
        line!(text, "sum += hidden_rows[{at}u + slot] * {row};");
    }
    line!(text, "return sum;\n}}");
}

/// Writes an encoded point into the rows of samples.
fn write_encoded(n_encoded: u32, text: &mut Text) {
    line!(text, "fn write_encoded(u: vec3f, column: u32, apart: u32) {{");
    line!(text, "let encoded = encode(u);");
    for i in 0..n_encoded {
        let (quad, place) = (i / 4, i % 4);
        line!(text, "sample_rows[(ENCODED + {i}u) * apart + column] = encoded[{quad}][{place}];");
    }
    line!(text, "}}");
}
