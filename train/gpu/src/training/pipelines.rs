//! All kernels of a step.

use std::thread::ScopedJoinHandle;

use super::kernel::{Pipeline, Program};
use crate::render::Error;

fn finished(pipeline: ScopedJoinHandle<'_, Result<Pipeline, Error>>) -> Result<Pipeline, Error> {
    pipeline.join().map_err(|_| Error::Device("a kernel cannot be compiled".to_owned()))?
}

/// Fields named as the entry points are.
macro_rules! pipelines {
    ($($name:ident),* $(,)?) => {
        /// All kernels of a step.
        #[derive(Debug)]
        pub(super) struct Pipelines {
            $(pub(super) $name: Pipeline,)*
        }

        impl Pipelines {
            /// Compiles them side by side: a driver may take a second for each.
            pub(super) fn new(program: &Program<'_>) -> Result<Self, Error> {
                std::thread::scope(|threads| {
                    $(let $name = threads.spawn(|| program.pipeline(stringify!($name)));)*
                    Ok(Self { $($name: finished($name)?,)* })
                })
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
