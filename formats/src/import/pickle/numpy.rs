//! Arrays of numpy inside a pickle.

use super::machine::Machine;
use super::value::{NumpyArray, NumpyKind, NumpyType, Object, Value};
use crate::import::ImportError;
use crate::import::tensor::{Numbers, Placement, Storage, Tensor};

impl<'a> Machine<'a, '_> {
    /// From what `ndarray.__setstate__` is given: a version (left out by the oldest),
    /// shape, type, whether in Fortran's order, and the contents.
    pub(super) fn array_of_state(&mut self, state: Value<'a>) -> Result<Object<'a>, ImportError> {
        let fields = match self.object(state) {
            Some(Object::Sequence(fields)) => match fields[..] {
                [_, shape, numbers, fortran, contents] | [shape, numbers, fortran, contents] => {
                    Some((shape, numbers, fortran, contents))
                }
                _ => None,
            },
            _ => None,
        };
        let (shape, numbers, fortran, contents) =
            fields.ok_or_else(|| self.expected("the state of a numpy array"))?;
        self.array(shape, numbers, fortran, contents)
    }

    pub(super) fn array(
        &mut self,
        shape: Value<'a>,
        numbers: Value<'a>,
        fortran: Value<'a>,
        contents: Value<'a>,
    ) -> Result<Object<'a>, ImportError> {
        let Some(&Object::NumpyType(numbers)) = self.object(numbers) else {
            return Err(self.expected("the type of a numpy array"));
        };
        let shape = self.indices(shape)?;
        let fortran = match fortran {
            Value::Bool(fortran) => fortran,
            Value::Int(fortran) => fortran != 0,
            _ => return Err(self.expected("whether a numpy array is in Fortran's order")),
        };
        match numbers.kind {
            NumpyKind::Number(_) => {
                Ok(Object::Array(NumpyArray { numbers, shape, fortran, bytes: contents }))
            }
            NumpyKind::Object => {
                let items = self.items(contents)?;
                let len = shape.iter().try_fold(1_usize, |len, n| len.checked_mul(*n));
                if len != Some(items.len()) || (fortran && shape.len() > 1) {
                    return Err(self.expected("as many objects as a numpy array's shape, in order"));
                }
                Ok(Object::Sequence(items))
            }
            NumpyKind::Other => Ok(Object::Opaque),
        }
    }

    /// A single number.
    pub(super) fn scalar(
        &mut self,
        numbers: Value<'a>,
        contents: Value<'a>,
    ) -> Result<Value<'a>, ImportError> {
        let Some(&Object::NumpyType(numbers)) = self.object(numbers) else {
            return Err(self.expected("the type of a numpy number"));
        };
        let NumpyType { kind: NumpyKind::Number(element), big_endian } = numbers else {
            return self.make(Object::Opaque);
        };
        let number = || {
            let placement = Placement::contiguous(&[], false)?;
            let storage = bytes_of(contents, &self.objects)?;
            Tensor::new(Numbers { element, big_endian }, placement, storage).ok()?.number()
        };
        number().map(Value::Float).ok_or_else(|| self.expected("the bytes of a numpy number"))
    }
}

/// The bytes that a value holds. Python 2 has texts for them.
pub(super) fn bytes_of<'a>(value: Value<'a>, objects: &[Object<'a>]) -> Option<Storage<'a>> {
    match value {
        Value::Bytes(bytes) => Some(Storage::File(bytes)),
        Value::Text(text) => Some(Storage::File(text.as_bytes())),
        Value::Object(index) => match objects.get(index) {
            Some(Object::Decoded(bytes)) => Some(Storage::Decoded(bytes.clone())),
            _ => None,
        },
        _ => None,
    }
}
