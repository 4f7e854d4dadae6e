//! Kinds of field beside the hash grid.

mod plenoxels;
