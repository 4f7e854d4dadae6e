//! How the networks follow their gradient on the GPU, and where other kernels read them.

use bytemuck::{Pod, Zeroable};
use pocketnerf_core::field::Decoder;
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{DType, Layout, TensorView};

use super::fixed::Fixed;
use super::networks::Networks;
use super::pipelines::Pipelines;
use super::sequence::Sequence;
use crate::pack::network_rows;
use crate::render::{Error, Gpu};

/// Marks what is laid out as it is, not rounded: `networks.wgsl`.
const EXACT: u32 = 1 << 31;
/// What is added to a parameter's number to say so; more parameters no network has, and f32 holds
/// all these numbers.
const EXACT_FROM: u32 = 1 << 23;

/// `Range` in `networks.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
struct Range {
    first: u32,
    rows: u32,
    columns: u32,
    scratch: u32,
}

/// A parameter and what is kept of it: `Learnt` in `networks.wgsl`.
pub(super) type LearntNumbers = [f32; 4];

/// The networks' parameters, and what brings them further.
#[derive(Debug)]
pub(super) struct Following {
    pub(super) learnt: wgpu::Buffer,
    follow: wgpu::BindGroup,
    n_ranges: u32,
    /// What lays them out for both readers, and how many numbers.
    lay_out: [(wgpu::BindGroup, u32); 2],
}

impl Following {
    /// For networks like those of `decoder`.
    pub(super) fn new(
        gpu: &Gpu,
        p: &Pipelines,
        fixed: &Fixed,
        networks: &Networks,
        decoder: &Decoder<'_>,
    ) -> Result<Self, Error> {
        use wgpu::BufferUsages as Usage;
        let (ranges, n_scratch) = ranges(networks.layers());
        let storage = |what, numbers: usize, more: Usage| {
            gpu.buffer(what, 4 * numbers as u64, Usage::STORAGE | more)
        };
        let (read, write) = (Usage::COPY_SRC, Usage::COPY_DST);
        let learnt = storage("networks", 4 * networks.n_parameters, read | write)?;
        let scratch = storage("networks", n_scratch.max(4), Usage::empty())?;
        let own = gpu.upload("networks", bytemuck::cast_slice(&ranges))?;
        let follow = [
            (0, &fixed.frame),
            (9, &fixed.counters),
            (26, &fixed.gradient),
            (43, &own),
            (44, &learnt),
            (45, &scratch),
        ];
        let sources = sources(networks, decoder)?;
        let lay_out = |sources: &[u32], to| -> Result<_, Error> {
            let own = gpu.upload("networks", bytemuck::cast_slice(sources))?;
            let buffers = [(44, &learnt), (46, &own), (47, to)];
            Ok((p.lay_out.group(gpu, &buffers)?, sources.len() as u32))
        };
        Ok(Self {
            follow: p.follow.group(gpu, &follow)?,
            n_ranges: ranges.len() as u32,
            lay_out: [
                lay_out(&sources[0], &fixed.matrices)?,
                lay_out(&sources[1], &fixed.weights)?,
            ],
            learnt,
        })
    }

    /// New parameters from their gradient.
    pub(super) fn follow(&self, p: &Pipelines, to: &mut Sequence<'_>) {
        p.follow.run(to, &self.follow, [self.n_ranges, 1, 1]);
        self.lay_out(p, to);
    }

    /// Where other kernels read them.
    pub(super) fn lay_out(&self, p: &Pipelines, to: &mut Sequence<'_>) {
        for (group, n) in &self.lay_out {
            p.lay_out.run(to, group, [n.div_ceil(64), 1, 1]);
        }
    }
}

/// Weights and bias of layers with so many inputs and outputs, and the numbers that their matrices
/// need beside.
fn ranges(layers: impl Iterator<Item = [u32; 2]>) -> (Vec<Range>, usize) {
    let (mut ranges, mut first, mut scratch) = (Vec::new(), 0, 0);
    for [rows, columns] in layers {
        for rows in [rows, 1] {
            ranges.push(Range { first, rows, columns, scratch });
            first += rows * columns;
            let side = rows.min(columns);
            // Two of the matrix, and two squares.
            scratch += if rows > 1 { 2 * (rows * columns + side * side) } else { 0 };
        }
    }
    (ranges, scratch as usize)
}

