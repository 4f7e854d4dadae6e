//! Random numbers that depend on a seed and a place, not on the order of calls.

use pocketnerf_core::math;

/// A small generator: SplitMix64.
///
/// Streams made from different places are independent for all purposes here,
/// so that every ray, cell or parameter draws the same numbers at any thread
/// count.
#[derive(Clone, Copy, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of `seed` at a place, such as (purpose, step, ray).
    #[must_use]
    pub fn new(seed: u64, place: [u64; 3]) -> Self {
        let mut state = mix(seed ^ 0x9e37_79b9_7f4a_7c15);
        for p in place {
            state = mix(state ^ p.wrapping_mul(0xd1b5_4a32_d192_ed03));
        }
        Self { state }
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.state)
    }

    /// Uniform in [0, 1).
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Uniform in 0 .. n.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }
}

/// Normally distributed with mean 0 and variance 1, by Box and Muller's method.
#[must_use]
pub fn normal(random: &mut Random) -> f32 {
    let (u, v) = (1.0 - random.next_f32(), random.next_f32());
    (-2.0 * math::ln(u)).sqrt() * math::cos(std::f32::consts::TAU * v)
}

/// The finaliser of SplitMix64 (Steele et al. 2014).
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_and_repeatable() {
        let mut sum = 0.0;
        let mut counts = [0usize; 7];
        for place in 0..20_000 {
            let mut random = Random::new(5, [1, 2, place]);
            sum += f64::from(random.next_f32());
            counts[random.below(7)] += 1;
        }
        assert!((sum / 20_000.0 - 0.5).abs() < 0.01);
        assert!(counts.iter().all(|c| (2600..3100).contains(c)), "{counts:?}");
        let draw = |seed, place| Random::new(seed, place).next_u64();
        assert_eq!(draw(1, [2, 3, 4]), draw(1, [2, 3, 4]));
        assert_ne!(draw(1, [2, 3, 4]), draw(1, [2, 4, 3]));
        assert_ne!(draw(1, [2, 3, 4]), draw(2, [2, 3, 4]));
    }
}
