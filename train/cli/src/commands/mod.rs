//! The command line: a thin layer over the library. One file a command.

mod bench;
mod chart;
mod convert;
mod demo;
mod eval;
mod info;
mod reading;
mod render;
mod sampling;
mod train;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, Subcommand};
use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{PixelOrigin, Precision};
use pocketnerf_train::picture;

use reading::Reading;

/// Whatever stops a command: its text is one line.
type Failure = Box<dyn std::error::Error>;

/// Radiance fields on ordinary CPUs: photos with known cameras in, a compact
/// model file out, new views from any side.
#[derive(Debug, Parser)]
#[command(version)]
struct Command {
    #[command(subcommand)]
    action: Action,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Train on the built-in scene, save, render, and compare with the truth.
    Demo(demo::Demo),
    /// Learn a model from a dataset.
    Train(train::Train),
    /// Compare a model's pictures with a dataset's.
    Eval(eval::Eval),
    /// Make a model file of what another program trained, or of a model in f32.
    ///
    /// Reads checkpoints of nerf-pytorch (yenchenlin, krrish94), nerf_pl and the original
    /// program (torch, numpy or safetensors). No pickle is ever executed.
    Convert(Box<convert::Convert>),
    /// Render pictures of a model.
    Render(render::Render),
    /// Tell what is in a model file, a checkpoint or a dataset.
    Info(info::Info),
    /// Chart accuracy against speed over a sweep of models and settings.
    Chart(Box<chart::Chart>),
    /// Measure the machine, and every stage of training and rendering.
    ///
    /// First what the machine can do, then how near each stage comes to what bounds
    /// it: multiply-adds, reads at random places or memory bandwidth. Takes about
    /// half a minute; whatever else the machine does makes the figures worse.
    Bench(bench::Bench),
}

/// Options of every command.
#[derive(Clone, Debug, Args)]
struct Common {
    /// Worker threads; the machine's cores unless told.
    #[arg(long, global = true, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Vector instructions: portable, sse4.2, avx2, avx512, neon; the best
    /// this machine has unless told.
    #[arg(long, global = true, value_name = "LEVEL", value_parser = parse_simd)]
    simd: Option<SimdLevel>,
    /// Visit every step of a ray instead of crossing empty space in strides.
    #[arg(long, global = true)]
    no_skip: bool,
    /// Speed against accuracy of pictures, from 0, the fastest, to 1, where every
    /// pixel is rendered as the model says; what the model file says unless told, or 0.5.
    #[arg(long, global = true, value_name = "Q", value_parser = parse_quality)]
    quality: Option<f32>,
    /// Print one JSON object on standard output and nothing else there.
    #[arg(long, global = true)]
    json: bool,
    /// No progress.
    #[arg(long, global = true)]
    quiet: bool,
    /// When the program began.
    #[arg(skip = Instant::now())]
    started: Instant,
}

impl Common {
    fn simd(&self) -> SimdLevel {
        self.simd.unwrap_or_else(SimdLevel::detect)
    }

    /// How pictures of a model with this [quality](pocketnerf_formats::About::quality) of
    /// its own are rendered.
    fn picture(&self, own: Option<f32>) -> picture::Settings {
        let usual = picture::Settings::default();
        picture::Settings {
            simd: self.simd(),
            skip: !self.no_skip,
            quality: self.quality.or(own).unwrap_or(usual.quality),
            ..usual
        }
    }

    /// A line for people: on standard error when standard output is JSON's.
    fn say(&self, text: &str) {
        if self.json {
            eprintln!("{text}");
        } else {
            print_line(text);
        }
    }
}

