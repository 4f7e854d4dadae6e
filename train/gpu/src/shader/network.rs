//! Dense layers in WGSL.

use alloc::string::String;
use core::fmt;

use super::text::{Text, line};
use crate::pack::Layer;

/// What a layer reads: quads with a name.
pub(super) type Source<'s> = (&'s str, usize);

/// Statements that compute `to`, an array of quads, from `sources`, one after another.
pub(super) fn layer(text: &mut Text, layer: &Layer, sources: &[Source<'_>], to: &str, relu: bool) {
    let n = layer.n_output;
    line!(text, "var {to}: array<vec4f, {n}>;");
    line!(text, "for (var o = 0u; o < times({n}u); o++) {{");
    quad(text, layer, sources, true);
    line!(text, "{to}[o] = {};", if relu { "max(sum, vec4f())" } else { "sum" });
    line!(text, "}}");
}

/// Two layers with ReLU between them: what a quad of the first gives is added to the outputs
/// of the second at once, so that no array is written at a place that compilers do not know.
fn pair(
    text: &mut Text,
    [first, second]: [&Layer; 2],
    sources: &[Source<'_>],
    to: &str,
    relu: bool,
) {
    let (hidden, n) = (first.n_output, second.n_output);
    line!(text, "var {to}: array<vec4f, {n}>;");
    let each = |text: &mut Text, value: fmt::Arguments<'_>| {
        line!(text, "for (var j = 0u; j < {n}u; j++) {{");
        line!(text, "{to}[j] = {value};");
        line!(text, "}}");
    };
    if let Some(bias) = second.bias {
        each(text, format_args!("weights[{bias}u + j]"));
    }
    line!(text, "for (var o = 0u; o < times({hidden}u); o++) {{");
    quad(text, first, sources, false);
    line!(text, "let h = max(sum, vec4f());");
    line!(text, "let v = {}u + {}u * o;", second.first, 4 * n);
    each(text, format_args!("{to}[j] + product(h, v + j, {n}u)"));
    line!(text, "}}");
    if relu {
        each(text, format_args!("max({to}[j], vec4f())"));
    }
}

/// Statements that make `sum` output quad `o` of a layer. Where arrays are indexed by what
/// compilers do not know in any case, the loop over inputs may stay one.
fn quad(text: &mut Text, layer: &Layer, sources: &[Source<'_>], is_loop: bool) {
    let Layer { mut first, n_output: n, .. } = *layer;
    line!(text, "var sum = vec4f();");
    if let Some(bias) = layer.bias {
        line!(text, "sum = weights[{bias}u + o];");
    }
    let times = if is_loop { "times" } else { "" };
    for (name, quads) in sources {
        line!(text, "for (var i = 0u; i < {times}({quads}u); i++) {{");
        line!(text, "sum += product({name}[i], {first}u + {}u * i + o, {n}u);", 4 * n);
        line!(text, "}}");
        first += 4 * n * quads;
    }
}

/// A function from an array of quads to another: ReLU between layers, none after the last.
pub(super) fn function(text: &mut Text, name: &str, layers: &[Layer]) {
    let (Some(first), Some(last)) = (layers.first(), layers.last()) else { return };
    let [n_input, n_output] = [first.n_input, last.n_output];
    let input = format_args!("ptr<function, array<vec4f, {n_input}>>");
    line!(text, "fn {name}(input: {input}) -> array<vec4f, {n_output}> {{");
    let result = chain(text, layers, &[("(*input)", n_input)], "y");
    line!(text, "return {result};\n}}");
}

/// The same as statements; returns the name of the last array. The first one is called `name`,
/// and each other one so once more.
pub(super) fn chain(
    text: &mut Text,
    layers: &[Layer],
    sources: &[Source<'_>],
    name: &str,
) -> String {
    // In pairs; an odd one comes first.
    let (odd, pairs) = layers.split_at(layers.len() % 2);
    let n = odd.len() + pairs.len() / 2;
    let mut last = (String::new(), 0);
    for (i, group) in odd.chunks(1).chain(pairs.chunks(2)).enumerate() {
        let to = [name, &last.0].concat();
        let read = [(last.0.as_str(), last.1)];
        let (sources, relu) = (if i == 0 { sources } else { &read }, i + 1 < n);
        match group {
            [first, second] => pair(text, [first, second], sources, &to, relu),
            _ => layer(text, &group[0], sources, &to, relu),
        }
        last = (to, group[group.len() - 1].n_output);
    }
    last.0
}
