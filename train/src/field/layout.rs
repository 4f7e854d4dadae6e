//! Where each tensor of a field lies in the flat parameter buffer.

use pocketnerf_core::{DType, Error, Layout as Order, TensorView};

/// What the values of a tensor are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Entries that are looked up: many, of which a point reads few.
    Table,
    /// Weights of a layer.
    Weight,
    /// Biases of a layer.
    Bias,
    /// Numbers that are not trained.
    Fixed,
}

/// A named tensor of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it belongs to, in the words of the field's kind.
    pub network: &'static str,
    /// Number of the layer (or level) there.
    pub layer: usize,
    /// What its values are.
    pub role: Role,
}

/// A named range of the flat buffer, row-major `[rows, cols]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// What it is.
    pub part: Part,
    /// First value.
    pub start: usize,
    /// Shape.
    pub shape: [usize; 2],
}

impl Range {
    /// Values in the range.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    /// Whether the range holds nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The indices of its values.
    #[must_use]
    pub const fn indices(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.len()
    }

    /// These values as a tensor.
    pub(super) fn tensor<'a>(
        &self,
        bytes: &'a [u8],
        dtype: DType,
        scale_log2: i8,
    ) -> Result<TensorView<'a>, Error> {
        let shape = self.shape.map(|n| n as u32);
        TensorView::new(bytes, dtype, shape, scale_log2, Order::RowMajor)
    }

    /// Its part of `parameters` as a tensor.
    ///
    /// # Errors
    /// Whatever core's validation reports.
    pub fn of<'a>(&self, parameters: &'a [f32]) -> Result<TensorView<'a>, Error> {
        self.tensor(bytemuck::must_cast_slice(&parameters[self.indices()]), DType::F32, 0)
    }
}

/// All ranges of a field: tables first, then the networks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    ranges: Vec<Range>,
    n_tables: usize,
}

impl Layout {
    /// Appends a tensor. Tables come before all others.
    pub(super) fn push(&mut self, part: Part, shape: [usize; 2]) {
        let start = self.len();
        self.ranges.push(Range { part, start, shape });
        self.n_tables += usize::from(part.role == Role::Table);
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ranges.last().map_or(0, |r| r.start + r.len())
    }

    /// Whether there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All ranges in order.
    #[must_use]
    pub fn ranges(&self) -> &[Range] {
        &self.ranges
    }

    /// The ranges of the tables.
    #[must_use]
    pub fn tables(&self) -> &[Range] {
        &self.ranges[..self.n_tables]
    }

    /// The ranges after the tables.
    #[must_use]
    pub fn networks(&self) -> &[Range] {
        &self.ranges[self.n_tables..]
    }

    /// Where the networks' parameters begin.
    #[must_use]
    pub fn networks_start(&self) -> usize {
        self.networks().first().map_or(self.len(), |range| range.start)
    }

    /// The range of a part, which must exist.
    #[must_use]
    pub fn range(&self, part: Part) -> Range {
        *self.ranges.iter().find(|r| r.part == part).expect("a part of this layout")
    }
}
