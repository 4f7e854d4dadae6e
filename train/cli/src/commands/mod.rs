//! The command line, a thin layer over the library: one file per command.

mod antialias;
mod baseline_file;
mod bench;
mod chart;
mod convert;
mod demo;
mod device;
mod eval;
mod export;
mod info;
mod memory;
mod model_file;
mod parse;
mod prepare;
mod progress;
mod reading;
mod render;
mod rendering;
mod repack;
pub(crate) mod stop;
mod stress;
mod tool;
mod train;
#[cfg(feature = "view")]
mod view;
#[cfg(not(feature = "view"))]
#[path = "view/without.rs"]
mod view;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Parser, Subcommand};
use model_file::{open, open_to_render, read_model};
use reading::Reading;
use serde_json::Value;

use crate::host::Hosted;
pub use reading::{HeldDataset, hold};

/// Why a command stopped: its text is one line.
pub(crate) type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The heading of options that most commands have.
const COMMON: &str = "Common options";

/// Radiance fields on ordinary CPUs: photos with known cameras in, a compact
/// model file out, new views from any side.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Command {
    #[command(subcommand)]
    action: Action,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Train on the built-in scene, render it, and compare with the truth
    Demo(demo::Demo),
    /// Make a dataset from photographs or a video
    ///
    /// Runs COLMAP, and ffmpeg for a video, where they are installed. DIR/images has the
    /// photographs and DIR/sparse their cameras, which `train` reads; DIR/prepare.log has what these
    /// programs said.
    ///
    /// What is done already is kept in DIR, so the same command continues after an interruption.
    Prepare(prepare::Prepare),
    /// Train a model on a dataset
    ///
    /// Ctrl-C, SIGTERM or SIGHUP saves a checkpoint beside the model (scene.pnerf:
    /// scene.ckpt.pnerf), prints how to resume, and ends with status 130. A second one stops at
    /// once, and so does one before the first step, when there is nothing to save.
    ///
    /// For most of a long run one view in 25 is held out, three at least (of less than 32, none).
    /// Where these are worse in the end than they were before, the run goes back to their best
    /// moment, ends early and says so.
    Train(Box<train::Train>),
    /// Compare renderings of a model with the images of a dataset
    Eval(eval::Eval),
    /// Convert another program's checkpoint to a .pnerf model
    ///
    /// Reads checkpoints of the original NeRF, nerf-pytorch and nerf_pl, and hash grids of
    /// instant-ngp, torch-ngp, ngp_pl and nerfstudio. A hash grid learns from the pictures of
    /// models of TensoRF and Plenoxels of svox2. No pickle is ever executed. A .pnerf model or
    /// checkpoint is written again in another precision.
    Convert(Box<convert::Convert>),
    /// Render a model
    Render(render::Render),
    /// Show a model in a window, or as text in a terminal
    #[cfg_attr(feature = "view", command(after_help = pocketnerf_view::window::input::HELP))]
    #[cfg_attr(not(feature = "view"), command(hide = true))]
    View(Box<view::View>),
    /// Export the surface of a model: a mesh or a point cloud
    ///
    /// The surface is where the light of a pixel begins to be held back, seen from many cameras:
    /// those of the photographs with --data, else a sphere of cameras around the model. Coordinates
    /// and units are the dataset's, as `render --pose` takes them; the worlds of COLMAP and LLFF
    /// are turned and scaled when read. Colours are the mean of what is seen of each point.
    Export(export::Export),
    /// Pack a model: the same pictures from fewer bytes
    ///
    /// Tables and occupied cells are coded, and table entries that no picture depends on become
    /// 0. All commands read packed files; `train` writes them. A microcontroller, which reads
    /// weights in place, needs `pocketnerf unpack` before.
    ///
    /// With --max-bytes, values of tables are also rounded, more coarsely where pictures suffer
    /// least; no photographs are needed.
    Repack(repack::Repack),
    /// Unpack a packed model to an ordinary file, which is read in place
    Unpack(repack::Unpack),
    /// Show details of a model, checkpoint or dataset
    Info(info::Info),
    /// Chart accuracy against speed over a sweep of models and settings
    ///
    /// Trains a sweep of models (or takes yours), renders each at several qualities, times
    /// all of them in interleaved rounds, and writes DIR/index.html (one self-contained
    /// page), chart.svg, chart.png, points.csv and points.json, with models and pictures
    /// beside them.
    ///
    /// Models and scores already in DIR are kept, so the same command continues after an
    /// interruption. Times always come from one run.
    Chart(Box<chart::Chart>),
    /// Test where radiance fields fail: spoilt photographs, cameras and settings
    ///
    /// Spoils a scene in one way after the other, trains and compares, and writes
    /// DIR/index.html (one self-contained page), stress.svg, stress.csv and stress.json. Each row
    /// says what was lost, whether that is within a bar, and if not, whether the program said so.
    ///
    /// What is measured already is kept in DIR, so the same command continues after an
    /// interruption.
    Stress(Box<stress::Stress>),
    /// Measure the machine and every stage of training and rendering
    ///
    /// Reports first what the machine can do, then how close each stage comes to its bound,
    /// which is multiply-adds, random reads or memory bandwidth. Takes about half a minute;
    /// other load on the machine makes the figures worse.
    Bench(bench::Bench),
}

