//! What the page gives to a GPU.

use alloc::string::String;

use pocketnerf_core::{Error, Model, RenderOptions};
use pocketnerf_gpu::{pack::Packed, shader};

/// The program that renders a model on a GPU, and the model as it reads it.
#[derive(Debug)]
pub struct Parts {
    program: String,
    packed: Packed,
}

impl Parts {
    pub(crate) fn new(model: &Model<'_>, options: &RenderOptions) -> Result<Self, Error> {
        let packed = Packed::new(model)?;
        Ok(Self { program: shader::source(model, &packed, options), packed })
    }

    /// The program, in WGSL.
    #[must_use]
    pub fn program(&self) -> &str {
        &self.program
    }

    /// Its buffers.
    #[must_use]
    pub const fn packed(&self) -> &Packed {
        &self.packed
    }

    /// Address and length, bytes, of a part: 0 the program, 1 weights, 2 tables, 3 cells.
    pub(crate) fn part(&self, which: u32) -> (*const u8, usize) {
        let Packed { weights, tables, occupancy, .. } = &self.packed;
        match which {
            0 => (self.program.as_ptr(), self.program.len()),
            1 => (weights.as_ptr().cast(), size_of_val(weights.as_slice())),
            2 => (tables.as_ptr().cast(), size_of_val(tables.as_slice())),
            _ => (occupancy.as_ptr().cast(), size_of_val(occupancy.as_slice())),
        }
    }
}
