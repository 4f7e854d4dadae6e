//! From nested values to names.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::string::String;
use std::vec::Vec;

use super::numpy::bytes_of;
use super::value::{NumpyArray, NumpyKind, NumpyType, Object, TorchTensor, Value};
use super::{Pickle, TorchStorage};
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::import::error::shown;
use crate::import::tensor::{Numbers, Placement, Storage, Tensor};
use crate::import::tree::{Leaf, Tree};

/// Most names. A value that is shared has one for every way that leads to it, so a
/// short pickle can have more of them than there are atoms.
const MAX_NAMES: usize = 1_000_000;
/// Most levels. A value that holds itself has no end of them.
const MAX_DEPTH: usize = 64;

/// A container that is being walked through.
struct Level {
    object: usize,
    next: usize,
    /// Bytes of the container's own name.
    path_bytes: usize,
}

impl<'a> Pickle<'a> {
    /// Everything that can be named. `find` gives the bytes of a torch storage.
    pub(in crate::import) fn flatten(
        &self,
        budget: &mut Budget,
        big_endian: bool,
        find: impl Fn(&TorchStorage<'a>) -> Result<&'a [u8], ImportError>,
    ) -> Result<Tree<'a>, ImportError> {
        let mut leaves = Vec::new();
        let mut levels: Vec<Level> = Vec::new();
        let mut path = String::new();
        let mut visit = Some(self.root);
        loop {
            if let Some(value) = visit.take() {
                // What is passed over takes time as well, and so does looking up a key.
                budget.spend_on::<(String, Leaf<'_>, usize)>(1)?;
                budget.spend(path.len() + self.key_bytes(value))?;
                match value {
                    Value::Object(object) if self.is_container(object) => {
                        if levels.len() == MAX_DEPTH {
                            let what = "levels of the pickle, or it holds itself";
                            return Err(ImportError::TooMuch { what, limit: MAX_DEPTH });
                        }
                        levels.push(Level { object, next: 0, path_bytes: path.len() });
                    }
                    value => {
                        let leaf = self.leaf(value, &path, big_endian, &find)?;
                        if let Some(Leaf::Tensor(tensor)) = &leaf {
                            budget.spend_on::<[usize; 2]>(tensor.shape().len())?;
                        }
                        leaves.extend(leaf.map(|leaf| (path.clone(), leaf)));
                    }
                }
                if leaves.len() > MAX_NAMES {
                    let what = "names in the pickle";
                    return Err(ImportError::TooMuch { what, limit: MAX_NAMES });
                }
            }
            let Some(level) = levels.last_mut() else { return Tree::new(leaves) };
            path.truncate(level.path_bytes);
            match self.child(level.object, level.next) {
                Some((key, value)) => {
                    level.next += 1;
                    visit = extend(&mut path, key).then_some(value);
                }
                None => {
                    levels.pop();
                }
            }
        }
    }

    /// The length of the key that a tensor's storage is looked up by.
    fn key_bytes(&self, value: Value<'a>) -> usize {
        let Value::Object(index) = value else { return 0 };
        let Object::Tensor(tensor) = &self.objects[index] else { return 0 };
        match &self.objects[tensor.storage] {
            Object::Storage(storage) => storage.key.len(),
            _ => 0,
        }
    }

    fn is_container(&self, object: usize) -> bool {
        matches!(self.objects[object], Object::Sequence(_) | Object::Dict(_) | Object::Namespace(_))
    }

    /// The key and the value at a position in a container.
    fn child(&self, object: usize, at: usize) -> Option<(Value<'a>, Value<'a>)> {
        match &self.objects[object] {
            Object::Sequence(items) => {
                items.get(at).map(|item| (Value::Int(i64::try_from(at).unwrap_or(i64::MAX)), *item))
            }
            Object::Dict(pairs) | Object::Namespace(pairs) => pairs.get(at).copied(),
            _ => None,
        }
    }

    /// The leaf that a value becomes; `None` if it has no counterpart.
    fn leaf(
        &self,
        value: Value<'a>,
        path: &str,
        big_endian: bool,
        find: &impl Fn(&TorchStorage<'a>) -> Result<&'a [u8], ImportError>,
    ) -> Result<Option<Leaf<'a>>, ImportError> {
        let tensor = match value {
            Value::Bool(truth) => return Ok(Some(Leaf::Number(f64::from(u8::from(truth))))),
            Value::Int(number) => return Ok(Some(Leaf::Number(number as f64))),
            Value::Float(number) => return Ok(Some(Leaf::Number(number))),
            Value::Text(text) => return Ok(Some(Leaf::Text(Cow::Borrowed(text)))),
            Value::None | Value::Bytes(_) => return Ok(None),
            Value::Object(index) => match &self.objects[index] {
                Object::Tensor(tensor) => self.torch_tensor(tensor, big_endian, find)?,
                Object::Array(array) => self.numpy_array(array),
                _ => return Ok(None),
            },
        };
        let named = |problem| ImportError::Tensor { name: shown(path), problem };
        tensor.map(Leaf::Tensor).map(Some).map_err(named)
    }

    fn torch_tensor(
        &self,
        tensor: &TorchTensor,
        big_endian: bool,
        find: &impl Fn(&TorchStorage<'a>) -> Result<&'a [u8], ImportError>,
    ) -> Result<Result<Tensor<'a>, &'static str>, ImportError> {
        let Object::Storage(storage) = &self.objects[tensor.storage] else {
            return Ok(Err("its storage is none"));
        };
        let numbers = Numbers { element: tensor.element, big_endian };
        Ok(Tensor::new(numbers, tensor.placement.clone(), Storage::File(find(storage)?)))
    }

    fn numpy_array(&self, array: &NumpyArray<'a>) -> Result<Tensor<'a>, &'static str> {
        let NumpyType { kind: NumpyKind::Number(element), big_endian } = array.numbers else {
            return Err("its type is not one of numbers");
        };
        let placement = Placement::contiguous(&array.shape, array.fortran)
            .ok_or("its shape has more numbers than can be counted")?;
        let storage = bytes_of(array.bytes, &self.objects).ok_or("its contents are not bytes")?;
        Tensor::new(Numbers { element, big_endian }, placement, storage)
    }
}

/// Adds a key to the name of its container, where the key can be part of a name.
fn extend(path: &mut String, key: Value<'_>) -> bool {
    if !path.is_empty() {
        path.push('.');
    }
    match key {
        Value::Text(key) => path.push_str(key),
        Value::Int(key) => return write!(path, "{key}").is_ok(),
        _ => return false,
    }
    true
}
