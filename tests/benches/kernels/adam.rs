//! A step of the optimizer over a level of 2^16 entries with four features.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use fearless_simd::dispatch;
use pocketnerf_train::field::rounding::EightBits;
use pocketnerf_train::random::Random;
use pocketnerf_train::trainer::{Adam, Slices};

use crate::synthetic::{level, numbers};

const PARAMETERS: usize = 4 << 16;
/// Entries of a grid change in blocks of eight.
const BLOCK: usize = 32;

/// `touched`: percentage of the blocks that have a gradient.
#[divan::bench(args = [0, 25, 100])]
fn step(bencher: Bencher<'_, '_>, touched: usize) {
    let mut random = Random::new(2, [0; 3]);
    let mut given = numbers(0, PARAMETERS, -1.0, 1.0);
    for block in given.chunks_mut(BLOCK) {
        if random.below(100) >= touched {
            block.fill(0.0);
        }
    }
    let mut parameters = numbers(1, PARAMETERS, -1.0, 1.0);
    let mut square = vec![0.0; PARAMETERS];
    let mut rounded = vec![0; PARAMETERS];
    let rounding = EightBits::at(-7).expect("within the range");
    let adam = Adam { beta1: 0.0, ..Adam::default() };
    let rate = adam.corrected(1e-3, 10);
    let level = level();
    let bencher = bencher.counter(ItemsCount::new(PARAMETERS));
    // The step leaves zeros: each needs gradients of its own.
    bencher.with_inputs(|| given.clone()).bench_local_refs(|gradient| {
        dispatch!(level, simd => adam.update(simd, rate, rounding, Slices {
            parameters: &mut parameters,
            gradient,
            mean: &mut [],
            square: &mut square,
            rounded: &mut rounded,
        }));
        black_box(&mut parameters);
    });
}
