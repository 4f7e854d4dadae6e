//! The shape of a field's networks, for people and for benchmarks.

use pocketnerf_core::TensorView;
use pocketnerf_core::encoding::{Fourier, Waves};
use pocketnerf_core::field::{NerfField, NerfNetwork};
use pocketnerf_core::network::Dense;
use serde::Serialize;

/// The networks of a field whose samples have their own colours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NetworksReport {
    /// How positions are encoded.
    pub positions: EncodingReport,
    /// How directions are encoded; `None` without view dependence.
    pub directions: Option<EncodingReport>,
    /// From the network's output to a density: `relu`, `softplus` or `exp`.
    pub activation: String,
    /// The network that is rendered.
    pub fine: NetworkReport,
    /// The network that decides where samples lie, if there is one.
    pub coarse: Option<NetworkReport>,
}

/// How coordinates are encoded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EncodingReport {
    /// Frequencies.
    pub waves: WavesReport,
    /// Whether the coordinates themselves are passed too.
    pub input: bool,
    /// Number of values.
    pub values: usize,
}

/// Frequencies of an encoding.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum WavesReport {
    /// Powers of two.
    Octaves {
        /// How many.
        octaves: u32,
        /// Whether they are multiplied by π.
        pi: bool,
    },
    /// Random ones.
    Random {
        /// How many.
        random_frequencies: usize,
    },
}

/// One network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NetworkReport {
    /// Layers of the trunk.
    pub depth: usize,
    /// Their widths.
    pub widths: Vec<usize>,
    /// Layers of the trunk that read the position again.
    pub skips: Vec<usize>,
    /// Width of the layer between trunk and colour, if there is one.
    pub feature: Option<usize>,
    /// Widths of the colour's layers.
    pub color: Vec<usize>,
    /// Number of weights and biases.
    pub parameters: usize,
    /// Multiply-adds of one evaluation.
    #[serde(skip)]
    pub multiply_adds: usize,
    /// Those of them with encoded coordinates: training needs no gradients of these.
    #[serde(skip)]
    pub multiply_adds_of_inputs: usize,
}

/// Describes the networks of a field.
pub(in crate::field) fn report(field: &NerfField<'_>) -> NetworksReport {
    let encoding = |encoding: &Fourier<'_>| EncodingReport {
        waves: match encoding.waves {
            Waves::Octaves { n, pi } => WavesReport::Octaves { octaves: n, pi },
            Waves::Gaussian(matrix) => WavesReport::Random { random_frequencies: matrix.cols() },
        },
        input: encoding.include_input,
        values: encoding.n_output(),
    };
    let positions = encoding(&field.positions);
    let directions = field.directions.as_ref().map(encoding);
    let inputs = [positions.values, directions.as_ref().map_or(0, |encoding| encoding.values)];
    NetworksReport {
        positions,
        directions,
        activation: format!("{:?}", field.activation).to_lowercase(),
        fine: network(&field.fine, inputs),
        coarse: field.coarse.as_ref().map(|coarse| network(coarse, inputs)),
    }
}

fn network(network: &NerfNetwork<'_>, [n_position, n_direction]: [usize; 2]) -> NetworkReport {
    let (trunk, color) = (network.trunk(), network.color.layers());
    let width = |layer: &Dense<'_>| layer.weight.cols();
    let size = |view: &TensorView<'_>| view.rows() * view.cols();
    let of = |layer: &Dense<'_>| size(&layer.weight) + layer.bias.as_ref().map_or(0, size);
    let skips: Vec<usize> = (0..trunk.len()).filter(|i| network.skips(*i)).collect();
    let readers = [0].iter().chain(&skips).map(|i| width(&trunk[*i])).sum::<usize>();
    NetworkReport {
        depth: trunk.len(),
        widths: trunk.iter().map(width).collect(),
        feature: network.feature.as_ref().map(width),
        color: color.iter().map(width).collect(),
        parameters: network.layers().map(of).sum(),
        multiply_adds: network.layers().map(|layer| size(&layer.weight)).sum(),
        multiply_adds_of_inputs: n_position * readers + n_direction * width(&color[0]),
        skips,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use crate::field::{FieldKind, NerfConfig, networks};
    use crate::trainer::TrainConfig;

    #[test]
    fn the_original_by_hand() {
        let field = NerfConfig::in_cells().build(1.0);
        let parameters = vec![0.0; field.layout().len()];
        let found = networks(&field.view(&parameters).unwrap()).unwrap();
        // Ten octaves of positions and four of directions, sines and cosines.
        let weights = 63 * 256
            + 6 * 256 * 256
            + (63 + 256) * 256
            + 256
            + 256 * 256
            + (256 + 27) * 128
            + 128 * 3;
        let biases = 8 * 256 + 1 + 256 + 128 + 3;
        assert_eq!(found.fine.multiply_adds, weights);
        assert_eq!(found.fine.multiply_adds_of_inputs, 2 * 63 * 256 + 27 * 128);
        let expected = json!({
            "positions": {"waves": {"octaves": 10, "pi": false}, "input": true, "values": 63},
            "directions": {"waves": {"octaves": 4, "pi": false}, "input": true, "values": 27},
            "activation": "exp",
            "fine": {"depth": 8, "widths": vec![256; 8], "skips": [5], "feature": 256,
                "color": [128, 3], "parameters": weights + biases},
            "coarse": null,
        });
        assert_eq!(serde_json::to_value(&found).unwrap(), expected);
    }

    #[test]
    fn other_kinds_have_none() {
        let field = TrainConfig::hash_grid().field.kind().build(1.0);
        let parameters = vec![0.0; field.layout().len()];
        assert_eq!(networks(&field.view(&parameters).unwrap()), None);
    }
}
