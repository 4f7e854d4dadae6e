//! What can be wrong with a checkpoint, as values.

use core::fmt;
use std::boxed::Box;
use std::string::String;

use super::element::ElementType;

/// Why a checkpoint was refused: what was found and what was expected.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImportError {
    /// The first bytes are those of no container that is read.
    NotCheckpoint {
        /// The first eight bytes; zeros where the file is shorter.
        found: [u8; 8],
    },
    /// This part of the file ends before it is complete.
    CutOff(&'static str),
    /// This part of the file holds more than is read.
    TooMuch {
        /// The part, and what there is too much of.
        what: &'static str,
        /// The most that is read.
        limit: usize,
    },
    /// Bytes follow the end of the checkpoint.
    Trailing {
        /// How many.
        bytes: usize,
    },
    /// The zip archive's structure cannot be read, in the words of its reader.
    Archive(String),
    /// The compressed file cannot be unpacked, in the words of its reader.
    Inflate(String),
    /// What begins here is not what MessagePack has in its place.
    MessagePack {
        /// Where it stands in the file.
        at: usize,
        /// What was expected.
        expected: &'static str,
    },
    /// An entry of the zip archive is compressed or encrypted.
    Packed {
        /// The entry.
        entry: String,
    },
    /// An entry of the zip archive is damaged.
    Checksum {
        /// The entry.
        entry: String,
        /// CRC-32 in the archive.
        expected: u32,
        /// CRC-32 of the bytes.
        found: u32,
    },
    /// An entry of the zip archive is no array that can be read.
    Entry {
        /// The entry.
        entry: String,
        /// What is wrong with it.
        error: Box<Self>,
    },
    /// An entry that the checkpoint needs is not in the file.
    MissingEntry(String),
    /// An entry, a storage or a path occurs twice.
    Duplicate(String),
    /// The order of bytes that the checkpoint states is neither little nor big.
    ByteOrder(String),
    /// The pickle calls something that no tensor needs.
    Call(String),
    /// The pickle holds an instruction that no checkpoint needs.
    Opcode {
        /// The instruction.
        found: u8,
        /// Where it stands in the file or the entry.
        at: usize,
    },
    /// The pickle says one thing where another has to be.
    Pickle {
        /// Where the instruction stands in the file or the entry.
        at: usize,
        /// What has to be there.
        expected: &'static str,
    },
    /// A header cannot be read.
    Header {
        /// Which.
        header: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// Numbers of a type that is not read.
    ElementType(String),
    /// A storage is not as long as its tensors say.
    Storage {
        /// The storage's key.
        key: String,
        /// Bytes that are needed.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// A tensor's shape, strides and offset do not fit its storage.
    Tensor {
        /// The tensor.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A tensor of bytes was expected.
    NotBytes(ElementType),
}

/// A text from a file, made fit for one line.
pub(super) fn shown(text: &str) -> String {
    const MOST: usize = 160;
    let mut line: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    if text.chars().nth(MOST).is_some() {
        line.push('…');
    }
    line
}

impl core::error::Error for ImportError {}

impl fmt::Display for ImportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCheckpoint { found } => {
                write!(f, "not a checkpoint that can be read: begins with")?;
                found.iter().try_for_each(|byte| write!(f, " {byte:02x}"))?;
                write!(
                    f,
                    ", expected what torch.save, numpy.save, safetensors or instant-ngp write"
                )
            }
            Self::CutOff(part) => write!(f, "{part} ends too early: the file is cut off"),
            Self::TooMuch { what, limit } => write!(f, "{what}: more than {limit}, the most read"),
            Self::Trailing { bytes } => {
                write!(f, "{bytes} bytes after the end of the checkpoint, where none were expected")
            }
            Self::Archive(problem) => write!(f, "the zip archive cannot be read: {problem}"),
            Self::Inflate(problem) => {
                write!(f, "the compressed file cannot be unpacked: {problem}")
            }
            Self::MessagePack { at, expected } => {
                write!(f, "MessagePack, byte {at}: expected {expected}")
            }
            Self::Packed { entry } => write!(
                f,
                "the entry {entry} is compressed or encrypted, where torch.save stores: refused"
            ),
            Self::Checksum { entry, expected, found } => write!(
                f,
                "the entry {entry}: checksum {found:#010x} where {expected:#010x} was expected: \
                 the file is damaged"
            ),
            Self::Entry { entry, error } => write!(f, "the entry {entry}: {error}"),
            Self::MissingEntry(entry) => write!(f, "{entry}: not in the file"),
            Self::Duplicate(name) => write!(f, "{name}: occurs twice"),
            Self::ByteOrder(found) => {
                write!(f, "byte order {found} where little or big was expected")
            }
            Self::Call(name) => {
                write!(f, "the pickle calls {name}, which no tensor needs: refused")
            }
            Self::Opcode { found, at } => write!(
                f,
                "the pickle's byte {at}: instruction {found:#04x}, which no checkpoint needs: \
                 refused"
            ),
            Self::Pickle { at, expected } => {
                write!(f, "the pickle's byte {at}: expected {expected}")
            }
            Self::Header { header, problem } => write!(f, "{header}: {problem}"),
            Self::ElementType(found) => write!(f, "values of type {found} are not read"),
            Self::Storage { key, expected, found } => {
                write!(f, "storage {key}: {found} bytes where {expected} were expected")
            }
            Self::Tensor { name, problem } if name.is_empty() => write!(f, "the tensor: {problem}"),
            Self::Tensor { name, problem } => write!(f, "tensor {name}: {problem}"),
            Self::NotBytes(element) => {
                write!(f, "values of type {element} where bytes were expected")
            }
        }
    }
}
