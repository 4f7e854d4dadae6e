//! Checkpoints that other programs wrote, as named tensors.
//!
//! [`Checkpoint::read`] recognises a file by its contents:
//! * what `torch.save` writes, both the zip archive of today and the pickles of
//!   versions before 1.6;
//! * what `numpy.save` writes, an array of numbers or of arrays (the weights that
//!   the original NeRF's TensorFlow code saves);
//! * `.npz`, what `numpy.savez` and `numpy.savez_compressed` write: arrays of numbers, by
//!   the names that they were given there;
//! * `.safetensors`;
//! * MessagePack, what instant-ngp saves (once [`inflate`] has unpacked `.ingp`).
//!
//! Nested dictionaries and lists become dotted names. Tensors stay in the file's bytes
//! until their numbers are read, so optimizer state costs nothing. A pickle is a program:
//! an interpreter with the few instructions that tensors need reads it, calls nothing, and
//! refuses everything else by name. Reading always ends, and uses at most four times the
//! file's size and 64 MB of memory.
//!
//! # Example
//! ```
//! use pocketnerf_formats::import::{Checkpoint, Container};
//!
//! let header = br#"{"layer.weight":{"dtype":"F16","shape":[1,2],"data_offsets":[0,4]}}"#;
//! let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
//! bytes.extend(header);
//! bytes.extend([0x00, 0x3c, 0x00, 0xc0]);
//!
//! let checkpoint = Checkpoint::read(&bytes)?;
//! assert_eq!(checkpoint.container(), Container::Safetensors);
//! assert!(checkpoint.names().eq(["layer.weight"]));
//! let weight = checkpoint.tensor("layer.weight").ok_or("no weight")?;
//! assert_eq!((weight.shape(), weight.to_f32()?), (&[1, 2][..], vec![1.0, -2.0]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod archive;
mod budget;
mod element;
mod error;
mod field_error;
mod inflate;
mod layer;
mod message_pack;
pub mod nerf;
pub mod ngp;
mod npy;
mod npz;
mod pickle;
mod safetensors;
mod settings;
mod tensor;
mod tensors;
mod torch;
mod tree;
pub mod volume;

use core::fmt;

pub use element::ElementType;
pub use error::ImportError;
pub use field_error::FieldError;
pub use inflate::inflate;
pub use tensor::Tensor;

use budget::Budget;
use tree::{Leaf, Tree};

/// A checkpoint's tensors, numbers and texts by name. Borrows the file's bytes.
#[derive(Clone, Debug)]
pub struct Checkpoint<'a> {
    container: Container,
    tree: Tree<'a>,
}

/// The kinds of file that are read.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// A zip archive, as `torch.save` writes since torch 1.6.
    TorchZip,
    /// Pickles and storages one after the other, as `torch.save` wrote before.
    TorchLegacy,
    /// An array, as `numpy.save` writes.
    Numpy,
    /// A zip archive of arrays, as `numpy.savez` writes.
    Npz,
    /// A header in JSON, then the numbers.
    Safetensors,
    /// Nested values, one after another.
    MessagePack,
}

impl fmt::Display for Container {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TorchZip => "torch (zip archive)",
            Self::TorchLegacy => "torch (legacy pickles)",
            Self::Numpy => "numpy",
            Self::Npz => "numpy (zip archive)",
            Self::Safetensors => "safetensors",
            Self::MessagePack => "MessagePack",
        })
    }
}

impl<'a> Checkpoint<'a> {
    /// Reads a file that lies in memory: its structure, that every tensor lies inside
    /// it, and the checksums that a zip archive has. No tensor is decoded, but those of a
    /// compressed `.npz` are unpacked.
    ///
    /// # Errors
    /// What was found and what was expected; see [`ImportError`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, ImportError> {
        let mut budget = Budget::of(bytes.len());
        let (container, tree) = if bytes.starts_with(archive::MAGIC) {
            let entries = archive::entries(bytes, &mut budget)?;
            if npz::is_npz(&entries) && !torch::zip::is_torch(&entries) {
                (Container::Npz, npz::read(&entries, budget)?)
            } else {
                (Container::TorchZip, torch::zip::read(&entries, budget)?)
            }
        } else if bytes.starts_with(npy::MAGIC) {
            (Container::Numpy, npy::read(bytes, budget)?)
        } else if torch::legacy::is_legacy(bytes) {
            (Container::TorchLegacy, torch::legacy::read(bytes, budget)?)
        } else if safetensors::is_safetensors(bytes) {
            (Container::Safetensors, safetensors::read(bytes, budget)?)
        } else if message_pack::is_message_pack(bytes) {
            (Container::MessagePack, message_pack::read(bytes, budget)?)
        } else {
            let mut found = [0; 8];
            found.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
            return Err(ImportError::NotCheckpoint { found });
        };
        Ok(Self { container, tree })
    }

    /// The kind of file.
    #[must_use]
    pub const fn container(&self) -> Container {
        self.container
    }

    /// The names of the tensors in the order of the file: the keys and indices that
    /// lead to one, joined by dots, as `state_dict.layers.0.weight`. A file that is a
    /// single tensor gives it the empty name. What stands under a key that is neither a
    /// text nor an integer has no name. Binary values are tensors of [`ElementType::U8`].
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tree.iter().filter_map(|(name, leaf)| matches!(leaf, Leaf::Tensor(_)).then_some(name))
    }

    /// The tensor of this name.
    #[must_use]
    pub fn tensor(&self, name: &str) -> Option<&Tensor<'a>> {
        match self.tree.get(name) {
            Some(Leaf::Tensor(tensor)) => Some(tensor),
            _ => None,
        }
    }

    /// The number of this name: an integer, a truth value (0 or 1) or a float. Not a
    /// tensor of one number.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.tree.get(name) {
            Some(Leaf::Number(number)) => Some(*number),
            _ => None,
        }
    }

    /// The text of this name.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.tree.get(name) {
            Some(Leaf::Text(text)) => Some(text),
            _ => None,
        }
    }
}