/// Options of every command.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = COMMON)]
struct Common {
    /// Number of worker threads [default: all cores]
    #[arg(long, global = true, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print one JSON object on standard output, and nothing else there
    #[arg(long, global = true)]
    json: bool,
    /// Show no progress
    #[arg(long, global = true)]
    quiet: bool,
    /// When the program started.
    #[arg(skip = Instant::now())]
    started: Instant,
    /// The program that runs the command, where that is another one.
    #[arg(skip)]
    host: Option<Hosted>,
}

impl Common {
    /// A line for people: on standard error if standard output is for JSON.
    fn say(&self, text: &str) {
        if self.json {
            eprintln!("{text}");
        } else {
            print_line(text);
        }
    }

    /// Something that may spoil the result: it is said in spite of `--quiet`.
    fn warn(&self, warning: &str) {
        match &self.host {
            Some(Hosted(host)) => host.warning(warning),
            None => eprintln!("warning: {warning}"),
        }
    }

    /// What `--json` prints, with what the user should know.
    fn print_json(&self, mut object: Value, warnings: &[String]) {
        object["warnings"] = warnings.into();
        self.result(object);
    }

    /// The same of what has its `warnings` already.
    fn result(&self, object: Value) {
        match &self.host {
            Some(Hosted(host)) => host.result(object),
            None => print_line(object),
        }
    }
}

/// A line on standard output. It is no error if nobody reads it.
fn print_line(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

impl Command {
    /// Says when the program started, and who runs the command where that is another program.
    pub(crate) fn begun(mut self, started: Instant, host: Option<Hosted>) -> Self {
        self.common.started = started;
        self.common.host = host;
        self
    }
}

/// Whether a command ended because it was asked to.
pub(crate) fn is_interruption(failure: &Failure) -> bool {
    failure.is::<train::Interrupted>() || failure.is::<stop::Interrupted>()
}

/// Where the run of training is saved that ended with this failure.
pub(crate) fn saved(failure: &Failure) -> Option<PathBuf> {
    let interrupted = failure.downcast_ref().map(train::Interrupted::checkpoint);
    interrupted.or_else(|| failure.downcast_ref().map(train::Unfinished::checkpoint))
}

/// Runs a command.
pub(crate) fn execute(command: &Command) -> Result<(), Failure> {
    let common = &command.common;
    // A host has a pool of its own.
    if let (Some(n), None) = (common.threads, &common.host) {
        rayon::ThreadPoolBuilder::new().num_threads(n.into()).build_global()?;
    }
    match &command.action {
        Action::Demo(action) => action.run(common),
        Action::Prepare(action) => action.run(common),
        Action::Train(action) => action.run(common),
        Action::Eval(action) => action.run(common),
        Action::Convert(action) => action.run(common),
        Action::Render(action) => action.run(common),
        Action::View(action) => action.run(common),
        Action::Export(action) => action.run(common),
        Action::Repack(action) => action.run(common),
        Action::Unpack(action) => action.run(common),
        Action::Info(action) => action.run(common),
        Action::Chart(action) => action.run(common),
        Action::Stress(action) => action.run(common),
        Action::Bench(action) => action.run(common),
    }
}

/// Creates a folder for results.
fn make_folder(path: &Path) -> Result<PathBuf, Failure> {
    std::fs::create_dir_all(path)
        .map_err(|e| format!("{}: this folder cannot be created: {e}", path.display()))?;
    Ok(path.to_owned())
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, ValueEnum};

    use super::*;

    /// Headings of options, in the order of every command: a method's before the next one's.
    fn headings() -> Vec<String> {
        let methods = train::Method::value_variants().iter();
        let methods = methods.map(|method| format!("With --method {}", method.name()));
        let before = ["Options", "Dataset", "Scene", "Model"].map(str::to_owned);
        let after = ["Distillation", "Window", "Without a window", "Rendering", COMMON];
        before.into_iter().chain(methods).chain(after.map(str::to_owned)).collect()
    }

    #[test]
    fn groups_of_options_have_one_order() {
        let mut command = Command::command();
        command.build();
        command.clone().debug_assert();
        for sub in command.get_subcommands_mut().filter(|sub| sub.get_name() != "help") {
            let help = sub.render_long_help().to_string();
            let titles = help.lines().filter(|line| !line.starts_with(' '));
            let found: Vec<&str> = titles.filter_map(|line| line.strip_suffix(':')).collect();
            let known = headings();
            let known = known.iter().filter(|heading| found.contains(&heading.as_str()));
            let found = found.iter().filter(|heading| **heading != "Arguments");
            assert!(found.eq(known), "{help}");
        }
    }

    #[test]
    fn options_are_where_they_mean_something() {
        let command = Command::command();
        let has = |name: &str, option: &str| {
            let sub = command.find_subcommand(name).unwrap();
            sub.get_arguments().any(|argument| argument.get_long() == Some(option))
        };
        for (option, commands) in [
            (
                "simd",
                &[
                    "demo", "train", "eval", "convert", "render", "export", "repack", "chart",
                    "stress", "bench",
                ][..],
            ),
            ("quality", &["demo", "eval", "convert", "render", "view", "bench"]),
            ("no-skip", &["demo", "eval", "convert", "render", "bench"]),
            ("sampling", &["train", "eval", "render", "chart"]),
        ] {
            for sub in command.get_subcommands() {
                let name = sub.get_name();
                let is_there = name != "view" || cfg!(feature = "view");
                let expected = commands.contains(&name) && is_there;
                assert_eq!(has(name, option), expected, "{name} --{option}");
            }
        }
    }
}
