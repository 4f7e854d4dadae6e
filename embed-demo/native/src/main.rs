//! `pocketnerf-view`: a window on a `.pnerf` file.
#![forbid(unsafe_code)]

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use pocketnerf_view::app::{self, Settings};
use pocketnerf_view::headless::Request;
use pocketnerf_view::modes::Mode;
use pocketnerf_view::painter::Painter;
use pocketnerf_view::show::Show;
use pocketnerf_view::view::View;
use pocketnerf_view::{Failure, input, say, script};

/// What `pocketnerf demo --log2-hashmap-size 12` made of the built-in scene.
const STILL_LIFE: &[u8] = include_bytes!("../../still-life.pnerf");

/// A window on a .pnerf file, rendered on the CPU.
#[derive(Debug, Parser)]
#[command(version, after_help = input::HELP)]
struct Arguments {
    /// Model file; without one, the still life that is part of this program.
    model: Option<PathBuf>,
    /// Width and height in pixels; the model's own unless told.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// What to show.
    #[arg(long, value_enum, value_name = "WHAT", default_value = "colour")]
    mode: Mode,
    /// Speed against accuracy of whole pictures, from 0 to 1; what the model file says unless
    /// told, or 0.5.
    #[arg(long, value_name = "Q", value_parser = parse_quality)]
    quality: Option<f32>,
    /// Threads that render; the machine's cores unless told.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Pictures a second while things move; they become smaller until it is held.
    #[arg(long, value_name = "F", default_value = "30", value_parser = parse_fps)]
    fps: f64,
    /// Begin without figures (h).
    #[arg(long)]
    no_overlay: bool,
    /// Folder of screenshots (s).
    #[arg(long, value_name = "DIR", default_value = ".")]
    screenshots: PathBuf,
    #[arg(long, value_name = "FILE", help = script::HELP, conflicts_with = "headless")]
    script: Option<PathBuf>,
    /// No window: write a picture (view.png unless --out), or those of --orbit (orbit).
    #[arg(long)]
    headless: bool,
    /// The picture without a window, or the folder of an orbit; implies --headless.
    #[arg(long, value_name = "FILE|DIR", conflicts_with_all = ["script", "terminal"])]
    out: Option<PathBuf>,
    /// So many views in a circle; implies --headless.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000),
        conflicts_with_all = ["script", "terminal"])]
    orbit: Option<u32>,
    /// The picture as text in 24-bit colours; implies --headless.
    #[arg(long, conflicts_with = "script")]
    terminal: bool,
    /// Columns of --terminal; those of the terminal unless told.
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
    let file = pocketnerf_formats::open_verified(&bytes)
        .map_err(|e| format!("{name}: {e}; give a model that `pocketnerf info` can read"))?;
    // Where there is memory to spare: the same pictures in less time.
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    let view = View::new(&file);
    let quality = arguments.quality.or(file.about.quality).unwrap_or(0.5);
    let painter = Painter::new(&model, arguments.threads.unwrap_or(0).into())?;
    if arguments.headless
        || arguments.out.is_some()
        || arguments.orbit.is_some()
        || arguments.terminal
    {
        let (default, terminal) = match arguments.orbit {
            Some(_) => ("orbit", None),
            None => ("view.png", arguments.terminal.then(|| arguments.width.unwrap_or(0))),
        };
        let request = Request {
            mode: arguments.mode,
            quality,
            size: arguments.size,
            orbit: arguments.orbit,
            terminal,
            out: arguments.out.clone().unwrap_or_else(|| default.into()),
        };
        say(request.run(&painter, &view)?.trim_end_matches('\n'));
        return Ok(());
    }
    let script = arguments.script.as_deref().map(read_script).transpose()?;
    let stem = arguments.model.as_deref().and_then(Path::file_stem);
    let settings = Settings {
        stem: stem.map_or_else(|| "still-life".to_owned(), |stem| stem.to_string_lossy().into()),
        name: stem.map_or(name, |stem| stem.to_string_lossy().into()),
        size: arguments.size,
        overlay: !arguments.no_overlay,
        screenshots: arguments.screenshots.clone(),
        script,
    };
    app::run(Show::new(painter, view, arguments.mode, quality, arguments.fps), settings)
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
