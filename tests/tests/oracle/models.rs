//! Random models whose pictures have edges, mist and empty places.

use pocketnerf_core::encoding::{
    CornerLevel, CornerLevels, GridIndex, HashGrid, HashGridConfig, MAX_LEVELS, Planes, VoxelGrid,
    planes,
};
use pocketnerf_core::field::{
    Activation, AnyField, Decoder, DerfField, HashGridField, HeadShape, PlanesField, PlenoxelField,
    Shading,
};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::space::{Contracted, Ndc};
use pocketnerf_core::{
    Camera, ColorSpace, DType, Display, Layout, Model, Occupancy, Sampling, Space, TensorView,
};

use crate::nerf::Nerf;

/// Knuth's MMIX generator: the same numbers on every machine.
pub(crate) struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in [-1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
}

/// How positions are encoded.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Encoding {
    /// A hash grid of so many features per level.
    HashGrid(u32),
    /// One whose corners are numbered one by one.
    Corners(u32),
    /// Vanilla NeRFs, which have their own shading.
    Nerf(Nerf),
    /// A grid of so many voxels along an axis, which has its own shading.
    Voxels(u32),
    /// Planes and lines of so many components along an axis.
    Planes(u32),
    /// So many heads, which have their own shading.
    Derf(u32),
}

/// What to build.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recipe {
    pub encoding: Encoding,
    /// Of all tensors; `I8`: of the tables alone, beside networks in f16.
    pub dtype: DType,
    pub shading: Shading,
    pub sh_degree: u32,
    /// Cells along an axis; `None`: no occupancy.
    pub occupancy: Option<u32>,
    pub seed: u64,
}

impl Recipe {
    pub(crate) const PLAIN: Self = Self {
        encoding: Encoding::HashGrid(2),
        dtype: DType::F32,
        shading: Shading::PerSample,
        sh_degree: 3,
        occupancy: Some(16),
        seed: 1,
    };

    /// Every encoding with every stored type that it has and every shading, with and without
    /// occupancy; the degree of the harmonics goes round.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let encodings = [1, 2, 4, 8]
            .map(Encoding::HashGrid)
            .into_iter()
            .chain([Encoding::Corners(2), Encoding::Corners(4)]);
        let decoded = encodings.enumerate().flat_map(|(e, encoding)| {
            (0..12).map(move |n| Self {
                encoding,
                dtype: match n {
                    8.. => DType::I8,
                    _ if n & 1 == 0 => DType::F32,
                    _ => DType::F16,
                },
                shading: if n & 2 == 0 { Shading::PerSample } else { Shading::PerRay },
                // 24 cells are no power of two: cell walls are rounded numbers.
                occupancy: (n & 4 != 0 || n == 9).then_some(if n & 1 == 0 { 16 } else { 24 }),
                sh_degree: 1 + (e as u32 + n) % 4,
                seed: 1000 + 8 * e as u64 + u64::from(n) + if n < 8 { 0 } else { 1000 },
            })
        });
        let others = Self::nerfs().chain(Self::voxels()).chain(Self::planes()).chain(Self::derfs());
        decoded.chain(others)
    }

    /// Builds the model; its bytes are never freed.
    pub(crate) fn build(self) -> Model<'static> {
        let mut tensors = Tensors { random: Random(self.seed), dtype: self.dtype, made: 0 };
        let field = match self.encoding {
            Encoding::HashGrid(n_features_per_level) | Encoding::Corners(n_features_per_level) => {
                let index = match self.encoding {
                    Encoding::Corners(_) => corners(),
                    _ => GridIndex::Blocked,
                };
                let grid = tensors.hash_grid(n_features_per_level, index);
                if tensors.dtype == DType::I8 {
                    tensors.dtype = DType::F16;
                }
                let decoder = self.decoder(&mut tensors, grid.config.n_output());
                AnyField::HashGrid(HashGridField { grid, decoder })
            }
            Encoding::Planes(n_components) => {
                let planes = tensors.planes(n_components);
                if tensors.dtype == DType::I8 {
                    tensors.dtype = DType::F16;
                }
                let decoder = self.decoder(&mut tensors, planes.n_output());
                AnyField::Planes(PlanesField { planes, decoder })
            }
            Encoding::Derf(heads) => AnyField::Derf(tensors.derf(heads, self.sh_degree > 1)),
            Encoding::Nerf(nerf) => AnyField::Nerf(nerf.build(&mut tensors)),
            Encoding::Voxels(resolution) => AnyField::Plenoxels(PlenoxelField {
                grid: tensors.voxels(resolution, PlenoxelField::n_values(self.sh_degree)),
                sh_degree: self.sh_degree,
                log_density_bias: -1.0,
            }),
        };
        let model = Model {
            field,
            space: Space::Box { min: [-1.0, -0.75, -1.0], max: [1.0, 0.75, 0.5] },
            occupancy: self.occupancy.map(|n| occupancy(n, &mut tensors.random)),
            sampling: Sampling { step: 0.03, near: 0.5, far: 6.0, min_transmittance: 1e-4 },
            hierarchical: None,
            display: Display {
                background: [1.0, 0.5, 0.25],
                color_space: ColorSpace::Srgb,
                tolerance: Display::TOLERANCE,
            },
        };
        model.validate().expect("a model that fits together");
        model
    }

    fn decoder(self, tensors: &mut Tensors, n_encoded: usize) -> Decoder<'static> {
        const N_FEATURES: u32 = 7;
        let n_color = (N_FEATURES + self.sh_degree * self.sh_degree) as usize;
        let density = [
            tensors.dense(n_encoded, 24, 1.0, true),
            // 13 is no multiple of what a kernel computes at a time.
            tensors.dense(24, 13, 1.0, false),
            tensors.dense(13, 1 + N_FEATURES as usize, 4.0, true),
        ];
        let color = [tensors.dense(n_color, 16, 1.0, true), tensors.dense(16, 3, 2.0, false)];
        Decoder {
            density: Mlp::new(&density).unwrap(),
            color: Mlp::new(&color).unwrap(),
            n_features: N_FEATURES,
            sh_degree: self.sh_degree,
            shading: self.shading,
            log_density_bias: -1.0,
        }
    }
}

