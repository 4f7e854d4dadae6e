//! What a checkpoint says of itself: numbers and texts by name, each checked.

use core::ops::RangeInclusive;
use std::format;
use std::string::{String, ToString};

use crate::import::{Checkpoint, FieldError, Tensor};

/// A checkpoint and the path of the values to read.
#[derive(Clone, Copy, Debug)]
pub(in crate::import) struct Settings<'c, 'a>(pub(in crate::import) &'c Checkpoint<'a>);

impl<'c, 'a> Settings<'c, 'a> {
    /// A number that has to be there.
    pub(in crate::import) fn number(self, name: &str) -> Result<f64, FieldError> {
        self.0.number(name).ok_or_else(|| FieldError::Missing(name.to_string()))
    }

    /// A whole number, or `default` where there is none.
    pub(in crate::import) fn count(
        self,
        name: &str,
        default: u32,
        range: RangeInclusive<u32>,
    ) -> Result<u32, FieldError> {
        let found = self.0.number(name).unwrap_or(default.into());
        let number = found as u32;
        match f64::from(number) == found && range.contains(&number) {
            true => Ok(number),
            false => {
                let expected = format!("{} to {}", range.start(), range.end());
                Err(setting(name, &found.to_string(), &expected))
            }
        }
    }

    /// A text, or `default` where there is none: one of `known`, in capitals or not.
    pub(in crate::import) fn choice(
        self,
        name: &str,
        default: &'static str,
        known: &[&'static str],
    ) -> Result<&'static str, FieldError> {
        let found = self.0.text(name).unwrap_or(default);
        let choice = known.iter().find(|choice| choice.eq_ignore_ascii_case(found));
        choice.copied().ok_or_else(|| setting(name, found, &known.join(" or ")))
    }

    /// Numbers that are listed under a name, all of them finite; `None` where one is not
    /// there.
    pub(in crate::import) fn vector<const N: usize>(self, name: &str) -> Option<[f32; N]> {
        let mut vector = [0.0; N];
        for (i, value) in vector.iter_mut().enumerate() {
            *value = self.0.number(&format!("{name}.{i}"))? as f32;
        }
        vector.iter().all(|value| value.is_finite()).then_some(vector)
    }

    /// A tensor that has to be there.
    pub(in crate::import) fn tensor(self, name: &str) -> Result<&'c Tensor<'a>, FieldError> {
        self.0.tensor(name).ok_or_else(|| FieldError::Missing(name.to_string()))
    }
}

/// The error of a value that no model has.
pub(in crate::import) fn setting(name: &str, found: &str, expected: &str) -> FieldError {
    let [name, found, expected] = [name, found, expected].map(String::from);
    FieldError::Setting { name, found, expected }
}
