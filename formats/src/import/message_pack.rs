//! MessagePack: values one after another, each with a byte that tells its kind.
//!
//! One map is the file. Binary values are tensors of bytes; extensions and nothing
//! (`nil`) have no names.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::string::String;
use std::vec::Vec;

use rmp::Marker;
use rmp::decode::{RmpRead, read_marker};

use super::ImportError;
use super::budget::Budget;
use super::element::ElementType;
use super::tensor::{Numbers, Placement, Storage, Tensor};
use super::tree::{Leaf, Tree};

/// Most values in all.
const MAX_VALUES: usize = 1_000_000;
/// Most levels.
const MAX_DEPTH: usize = 64;

/// Whether the file is a map whose first key is a text. That is little to go by: others are
/// to be asked first.
pub(super) fn is_message_pack(bytes: &[u8]) -> bool {
    let ([0x81..=0x8f, key, ..] | [0xde, _, _, key, ..] | [0xdf, _, _, _, _, key, ..]) = bytes
    else {
        return false;
    };
    matches!(key, 0xa0..=0xbf | 0xd9..=0xdb)
}

pub(super) fn read(bytes: &[u8], budget: Budget) -> Result<Tree<'_>, ImportError> {
    let mut reader = Reader { bytes, rest: bytes, budget, leaves: Vec::new() };
    reader.read()?;
    match reader.rest.len() {
        0 => Tree::new(reader.leaves),
        bytes => Err(ImportError::Trailing { bytes }),
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    rest: &'a [u8],
    budget: Budget,
    leaves: Vec<(String, Leaf<'a>)>,
}

/// A value, or the beginning of one that holds others.
enum Value<'a> {
    Leaf(Leaf<'a>),
    Nameless,
    Map(usize),
    Array(usize),
}

/// A map or an array that is being read.
struct Open {
    is_map: bool,
    next: usize,
    len: usize,
    /// Bytes of its own name.
    path_bytes: usize,
}

impl<'a> Reader<'a> {
    fn read(&mut self) -> Result<(), ImportError> {
        let mut open: Vec<Open> = Vec::new();
        let mut path = String::new();
        for _ in 0..MAX_VALUES {
            let path_bytes = path.len();
            match self.value()? {
                Value::Nameless => {}
                Value::Leaf(leaf) => {
                    self.budget.spend_on::<(String, Leaf<'_>, usize, [usize; 2])>(1)?;
                    self.budget.spend(path.len())?;
                    self.leaves.push((path.clone(), leaf));
                }
                Value::Map(len) => open.push(Open { is_map: true, next: 0, len, path_bytes }),
                Value::Array(len) => open.push(Open { is_map: false, next: 0, len, path_bytes }),
            }
            if open.len() > MAX_DEPTH {
                let what = "levels of MessagePack";
                return Err(ImportError::TooMuch { what, limit: MAX_DEPTH });
            }
            while open.last().is_some_and(|open| open.next == open.len) {
                open.pop();
            }
            let Some(last) = open.last_mut() else { return Ok(()) };
            path.truncate(last.path_bytes);
            if !path.is_empty() {
                path.push('.');
            }
            if last.is_map {
                let key = self.key()?;
                path.push_str(key);
            } else if write!(path, "{}", last.next).is_err() {
                return Err(self.expected("an index"));
            }
            last.next += 1;
        }
        Err(ImportError::TooMuch { what: "values of MessagePack", limit: MAX_VALUES })
    }

    fn key(&mut self) -> Result<&'a str, ImportError> {
        match self.value()? {
            Value::Leaf(Leaf::Text(Cow::Borrowed(key))) => Ok(key),
            _ => Err(self.expected("a text as key")),
        }
    }

    fn value(&mut self) -> Result<Value<'a>, ImportError> {
        let marker = read_marker(&mut self.rest).map_err(|_| cut_off())?;
        let number = |number| Ok(Value::Leaf(Leaf::Number(number)));
        match marker {
            Marker::FixPos(value) => number(value.into()),
            Marker::FixNeg(value) => number(value.into()),
            Marker::True => number(1.0),
            Marker::False => number(0.0),
            Marker::U8 => number(self.number(RmpRead::read_data_u8)?.into()),
            Marker::U16 => number(self.number(RmpRead::read_data_u16)?.into()),
            Marker::U32 => number(self.number(RmpRead::read_data_u32)?.into()),
            Marker::U64 => number(self.number(RmpRead::read_data_u64)? as f64),
            Marker::I8 => number(self.number(RmpRead::read_data_i8)?.into()),
            Marker::I16 => number(self.number(RmpRead::read_data_i16)?.into()),
            Marker::I32 => number(self.number(RmpRead::read_data_i32)?.into()),
            Marker::I64 => number(self.number(RmpRead::read_data_i64)? as f64),
            Marker::F32 => number(self.number(RmpRead::read_data_f32)?.into()),
            Marker::F64 => number(self.number(RmpRead::read_data_f64)?),
            Marker::FixStr(len) => self.text(len.into()),
            Marker::Str8 | Marker::Str16 | Marker::Str32 => {
                let len = self.length(marker)?;
                self.text(len)
            }
            Marker::Bin8 | Marker::Bin16 | Marker::Bin32 => {
                let len = self.length(marker)?;
                Ok(Value::Leaf(Leaf::Tensor(tensor(self.take(len)?))))
            }
            Marker::FixArray(len) => Ok(Value::Array(len.into())),
            Marker::Array16 | Marker::Array32 => self.length(marker).map(Value::Array),
            Marker::FixMap(len) => Ok(Value::Map(len.into())),
            Marker::Map16 | Marker::Map32 => self.length(marker).map(Value::Map),
            Marker::Null => Ok(Value::Nameless),
            Marker::FixExt1 => self.extension(1),
            Marker::FixExt2 => self.extension(2),
            Marker::FixExt4 => self.extension(4),
            Marker::FixExt8 => self.extension(8),
            Marker::FixExt16 => self.extension(16),
            Marker::Ext8 | Marker::Ext16 | Marker::Ext32 => {
                let len = self.length(marker)?;
                self.extension(len)
            }
            Marker::Reserved => Err(self.expected("a value")),
        }
    }

    /// The length that follows a marker, in as many bytes as the marker says.
    fn length(&mut self, marker: Marker) -> Result<usize, ImportError> {
        let length = match marker {
            Marker::Str8 | Marker::Bin8 | Marker::Ext8 => {
                self.number(RmpRead::read_data_u8)?.into()
            }
            Marker::Str16 | Marker::Bin16 | Marker::Ext16 | Marker::Array16 | Marker::Map16 => {
                self.number(RmpRead::read_data_u16)?.into()
            }
            _ => self.number(RmpRead::read_data_u32)?,
        };
        usize::try_from(length).map_err(|_| cut_off())
    }

    fn number<T, E>(
        &mut self,
        read: impl FnOnce(&mut &'a [u8]) -> Result<T, E>,
    ) -> Result<T, ImportError> {
        read(&mut self.rest).map_err(|_| cut_off())
    }

    fn text(&mut self, len: usize) -> Result<Value<'a>, ImportError> {
        let text = core::str::from_utf8(self.take(len)?);
        let text = text.map_err(|_| self.expected("a text in UTF-8"))?;
        Ok(Value::Leaf(Leaf::Text(Cow::Borrowed(text))))
    }

    fn extension(&mut self, len: usize) -> Result<Value<'a>, ImportError> {
        // A byte for its type.
        self.take(len.saturating_add(1)).map(|_| Value::Nameless)
    }

    fn take(&mut self, len: usize) -> Result<&'a [u8], ImportError> {
        let (taken, rest) = self.rest.split_at_checked(len).ok_or_else(cut_off)?;
        self.rest = rest;
        Ok(taken)
    }

    /// What was read last is not that.
    fn expected(&self, expected: &'static str) -> ImportError {
        ImportError::MessagePack { at: self.bytes.len() - self.rest.len(), expected }
    }
}