/// Of each number of the matrices, and of the rows that pictures have, which parameter it is: their
/// layouts of networks whose parameters are their own numbers.
fn sources(networks: &Networks, decoder: &Decoder<'_>) -> Result<[Vec<u32>; 2], Error> {
    let n = networks.n_parameters as u32;
    let own: Vec<[u8; 4]> = (1..=n).map(|number| (number as f32).to_le_bytes()).collect();
    let exact: Vec<f32> = (1..=n).map(|number| (number + EXACT_FROM) as f32).collect();
    let mut rest = own.as_flattened();
    let mut tensor = |rows: u32, columns: u32| -> Result<TensorView<'_>, pocketnerf_core::Error> {
        let bytes = rest.split_off(..4 * (rows * columns) as usize).unwrap_or_default();
        TensorView::new(bytes, DType::F32, [rows, columns], 0, Layout::RowMajor)
    };
    let mut network = |widths: &[u32]| -> Result<Mlp<'_>, pocketnerf_core::Error> {
        let layers = widths.windows(2).map(|pair| {
            Ok(Dense { weight: tensor(pair[0], pair[1])?, bias: Some(tensor(1, pair[1])?) })
        });
        Mlp::new(&layers.collect::<Result<Vec<_>, pocketnerf_core::Error>>()?)
    };
    let [density, color] = &networks.widths;
    let (density, color) = (network(density)?, network(color)?);
    let matrices = networks.matrices([&density, &color], &exact);
    let rows = network_rows(&Decoder { density, color, ..*decoder });
    let source = |value: &f32| match *value as u32 {
        number if number > EXACT_FROM => EXACT | (number - EXACT_FROM),
        number => number,
    };
    Ok([matrices.iter().map(source).collect(), rows.as_flattened().iter().map(source).collect()])
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::field::Shading;

    use super::*;

    #[test]
    fn ranges_by_hand() {
        let (ranges, n) = ranges([[10, 20], [20, 3]].into_iter());
        let range = |first, rows, columns, scratch| Range { first, rows, columns, scratch };
        let all = [
            range(0, 10, 20, 0),
            range(200, 1, 20, 600),
            range(220, 20, 3, 600),
            range(280, 1, 3, 738),
        ];
        assert_eq!((&ranges[..], n), (&all[..], 738));
    }

    #[test]
    fn sources_by_hand() {
        // Two encoded values, three hidden ones, density and two features; these and one
        // harmonic become three channels.
        let networks = Networks::new(vec![2, 3, 3], vec![3, 3], 2);
        let weight = TensorView::new(&[0; 4], DType::F32, [1, 1], 0, Layout::RowMajor).unwrap();
        let other = Mlp::new(&[Dense { weight, bias: None }]).unwrap();
        let decoder = Decoder {
            density: other,
            color: other,
            n_features: 2,
            sh_degree: 1,
            shading: Shading::PerRay,
            log_density_bias: 0.0,
        };
        let [matrices, rows] = sources(&networks, &decoder).unwrap();
        assert_eq!(matrices.len(), 4 * networks.n_quads);
        // The first matrix, a row an input of sixteen outputs, and its bias; then the way back.
        assert_eq!(matrices[..5], [1, 2, 3, 0, 0]);
        assert_eq!(
            (matrices[16..20].to_vec(), matrices[32..35].to_vec()),
            (vec![4, 5, 6, 0], vec![7, 8, 9])
        );
        assert_eq!(matrices[48..51], [EXACT | 1, EXACT | 4, 0]);
        // Pictures have quads: features first, the density in a quad of its own.
        assert_eq!(rows[..4], [1, 2, 3, 0]);
        let second = 4 * 5;
        assert_eq!(rows[second..second + 8], [11, 12, 0, 0, 10, 0, 0, 0]);
    }
}
