//! Numbers for kernels to work on, the same in every run.

use fearless_simd::Level;
use half::f16;
use pocketnerf_core::{DType, SimdLevel};
use pocketnerf_train::random::Random;

/// Points of a batch, as in `Tuning::FAST`.
pub(crate) const POINTS: usize = 1024;

/// The best vector instructions of this machine.
pub(crate) fn level() -> Level {
    SimdLevel::detect().token().expect("detected")
}

/// Uniform from `low` to `high`; `place` chooses which numbers.
pub(crate) fn numbers(place: u64, n: usize, low: f32, high: f32) -> Vec<f32> {
    let mut random = Random::new(1, [place, 0, 0]);
    (0..n).map(|_| low + (high - low) * random.next_f32()).collect()
}

/// Numbers as a model file holds them.
pub(crate) fn stored(dtype: DType, numbers: &[f32]) -> Vec<u8> {
    let bytes = |v: &f32| match dtype {
        DType::F16 => f16::from_f32(*v).to_le_bytes().to_vec(),
        DType::I8 => vec![((127.0 * v) as i8).cast_unsigned()],
        _ => v.to_le_bytes().to_vec(),
    };
    numbers.iter().flat_map(bytes).collect()
}

/// A stored type that kernels are generic over, and its name in a tensor.
pub(crate) trait Stored: pocketnerf_core::store::Store {
    const DTYPE: DType;
}

impl Stored for pocketnerf_core::store::F32 {
    const DTYPE: DType = DType::F32;
}

impl Stored for pocketnerf_core::store::F16 {
    const DTYPE: DType = DType::F16;
}

impl Stored for pocketnerf_core::store::I8 {
    const DTYPE: DType = DType::I8;
}
