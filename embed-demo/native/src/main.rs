//! `pocketnerf-view`: a window on a `.pnerf` file.
#![forbid(unsafe_code)]

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser};
use pocketnerf_view::output::Request;
use pocketnerf_view::paint::Painter;
use pocketnerf_view::paint::modes::Mode;
use pocketnerf_view::show::Show;
use pocketnerf_view::view::View;
use pocketnerf_view::window::{self, Settings, input, script};
use pocketnerf_view::{Failure, say};

/// The model that `pocketnerf demo --log2-hashmap-size 12` makes of the built-in scene.
const STILL_LIFE: &[u8] = include_bytes!("../../still-life.pnerf");

/// Shows a .pnerf file in a window, rendered on the CPU
#[derive(Debug, Parser)]
#[command(version, after_help = input::HELP)]
struct Arguments {
    /// Model file [default: a still life that is part of this program]
    model: Option<PathBuf>,
    /// What to show
    #[arg(long, value_enum, value_name = "WHAT", default_value_t)]
    mode: Mode,
    /// Width and height in pixels [default: as the model file says]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    window: WindowOptions,
    #[command(flatten)]
    output: OutputOptions,
    /// From 0 (fastest) to 1 (every pixel is rendered) for the picture at rest [default: as
    /// the model file says, or 0.5]
    #[arg(long, value_name = "Q", value_parser = parse_quality, help_heading = "Rendering")]
    quality: Option<f32>,
    /// Device that renders colours and depths; if no GPU works, the CPU does
    #[cfg(feature = "gpu")]
    #[arg(long, value_enum, value_name = "DEVICE", default_value_t, help_heading = "Rendering")]
    device: Device,
    /// Number of worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
        help_heading = "Common options")]
    threads: Option<u16>,
}

/// What renders.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Device {
    #[default]
    Cpu,
    Gpu,
}

/// How the window behaves.
#[derive(Debug, Args)]
#[command(next_help_heading = "Window")]
struct WindowOptions {
    /// Pictures per second while something moves; their size is chosen to hold it
    #[arg(long, value_name = "F", default_value = "30", value_parser = parse_fps)]
    fps: f64,
    /// Start without the overlay (key h)
    #[arg(long)]
    no_overlay: bool,
    /// Folder for screenshots (key s)
    #[arg(long, value_name = "DIR", default_value = ".")]
    screenshots: PathBuf,
    #[arg(long, value_name = "FILE", help = script::HELP.0, long_help = script::HELP.1,
        conflicts_with = "headless")]
    script: Option<PathBuf>,
}

/// What is made in place of a window.
#[derive(Debug, Args)]
#[command(next_help_heading = "Without a window")]
struct OutputOptions {
    /// Write a picture
    #[arg(long)]
    headless: bool,
    /// File for one picture, folder for several; implies --headless [default: view.png or
    /// orbit]
    #[arg(long, value_name = "FILE|DIR", conflicts_with_all = ["script", "terminal"])]
    out: Option<PathBuf>,
    /// Render N views on a circle around the scene; implies --headless
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000),
        conflicts_with_all = ["script", "terminal"])]
    orbit: Option<u32>,
    /// Print the picture as text in 24-bit colours; implies --headless
    #[arg(long, conflicts_with = "script")]
    terminal: bool,
    /// Columns of --terminal [default: those of the terminal]
    #[arg(long, value_name = "COLUMNS", requires = "terminal",
        value_parser = clap::value_parser!(u32).range(1..=4096))]
    width: Option<u32>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("pocketnerf-view: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (name, bytes) = match &arguments.model {
        Some(path) => (path.display().to_string(), Cow::Owned(read(path)?)),
        None => ("still life".to_owned(), Cow::Borrowed(STILL_LIFE)),
    };
    let refused = |e| format!("{name}: {e}; give a model that `pocketnerf info` can read");
    let bytes = pocketnerf_formats::unpacked(&bytes).map_err(refused)?;
    let file = pocketnerf_formats::open_verified(&bytes).map_err(refused)?;
    // The same pictures in less time, for some memory.
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    let view = View::new(&file);
    let quality = arguments.quality.or(file.about.quality).unwrap_or(0.5);
    let painter = Painter::new(&model, arguments.threads.unwrap_or(0).into())?;
    #[cfg(feature = "gpu")]
    let painter = on_device(painter, arguments.device);
    let output = &arguments.output;
    if output.headless || output.out.is_some() || output.orbit.is_some() || output.terminal {
        let (default, terminal) = match output.orbit {
            Some(_) => ("orbit", None),
            None => ("view.png", output.terminal.then(|| output.width.unwrap_or(0))),
        };
        let request = Request {
            mode: arguments.mode,
            quality,
            size: arguments.size,
            orbit: output.orbit,
            terminal,
            out: output.out.clone().unwrap_or_else(|| default.into()),
        };
        say(request.run(&painter, &view)?.trim_end_matches('\n'));
        return Ok(());
    }
    let options = &arguments.window;
    let script = options.script.as_deref().map(read_script).transpose()?;
    let stem = arguments.model.as_deref().and_then(Path::file_stem);
    let settings = Settings {
        stem: stem.map_or_else(|| "still-life".to_owned(), |stem| stem.to_string_lossy().into()),
        name: stem.map_or(name, |stem| stem.to_string_lossy().into()),
        size: arguments.size,
        overlay: !options.no_overlay,
        screenshots: options.screenshots.clone(),
        script,
    };
    window::run(Show::new(painter, view, arguments.mode, quality, options.fps), settings)
}

/// The same painter on a GPU, if one is wanted and there is one; else a warning says why not.
#[cfg(feature = "gpu")]
fn on_device(painter: Painter<'_>, device: Device) -> Painter<'_> {
    if device == Device::Cpu {
        return painter;
    }
    match pocketnerf_gpu::Gpu::open(pocketnerf_gpu::Software::from_environment()) {
        Ok(gpu) => painter.on(&gpu),
        Err(why) => {
            eprintln!("warning: {why}: pictures are rendered on the CPU");
            painter
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = std::fs::read(path);
    Ok(bytes.map_err(|e| format!("{}: cannot be read: {e}; give a .pnerf file", path.display()))?)
}

fn read_script(path: &Path) -> Result<Vec<script::Line>, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| format!("{}: cannot be read: {e}; give a text file", path.display()))?;
    Ok(script::parse(&text).map_err(|e| format!("{}: {e}", path.display()))?)
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
