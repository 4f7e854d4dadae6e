//! Options of commands that render, and of those that compute with vector instructions.

use clap::{Args, ValueEnum};
use pocketnerf_core::{Camera, SimdLevel};
use pocketnerf_formats::DefaultCamera;
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

/// Pixels that differ from those of the photographs by more than so many times are said.
const LIKE: f32 = 1.5;

/// What to say of pictures whose pixels are larger or smaller than those of the photographs that
/// a model has learnt from.
pub(super) fn size_doubt(own: Option<DefaultCamera>, camera: &Camera) -> Option<String> {
    let own = own?.camera();
    let pixel = |camera: &Camera| 1.0 / camera.focal[0];
    let times = pixel(camera) / pixel(&own);
    if times > LIKE {
        Some(format!(
            "pictures of {} pixels show {times:.1} times as much in a pixel as the photographs: \
             edges are jagged; render them larger and scale them down",
            camera.width
        ))
    } else if times < 1.0 / LIKE {
        Some(format!(
            "pictures of {} pixels show {:.1} times as little in a pixel as the photographs: no \
             photograph shows such details; train on larger ones",
            camera.width,
            1.0 / times
        ))
    } else {
        None
    }
}

impl Rendering {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_other_pixels_are_said() {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let at = |width: u32| Camera::from_fov_x(width, width, 0.7, pose);
        let own = DefaultCamera { camera_to_world: pose, fov_x: 0.7, width: 800, height: 800 };
        let said = |width: u32| size_doubt(Some(own), &at(width));
        assert_eq!((said(800), said(600), said(1100)), (None, None, None));
        assert!(said(200).unwrap().contains("4.0 times as much"));
        assert!(said(1600).unwrap().contains("2.0 times as little"));
        assert_eq!(size_doubt(None, &at(100)), None);
    }
}
