//! Kinds of field beside the hash grid.

mod derf;
mod planes;
mod plenoxels;
