//! Pickles, read and never run.
//!
//! A pickle is a program for a small stack machine, which can call any function of
//! Python. Here the stack is real and the calls are not: a call that tensors need is
//! replaced by a note of what it would make, any other is refused by name. A name that
//! is mentioned and not called is harmless, and is passed over.

mod calls;
mod flatten;
mod globals;
mod literals;
mod machine;
mod numpy;
mod opcodes;
mod source;
mod value;

use std::format;
use std::string::String;
use std::vec::Vec;

pub(super) use value::{NumpyKind, NumpyType, TorchStorage};

use super::ImportError;
use super::budget::Budget;
use super::error::shown;
use machine::Machine;
use source::Source;
use value::{Object, Value};

/// What a pickle made.
#[derive(Debug)]
pub(super) struct Pickle<'a> {
    root: Value<'a>,
    objects: Vec<Object<'a>>,
    /// Where the bytes after it begin.
    pub(super) end: usize,
}

/// Reads the pickle that begins at `at`.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    at: usize,
    budget: &mut Budget,
) -> Result<Pickle<'a>, ImportError> {
    let mut machine = Machine::new(Source::new(bytes, at), budget);
    let root = machine.run()?;
    Ok(Pickle { root, end: machine.source.at(), objects: machine.objects })
}

impl<'a> Pickle<'a> {
    /// Every mention of a torch storage.
    pub(super) fn storages(&self) -> impl Iterator<Item = &TorchStorage<'a>> {
        self.objects.iter().filter_map(|object| match object {
            Object::Storage(storage) => Some(storage),
            _ => None,
        })
    }

    /// The integer of a pickle that is one.
    pub(super) fn integer(&self) -> Option<i64> {
        match self.root {
            Value::Int(integer) => Some(integer),
            _ => None,
        }
    }

    /// The texts of a pickle that is a list of texts.
    pub(super) fn texts(&self) -> Option<Vec<&'a str>> {
        let Value::Object(index) = self.root else { return None };
        let Object::Sequence(items) = &self.objects[index] else { return None };
        let text = |item: &Value<'a>| match item {
            Value::Text(text) => Some(*text),
            _ => None,
        };
        items.iter().map(text).collect()
    }
}

fn shown_name(module: &str, name: &str) -> String {
    format!("{}.{}", shown(module), shown(name))
}
