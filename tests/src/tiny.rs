//! Models small enough for golden files, the same on every machine.

use pocketnerf_core::encoding::{
    Affine, Fourier, GridIndex, HashGrid, HashGridConfig, MAX_LEVELS, Planes, VoxelGrid, Waves,
    planes,
};
use pocketnerf_core::field::{
    Activation, Decoder, DerfField, HashGridField, HeadShape, NerfField, NerfNetwork, PlanesField,
    PlenoxelField, Shading,
};
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::space::Ndc;
use pocketnerf_core::{
    AnyField, Camera, ColorSpace, DType, Display, Layout, Model, Occupancy, Sampling, Space,
    TensorView,
};
use pocketnerf_formats::{About, DefaultCamera, PhotographList, Provenance, Scene};

/// The memory that tiny models borrow.
#[derive(Debug)]
pub struct Tiny {
    weights: Vec<u8>,
    coarse: Vec<u8>,
    fine: Vec<u8>,
    /// Cells along an axis.
    resolution: u32,
    /// Numbers of the bricks of a grid of eight voxels along an axis.
    numbers: Vec<u8>,
}

/// Cuts tensors off the front of a buffer.
struct Cutter<'a>(&'a [u8]);

impl<'a> Cutter<'a> {
    fn tensor(&mut self, rows: u32, cols: u32) -> TensorView<'a> {
        let (bytes, rest) = self.0.split_at(4 * (rows * cols) as usize);
        self.0 = rest;
        TensorView::new(bytes, DType::F32, [rows, cols], 0, Layout::RowMajor).unwrap()
    }

    fn layer(&mut self, n_in: u32, n_out: u32) -> Dense<'a> {
        Dense { weight: self.tensor(n_in, n_out), bias: Some(self.tensor(1, n_out)) }
    }

    fn mlp(&mut self, widths: &[u32]) -> Mlp<'a> {
        let layers = widths.windows(2).map(|pair| self.layer(pair[0], pair[1]));
        let layers: Vec<Dense<'_>> = layers.collect();
        Mlp::new(&layers).unwrap()
    }
}

impl Default for Tiny {
    fn default() -> Self {
        Self::new()
    }
}

