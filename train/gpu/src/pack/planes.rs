//! Planes and lines.

use alloc::vec::Vec;

use pocketnerf_core::encoding::Planes;

use super::tables::push;

#[derive(Debug)]
pub(crate) struct PackedPlanes {
    /// Entries along an axis.
    pub(crate) resolution: u32,
    pub(crate) pairs: Vec<PackedPair>,
}

/// A plane and its line in the buffer of tables.
#[derive(Debug)]
pub(crate) struct PackedPair {
    /// The axis along which the line lies.
    pub(crate) axis: usize,
    /// The numbers of the first value of the plane and of the line.
    pub(crate) first: [usize; 2],
    /// What a product of their values is multiplied by.
    pub(crate) factor: f32,
}

/// Appends the tables to `words`.
pub(super) fn pack(planes: &Planes<'_>, words: &mut Vec<u32>) -> PackedPlanes {
    let n_pairs = Planes::n_pairs(planes.n_components);
    let mut pairs = Vec::new();
    for (number, pair) in planes.pairs.iter().enumerate().take(n_pairs) {
        pairs.push(PackedPair {
            axis: Planes::axis(planes.n_components, number),
            first: [push(&pair.plane, words), push(&pair.line, words)],
            factor: pair.plane.scale() * pair.line.scale(),
        });
    }
    PackedPlanes { resolution: planes.resolution, pairs }
}
