//! Which vector instructions a kernel may use: a value the caller passes.

use core::fmt;
use core::str::FromStr;

use fearless_simd::Level;

use crate::Error;

/// A family of vector instructions.
///
/// `detect` asks the machine (feature `std`); `compiled` answers from what the
/// build was told. Asking for a level that is not there is an error, never a
/// silent fallback.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SimdLevel {
    /// What the target guarantees and no more (SSE2 on x86-64, scalar code on a
    /// microcontroller, and everywhere with the feature `scalar`).
    Portable,
    /// x86-64-v2: 4 lanes.
    Sse42,
    /// x86-64-v3: 8 lanes, fused multiply-add.
    Avx2,
    /// Ice Lake and Zen 4 upwards: 16 lanes.
    Avx512,
    /// aarch64: 4 lanes.
    Neon,
    /// WebAssembly `simd128`: 4 lanes.
    Wasm128,
}

impl SimdLevel {
    /// Every level, weakest first.
    pub const ALL: [Self; 6] =
        [Self::Portable, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon, Self::Wasm128];

    /// The best level of this machine.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn detect() -> Self {
        Self::name_of(Level::new())
    }

    /// The best level that the build's target features promise.
    #[must_use]
    pub fn compiled() -> Self {
        Self::name_of(Level::baseline())
    }

    /// Whether a kernel can run at this level here.
    #[must_use]
    pub fn is_available(self) -> bool {
        self.token().is_ok()
    }

    /// The token that `fearless_simd` dispatches on: for the trainer, whose
    /// kernels pass through the same door.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`].
    pub fn token(self) -> Result<Level, Error> {
        #[cfg(feature = "std")]
        let best = Level::new();
        #[cfg(not(feature = "std"))]
        let best = Level::baseline();
        let level = match self {
            #[cfg(feature = "scalar")]
            Self::Portable => Some(Level::fallback()),
            #[cfg(not(feature = "scalar"))]
            Self::Portable => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Sse42 => best.as_sse4_2().map(fearless_simd::Simd::level),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => best.as_avx2().map(fearless_simd::Simd::level),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => best.as_avx512().map(fearless_simd::Simd::level),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => best.as_neon().map(fearless_simd::Simd::level),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Self::Wasm128 => best.as_wasm_simd128().map(fearless_simd::Simd::level),
            #[allow(unreachable_patterns, reason = "which levels exist depends on the target")]
            _ => None,
        };
        let _ = best;
        level.ok_or(Error::SimdUnavailable(self))
    }

    fn name_of(level: Level) -> Self {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            if level.as_avx512().is_some() {
                return Self::Avx512;
            }
            if level.as_avx2().is_some() {
                return Self::Avx2;
            }
            if level.as_sse4_2().is_some() {
                return Self::Sse42;
            }
        }
        #[cfg(target_arch = "aarch64")]
        if level.as_neon().is_some() {
            return Self::Neon;
        }
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        if level.as_wasm_simd128().is_some() {
            return Self::Wasm128;
        }
        let _ = level;
        Self::Portable
    }

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
            Self::Wasm128 => "wasm128",
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for SimdLevel {
    type Err = &'static str;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|level| level.name() == s)
            .ok_or("expected one of portable, sse4.2, avx2, avx512, neon, wasm128")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip_and_portable_is_always_there() {
        for level in SimdLevel::ALL {
            assert_eq!(level.name().parse(), Ok(level));
        }
        assert!(SimdLevel::Portable.is_available());
        assert!(SimdLevel::compiled().is_available());
    }
}
