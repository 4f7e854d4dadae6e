//! Kinds of field beside the hash grid.

mod derf;
mod nerf;
mod planes;
mod plenoxels;