/// A line on standard output. Who reads it may have gone: that is no fault.
fn print_line(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn parse_quality(text: &str) -> Result<f32, String> {
    let quality = text.parse().ok().filter(|q| (0.0..=1.0).contains(q));
    quality.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

fn parse_pixel_origin(text: &str) -> Result<PixelOrigin, String> {
    match text {
        "center" => Ok(PixelOrigin::Center),
        "corner" => Ok(PixelOrigin::Corner),
        _ => Err("expected center or corner".to_owned()),
    }
}

fn parse_precision(text: &str) -> Result<Precision, String> {
    match text {
        "i8" => Ok(Precision::I8),
        "f16" => Ok(Precision::F16),
        "f32" => Ok(Precision::F32),
        _ => Err("expected i8, f16 or f32".to_owned()),
    }
}

/// More than no time, less than a year.
fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| *s > 0.0 && *s < 3e7);
    seconds.ok_or_else(|| "expected a number above 0".to_owned())
}

/// A box by its corners.
fn parse_box(text: &str) -> Result<[[f32; 3]; 2], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([a, b, c, d, e, f])
            if [[a, d], [b, e], [c, f]]
                .iter()
                .all(|[low, high]| (1e-6..1e6).contains(&(*high - *low))) =>
        {
            Ok([[*a, *b, *c], [*d, *e, *f]])
        }
        _ => {
            Err("expected six numbers X0,Y0,Z0,X1,Y1,Z1, the first three below the others"
                .to_owned())
        }
    }
}

fn parse_simd(name: &str) -> Result<SimdLevel, String> {
    let level: SimdLevel = name.parse().map_err(str::to_owned)?;
    level.token().map(|_| level).map_err(|e| e.to_string())
}

/// Three numbers from 0 to 1, or `white` or `black`.
fn parse_color(text: &str) -> Result<[f32; 3], String> {
    match text {
        "white" => return Ok([1.0; 3]),
        "black" => return Ok([0.0; 3]),
        _ => {}
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([r, g, b]) if [r, g, b].iter().all(|v| (0.0..=1.0).contains(*v)) => Ok([*r, *g, *b]),
        _ => Err("expected white, black or three numbers from 0 to 1: R,G,B".to_owned()),
    }
}

/// Runs the command of this process; `started` is when the program began.
#[must_use]
pub fn run(started: Instant) -> ExitCode {
    let mut command = Command::parse();
    command.common.started = started;
    match execute(&command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("pocketnerf: {failure}");
            if failure.is::<train::Interrupted>() || failure.is::<chart::Interrupted>() {
                ExitCode::from(train::INTERRUPTED)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

fn execute(command: &Command) -> Result<(), Failure> {
    let common = &command.common;
    if let Some(n) = common.threads {
        rayon::ThreadPoolBuilder::new().num_threads(n.into()).build_global()?;
    }
    match &command.action {
        Action::Demo(action) => action.run(common),
        Action::Train(action) => action.run(common),
        Action::Eval(action) => action.run(common),
        Action::Convert(action) => action.run(common),
        Action::Render(action) => action.run(common),
        Action::Info(action) => action.run(common),
        Action::Chart(action) => action.run(common),
        Action::Bench(action) => action.run(common),
    }
}

/// Reads a model file whole.
fn read_model(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|e| format!("{}: cannot be read: {e}", path.display()).into())
}

/// Opens a model's bytes; the error names the file.
fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<pocketnerf_formats::ModelFile<'a>, Failure> {
    pocketnerf_formats::open_verified(bytes).map_err(|e| format!("{}: {e}", path.display()).into())
}

/// The same, to be rendered: `table` becomes the model's table of surroundings.
fn open_to_render<'a>(
    path: &Path,
    bytes: &'a [u8],
    table: &'a mut Vec<u8>,
) -> Result<pocketnerf_formats::ModelFile<'a>, Failure> {
    let mut file = open(path, bytes)?;
    table.resize(file.model.table_len(), 0);
    file.model = file.model.with_table(table)?;
    Ok(file)
}

/// Makes a folder for results.
fn make_folder(path: &Path) -> Result<PathBuf, Failure> {
    std::fs::create_dir_all(path)
        .map_err(|e| format!("{}: this folder cannot be made: {e}", path.display()))?;
    Ok(path.to_owned())
}

/// The most memory that this process has held, where the system tells.
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}
