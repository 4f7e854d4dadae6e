//! The calls that a pickle makes, of which none is made: what is known of the outcome
//! is noted.

use std::sync::Arc;
use std::vec::Vec;

use super::globals::{Known, known, storage_element, torch_element};
use super::machine::Machine;
use super::value::{NumpyType, Object, TorchStorage, TorchTensor, Value};
use crate::import::ImportError;
use crate::import::element::ElementType;
use crate::import::tensor::Placement;

impl<'a> Machine<'a, '_> {
    /// What calling `callee` would make.
    pub(super) fn call(
        &mut self,
        callee: Value<'a>,
        arguments: Value<'a>,
    ) -> Result<Value<'a>, ImportError> {
        let known = match self.object(callee) {
            Some(Object::Global { module, name }) => known(module, name),
            _ => None,
        };
        let Some(known) = known else { return Err(self.refuse_call(callee)) };
        let Some(Object::Sequence(arguments)) = self.object(arguments) else {
            return Err(self.expected("arguments for the call"));
        };
        // No call that is understood has more.
        let mut few = [Value::None; 8];
        few.iter_mut().zip(arguments).for_each(|(to, from)| *to = *from);
        let is_empty = arguments.is_empty();
        let last = arguments.last().copied().unwrap_or(Value::None);
        let object = match known {
            Known::Dict => Object::Dict(self.pairs(last)?),
            Known::Namespace => Object::Namespace(Vec::new()),
            Known::Sequence => Object::Sequence(self.items(few[0])?),
            Known::Opaque => Object::Opaque,
            Known::Encode => self.encode(few[0], few[1])?,
            Known::Tensor => self.tensor(few, None)?,
            Known::TypedTensor => {
                let named = match self.object(few[6]) {
                    Some(Object::Global { module, name }) => torch_element(module, name),
                    _ => None,
                };
                let element = named.ok_or_else(|| self.expected("a tensor's type"))?;
                self.tensor(few, Some(element))?
            }
            Known::Itself => return Ok(few[0]),
            Known::Bytes if is_empty => return Ok(Value::Bytes(&[])),
            Known::Bytes => return Ok(few[0]),
            Known::NumpyType => match few[0] {
                Value::Text(name) => Object::NumpyType(NumpyType::parse(name)),
                _ => return Err(self.expected("the name of a numpy type")),
            },
            Known::Array => Object::EmptyArray,
            Known::ArrayOfBytes => {
                let order = matches!(few[3], Value::Text("F"));
                self.array(few[2], few[1], Value::Bool(order), few[0])?
            }
            Known::Scalar => return self.scalar(few[0], few[1]),
        };
        self.make(object)
    }

    /// Gives a value its state.
    pub(super) fn build(&mut self, target: Value<'a>, state: Value<'a>) -> Result<(), ImportError> {
        let Value::Object(index) = target else { return Err(self.expected("something to build")) };
        let built = match &self.objects[index] {
            Object::Namespace(_) => Object::Namespace(self.pairs(state)?),
            Object::EmptyArray => self.array_of_state(state)?,
            Object::NumpyType(numpy) => {
                let order = match self.object(state) {
                    Some(Object::Sequence(fields)) => fields.get(1).copied(),
                    _ => None,
                };
                let big_endian = matches!(order, Some(Value::Text(">") | Value::Bytes(b">")));
                Object::NumpyType(NumpyType { big_endian, ..*numpy })
            }
            // Notes beside a dictionary's items, such as a state dict's versions.
            Object::Dict(_) | Object::Opaque => return Ok(()),
            Object::Global { .. } => return Err(self.refuse_call(target)),
            _ => return Err(self.expected("something that has a state")),
        };
        self.objects[index] = built;
        Ok(())
    }

    /// What torch keeps outside the pickle, from the tuple that names it.
    pub(super) fn storage(&mut self, id: Value<'a>) -> Result<TorchStorage<'a>, ImportError> {
        let expected = || self.expected("the name of a torch storage");
        let Some(Object::Sequence(id)) = self.object(id) else { return Err(expected()) };
        let &[Value::Text("storage"), class, Value::Text(key), _, len, ref rest @ ..] = &id[..]
        else {
            return Err(expected());
        };
        let Some(Object::Global { module, name }) = self.object(class) else {
            return Err(expected());
        };
        let element = storage_element(module, name)
            .ok_or_else(|| ImportError::ElementType(super::shown_name(module, name)))?;
        let view = match rest.first().and_then(|view| self.object(*view)) {
            Some(Object::Sequence(view)) => match view[..] {
                [_, offset, len] => Some((self.index(offset)?, self.index(len)?)),
                _ => return Err(expected()),
            },
            _ => None,
        };
        let storage = TorchStorage { key, element, len: self.index(len)?, view };
        // Looking a long key up takes time, whenever it is mentioned.
        self.budget.spend(key.len())?;
        Ok(storage)
    }

    fn tensor(
        &mut self,
        [storage, offset, shape, strides, ..]: [Value<'a>; 8],
        element: Option<ElementType>,
    ) -> Result<Object<'a>, ImportError> {
        let (Value::Object(index), Some(Object::Storage(of))) = (storage, self.object(storage))
        else {
            return Err(self.expected("a tensor's storage"));
        };
        let element = element.or(of.element).ok_or_else(|| self.expected("a tensor's type"))?;
        let placement = Placement {
            offset: self.index(offset)?,
            shape: self.indices(shape)?,
            strides: self.indices(strides)?,
        };
        Ok(Object::Tensor(TorchTensor { storage: index, element, placement }))
    }

    /// Bytes that protocol 2, which has none, writes as a text of Latin-1.
    fn encode(&mut self, text: Value<'a>, coding: Value<'a>) -> Result<Object<'a>, ImportError> {
        let (Value::Text(text), Value::Text("latin1" | "latin-1")) = (text, coding) else {
            return Err(self.expected("a text to encode as latin1"));
        };
        self.budget.spend(2 * text.len())?;
        let bytes: Option<Arc<[u8]>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
        bytes.map(Object::Decoded).ok_or_else(|| self.expected("letters of latin1"))
    }

    /// A dictionary's items; those of nothing, or of a class (the default's), are none.
    fn pairs(&mut self, from: Value<'a>) -> Result<Vec<(Value<'a>, Value<'a>)>, ImportError> {
        let copied = match self.object(from) {
            None | Some(Object::Global { .. }) => return Ok(Vec::new()),
            Some(Object::Dict(pairs)) => pairs.clone(),
            Some(Object::Sequence(items)) => {
                let pair = |item: &Value<'a>| match self.object(*item) {
                    Some(Object::Sequence(pair)) => match pair[..] {
                        [key, value] => Some((key, value)),
                        _ => None,
                    },
                    _ => None,
                };
                let pairs: Option<Vec<_>> = items.iter().map(pair).collect();
                pairs.ok_or_else(|| self.expected("pairs of keys and values"))?
            }
            Some(_) => return Err(self.expected("a dictionary")),
        };
        self.budget.spend_on::<(Value<'_>, Value<'_>)>(copied.len())?;
        Ok(copied)
    }

    /// A sequence's items; those of nothing are none.
    pub(super) fn items(&mut self, from: Value<'a>) -> Result<Vec<Value<'a>>, ImportError> {
        match self.object(from) {
            None => Ok(Vec::new()),
            Some(Object::Sequence(items)) => {
                let copied = items.clone();
                self.budget.spend_on::<Value<'_>>(copied.len())?;
                Ok(copied)
            }
            Some(_) => Err(self.expected("a sequence")),
        }
    }

    /// An index, a length or a stride.
    pub(super) fn index(&self, value: Value<'a>) -> Result<usize, ImportError> {
        let index = match value {
            Value::Int(index) => usize::try_from(index).ok(),
            _ => None,
        };
        index.ok_or_else(|| self.expected("an integer that is not negative"))
    }

    pub(super) fn indices(&mut self, values: Value<'a>) -> Result<Vec<usize>, ImportError> {
        let values = self.items(values)?;
        values.iter().map(|value| self.index(*value)).collect()
    }
}
