//! Checkpoints of other programs: their containers, and the NeRFs and hash grids in them.

mod containers;
mod nerf;
mod ngp;
