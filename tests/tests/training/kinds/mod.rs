//! Kinds of field beside the hash grid.

mod nerf;
mod plenoxels;
