//! The options of `pocketnerf-view`, which `pocketnerf view` has too.

use std::path::PathBuf;

use clap::Args;

use crate::paint::modes::Mode;
use crate::window::script;

/// What is shown, and how.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// Model file [default: a still life that is part of this program]
    pub model: Option<PathBuf>,
    /// What to show
    #[arg(long, value_enum, value_name = "WHAT", default_value_t)]
    pub mode: Mode,
    /// Width and height in pixels [default: as the model file says]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// How the window behaves.
    #[command(flatten)]
    pub window: WindowOptions,
    /// What is made in place of a window.
    #[command(flatten)]
    pub output: OutputOptions,
    /// From 0 (fastest) to 1 (every pixel is rendered) for the picture at rest [default: as
    /// the model file says, or 0.5]
    #[arg(long, value_name = "Q", value_parser = parse_quality, help_heading = "Rendering")]
    pub quality: Option<f32>,
    /// Device that renders colours and depths; if no GPU works, the CPU does
    #[cfg(feature = "gpu")]
    #[arg(long, value_enum, value_name = "DEVICE", default_value_t, help_heading = "Rendering")]
    pub device: Device,
}

/// What renders.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Device {
    /// The processor.
    #[default]
    Cpu,
    /// The best GPU.
    Gpu,
}

/// How the window behaves.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Window")]
pub struct WindowOptions {
    /// Pictures per second while something moves; their size is chosen to hold it
    #[arg(long, value_name = "F", default_value = "30", value_parser = parse_fps)]
    pub fps: f64,
    /// Start without the overlay (key h)
    #[arg(long)]
    pub no_overlay: bool,
    /// Folder for screenshots (key s)
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub screenshots: PathBuf,
    /// File for the camera path through keyframes (key w), for `pocketnerf render --camera-path`
    #[arg(long, value_name = "FILE", default_value = "camera_path.json")]
    pub save_path: PathBuf,
    /// Input to play.
    #[arg(long, value_name = "FILE", help = script::HELP.0, long_help = script::HELP.1,
        conflicts_with = "headless")]
    pub script: Option<PathBuf>,
}

/// What is made in place of a window.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Without a window")]
pub struct OutputOptions {
    /// Write a picture
    #[arg(long)]
    pub headless: bool,
    /// File for one picture, folder for several; implies --headless [default: view.png or
    /// orbit]
    #[arg(long, value_name = "FILE|DIR", conflicts_with_all = ["script", "terminal"])]
    pub out: Option<PathBuf>,
    /// Render N views on a circle around the scene; implies --headless
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000),
        conflicts_with_all = ["script", "terminal"])]
    pub orbit: Option<u32>,
    /// Print the picture as text in 24-bit colours; implies --headless
    #[arg(long, conflicts_with = "script")]
    pub terminal: bool,
    /// Columns of --terminal [default: those of the terminal]
    #[arg(long, value_name = "COLUMNS", requires = "terminal",
        value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub width: Option<u32>,
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
    let sides = text.split_once('x').and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT, 1 to 16384 each, as in 800x600".to_owned())
}

fn parse_quality(text: &str) -> Result<f32, String> {
    let quality = text.parse().ok().filter(|q| (0.0..=1.0).contains(q));
    quality.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

fn parse_fps(text: &str) -> Result<f64, String> {
    let fps = text.parse().ok().filter(|fps| (1.0..=240.0).contains(fps));
    fps.ok_or_else(|| "expected a number from 1 to 240".to_owned())
}
