//! The quantities that a chart can show.

use super::Point;

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Small figures.
    Less,
    /// Large figures.
    More,
}

/// A figure of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Axis {
    /// Peak signal-to-noise ratio, dB
    Psnr,
    /// PSNR of the worst view, dB
    PsnrMin,
    /// Structural similarity
    Ssim,
    /// Structural similarity at five scales
    MsSsim,
    /// Learned perceptual distance
    Lpips,
    /// Mean error of the depth, scene units
    DepthError,
    /// Milliseconds per picture
    MsPerFrame,
    /// Rays, or pixels, per second
    RaysPerSecond,
    /// Seconds of training
    TrainSeconds,
    /// Size of the model file
    Bytes,
    /// Evaluations of the field per pixel
    SamplesPerRay,
    /// Memory for rendering beside file and picture, bytes
    RenderMemory,
    /// Peak memory of training, bytes
    TrainMemory,
}

impl Axis {
    /// Every axis: accuracy first, then costs.
    pub const ALL: [Self; 13] = [
        Self::Psnr,
        Self::PsnrMin,
        Self::Ssim,
        Self::MsSsim,
        Self::Lpips,
        Self::DepthError,
        Self::MsPerFrame,
        Self::RaysPerSecond,
        Self::TrainSeconds,
        Self::Bytes,
        Self::SamplesPerRay,
        Self::RenderMemory,
        Self::TrainMemory,
    ];

    /// The key of the figure in `points.csv` and `points.json`.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Psnr => "psnr",
            Self::PsnrMin => "psnr_min",
            Self::Ssim => "ssim",
            Self::MsSsim => "ms_ssim",
            Self::Lpips => "lpips",
            Self::DepthError => "depth_error",
            Self::MsPerFrame => "ms_per_frame",
            Self::RaysPerSecond => "rays_per_second",
            Self::TrainSeconds => "train_seconds",
            Self::Bytes => "bytes",
            Self::SamplesPerRay => "samples_per_ray",
            Self::RenderMemory => "render_memory_bytes",
            Self::TrainMemory => "train_memory_bytes",
        }
    }

    /// The label of the axis.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Psnr => "PSNR, dB",
            Self::PsnrMin => "PSNR of the worst view, dB",
            Self::Ssim => "SSIM",
            Self::MsSsim => "MS-SSIM",
            Self::Lpips => "LPIPS",
            Self::DepthError => "depth error, scene units",
            Self::MsPerFrame => "ms a frame",
            Self::RaysPerSecond => "rays a second",
            Self::TrainSeconds => "seconds of training",
            Self::Bytes => "bytes of the model",
            Self::SamplesPerRay => "samples a ray",
            Self::RenderMemory => "bytes to render with",
            Self::TrainMemory => "bytes to train with",
        }
    }

    /// Which way is better.
    #[must_use]
    pub const fn better(self) -> Better {
        match self {
            Self::Psnr | Self::PsnrMin | Self::Ssim | Self::MsSsim | Self::RaysPerSecond => {
                Better::More
            }
            _ => Better::Less,
        }
    }

    /// Whether it is a measure of accuracy, not a cost.
    #[must_use]
    pub const fn is_accuracy(self) -> bool {
        matches!(
            self,
            Self::Psnr | Self::PsnrMin | Self::Ssim | Self::MsSsim | Self::Lpips | Self::DepthError
        )
    }

    /// Whether it is as unsteady as the times of pictures are.
    #[must_use]
    pub const fn is_time(self) -> bool {
        matches!(self, Self::MsPerFrame | Self::RaysPerSecond)
    }

    /// The point's figure, if it is known and finite. Equal pictures, whose PSNR is
    /// infinite, have none.
    #[must_use]
    pub fn value(self, point: &Point) -> Option<f64> {
        let count = |n: Option<u64>| n.map(|n| n as f64);
        let value = match self {
            Self::Psnr => point.psnr,
            Self::PsnrMin => point.psnr_min,
            Self::Ssim => point.ssim,
            Self::MsSsim => point.ms_ssim,
            Self::Lpips => point.lpips,
            Self::DepthError => point.depth_error,
            Self::MsPerFrame => point.ms_per_frame,
            Self::RaysPerSecond => point.rays_per_second,
            Self::TrainSeconds => point.train_seconds,
            Self::Bytes => count(point.bytes),
            Self::SamplesPerRay => point.samples_per_ray,
            Self::RenderMemory => count(point.render_memory_bytes),
            Self::TrainMemory => count(point.train_memory_bytes),
        };
        value.filter(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_those_of_the_files() {
        let point = serde_json::to_value(Point::default()).unwrap();
        for axis in Axis::ALL {
            assert!(point.get(axis.key()).is_some(), "{}", axis.key());
        }
    }
}
