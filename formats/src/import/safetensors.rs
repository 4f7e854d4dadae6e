//! `.safetensors`: the header's length (`u64`, little endian), the header (JSON: of each
//! tensor its type, shape and range of bytes; texts under `__metadata__`), then the bytes.
//!
//! The ranges have to cover the bytes, once each.

use core::fmt;
use std::borrow::Cow;
use std::format;
use std::string::{String, ToString as _};
use std::vec::Vec;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};

use super::ImportError;
use super::budget::Budget;
use super::element::ElementType;
use super::error::shown;
use super::tensor::{Numbers, Placement, Storage, Tensor};
use super::tree::{Leaf, Tree};

/// Longest header: that of a hundred thousand tensors. It takes up to eight times
/// its length in memory.
const MAX_HEADER: usize = 8 << 20;

pub(super) fn is_safetensors(bytes: &[u8]) -> bool {
    let header =
        bytes.split_first_chunk().map(|(length, rest)| (u64::from_le_bytes(*length), rest));
    // Text in place of the length would make it far longer.
    header.is_some_and(|(length, rest)| length < 1 << 32 && rest.starts_with(b"{"))
}

pub(super) fn read(bytes: &[u8], mut budget: Budget) -> Result<Tree<'_>, ImportError> {
    let cut_off = || ImportError::CutOff("the header of .safetensors");
    let (length, rest) = bytes.split_first_chunk().ok_or_else(cut_off)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
    if length > MAX_HEADER {
        let what = "bytes of a .safetensors header";
        return Err(ImportError::TooMuch { what, limit: MAX_HEADER });
    }
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut_off)?;
    let header: Header = serde_json::from_slice(header).map_err(|error| {
        let problem = shown(&error.to_string());
        ImportError::Header { header: "the header of .safetensors", problem }
    })?;
    budget.spend_on::<(String, Leaf<'_>)>(header.tensors.len() + header.texts.len())?;
    let mut leaves = Vec::new();
    let mut ranges = Vec::new();
    for (name, info) in header.tensors {
        let tensor = info.tensor(&name, data)?;
        ranges.push((info.data_offsets, name.clone()));
        leaves.push((name, Leaf::Tensor(tensor)));
    }
    for (key, text) in header.texts {
        leaves.push((format!("{METADATA}.{key}"), Leaf::Text(Cow::Owned(text))));
    }
    check_cover(ranges, data.len())?;
    Tree::new(leaves)
}

const METADATA: &str = "__metadata__";

/// Every byte belongs to one tensor.
fn check_cover(mut ranges: Vec<([usize; 2], String)>, length: usize) -> Result<(), ImportError> {
    ranges.sort_unstable();
    let mut end = 0;
    for ([from, to], name) in ranges {
        if from != end {
            let problem = "its bytes do not begin where those of the tensor before it end";
            return Err(ImportError::Tensor { name: shown(&name), problem });
        }
        end = to;
    }
    match length - end {
        0 => Ok(()),
        bytes => Err(ImportError::Trailing { bytes }),
    }
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Info {
    dtype: String,
    shape: Vec<usize>,
    data_offsets: [usize; 2],
}

impl Info {
    fn tensor<'a>(&self, name: &str, data: &'a [u8]) -> Result<Tensor<'a>, ImportError> {
        let refuse = |problem| ImportError::Tensor { name: shown(name), problem };
        let element =
            element(&self.dtype).ok_or_else(|| ImportError::ElementType(shown(&self.dtype)))?;
        let [from, to] = self.data_offsets;
        let bytes =
            data.get(from..to).ok_or(refuse("its bytes reach beyond the end of the file"))?;
        let placement = Placement::contiguous(&self.shape, false)
            .ok_or(refuse("its shape has more numbers than can be counted"))?;
        let numbers = Numbers { element, big_endian: false };
        let tensor = Tensor::new(numbers, placement, Storage::File(bytes)).map_err(refuse)?;
        match tensor.len() * element.size() == bytes.len() {
            true => Ok(tensor),
            false => Err(refuse("its bytes are more than its shape needs")),
        }
    }
}

/// What the format calls the types.
fn element(dtype: &str) -> Option<ElementType> {
    Some(match dtype {
        "BOOL" => ElementType::Bool,
        "U8" => ElementType::U8,
        "U16" => ElementType::U16,
        "U32" => ElementType::U32,
        "U64" => ElementType::U64,
        "I8" => ElementType::I8,
        "I16" => ElementType::I16,
        "I32" => ElementType::I32,
        "I64" => ElementType::I64,
        "F16" => ElementType::F16,
        "BF16" => ElementType::Bf16,
        "F32" => ElementType::F32,
        "F64" => ElementType::F64,
        _ => return None,
    })
}

/// A key that occurs twice is there twice.
#[derive(Default)]
struct Header {
    texts: Vec<(String, String)>,
    tensors: Vec<(String, Info)>,
}

impl<'de> Deserialize<'de> for Header {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(HeaderVisitor)
    }
}

struct HeaderVisitor;

impl<'de> Visitor<'de> for HeaderVisitor {
    type Value = Header;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of tensors")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Header, A::Error> {
        let mut header = Header::default();
        while let Some(key) = map.next_key::<String>()? {
            if key == METADATA {
                let Texts(texts) = map.next_value()?;
                header.texts.extend(texts);
            } else {
                header.tensors.push((key, map.next_value()?));
            }
        }
        Ok(header)
    }
}

/// An object of texts, a key that occurs twice being there twice.
struct Texts(Vec<(String, String)>);

impl<'de> Deserialize<'de> for Texts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TextsVisitor)
    }
}

struct TextsVisitor;

impl<'de> Visitor<'de> for TextsVisitor {
    type Value = Texts;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of texts")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Texts, A::Error> {
        let mut texts = Vec::new();
        while let Some(text) = map.next_entry()? {
            texts.push(text);
        }
        Ok(Texts(texts))
    }
}
