//! Counts what a field computes and reads.

use pocketnerf_core::field::Shading;
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{AnyField, TensorView};
use pocketnerf_formats::{Role, tensors};
use pocketnerf_train::field::networks;

/// Multiplications and additions of a network's forward pass for one point, without biases
/// and ReLU.
#[must_use]
pub fn network_flops(network: &Mlp<'_>) -> f64 {
    layers(network).sum()
}

/// The same without the last layer.
#[must_use]
pub fn hidden_flops(network: &Mlp<'_>) -> f64 {
    layers(network).take(network.layers().len() - 1).sum()
}

/// Those of the backward pass with known hidden layers: gradients of weights and inputs.
#[must_use]
pub fn backward_flops(network: &Mlp<'_>) -> f64 {
    2.0 * network_flops(network)
}

fn layers(network: &Mlp<'_>) -> impl Iterator<Item = f64> {
    network.layers().iter().map(dense_flops)
}

/// Multiplications and additions for the density and the channels of a sample, and for the
/// colour of a ray if that is computed once.
#[must_use]
pub fn field_flops(field: &AnyField<'_>) -> [f64; 2] {
    if let Some(networks) = networks(field) {
        return [2.0 * networks.fine.multiply_adds as f64, 0.0];
    }
    let Some(decoder) = field.decoder() else { return [0.0; 2] };
    let [density, color] = [&decoder.density, &decoder.color].map(network_flops);
    match decoder.shading {
        Shading::PerSample => [density + color, 0.0],
        Shading::PerRay => [density, color],
    }
}

fn dense_flops(layer: &Dense<'_>) -> f64 {
    (2 * layer.weight.rows() * layer.weight.cols()) as f64
}

/// Reads of a point from one grid level's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelReads {
    /// Entries.
    pub entries: f64,
    /// Size of an entry as it is stored, bytes.
    pub entry_bytes: f64,
    /// Size of the table, bytes.
    pub table_bytes: f64,
}

/// Reads of a point from each level; none if there is no grid.
#[must_use]
pub fn reads(field: &AnyField<'_>) -> Vec<LevelReads> {
    let level = |(number, table): (usize, TensorView<'_>)| LevelReads {
        entries: field.entries_read(number) as f64,
        entry_bytes: (table.cols() * table.dtype().size()) as f64,
        table_bytes: table.bytes().len() as f64,
    };
    tables(field).enumerate().map(level).collect()
}

/// Multiplications and additions to interpolate these: the weights of the entries, and the
/// features times the weights.
#[must_use]
pub fn encode_flops(field: &AnyField<'_>) -> Option<f64> {
    let entry = |(number, table): (usize, TensorView<'_>)| {
        field.entries_read(number) as f64 * (2 + 2 * table.cols()) as f64
    };
    let levels: Vec<f64> = tables(field).enumerate().map(entry).collect();
    (!levels.is_empty()).then(|| levels.iter().sum())
}

/// The tables of a field, one per level of a grid.
fn tables<'a>(field: &AnyField<'a>) -> impl Iterator<Item = TensorView<'a>> {
    tensors(field).filter(|(name, _)| name.role() == Role::Table).map(|(_, table)| table)
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::Error;

    use super::*;
    use pocketnerf_train::field::FieldConfig;
    use pocketnerf_train::trainer::TrainConfig;

    fn with_field<T>(
        config: &FieldConfig,
        look: impl FnOnce(&AnyField<'_>) -> T,
    ) -> Result<T, Error> {
        let field = config.kind().build(1.0);
        let parameters = vec![0.0; field.layout().len()];
        Ok(look(&field.training_view(&parameters)?))
    }

    #[test]
    fn the_default_field_by_hand() {
        with_field(&TrainConfig::hash_grid().field, |field| {
            // 36 -> 64 -> 16 and 15 + 16 -> 64 -> 64 -> 3.
            let decoder = field.decoder().expect("a hash grid");
            assert_eq!(network_flops(&decoder.density), 2.0 * (2304.0 + 1024.0));
            assert_eq!(hidden_flops(&decoder.density), 2.0 * 2304.0);
            assert_eq!(network_flops(&decoder.color), 2.0 * (1984.0 + 4096.0 + 192.0));
            assert_eq!(backward_flops(&decoder.density), 4.0 * 3328.0);
            // 9 levels of 8 corners: 4 features of a byte; two multiplications for
            // each weight and two operations for each feature.
            let levels = reads(field);
            assert_eq!(levels.iter().map(|l| l.entries).sum::<f64>(), 72.0);
            assert!(levels.iter().all(|l| l.entry_bytes == 4.0));
            // 16 corners along an axis are 9 blocks of 2.
            assert_eq!(levels[0].table_bytes, 9.0 * 9.0 * 9.0 * 8.0 * 4.0);
            assert_eq!(levels[8].table_bytes, 131_072.0 * 4.0);
            assert_eq!(encode_flops(field), Some(72.0 * 10.0));
        })
        .unwrap();
    }

    #[test]
    fn two_features_and_no_grid() {
        let mut two = TrainConfig::hash_grid().field;
        let grid = &mut two.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.n_features_per_level) = (3, 2);
        with_field(&two, |field| {
            assert_eq!(encode_flops(field), Some(3.0 * 8.0 * 6.0));
            assert!(reads(field).iter().all(|l| l.entry_bytes == 2.0));
        })
        .unwrap();
        with_field(&TrainConfig::nerf().field, |field| {
            assert_eq!(encode_flops(field), None);
            assert!(reads(field).is_empty());
        })
        .unwrap();
    }
}
