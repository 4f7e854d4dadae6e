//! Training as a whole, on the built-in scene made tiny: the same bytes at any
//! number of threads and after any interruption, and nothing goes wrong in
//! silence.

mod builtin;
mod cut_out;
mod determinism;
mod few_views;
mod finished;
mod fog;
mod guard;
mod jumps;
mod kinds;
mod masked;
mod mutated;
mod ndc;
mod opaque;
mod poses;
mod refusals;
mod setup;
mod teachers;
