//! `.safetensors`.

use pocketnerf_formats::import::{Checkpoint, Container, ElementType};

use super::{expect, fixture, tensor};

#[test]
fn every_tensor_is_found() {
    let bytes = fixture("tiny.safetensors");
    let checkpoint = Checkpoint::read(&bytes).unwrap();
    assert_eq!(checkpoint.container(), Container::Safetensors);
    let names = ["model.weight", "model.half", "model.bf16", "empty", "model.count", "bits"];
    assert!(checkpoint.names().eq(names));
    expect(&checkpoint, "model.weight", &[2, 3], &[0, 1, 2, 3, 4, 5]);
    expect(&checkpoint, "model.half", &[4], &[0, 1, 2, 3]);
    expect(&checkpoint, "model.bf16", &[2], &[0, 8]);
    expect(&checkpoint, "model.count", &[], &[-40]);
    expect(&checkpoint, "empty", &[0, 7], &[]);
    let bits = tensor(&checkpoint, "bits");
    assert_eq!((bits.element_type(), bits.to_bytes().unwrap()), (ElementType::U8, vec![1, 2, 255]));
    assert_eq!(checkpoint.text("__metadata__.format"), Some("pt"));
}

/// A file of this header and eight bytes.
fn error(header: &str) -> String {
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.as_bytes());
    bytes.extend([0; 8]);
    Checkpoint::read(&bytes).unwrap_err().to_string()
}

fn range(name: &str, from: u64, to: u64) -> String {
    let shape = to.saturating_sub(from);
    format!(r#""{name}":{{"dtype":"U8","shape":[{shape}],"data_offsets":[{from},{to}]}}"#)
}

#[test]
fn ranges_cover_the_bytes_once() {
    let of = |ranges: &[String]| error(&format!("{{{}}}", ranges.join(",")));
    let gap = "tensor b: its bytes do not begin where those of the tensor before it end";
    assert_eq!(of(&[range("a", 0, 3), range("b", 4, 8)]), gap);
    assert_eq!(of(&[range("a", 0, 5), range("b", 4, 8)]), gap);
    let trailing = "4 bytes after the end of the checkpoint, where none were expected";
    assert_eq!(of(&[range("a", 0, 4)]), trailing);
    let beyond = "tensor a: its bytes reach beyond the end of the file";
    assert_eq!(of(&[range("a", 0, 9)]), beyond);
    assert_eq!(of(&[range("a", 8, 0)]), beyond);
    assert_eq!(of(&[range("a", 0, u64::MAX)]), beyond);
    assert_eq!(of(&[range("a", 0, 4), range("a", 4, 8)]), "a: occurs twice");
}

#[test]
fn headers_are_refused_with_what_is_wrong() {
    let of = |dtype: &str, shape: &str| {
        error(&format!(r#"{{"a":{{"dtype":"{dtype}","shape":{shape},"data_offsets":[0,8]}}}}"#))
    };
    assert_eq!(of("F8_E4M3", "[8]"), "values of type F8_E4M3 are not read");
    assert_eq!(of("F32", "[1]"), "tensor a: its bytes are more than its shape needs");
    assert_eq!(of("F32", "[3]"), "tensor a: it reaches beyond the end of its storage");
    let uncountable = "tensor a: its shape has more numbers than can be counted";
    assert_eq!(of("F32", "[9007199254740992,9007199254740992]"), uncountable);
    assert!(of("F32", "[-2]").starts_with("the header of .safetensors: "));
    assert!(error("{").starts_with("the header of .safetensors: EOF"));
    let deep = format!("{}{}", r#"{"a":"#, "[".repeat(100_000));
    assert!(error(&deep).starts_with("the header of .safetensors: "));
}
