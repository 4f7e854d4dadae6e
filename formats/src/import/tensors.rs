//! The tensors of one network in a checkpoint: each is to be used, once.
use core::ops::RangeInclusive;
use std::collections::BTreeSet;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use super::field_error::FieldError;
use super::layer::Layer;
use super::{Checkpoint, Tensor};

/// The tensors whose names begin alike.
#[derive(Debug)]
pub(in crate::import) struct Tensors<'c, 'a> {
    checkpoint: &'c Checkpoint<'a>,
    prefix: String,
    unused: BTreeSet<&'c str>,
}

impl<'c, 'a> Tensors<'c, 'a> {
    /// `None` where no name begins so. Networks on several devices have `module.` before
    /// every name.
    pub(in crate::import) fn of(checkpoint: &'c Checkpoint<'a>, prefix: &str) -> Option<Self> {
        let under = |prefix: &str| -> BTreeSet<&'c str> {
            checkpoint.names().filter_map(|name| name.strip_prefix(prefix)).collect()
        };
        let several = format!("{prefix}module.");
        let on_several = checkpoint.names().any(|name| name.starts_with(&several));
        let prefix = if on_several { several } else { prefix.to_string() };
        let unused = under(&prefix);
        (!unused.is_empty()).then_some(Self { checkpoint, prefix, unused })
    }

    /// Whether there is a tensor of this name.
    pub(in crate::import) fn has(&self, name: &str) -> bool {
        self.checkpoint.tensor(&format!("{}{name}", self.prefix)).is_some()
    }

    /// How many layers there are whose names differ in their number alone, from `first` on.
    pub(in crate::import) fn count(&self, first: usize, name: impl Fn(usize) -> String) -> usize {
        (first..).take_while(|i| self.has(&format!("{}.weight", name(*i)))).count()
    }

    /// The layer whose weight `[n_out, n_in]` and bias have this name.
    pub(in crate::import) fn layer(&mut self, name: &str) -> Result<Layer, FieldError> {
        let (shape, weight) = self.matrix(&format!("{name}.weight"))?;
        let bias = self.vector(&format!("{name}.bias"), shape[0])?;
        Ok(Layer::transposed(shape, &weight, bias))
    }

    /// The layer without bias whose weight `[n_out, n_in]` has this name.
    pub(in crate::import) fn unbiased(&mut self, name: &str) -> Result<Layer, FieldError> {
        let (shape, weight) = self.matrix(&format!("{name}.weight"))?;
        Ok(Layer::transposed(shape, &weight, Vec::new()))
    }

    /// The numbers of a tensor of any shape.
    pub(in crate::import) fn numbers(&mut self, name: &str) -> Result<Vec<f32>, FieldError> {
        let (name, tensor) = self.take(name)?;
        values(name, tensor)
    }

    /// The one whole number of a tensor.
    pub(in crate::import) fn count_of(
        &mut self,
        name: &str,
        range: RangeInclusive<u32>,
    ) -> Result<u32, FieldError> {
        let numbers = self.numbers(name)?;
        match numbers[..] {
            [number] if number.fract() == 0.0 && range.contains(&(number as u32)) => {
                Ok(number as u32)
            }
            _ => Err(FieldError::Setting {
                name: format!("{}{name}", self.prefix),
                found: format!("{:?}", &numbers[..numbers.len().min(4)]),
                expected: format!("{} to {}", range.start(), range.end()),
            }),
        }
    }

    /// The bytes of a list of them, where there is one.
    pub(in crate::import) fn bytes(&mut self, name: &str) -> Result<Option<Vec<u8>>, FieldError> {
        if !self.has(name) {
            return Ok(None);
        }
        let (name, tensor) = self.take(name)?;
        tensor.to_bytes().map(Some).map_err(|error| FieldError::Tensor(name, error))
    }

    /// The shape of a tensor, where there is one.
    pub(in crate::import) fn shape(&self, name: &str) -> Option<&'c [usize]> {
        self.checkpoint.tensor(&format!("{}{name}", self.prefix)).map(Tensor::shape)
    }

    /// The layer whose weight `[n_in, n_out]` and bias have these names.
    pub(in crate::import) fn pair(
        &mut self,
        weight: &str,
        bias: &str,
    ) -> Result<Layer, FieldError> {
        let (shape, weight) = self.matrix(weight)?;
        let bias = self.vector(bias, shape[1])?;
        Ok(Layer::new(shape, weight, bias))
    }

    /// Tensors that the program saves and does not use.
    pub(in crate::import) fn ignore(&mut self, prefix: &str) {
        self.unused.retain(|name| !name.starts_with(prefix));
    }

    /// Checks that all have been used.
    pub(in crate::import) fn finish(self) -> Result<(), FieldError> {
        let full = |name: &str| format!("{}{name}", self.prefix);
        // A bias alone: its layer was not counted.
        let weight = |name: &&str| Some(format!("{}.weight", name.strip_suffix(".bias")?));
        let alone = self.unused.iter().filter_map(weight).find(|weight| !self.has(weight));
        if let Some(weight) = alone {
            return Err(FieldError::Missing(full(&weight)));
        }
        match self.unused.first() {
            Some(name) => Err(FieldError::Extra(full(name))),
            None => Ok(()),
        }
    }

    fn matrix(&mut self, name: &str) -> Result<([usize; 2], Vec<f32>), FieldError> {
        let (name, tensor) = self.take(name)?;
        let &[rows, columns] = tensor.shape() else {
            return Err(shape(name, tensor, "a matrix".to_string()));
        };
        if rows == 0 || columns == 0 {
            return Err(shape(name, tensor, "a matrix that is not empty".to_string()));
        }
        Ok(([rows, columns], values(name, tensor)?))
    }

    fn vector(&mut self, name: &str, len: usize) -> Result<Vec<f32>, FieldError> {
        let (name, tensor) = self.take(name)?;
        if tensor.shape() != [len] {
            return Err(shape(name, tensor, format!("[{len}]")));
        }
        values(name, tensor)
    }

    /// The tensor of this name, and its full name.
    pub(in crate::import) fn take(
        &mut self,
        name: &str,
    ) -> Result<(String, &'c Tensor<'a>), FieldError> {
        let full = format!("{}{name}", self.prefix);
        self.unused.remove(name);
        match self.checkpoint.tensor(&full) {
            Some(tensor) => Ok((full, tensor)),
            None => Err(FieldError::Missing(full)),
        }
    }
}

/// The error of a tensor of another shape.
pub(in crate::import) fn shape(name: String, tensor: &Tensor<'_>, expected: String) -> FieldError {
    FieldError::Shape { name, found: tensor.shape().to_vec(), expected }
}

/// The numbers of a tensor, all of them finite.
pub(in crate::import) fn values(
    name: impl Into<String>,
    tensor: &Tensor<'_>,
) -> Result<Vec<f32>, FieldError> {
    let name = name.into();
    match tensor.to_f32() {
        Err(error) => Err(FieldError::Tensor(name, error)),
        Ok(values) if values.iter().all(|value| value.is_finite()) => Ok(values),
        Ok(_) => Err(FieldError::NotFinite(name)),
    }
}