/// Makes tensors of random values.
pub(crate) struct Tensors {
    random: Random,
    pub dtype: DType,
    made: usize,
}

impl Tensors {
    /// Uniform values in [-amplitude, amplitude). Half precision is stored with a
    /// scale of its own for each tensor, never 1.
    pub(crate) fn tensor(
        &mut self,
        rows: usize,
        cols: usize,
        amplitude: f32,
    ) -> TensorView<'static> {
        let scale_log2 = match self.dtype {
            DType::F16 => [-9, 3, -2, 6][self.made % 4],
            // Whole numbers from -128 to 127.
            DType::I8 => -7,
            _ => 0,
        };
        self.made += 1;
        let scale = f32::from(scale_log2).exp2();
        let mut bytes = Vec::new();
        for _ in 0..rows * cols {
            let stored = self.random.signed() * amplitude / scale;
            match self.dtype {
                DType::F16 => bytes.extend(half::f16::from_f32(stored).to_le_bytes()),
                DType::I8 => bytes.push((stored.floor() as i8).cast_unsigned()),
                _ => bytes.extend(stored.to_le_bytes()),
            }
        }
        let shape = [rows as u32, cols as u32];
        TensorView::new(bytes.leak(), self.dtype, shape, scale_log2, Layout::RowMajor).unwrap()
    }

    /// A layer that keeps the spread of its inputs, times `gain`.
    pub(crate) fn dense(
        &mut self,
        n_in: usize,
        n_out: usize,
        gain: f32,
        bias: bool,
    ) -> Dense<'static> {
        let weight = self.tensor(n_in, n_out, gain * (6.0 / n_in as f32).sqrt());
        Dense { weight, bias: bias.then(|| self.tensor(1, n_out, 0.5)) }
    }

    /// Heads somewhere in the unit cube, whose layers fill no panel.
    fn derf(&mut self, n_heads: u32, directed: bool) -> DerfField<'static> {
        let shape = HeadShape {
            octaves: 2,
            direction_octaves: directed.then_some(1),
            depth: 3,
            width: 20,
            skip: 2,
            color_width: 9,
            activation: Activation::Exp,
        };
        let heads = self.tensor(n_heads as usize, shape.n_parameters(), 0.5);
        let sites = (0..3 * n_heads).flat_map(|_| self.random.unit().to_le_bytes());
        let sites: Vec<u8> = sites.collect();
        let (shape_of_sites, layout) = ([n_heads, 3], Layout::RowMajor);
        let sites = TensorView::new(sites.leak(), DType::F32, shape_of_sites, 0, layout).unwrap();
        DerfField { shape, sites, heads, density_scale: 3.0 }
    }

    /// Few entries: products vary from one place to the next.
    fn planes(&mut self, n_components: u32) -> Planes<'static> {
        const RESOLUTION: u32 = 13;
        let mut pairs = [planes::Pair::EMPTY; planes::MAX_PAIRS];
        for pair in &mut pairs[..Planes::n_pairs(n_components)] {
            let mut table = |rows: u32| self.tensor(rows as usize, planes::FEATURES, 1.0);
            *pair = planes::Pair { plane: table(RESOLUTION.pow(2)), line: table(RESOLUTION) };
        }
        Planes { resolution: RESOLUTION, n_components, pairs }
    }

    /// Half of the bricks hold nothing, and some share what they hold.
    fn voxels(&mut self, resolution: u32, n_values: usize) -> VoxelGrid<'static> {
        const N_BRICKS: u32 = 20;
        let along = resolution / 4 + 1;
        let numbers = (0..along.pow(3)).flat_map(|_| {
            let number = (2.0 * self.random.signed() * N_BRICKS as f32) as i32;
            (number.clamp(0, N_BRICKS as i32 - 1) as u16).to_le_bytes()
        });
        let numbers: Vec<u8> = numbers.collect();
        let shape = [along.pow(3), 1];
        let index =
            TensorView::new(numbers.leak(), DType::U16, shape, 0, Layout::RowMajor).unwrap();
        VoxelGrid { resolution, index, values: self.tensor(64 * N_BRICKS as usize, n_values, 1.0) }
    }

    /// Coarse levels are dense, fine ones hashed.
    fn hash_grid(&mut self, n_features_per_level: u32, index: GridIndex) -> HashGrid<'static> {
        let config = HashGridConfig {
            n_levels: 6,
            n_features_per_level,
            log2_hashmap_size: 10,
            base_resolution: 4,
            per_level_scale: 1.5,
            index,
        };
        assert!(config.level(0).dense_side > 0, "a dense level");
        assert_eq!(config.level(5).dense_side, 0, "a hashed level");
        let mut levels = [TensorView::EMPTY; MAX_LEVELS];
        for (l, table) in levels.iter_mut().enumerate().take(config.n_levels as usize) {
            let entries = config.level(l).entries as usize;
            *table = self.tensor(entries, n_features_per_level as usize, 1.0);
        }
        HashGrid { config, levels }
    }
}

