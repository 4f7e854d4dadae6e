//! The paper's network from one end to the other: how near it comes to what the
//! machine multiplies and adds in registers.

use std::cell::RefCell;
use std::hint::black_box;

use fearless_simd::dispatch;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{Activation, Field, NerfField, NerfNetwork, Samples};
use pocketnerf_core::network::{Dense, Mlp, panel_len};
use pocketnerf_core::scratch::Workspace;
use pocketnerf_core::store::F16;
use pocketnerf_core::{DType, Error, Layout, SimdLevel, TensorView, Tuning};

use super::machine::{Machine, Rate, forward_rate};
use super::stage::{Crowd, Demand, Measured, StageCost, stages};
use crate::aligned::Aligned;

/// Samples that a thread asks for at a time, in batches as in rendering.
const SAMPLES: usize = 4096;

/// Inputs of the trunk's layers: eight of 256, the encoded position again at the sixth.
const TRUNK: [usize; 8] = [63, 256, 256, 256, 256, 63 + 256, 256, 256];

/// Times position and direction to density and colour, weights in half precision, on
/// all threads of the current pool.
///
/// # Errors
/// When the SIMD level is not there.
pub fn measure(simd: SimdLevel, machine: &Machine, quick: bool) -> Result<StageCost, Error> {
    let level = simd.token()?;
    // Which weights does not matter, as long as no product is so small that it is slow.
    let weights: Vec<u8> =
        (0..(63 + 256) * 256u32).flat_map(|i| (0x2c00 + i as u16 % 1024).to_le_bytes()).collect();
    let field = field(&weights)?;
    let batch = Tuning::FAST.samples;
    let coordinates: [Vec<f32>; 3] =
        [37, 101, 73].map(|step| (0..batch).map(|i| (i * step % 997) as f32 / 997.0).collect());
    let points = [0, 1, 2].map(|axis| &coordinates[axis][..]);
    let samples = Samples { points, directions: points };
    let rate = forward_rate(quick, SAMPLES as f64, || {
        MEMORY.with_borrow_mut(|memory| {
            let mut work = memory.get_or_insert_with(|| Memory::new(&field)).workspace();
            for _ in 0..SAMPLES / batch {
                dispatch!(level, simd => {
                    field.density_features::<_, F16>(simd, samples, &mut work);
                });
                black_box(&work.output[0]);
            }
        });
    });
    Ok(row(&field, rate, machine))
}

thread_local! {
    /// Allocated once a thread.
    static MEMORY: RefCell<Option<Memory>> = const { RefCell::new(None) };
}

/// What a [`Workspace`] borrows.
struct Memory {
    a: Aligned<f32>,
    b: Aligned<f32>,
    output: Aligned<f32>,
    panel: Aligned<f32>,
}

impl Memory {
    fn new(field: &NerfField<'_>) -> Self {
        let (limits, stride) = (field.limits(), Tuning::FAST.stride());
        Self {
            a: Aligned::new(limits.rows[0] * stride),
            b: Aligned::new(limits.rows[1] * stride),
            output: Aligned::new((1 + limits.channels) * stride),
            panel: Aligned::new(panel_len(limits.width)),
        }
    }

    fn workspace(&mut self) -> Workspace<'_> {
        let Self { a, b, output, panel } = self;
        Workspace { a, b, output, panel, stride: Tuning::FAST.stride() }
    }
}

/// The paper's network; all layers share their weights' bytes.
fn field(weights: &[u8]) -> Result<NerfField<'_>, Error> {
    let layer = |n_in: usize, n_out: usize| {
        let tensor = |rows: usize| {
            let (bytes, shape) = (&weights[..2 * rows * n_out], [rows as u32, n_out as u32]);
            TensorView::new(bytes, DType::F16, shape, -4, Layout::RowMajor)
        };
        Ok(Dense { weight: tensor(n_in)?, bias: Some(tensor(1)?) })
    };
    let trunk = TRUNK.map(|n_in| layer(n_in, 256)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let color = Mlp::new(&[layer(256 + 27, 128)?, layer(128, 3)?])?;
    let (density, feature) = (layer(256, 1)?, Some(layer(256, 256)?));
    let octaves = |n| Fourier { waves: Waves::Octaves { n, pi: false }, include_input: true };
    let field = NerfField {
        positions: octaves(10),
        directions: Some(octaves(4)),
        map: Affine::CENTRED,
        activation: Activation::Relu,
        density_scale: 1.0,
        fine: NerfNetwork::new(&trunk, [1 << 5, 0], density, feature, color)?,
        coarse: None,
    };
    field.validate()?;
    Ok(field)
}

/// Multiplications and additions of a sample, nothing that fills up a kernel.
fn flops(network: &NerfNetwork<'_>) -> f64 {
    let layers = network.trunk().iter().chain([&network.density]).chain(&network.feature);
    let layers = layers.chain(network.color.layers());
    layers.map(|layer| (2 * layer.weight.rows() * layer.weight.cols()) as f64).sum()
}

fn row(field: &NerfField<'_>, rate: Rate, machine: &Machine) -> StageCost {
    let seconds = machine.threads as f64 * SAMPLES as f64 / rate.all;
    let measured = Measured {
        name: "8x256 f16, all threads",
        unit: "sample",
        units: SAMPLES as u64,
        seconds,
        demand: Demand::fma(flops(&field.fine)),
    };
    stages(&[measured], seconds, SAMPLES as u64, machine, Crowd::All).swap_remove(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_by_hand() {
        let weights = vec![0; 2 * (63 + 256) * 256];
        let field = field(&weights).unwrap();
        let trunk = 63 * 256 + 6 * 256 * 256 + (63 + 256) * 256;
        let heads = 256 + 256 * 256 + 283 * 128 + 128 * 3;
        assert_eq!(flops(&field.fine), f64::from(2 * (trunk + heads)));
    }

    #[test]
    fn a_rate_is_found() {
        let simd = SimdLevel::detect();
        let machine = Machine::measure(simd, true).unwrap();
        let row = measure(simd, &machine, true).unwrap();
        let fraction = row.fraction_of_peak.unwrap();
        assert!(fraction > 0.01 && fraction < 3.0, "{row:?}");
        assert_eq!(row.units, 4096);
    }
}
