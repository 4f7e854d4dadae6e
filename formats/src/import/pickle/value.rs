//! What a pickle makes.

use std::sync::Arc;
use std::vec::Vec;

use crate::import::element::ElementType;
use crate::import::tensor::Placement;

/// A value on the machine's stack. What is larger than a few words lies in the
/// machine's list of objects, where any number of values can share it.
#[derive(Clone, Copy, Debug)]
pub(in crate::import) enum Value<'a> {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(&'a str),
    Bytes(&'a [u8]),
    /// An index of the list.
    Object(usize),
}

/// Something that values share.
#[derive(Debug)]
pub(in crate::import) enum Object<'a> {
    /// A list, a tuple or a set.
    Sequence(Vec<Value<'a>>),
    Dict(Vec<(Value<'a>, Value<'a>)>),
    /// A plain object, whose attributes are a dictionary.
    Namespace(Vec<(Value<'a>, Value<'a>)>),
    /// Bytes that the pickle held as a text.
    Decoded(Arc<[u8]>),
    /// The name of a function or a class.
    Global {
        module: &'a str,
        name: &'a str,
    },
    Storage(TorchStorage<'a>),
    Tensor(TorchTensor),
    NumpyType(NumpyType),
    /// An array that has not been filled yet.
    EmptyArray,
    Array(NumpyArray<'a>),
    /// Something harmless that holds no tensors.
    Opaque,
}

/// What torch says of a storage where a tensor refers to it.
#[derive(Clone, Copy, Debug)]
pub(in crate::import) struct TorchStorage<'a> {
    pub(in crate::import) key: &'a str,
    /// `None` for bytes that their tensors give a type.
    pub(in crate::import) element: Option<ElementType>,
    /// How many numbers it has.
    pub(in crate::import) len: usize,
    /// The numbers of the file's storage that are this one's, from the first on;
    /// `None` for all of them.
    pub(in crate::import) view: Option<(usize, usize)>,
}

impl TorchStorage<'_> {
    /// Bytes of a number.
    pub(in crate::import) fn element_size(&self) -> usize {
        self.element.map_or(1, ElementType::size)
    }
}

/// A tensor in a torch storage.
#[derive(Clone, Debug)]
pub(in crate::import) struct TorchTensor {
    /// The index of the storage in the list of objects.
    pub(in crate::import) storage: usize,
    pub(in crate::import) element: ElementType,
    pub(in crate::import) placement: Placement,
}

/// A type that numpy names.
#[derive(Clone, Copy, Debug)]
pub(in crate::import) struct NumpyType {
    pub(in crate::import) kind: NumpyKind,
    pub(in crate::import) big_endian: bool,
}

/// What an array's cells are.
#[derive(Clone, Copy, Debug)]
pub(in crate::import) enum NumpyKind {
    Number(ElementType),
    /// Values of any kind.
    Object,
    /// Texts, dates, complex numbers and the like.
    Other,
}

impl NumpyType {
    /// From `<f4`, `f8`, `|O` and the like.
    pub(in crate::import) fn parse(text: &str) -> Self {
        use ElementType::{Bool, F16, F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let kind = match text.trim_start_matches(['<', '>', '|', '=']) {
            "b1" | "?" | "bool" => NumpyKind::Number(Bool),
            "u1" | "uint8" => NumpyKind::Number(U8),
            "u2" | "uint16" => NumpyKind::Number(U16),
            "u4" | "uint32" => NumpyKind::Number(U32),
            "u8" | "uint64" => NumpyKind::Number(U64),
            "i1" | "int8" => NumpyKind::Number(I8),
            "i2" | "int16" => NumpyKind::Number(I16),
            "i4" | "int32" => NumpyKind::Number(I32),
            "i8" | "int64" => NumpyKind::Number(I64),
            "f2" | "float16" => NumpyKind::Number(F16),
            "f4" | "float32" => NumpyKind::Number(F32),
            "f8" | "float64" => NumpyKind::Number(F64),
            "O" | "O4" | "O8" => NumpyKind::Object,
            _ => NumpyKind::Other,
        };
        Self { kind, big_endian: text.starts_with('>') }
    }
}

/// An array of numbers, its bytes given in the pickle itself. One of objects becomes
/// a [`Object::Sequence`].
#[derive(Clone, Debug)]
pub(in crate::import) struct NumpyArray<'a> {
    pub(in crate::import) numbers: NumpyType,
    pub(in crate::import) shape: Vec<usize>,
    pub(in crate::import) fortran: bool,
    pub(in crate::import) bytes: Value<'a>,
}
