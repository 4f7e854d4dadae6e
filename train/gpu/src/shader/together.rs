//! The colour network of all rays of a workgroup together.

use alloc::string::ToString;

use super::network::row;
use super::text::{Text, line};
use crate::pack::{Layer, QUAD};

/// Rays at a time, and invocations that share them: as many groups of invocations, which have a
/// part of the outputs each, as quads of rays.
const RAYS: usize = 32;
const GROUPS: usize = 8;
/// Quads of a layer at most: 16 KiB of memory that a workgroup shares are there everywhere.
const MOST_QUADS: usize = 32;

/// Whether such layers can be computed together.
pub(super) fn fits(layers: &[Layer]) -> bool {
    let is_small = |layer: &Layer| layer.n_input.max(layer.n_output) <= MOST_QUADS;
    layers.iter().all(is_small) && layers.last().is_some_and(|last| last.n_output == 1)
}

/// Adds `keep`, what rays leave for the program `shade`, and `color_layers`, which makes of the
/// quads of `values` what adds up to those of the output, one a group.
pub(super) fn write(text: &mut Text, n_features: usize, layers: &[Layer]) {
    let quads = layers.iter().map(|layer| layer.n_input).max().unwrap_or(0).max(GROUPS);
    text.whole("N_VALUES", (RAYS * quads) as u32);
    text.whole("N_MEAN", n_features as u32);
    text.file(wgsl!("shade"));
    line!(text, "fn keep(number: u32) {{");
    (0..n_features).for_each(|i| line!(text, "means[N_MEAN * number + {i}u] = kept[{i}];"));
    line!(text, "}}");
    line!(text, "fn color_layers(ray: u32, group: u32) {{");
    for (l, layer) in layers.iter().enumerate() {
        line!(text, "{{");
        match l + 1 == layers.len() {
            true => last(text, layer),
            false => hidden(text, layer),
        }
        line!(text, "}}\nworkgroupBarrier();");
    }
    line!(text, "}}");
}

/// The rays of an invocation.
const fn rays() -> core::ops::Range<usize> {
    0..RAYS / GROUPS
}

/// Reads quad `i` of each ray.
fn inputs(text: &mut Text) {
    for r in rays() {
        line!(text, "let x{r} = values[{RAYS}u * i + ray + {}u];", GROUPS * r);
    }
}

/// Outputs of all groups, with ReLU, in the place of the inputs.
fn hidden(text: &mut Text, layer: &Layer) {
    let Layer { n_input, n_output: n, .. } = *layer;
    let parts = n.div_ceil(GROUPS);
    for p in 0..parts {
        // Where there are fewer quads than groups, some compute the last one once more.
        line!(text, "let q{p} = min(group + {}u, {}u);", GROUPS * p, n - 1);
        let bias = row(layer.bias, format_args!("q{p}")).to_string();
        rays().for_each(|r| line!(text, "var a{p}{r} = {bias};"));
    }
    line!(text, "for (var i = 0u; i < times({n_input}u); i++) {{");
    inputs(text);
    for p in 0..parts {
        for c in 0..QUAD {
            let at = format_args!("{}u * i + q{p}", QUAD * n);
            let weight = row(Some(layer.first + c * n), at).to_string();
            line!(text, "let w{p}{c} = {weight};");
            rays().for_each(|r| line!(text, "a{p}{r} += x{r}[{c}] * w{p}{c};"));
        }
    }
    line!(text, "}}\nworkgroupBarrier();");
    for p in 0..parts {
        for r in rays() {
            let to = format_args!("{RAYS}u * q{p} + ray + {}u", GROUPS * r);
            line!(text, "values[{to}] = max(a{p}{r}, vec4f());");
        }
    }
}

/// What each group's inputs add to the only quad of outputs.
fn last(text: &mut Text, layer: &Layer) {
    let bias = row(layer.bias, format_args!("0u")).to_string();
    rays().for_each(|r| line!(text, "var a{r} = select(vec4f(), {bias}, group == 0u);"));
    line!(text, "for (var i = group; i < {}u; i += {GROUPS}u) {{", layer.n_input);
    inputs(text);
    for c in 0..QUAD {
        let weight = row(Some(layer.first + c), format_args!("{QUAD}u * i")).to_string();
        line!(text, "let w{c} = {weight};");
        rays().for_each(|r| line!(text, "a{r} += x{r}[{c}] * w{c};"));
    }
    line!(text, "}}\nworkgroupBarrier();");
    for r in rays() {
        line!(text, "values[{RAYS}u * group + ray + {}u] = a{r};", GROUPS * r);
    }
}