fn tensor(bytes: &[u8]) -> Tensor<'_> {
    let numbers = Numbers { element: ElementType::U8, big_endian: false };
    let placement =
        Placement { shape: Vec::from([bytes.len()]), strides: Vec::from([1]), offset: 0 };
    Tensor::new(numbers, placement, Storage::File(bytes)).expect("a byte for every number")
}

fn cut_off() -> ImportError {
    ImportError::CutOff("MessagePack")
}

#[cfg(test)]
mod tests {
    use std::vec;

    use super::*;

    fn names(bytes: &[u8]) -> Result<Vec<String>, ImportError> {
        let tree = read(bytes, Budget::of(bytes.len()))?;
        Ok(tree.iter().map(|(name, _)| String::from(name)).collect())
    }

    #[test]
    fn values_by_name() {
        // {"a": [1, -1, true], "b": {"c": bin 01 02, "d": nil}, "e": 1.5}
        let bytes = [
            &[0x83, 0xa1, b'a', 0x93, 0x01, 0xff, 0xc3, 0xa1, b'b', 0x82, 0xa1, b'c'][..],
            &[0xc4, 0x02, 1, 2, 0xa1, b'd', 0xc0, 0xa1, b'e', 0xca, 0x3f, 0xc0, 0, 0],
        ]
        .concat();
        assert_eq!(names(&bytes).unwrap(), ["a.0", "a.1", "a.2", "b.c", "e"]);
        let tree = read(&bytes, Budget::of(bytes.len())).unwrap();
        assert!(matches!(tree.get("a.1"), Some(Leaf::Number(n)) if *n == -1.0));
        assert!(matches!(tree.get("e"), Some(Leaf::Number(n)) if *n == 1.5));
        let Some(Leaf::Tensor(tensor)) = tree.get("b.c") else { panic!("no tensor") };
        assert_eq!((tensor.shape(), tensor.to_bytes()), (&[2][..], Ok(vec![1, 2])));
        for end in 0..bytes.len() {
            assert_eq!(names(&bytes[..end]), Err(cut_off()), "{end}");
        }
        assert_eq!(names(&[&bytes[..], &[0]].concat()), Err(ImportError::Trailing { bytes: 1 }));
    }

