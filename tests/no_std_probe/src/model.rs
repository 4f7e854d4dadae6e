//! A model of constant bytes.

use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
use pocketnerf_core::field::{AnyField, Decoder, HashGridField, Shading};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{
    ColorSpace, DType, Display, Error, Layout, Model, Sampling, Space, TensorView,
};

/// Two levels of 216 entries, two f16 features each, and after them the weights
/// of the networks: 4 → 8 → 4 and 3 + 4 → 3.
// A section of its own: code size is measured without the model.
#[cfg_attr(target_os = "none", unsafe(link_section = ".model"))]
static BYTES: [u8; 2 * WEIGHTS] = pattern();
const ENTRIES: usize = 216;
const WEIGHTS: usize = 2 * 2 * ENTRIES + 4 * 8 + 8 * 4 + 7 * 3;

/// Small f16 values of both signs.
const fn pattern() -> [u8; 2 * WEIGHTS] {
    let mut bytes = [0; 2 * WEIGHTS];
    let mut i = 0;
    while i < WEIGHTS {
        // Exponent 13 or 14, that is 1/4 to 1, and a sign that changes.
        bytes[2 * i] = (i * 89) as u8;
        bytes[2 * i + 1] = 0x34 | (i * 5 % 8) as u8 | ((i / 3 % 2) as u8) << 7;
        i += 1;
    }
    bytes
}

/// Cuts tensors off the front of the bytes.
struct Reader(&'static [u8]);

impl Reader {
    fn tensor(&mut self, rows: u32, cols: u32) -> Result<TensorView<'static>, Error> {
        let len = (rows * cols) as usize * DType::F16.size();
        let (head, rest) = self.0.split_at_checked(len).ok_or(Error::Shape("model bytes"))?;
        self.0 = rest;
        TensorView::new(head, DType::F16, [rows, cols], 0, Layout::RowMajor)
    }

    fn layer(&mut self, n_in: u32, n_out: u32) -> Result<Dense<'static>, Error> {
        Ok(Dense { weight: self.tensor(n_in, n_out)?, bias: None })
    }
}

/// The model that the bytes hold.
pub(crate) fn open() -> Result<Model<'static>, Error> {
    // Not a constant to the optimiser, or it would render while compiling.
    let mut reader = Reader(core::hint::black_box(&BYTES[..]));
    let mut levels = [TensorView::EMPTY; MAX_LEVELS];
    for level in &mut levels[..2] {
        *level = reader.tensor(ENTRIES as u32, 2)?;
    }
    let config = HashGridConfig {
        n_levels: 2,
        n_features_per_level: 2,
        log2_hashmap_size: 8,
        base_resolution: 4,
        per_level_scale: 1.25,
        index: GridIndex::Blocked,
    };
    let decoder = Decoder {
        density: Mlp::new(&[reader.layer(4, 8)?, reader.layer(8, 4)?])?,
        color: Mlp::new(&[reader.layer(7, 3)?])?,
        n_features: 3,
        sh_degree: 2,
        shading: Shading::PerRay,
        log_density_bias: 0.0,
    };
    let model = Model {
        field: AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder }),
        space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
        occupancy: None,
        sampling: Sampling { step: 0.05, near: 0.1, far: 6.0, min_transmittance: 1e-3 },
        display: Display { background: [0.0; 3], color_space: ColorSpace::Srgb },
    };
    model.validate()?;
    Ok(model)
}
