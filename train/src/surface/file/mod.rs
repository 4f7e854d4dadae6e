//! Meshes as files of other programs: PLY, OBJ and GLB.

mod glb;
mod obj;
mod ply;
#[cfg(test)]
mod tests;

pub use glb::glb;
pub use obj::{mtl, obj};
pub use ply::{ply, points};