impl Tiny {
    /// Weights between -0.5 and 0.5 that only integers and one division decide.
    #[must_use]
    pub fn new() -> Self {
        let mut state = 1u32;
        let weights = (0..2048)
            .flat_map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (((state >> 8) as f32 - 8_388_608.0) / 16_777_216.0).to_le_bytes()
            })
            .collect();
        // 16 cells an axis, eight blocks; blocks 0 and 5 hold something.
        let mut coarse = vec![0; 16];
        coarse[0] = 1;
        coarse[10] = 2;
        let fine = (0..128u32).map(|i| (i * 37 % 251) as u8).collect();
        // Of 27 bricks the one in the middle and one beside it hold something, the same.
        let number = |place: u16| u16::from(place == 12 || place == 13);
        let numbers = (0..27).flat_map(|place| number(place).to_le_bytes()).collect();
        Self { weights, coarse, fine, resolution: 16, numbers }
    }

    /// Most weights are 0 and the cells are those of a ball: what packing makes smaller.
    #[must_use]
    pub fn trained() -> Self {
        let mut tiny = Self::new();
        for bytes in tiny.weights.as_chunks_mut::<4>().0 {
            let value = f32::from_le_bytes(*bytes);
            *bytes = if value.abs() < 0.4 { 0.0 } else { value }.to_le_bytes();
        }
        let n = 32;
        let inside = |cell: u32| {
            let square = |c: u32| (2 * c + 1).abs_diff(n).pow(2);
            square(cell % n) + square(cell / n % n) + square(cell / (n * n)) < 24 * 24
        };
        let cells = (0..n * n * n).filter(|cell| inside(*cell));
        let (coarse, fine) = pocketnerf_train::trainer::pack(n, cells).unwrap();
        Self { coarse, fine, resolution: n, ..tiny }
    }

    /// A hash grid of a dense and a hashed level, shaded once per ray, with occupancy.
    #[must_use]
    pub fn hash_grid(&self) -> Model<'_> {
        let mut cut = Cutter(&self.weights);
        let config = HashGridConfig {
            n_levels: 2,
            n_features_per_level: 2,
            log2_hashmap_size: 8,
            base_resolution: 4,
            per_level_scale: 2.0,
            index: GridIndex::Blocked,
        };
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (l, table) in levels.iter_mut().enumerate().take(2) {
            *table = cut.tensor(config.level(l).entries, 2);
        }
        let decoder = Decoder {
            density: cut.mlp(&[4, 8, 4]),
            color: cut.mlp(&[3 + 4, 8, 3]),
            n_features: 3,
            sh_degree: 2,
            shading: Shading::PerRay,
            log_density_bias: 1.5,
        };
        Model {
            field: AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder }),
            space: Space::Box { min: [-1.0, -1.0, -0.5], max: [1.0, 1.0, 0.5] },
            occupancy: Some(Occupancy::new(self.resolution, 1, &self.coarse, &self.fine).unwrap()),
            sampling: Sampling { step: 0.0625, near: 0.25, far: 6.0, min_transmittance: 1e-3 },
            hierarchical: None,
            display: Display {
                background: [1.0; 3],
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        }
    }

    /// The same hash grid in normalised device coordinates.
    #[must_use]
    pub fn ndc(&self) -> Model<'_> {
        let (min, max) = ([-1.5, -1.25, -1.0], [1.25, 1.5, 1.0]);
        let ndc = Ndc { near: 0.75, slope: [1.5, 2.0], min, max };
        let model = self.hash_grid();
        let sampling = Sampling { near: 0.0, ..model.sampling };
        Model { space: Space::Ndc(ndc), sampling, ..model }
    }

    /// A hash grid of one dense level, shaded per sample, without occupancy, in linear colours.
    #[must_use]
    pub fn per_sample(&self) -> Model<'_> {
        let mut cut = Cutter(&self.weights);
        let config = HashGridConfig {
            n_levels: 1,
            n_features_per_level: 4,
            log2_hashmap_size: 7,
            base_resolution: 3,
            per_level_scale: 1.5,
            index: GridIndex::Blocked,
        };
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        levels[0] = cut.tensor(config.level(0).entries, 4);
        let decoder = Decoder {
            density: cut.mlp(&[4, 16, 16, 6]),
            color: cut.mlp(&[5 + 9, 3]),
            n_features: 5,
            sh_degree: 3,
            shading: Shading::PerSample,
            log_density_bias: -0.5,
        };
        Model {
            field: AnyField::HashGrid(HashGridField { grid: HashGrid { config, levels }, decoder }),
            space: Space::Box { min: [0.0; 3], max: [2.0; 3] },
            occupancy: None,
            sampling: Sampling { step: 0.125, near: 0.0, far: 8.0, min_transmittance: 0.0 },
            hierarchical: None,
            display: Display {
                background: [0.0, 0.5, 1.0],
                color_space: ColorSpace::Linear,
                tolerance: Display::TOLERANCE,
            },
        }
    }
}

