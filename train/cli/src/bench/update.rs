//! What updating the parameters reads and writes.

use pocketnerf_core::AnyField;
use pocketnerf_formats::{Role, tensors};
use pocketnerf_train::trainer::Trainer;

use super::stage::Demand;

/// Bytes per grid parameter that a step does not change: its gradient is read.
const UNCHANGED: f64 = 4.0;
/// Bytes per grid parameter that a step changes: gradient, parameter and second moment are read and
/// written, the rounded parameter is written.
const CHANGED: f64 = 6.0 * 4.0 + 1.0;
/// Bytes per network parameter, which has a first moment too.
const NETWORK: f64 = 8.0 * 4.0 + 2.0;

/// Parameters of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sizes {
    grid: f64,
    networks: f64,
}

impl Sizes {
    pub(super) fn new(field: &AnyField<'_>) -> Self {
        let mut sizes = Self { grid: 0.0, networks: 0.0 };
        for (name, tensor) in tensors(field) {
            let len = (tensor.rows() * tensor.cols()) as f64;
            match name.role() {
                Role::Table => sizes.grid += len,
                _ => sizes.networks += len,
            }
        }
        sizes
    }

    /// The memory that a step's update reads and writes if this share of the grid changes.
    pub(super) fn adam(&self, changed: f64) -> Demand {
        let grid = self.grid * (UNCHANGED + changed * (CHANGED - UNCHANGED));
        // Parameters, second moments and what they are rounded to lie in memory from
        // step to step; of gradients there is a level's at a time.
        let memory = (4.0 + 4.0) * (self.grid + self.networks) + self.grid + 2.0 * self.networks;
        Demand::bandwidth(grid + self.networks * NETWORK, memory)
    }

    /// The memory that adding up the networks' gradients reads and writes: each group's and
    /// the sum are read, the sum is written.
    pub(super) fn reduction(&self, groups: usize) -> Demand {
        let bytes = 3.0 * 4.0 * self.networks * groups as f64;
        Demand::bandwidth(bytes, 4.0 * self.networks * (1 + groups) as f64)
    }
}

/// A copy of the tables' bytes.
pub(super) fn tables(trainer: &Trainer) -> Vec<u8> {
    let model = trainer.model();
    let tables = tensors(&model.field).filter(|(name, _)| name.role() == Role::Table);
    tables.flat_map(|(_, table)| table.bytes().iter().copied()).collect()
}

/// The share of the tables in registers with a value that has changed.
pub(super) fn changed(old: &[u8], trainer: &Trainer, lanes: usize) -> f64 {
    let new = tables(trainer);
    let registers = old.chunks(4 * lanes).zip(new.chunks(4 * lanes));
    let n = registers.len();
    registers.filter(|(old, new)| old != new).count() as f64 / n.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_train::trainer::TrainConfig;

    #[test]
    fn a_small_field_by_hand() {
        let mut config = TrainConfig::hash_grid().field;
        let grid = &mut config.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
        let field = config.kind().build(1.0);
        let parameters = vec![0.0; field.layout().len()];
        let sizes = Sizes::new(&field.view(&parameters).unwrap());
        // Two tables of 256 entries; 8 -> 64 -> 16 and 31 -> 64 -> 64 -> 3.
        let networks = (9 * 64 + 65 * 16 + 32 * 64 + 65 * 64 + 65 * 3) as f64;
        assert_eq!(sizes, Sizes { grid: 2048.0, networks });
        let adam = sizes.adam(0.5).bytes.unwrap();
        assert_eq!(adam, 2048.0 * 14.5 + networks * 34.0);
        assert_eq!(sizes.reduction(16).bytes, Some(12.0 * 16.0 * networks));
    }
}
