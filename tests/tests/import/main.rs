//! Checkpoints of other programs: their containers, and the NeRFs, hash grids and volumes in them.

mod containers;
mod nerf;
mod ngp;
mod volumes;