impl Tiny {
    /// Voxels with four harmonics a colour in two bricks.
    #[must_use]
    pub fn plenoxels(&self) -> Model<'_> {
        let shape = [27, 1];
        let index = TensorView::new(&self.numbers, DType::U16, shape, 0, Layout::RowMajor).unwrap();
        let values =
            TensorView::new(&self.weights, DType::F32, [128, 16], 0, Layout::RowMajor).unwrap();
        let grid = VoxelGrid { resolution: 8, index, values };
        let model = self.hash_grid();
        let field = PlenoxelField { grid, sh_degree: 2, log_density_bias: 1.5 };
        Model { field: AnyField::Plenoxels(field), ..model }
    }

    /// Planes and lines of five entries along an axis.
    #[must_use]
    pub fn planes(&self) -> Model<'_> {
        let mut cut = Cutter(&self.weights);
        let decoder = Decoder {
            density: cut.mlp(&[48, 4]),
            color: cut.mlp(&[3 + 4, 8, 3]),
            n_features: 3,
            sh_degree: 2,
            shading: Shading::PerRay,
            log_density_bias: 1.5,
        };
        let mut pairs = [planes::Pair::EMPTY; planes::MAX_PAIRS];
        for pair in &mut pairs[..Planes::n_pairs(16)] {
            *pair = planes::Pair { plane: cut.tensor(25, 8), line: cut.tensor(5, 8) };
        }
        let planes = Planes { resolution: 5, n_components: 16, pairs };
        Model { field: AnyField::Planes(PlanesField { planes, decoder }), ..self.hash_grid() }
    }

    /// Three heads of two layers.
    #[must_use]
    pub fn derf(&self) -> Model<'_> {
        let mut cut = Cutter(&self.weights);
        let shape = HeadShape {
            octaves: 1,
            direction_octaves: Some(0),
            depth: 2,
            width: 8,
            skip: 1,
            color_width: 5,
            activation: Activation::Exp,
        };
        let heads = cut.tensor(3, shape.n_parameters() as u32);
        let field = DerfField { shape, sites: cut.tensor(3, 3), heads, density_scale: 2.0 };
        Model { field: AnyField::Derf(field), ..self.hash_grid() }
    }

    /// A vanilla NeRF whose coarse network is smaller than the fine one, with random
    /// frequencies for directions and hierarchical sampling.
    #[must_use]
    pub fn nerf(&self) -> Model<'_> {
        let mut cut = Cutter(&self.weights);
        let positions = Fourier { waves: Waves::Octaves { n: 2, pi: true }, include_input: true };
        let directions = Fourier { waves: Waves::Gaussian(cut.tensor(3, 3)), include_input: false };
        let trunk = [cut.layer(15, 8), cut.layer(15 + 8, 10), cut.layer(10, 8)];
        let (density, feature) = (cut.layer(8, 1), cut.layer(8, 6));
        let color = cut.mlp(&[6 + 6, 5, 3]);
        let fine = NerfNetwork::new(&trunk, [0b010, 0b100], density, Some(feature), color);
        let trunk = [cut.layer(15, 6)];
        let coarse = NerfNetwork::new(&trunk, [0, 0], cut.layer(6, 1), None, cut.mlp(&[6 + 6, 3]));
        Model {
            field: AnyField::Nerf(NerfField {
                positions,
                directions: Some(directions),
                map: Affine { scale: [2.0, 1.0, 2.0], offset: [-1.0, -0.5, -1.0] },
                activation: Activation::Softplus,
                density_scale: 3.0,
                fine: fine.unwrap(),
                coarse: Some(coarse.unwrap()),
            }),
            space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
            occupancy: None,
            sampling: Sampling { step: 0.0625, near: 1.0, far: 5.0, min_transmittance: 0.0 },
            hierarchical: Some(Hierarchical { n_coarse: 16, n_fine: 24, reach: Reach::Clipped }),
            display: Display {
                background: [1.0; 3],
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        }
    }
}

/// Where the cameras of [`photographs`] are.
pub const EYES: [[f32; 3]; 3] = [[3.0, 0.0, 1.0], [0.0, -3.0, 0.5], [-2.0, 2.0, 2.0]];

/// Three cameras that look at the origin.
///
/// # Panics
/// Never.
#[must_use]
pub fn photographs() -> PhotographList {
    let camera = |eye| {
        let pose = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]);
        Camera::from_fov_x(40, 30, 0.75, pose)
    };
    PhotographList::new(&EYES.map(camera)).expect("three cameras")
}

/// Something in every field that a file can say beside the model.
#[must_use]
pub fn about() -> About<'static> {
    About {
        scene: Scene {
            scale: 2.0,
            rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.5, 0.25, -4.0],
            name: Some("tiny"),
        },
        camera: Some(DefaultCamera {
            #[rustfmt::skip]
            camera_to_world: [
                1.0, 0.0, 0.0, 0.0,
                0.0, 1.0, 0.0, 0.0,
                0.0, 0.0, 1.0, 3.0,
                0.0, 0.0, 0.0, 1.0,
            ],
            fov_x: 0.75,
            width: 160,
            height: 120,
        }),
        provenance: Some(Provenance {
            program: "pocketnerf-tests",
            method: "none",
            seed: 7,
            steps: 300,
            trained_on: 0x0123_4567_89ab_cdef,
            dataset: "nothing",
            train_psnr: Some(30.5),
        }),
        ..About::default()
    }
}
