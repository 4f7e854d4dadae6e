//! Dense layers in WGSL.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use core::fmt::Write;

use crate::pack::Layer;

/// What a layer reads: quads with a name.
pub(super) type Source<'s> = (&'s str, usize);

/// Statements that compute `to`, an array of quads, from `sources`, one after another.
pub(super) fn layer(
    text: &mut String,
    layer: &Layer,
    sources: &[Source<'_>],
    to: &str,
    relu: bool,
) {
    let n = layer.n_output;
    write_line(text, &format!("    var {to}: array<vec4f, {n}>;"));
    write_line(text, &format!("    for (var o = 0u; o < times({n}u); o++) {{"));
    quad(text, layer, sources, true);
    write_line(text, &format!("        {to}[o] = {};", activated("sum", relu)));
    write_line(text, "    }");
}

/// Two layers with ReLU between them: what a quad of the first gives is added to the outputs
/// of the second at once, so that no array is written at a place that compilers do not know.
fn pair(
    text: &mut String,
    [first, second]: [&Layer; 2],
    sources: &[Source<'_>],
    to: &str,
    relu: bool,
) {
    let (hidden, n) = (first.n_output, second.n_output);
    write_line(text, &format!("    var {to}: array<vec4f, {n}>;"));
    let each = |text: &mut String, indent: &str, statement: &str| {
        write_line(text, &format!("{indent}for (var j = 0u; j < {n}u; j++) {{"));
        write_line(text, &format!("{indent}    {statement}"));
        write_line(text, &format!("{indent}}}"));
    };
    if let Some(bias) = second.bias {
        each(text, "    ", &format!("{to}[j] = weights[{bias}u + j];"));
    }
    write_line(text, &format!("    for (var o = 0u; o < times({hidden}u); o++) {{"));
    quad(text, first, sources, false);
    write_line(text, "        let h = max(sum, vec4f());");
    write_line(text, &format!("        let v = {}u + {}u * o;", second.first, 4 * n));
    each(text, "        ", &format!("{to}[j] += {};", product("h", "v + j", n)));
    write_line(text, "    }");
    if relu {
        each(text, "    ", &format!("{to}[j] = max({to}[j], vec4f());"));
    }
}

/// Statements that make `sum` output quad `o` of a layer. Where arrays are indexed by what
/// compilers do not know in any case, the loop over inputs may stay one.
fn quad(text: &mut String, layer: &Layer, sources: &[Source<'_>], is_loop: bool) {
    let Layer { mut first, n_output: n, .. } = *layer;
    let begin = layer.bias.map_or("vec4f()".to_owned(), |bias| format!("weights[{bias}u + o]"));
    write_line(text, &format!("        var sum = {begin};"));
    for (name, quads) in sources {
        let end = if is_loop { format!("times({quads}u)") } else { format!("{quads}u") };
        write_line(text, &format!("        for (var i = 0u; i < {end}; i++) {{"));
        write_line(text, &format!("            let x = {name}[i];"));
        write_line(text, &format!("            let w = {first}u + {}u * i + o;", 4 * n));
        write_line(text, &format!("            sum += {};", product("x", "w", n)));
        write_line(text, "        }");
        first += 4 * n * quads;
    }
}

/// A quad times four rows of weights, `n` quads apart.
fn product(x: &str, at: &str, n: usize) -> String {
    let term = |i: usize| format!("{x}.{} * weights[{at} + {}u]", ["x", "y", "z", "w"][i], i * n);
    [0, 1, 2, 3].map(term).join(" + ")
}

fn activated(value: &str, relu: bool) -> String {
    if relu { format!("max({value}, vec4f())") } else { value.to_owned() }
}

/// A function from an array of quads to another: ReLU between layers, none after the last.
pub(super) fn function(text: &mut String, name: &str, layers: &[Layer]) {
    let (Some(first), Some(last)) = (layers.first(), layers.last()) else { return };
    let [n_input, n_output] = [first.n_input, last.n_output];
    write_line(
        text,
        &format!(
            "fn {name}(input: ptr<function, array<vec4f, {n_input}>>) -> array<vec4f, {n_output}> {{"
        ),
    );
    let result = chain(text, layers, &[("(*input)", n_input)], "y");
    write_line(text, &format!("    return {result};\n}}"));
}

/// The same as statements; returns the name of the last array. All are called `name` and a
/// number.
pub(super) fn chain(
    text: &mut String,
    layers: &[Layer],
    sources: &[Source<'_>],
    name: &str,
) -> String {
    // In pairs; an odd one comes first.
    let (odd, pairs) = layers.split_at(layers.len() % 2);
    let n = odd.len() + pairs.len() / 2;
    let mut last = (String::new(), 0);
    for (i, group) in odd.chunks(1).chain(pairs.chunks(2)).enumerate() {
        let to = format!("{name}{i}");
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

/// A line of the program.
pub(super) fn write_line(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}
