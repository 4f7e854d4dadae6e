//! The names of the weights.

use core::fmt;

use crate::metadata::field;

/// Which of a field's weights a tensor is: a code, and the number of a level or a layer,
/// from 0. Each kind of field has codes of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TensorName {
    pub(crate) code: u8,
    pub(crate) index: u32,
}

/// What a tensor is to its field, which decides how it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Entries that are looked up; one byte a value in `Precision::I8`.
    Table,
    /// Weights or biases of a network.
    Network,
    /// Constants in f32, whatever the precision.
    Exact,
    /// Whole numbers of two bytes, whatever the precision.
    Index,
}

/// A row of the list that each kind of field keeps of its names.
#[derive(Clone, Copy)]
pub(crate) struct Known {
    pub(crate) code: u8,
    pub(crate) text: &'static str,
    pub(crate) role: Role,
    /// Whether there are several, one for each level or layer.
    pub(crate) several: bool,
}

impl Known {
    /// The weights or the biases of one layer after another.
    pub(crate) const fn layers(code: u8, text: &'static str) -> Self {
        Self { code, text, role: Role::Network, several: true }
    }
}

impl TensorName {
    pub(crate) const fn new(code: u8, index: u32) -> Self {
        Self { code, index }
    }

    /// The name that a file states; `None` if no kind of field in this build has it.
    pub(crate) fn known(code: u8, index: u32) -> Option<Self> {
        let name = Self { code, index };
        let known = field::known(name)?;
        (known.several || index == 0).then_some(name)
    }

    /// What the tensor is to its field.
    #[must_use]
    pub fn role(self) -> Role {
        field::known(self).map_or(Role::Network, |known| known.role)
    }
}

impl fmt::Display for TensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match field::known(*self) {
            Some(known) if matches!(known.role, Role::Exact | Role::Index) => {
                f.write_str(known.text)
            }
            Some(known) => write!(f, "{} {}", known.text, self.index),
            None => write!(f, "of name {} {}", self.code, self.index),
        }
    }
}
