//! Options of commands that render, and of those that compute with vector instructions.

use clap::{Args, ValueEnum};
use pocketnerf_core::SimdLevel;
use pocketnerf_train::picture::{self, Settings};

use super::parse::{parse_quality, parse_simd};

/// Where the samples of a ray lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Sampling {
    /// Equal steps through occupied cells, until almost no light is left
    #[default]
    Occupancy,
    /// A fixed number per ray: evenly spaced, then where these have weight
    Hierarchical,
}

impl From<Sampling> for picture::Sampling {
    fn from(sampling: Sampling) -> Self {
        match sampling {
            Sampling::Occupancy => Self::Occupancy,
            Sampling::Hierarchical => Self::Hierarchical,
        }
    }
}

/// Which vector instructions a command uses.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = super::COMMON)]
pub(super) struct Vectors {
    /// Vector instructions: portable, sse4.2, avx2, avx512 or neon [default: the best
    /// available]
    #[arg(long, value_name = "LEVEL", value_parser = parse_simd)]
    pub(super) simd: Option<SimdLevel>,
}

impl Vectors {
    /// The level to use.
    pub(super) fn level(self) -> SimdLevel {
        self.simd.unwrap_or_else(SimdLevel::detect)
    }
}

/// How a command renders.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Rendering")]
pub(super) struct Rendering {
    /// From 0 (fastest) to 1 (every pixel is rendered) [default: as the model file says, or
    /// 0.5]
    #[arg(long, value_name = "Q", value_parser = parse_quality)]
    quality: Option<f32>,
    /// Disable empty-space skipping (slower; for debugging)
    #[arg(long)]
    no_skip: bool,
    #[command(flatten)]
    pub(super) vectors: Vectors,
}

impl Rendering {
    /// What to say of pictures that are to be compared and are not the model's best: at 0 lego
    /// loses 0.9 dB, the still life 1.2, at 0.25 they lose 0.2 and 0.0 (planes of 34 to 35 dB).
    pub(super) fn doubt(self) -> Option<String> {
        const LEAST: f32 = 0.25;
        let quality = self.quality.filter(|quality| *quality < LEAST)?;
        Some(format!(
            "--quality {quality}: about 1 dB is lost for speed; expected at least {LEAST} for the \
             model's own score"
        ))
    }

    /// The settings for a model with this [quality](pocketnerf_formats::About::quality) of
    /// its own.
    pub(super) fn settings(self, own: Option<f32>) -> Settings {
        let usual = Settings::default();
        Settings {
            simd: self.vectors.level(),
            skip: !self.no_skip,
            quality: self.quality.or(own).unwrap_or(usual.quality),
            ..usual
        }
    }
}