    #[test]
    fn what_is_not_read() {
        // A key that is a number, a key twice, a text that is none, the byte without meaning.
        let expected = |at, expected| Err(ImportError::MessagePack { at, expected });
        assert_eq!(names(&[0x81, 1, 2]), expected(2, "a text as key"));
        assert_eq!(names(&[0x81, 0xa1, 0xff, 1]), expected(3, "a text in UTF-8"));
        assert_eq!(names(&[0x81, 0xa1, b'a', 0xc1]), expected(4, "a value"));
        let twice = names(&[0x82, 0xa1, b'a', 1, 0xa1, b'a', 1]);
        assert_eq!(twice, Err(ImportError::Duplicate(String::from("a"))));
        // A map of maps without end, an array of more than there is.
        let deep = [&[0x81, 0xa1, b'a'][..]; 100].concat();
        assert!(matches!(names(&deep), Err(ImportError::TooMuch { limit: MAX_DEPTH, .. })));
        assert_eq!(names(&[0x81, 0xa1, b'a', 0xdd, 0xff, 0xff, 0xff, 0xff, 0]), Err(cut_off()));
        let many = [&[0x81, 0xa1, b'a', 0xdd, 0, 0x20, 0, 0][..], &vec![0xc0; 2 << 20]].concat();
        assert!(matches!(names(&many), Err(ImportError::TooMuch { limit: MAX_VALUES, .. })));
    }
}
