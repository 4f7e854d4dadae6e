//! Dense layers in WGSL.

use alloc::string::String;
use core::fmt;

use super::text::{Text, line};
use crate::pack::{Layer, QUAD};

/// What a layer reads: quads with a name.
pub(super) type Source<'s> = (&'s str, usize);

/// Statements that compute `to`, an array of quads, from `sources`, one after another.
pub(super) fn layer(text: &mut Text, layer: &Layer, sources: &[Source<'_>], to: &str, relu: bool) {
    let n = layer.n_output;
    line!(text, "var {to}: array<vec4f, {n}>;");
    line!(text, "for (var o = 0u; o < times({n}u); o++) {{");
    bias(text, layer);
    let mut first = layer.first;
    for (name, quads) in sources {
        // Arrays are indexed by what compilers do not know in any case: it stays a loop.
        line!(text, "for (var i = 0u; i < times({quads}u); i++) {{");
        line!(text, "sum += product({name}[i], {first}u + {}u * i + o, {n}u);", 4 * n);
        line!(text, "}}");
        first += 4 * n * quads;
    }
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
    for j in 0..n {
        line!(text, "{to}[{j}] = {};", row(second.bias, format_args!("{j}u")));
    }
    line!(text, "for (var o = 0u; o < times({hidden}u); o++) {{");
    bias(text, first);
    // Loops that are written out: not all compilers do it, and none needs to check them.
    let mut number = first.first;
    for (name, quads) in sources {
        for (i, c) in (0..*quads).flat_map(|i| (0..QUAD).map(move |c| (i, c))) {
            line!(text, "sum += {name}[{i}][{c}] * {};", row(Some(number), format_args!("o")));
            number += hidden;
        }
    }
    line!(text, "let h = max(sum, vec4f());");
    line!(text, "let v = {}u * o;", QUAD * n);
    for (c, j) in (0..QUAD).flat_map(|c| (0..n).map(move |j| (c, j))) {
        let first = Some(second.first + c * n + j);
        line!(text, "{to}[{j}] += h[{c}] * {};", row(first, format_args!("v")));
    }
    line!(text, "}}");
    if relu {
        (0..n).for_each(|j| line!(text, "{to}[{j}] = max({to}[{j}], vec4f());"));
    }
}

/// Statements that begin output quad `o` of a layer.
fn bias(text: &mut Text, layer: &Layer) {
    line!(text, "var sum = {};", row(layer.bias, format_args!("o")));
}

/// Row `first` plus `at` of the weights; zeros where there is none.
pub(super) const fn row(first: Option<usize>, at: fmt::Arguments<'_>) -> Row<'_> {
    Row(first, at)
}

pub(super) struct Row<'a>(Option<usize>, fmt::Arguments<'a>);

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(first) => write!(f, "weight({first}u + {})", self.1),
            None => f.write_str("vec4f()"),
        }
    }
}

/// What rays add up, quads of numbers, and the function that adds it.
pub(super) fn channels(text: &mut Text, n: usize) {
    line!(text, "alias Channels = array<vec4f, {n}>;");
    line!(text, "fn sum_of(a: Channels, weight: f32, b: Channels) -> Channels {{");
    line!(text, "return Channels(");
    (0..n).for_each(|c| line!(text, "a[{c}] + weight * b[{c}],"));
    line!(text, ");\n}}");
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
