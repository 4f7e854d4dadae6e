//! All kernels of a step.

use super::kernel::{Pipeline, Program};
use crate::render::Error;

/// Fields named as the entry points are.
macro_rules! pipelines {
    ($($name:ident),* $(,)?) => {
        /// All kernels of a step.
        #[derive(Debug)]
        pub(super) struct Pipelines {
            $(pub(super) $name: Pipeline,)*
        }

        impl Pipelines {
            pub(super) fn new(program: &Program<'_>) -> Result<Self, Error> {
                Ok(Self { $($name: program.pipeline(stringify!($name))?,)* })
            }
        }
    };
}

pipelines!(
    trace,
    shade,
    dense_rays,
    loss,
    outer_rays,
    drop,
    scan,
    gather,
    encode_again,
    dense_samples,
    outer_samples,
    reduce,
    follow,
    lay_out,
    sum_units,
    find_units,
    scatter,
    adam,
    hold_all,
    round_all,
    accumulate,
    look,
);
