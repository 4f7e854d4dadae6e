//! What a pickle may call, by its Python name.

use crate::import::element::ElementType;

/// A call that is understood, and what it makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Known {
    /// A dictionary of some kind: empty, a copy of another, or of pairs.
    Dict,
    /// A plain object that is filled later.
    Namespace,
    /// A sequence of what another one holds.
    Sequence,
    /// Something harmless without tensors.
    Opaque,
    /// Bytes, from a text whose letters stand for them.
    Encode,
    /// A tensor, from its storage, offset, shape, strides.
    Tensor,
    /// The same, with its type after two more arguments.
    TypedTensor,
    /// The first argument.
    Itself,
    /// Bytes, from bytes or nothing.
    Bytes,
    /// A numpy type, from its name.
    NumpyType,
    /// An array that is filled later.
    Array,
    /// An array, from bytes, type, shape, order.
    ArrayOfBytes,
    /// A single number, from type and bytes.
    Scalar,
}

/// What a name calls; `None` for what is refused.
pub(super) fn known(module: &str, name: &str) -> Option<Known> {
    Some(match (module, name) {
        ("collections", "OrderedDict" | "defaultdict" | "Counter")
        | ("builtins" | "__builtin__", "dict")
        | (
            "pytorch_lightning.utilities.parsing"
            | "lightning_fabric.utilities.data"
            | "lightning.fabric.utilities.data",
            "AttributeDict",
        ) => Known::Dict,
        ("argparse", "Namespace") => Known::Namespace,
        ("builtins" | "__builtin__", "list" | "tuple" | "set" | "frozenset")
        | ("torch", "Size") => Known::Sequence,
        ("torch", "device")
        | ("pathlib", "PosixPath" | "WindowsPath" | "PurePosixPath" | "PureWindowsPath") => {
            Known::Opaque
        }
        ("builtins" | "__builtin__", "bytes" | "bytearray") => Known::Bytes,
        ("_codecs", "encode") => Known::Encode,
        ("torch._utils", "_rebuild_tensor" | "_rebuild_tensor_v2") => Known::Tensor,
        ("torch._utils", "_rebuild_tensor_v3") => Known::TypedTensor,
        ("torch._utils", "_rebuild_parameter") => Known::Itself,
        ("numpy", "dtype") => Known::NumpyType,
        ("numpy.core.multiarray" | "numpy._core.multiarray", "_reconstruct") => Known::Array,
        ("numpy.core.multiarray" | "numpy._core.multiarray", "scalar") => Known::Scalar,
        ("numpy.core.numeric" | "numpy._core.numeric", "_frombuffer") => Known::ArrayOfBytes,
        _ => return None,
    })
}

/// The numbers of a class of storage: `Some(None)` where their tensors say it, `None`
/// where they are of a type that is not read.
pub(super) fn storage_element(module: &str, name: &str) -> Option<Option<ElementType>> {
    if !matches!(module, "torch" | "torch.cuda" | "torch.storage") {
        return None;
    }
    Some(Some(match name {
        "UntypedStorage" => return Some(None),
        "BoolStorage" => ElementType::Bool,
        "ByteStorage" => ElementType::U8,
        "CharStorage" => ElementType::I8,
        "ShortStorage" => ElementType::I16,
        "IntStorage" => ElementType::I32,
        "LongStorage" => ElementType::I64,
        "HalfStorage" => ElementType::F16,
        "BFloat16Storage" => ElementType::Bf16,
        "FloatStorage" => ElementType::F32,
        "DoubleStorage" => ElementType::F64,
        _ => return None,
    }))
}

/// The type that torch calls by this name.
pub(super) fn torch_element(module: &str, name: &str) -> Option<ElementType> {
    if module != "torch" {
        return None;
    }
    Some(match name {
        "bool" => ElementType::Bool,
        "uint8" => ElementType::U8,
        "uint16" => ElementType::U16,
        "uint32" => ElementType::U32,
        "uint64" => ElementType::U64,
        "int8" => ElementType::I8,
        "int16" => ElementType::I16,
        "int32" => ElementType::I32,
        "int64" => ElementType::I64,
        "float16" => ElementType::F16,
        "bfloat16" => ElementType::Bf16,
        "float32" => ElementType::F32,
        "float64" => ElementType::F64,
        _ => return None,
    })
}