/// Levels of 3 to 29 cells, some of whose corners go around their table.
fn corners() -> GridIndex {
    let mut levels = [CornerLevel::default(); MAX_LEVELS];
    let sizes = [(3.0, 4, 64), (5.0, 7, 344), (8.0, 9, 736), (12.5, 0, 1024), (19.25, 0, 512)];
    for (level, (scale, side, entries)) in levels.iter_mut().zip(sizes) {
        *level = CornerLevel { scale, side, entries };
    }
    levels[5] = CornerLevel { scale: 29.375, ..levels[3] };
    GridIndex::Corners(CornerLevels { shift: 0.5, levels })
}

/// Blocks that are empty, full or sprinkled with cells.
pub(crate) fn occupancy(resolution: u32, random: &mut Random) -> Occupancy<'static> {
    let (mut coarse, mut fine) = (Vec::new(), Vec::new());
    let mut filled = 0u16;
    for _ in 0..(resolution / 8).pow(3) {
        let fraction = [0.0, 0.0, 0.3, 1.0][(random.unit() * 4.0) as usize];
        if fraction == 0.0 {
            coarse.extend([0, 0]);
            continue;
        }
        filled += 1;
        coarse.extend(filled.to_le_bytes());
        for _ in 0..64 {
            let bits = (0..8).map(|x| u8::from(random.unit() < fraction) << x);
            fine.push(bits.fold(0, |all, bit| all | bit));
        }
    }
    Occupancy::new(resolution, 1, coarse.leak(), fine.leak()).unwrap()
}

/// The same field in normalised device coordinates, before the [camera], that looks
/// forwards at most of its pixels; its box ends before infinity.
pub(crate) fn in_ndc(model: Model<'static>) -> Model<'static> {
    let (min, max) = ([-1.6, -1.2, -1.0], [1.2, 1.6, 0.9]);
    let model = Model {
        space: Space::Ndc(Ndc { near: 1.0, slope: [1.2, 1.6], min, max }),
        sampling: Sampling { near: 0.25, ..model.sampling },
        ..model
    };
    model.validate().expect("a space that is one");
    model
}

/// The same field in contracted space, around the [camera] and beyond it: rays bend.
pub(crate) fn in_contracted(model: Model<'static>) -> Model<'static> {
    let space = Space::Contracted(Contracted { center: [0.3, -0.2, 0.1], radius: 1.4 });
    let model = Model { space, sampling: Sampling { near: 0.1, ..model.sampling }, ..model };
    model.validate().expect("a space that is one");
    model
}

/// A camera that sees all of the box, and past it.
pub(crate) fn camera(width: u32, height: u32) -> Camera {
    let pose = Camera::look_at([1.6, 1.1, 2.2], [0.0, 0.0, -0.2], [0.0, 1.0, 0.0]);
    Camera::from_fov_x(width, height, 1.0, pose)
}
