//! Words and numbers of an XML file.

use roxmltree::{Document, Node, ParsingOptions};

/// A file of more elements and attributes than this is not one of cameras.
const MOST: u32 = 4_000_000;

/// The document of a text; no entities are expanded.
pub(super) fn parse(text: &str) -> Result<Document<'_>, String> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST, ..Default::default() };
    Document::parse_with_options(text, options).map_err(|error| format!("not valid XML: {error}"))
}

/// The first child of a name.
pub(super) fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// The only number in a child; `None` where there is no such child.
pub(super) fn number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, String> {
    Ok(numbers::<1>(node, name)?.map(|[number]| number))
}

/// So many numbers in a child; `None` where there is no such child.
pub(super) fn numbers<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
) -> Result<Option<[f64; N]>, String> {
    let Some(child) = child(node, name) else { return Ok(None) };
    let words = child.text().unwrap_or_default().split_whitespace();
    let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).take(N + 1).collect();
    let is_all = child.text().unwrap_or_default().split_whitespace().count() == numbers.len();
    match <[f64; N]>::try_from(numbers) {
        Ok(numbers) if is_all && numbers.iter().all(|number| number.is_finite()) => {
            Ok(Some(numbers))
        }
        _ => Err(format!("<{name}> does not hold {N} finite numbers")),
    }
}

/// A number in an attribute.
pub(super) fn attribute(node: Node<'_, '_>, name: &str) -> Option<f64> {
    node.attribute(name)?.parse().ok()
}
