//! What a kind of encoding adds to the networks behind it.

use std::fmt::Debug;

use fearless_simd::Simd;
use pocketnerf_core::field::Decoder;
use pocketnerf_core::{AnyField, Error, TensorView};

use super::EncodedFieldConfig;
use crate::field::{FieldConfig, Range, Training};

/// An encoding of positions whose tables are trained. What is implemented is its shape.
pub trait Encoding: Clone + Debug + PartialEq + Send + Sync + Sized + 'static {
    /// The encoding with its tables, as core has it.
    type View<'a>: Copy + Debug + Send + Sync;

    /// Tables that are updated together, by one thread.
    const TABLES_OF_A_TASK: usize;

    /// Values of an encoded point.
    fn n_output(&self) -> usize;

    /// Shapes of the tables, a whole number of tasks.
    fn tables(&self) -> Vec<[usize; 2]>;

    /// What values of a table lie between at first.
    fn initial_range(&self, table: usize) -> [f32; 2];

    /// The encoding of tables.
    ///
    /// # Errors
    /// Those of `table`.
    fn view<'a>(
        &self,
        tables: &[Range],
        table: impl Fn(&Range) -> Result<TensorView<'a>, Error>,
    ) -> Result<Self::View<'a>, Error>;

    /// The field of an encoding and networks.
    fn field<'a>(view: Self::View<'a>, decoder: Decoder<'a>) -> AnyField<'a>;

    /// The kind of field of such a shape.
    fn config(field: EncodedFieldConfig<Self>) -> FieldConfig;

    /// How fields of it are trained.
    fn training(&self) -> Training {
        Training::USUAL
    }

    /// Encodes points, as core does.
    fn encode<S: Simd>(
        simd: S,
        view: &Self::View<'_>,
        points: [&[f32]; 3],
        out: &mut [f32],
        stride: usize,
    );

    /// Adds the gradient of a multiple of 16 points to that of a task's tables, one after another.
    ///
    /// `tables` are those that the points were encoded by; `rows` holds the gradient of all
    /// encoded values, `[n_output][stride]`.
    fn scatter<S: Simd>(
        &self,
        simd: S,
        task: (usize, &[TensorView<'_>]),
        points: [&[f32]; 3],
        rows: (&[f32], usize),
        gradient: &mut [f32],
    );

    /// Levels, the coarsest first.
    fn n_levels(&self) -> usize;

    /// Adds the gradient of unit coordinates, with the share of each level in it, as
    /// [`Back::points`](crate::field::Back::points) does; `tables` are the parameters.
    fn points_back<S: Simd>(
        &self,
        simd: S,
        tables: &[&[f32]],
        points: [&[f32]; 3],
        rows: (&[f32], usize),
        levels: &[f32],
        d_points: &mut [&mut [f32]; 3],
    );

    /// Moves values of a table, as far as they have a gradient, by this share towards the mean of
    /// their neighbours, where it has any.
    fn smooth<S: Simd>(&self, _: S, _table: usize, _share: f32, _: (&mut [f32], &[f32])) {}

    /// Checks that there can be such an encoding.
    ///
    /// # Errors
    /// What core's validation reports.
    fn validate(&self) -> Result<(), Error>;

    /// The finer encoding that is due when so much of a run is over.
    fn due(&self, _progress: f32) -> Option<Self> {
        None
    }

    /// The values of a finer encoding's tables that say the same as these: parameters or second
    /// moments.
    fn carried_over(&self, _finer: &Self, tables: &[&[f32]]) -> Vec<f32> {
        tables.concat()
    }

    /// What a checkpoint holds beside the model, where there is such a section.
    fn section(&self) -> Option<Vec<u8>> {
        None
    }
}
