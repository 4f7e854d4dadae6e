//! `pocketnerf chart`.

mod answer;
mod measure;
mod models;
mod plan;
mod progress;
mod scenes;
mod score;
mod write;

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::metrics::{Lpips, Metrics};
use pocketnerf_train::output;

use super::sampling::Sampling;
use super::{Common, Failure, Reading, make_folder};
use crate::chart::{Axis, Wish, peers};
use measure::measure;
use models::Models;

/// Chart accuracy against speed.
///
/// Trains a sweep of models (or takes yours), renders each in several qualities, times
/// all of them in interleaved rounds, and writes DIR/index.html (one page that needs
/// nothing else), chart.svg, chart.png, points.csv and points.json, with models and
/// pictures beside them.
///
/// Models and scores that DIR already holds are kept, so that the same command goes on
/// after an interruption; times are always those of one run.
#[derive(Debug, clap::Args)]
pub(super) struct Chart {
    /// Dataset folders; the built-in scene unless told.
    data: Vec<PathBuf>,
    /// Folder for everything.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Six small models and fewer rounds: a first chart in less than five minutes.
    #[arg(long)]
    quick: bool,
    /// Train a model with these options of `pocketnerf train`, as
    /// "--seconds 30 --log2-hashmap-size 15", in place of the sweep; may be given several
    /// times.
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true)]
    train: Vec<String>,
    /// Take these model files in place of the sweep.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    models: Vec<PathBuf>,
    /// How models are written down, each time another point: i8, f16, f32; as suits the
    /// model unless told.
    #[arg(long, value_name = "TYPE,…", value_delimiter = ',', value_parser = super::parse_precision)]
    precision: Vec<Precision>,
    /// Qualities of pictures, each another point; see --quality.
    #[arg(long, value_name = "Q,…", value_delimiter = ',', default_value = "0,0.5,1",
        value_parser = super::parse_quality)]
    qualities: Vec<f32>,
    /// Where along a ray the field is asked, each another point.
    #[arg(
        long,
        value_enum,
        value_name = "HOW,…",
        value_delimiter = ',',
        default_value = "occupancy"
    )]
    sampling: Vec<Sampling>,
    /// Render and compare with images so many times smaller, each a chart of its own;
    /// 1,2 for the whole sweep and 1 else unless told.
    #[arg(long, value_name = "K,…", value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=64))]
    downscale_factor: Vec<u32>,
    /// Which views: val or test.
    #[arg(long, default_value = "test")]
    split: Split,
    /// Compare so many views, spread evenly; all unless told, 4 with --quick.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    views: Option<u32>,
    /// What models and truth are composited on: white, black or R,G,B; the models' own
    /// background unless told.
    #[arg(long, value_name = "COLOR", value_parser = super::parse_color)]
    background: Option<[f32; 3]>,
    #[command(flatten)]
    reading: Reading,
    /// Rounds in which every point is timed once; 15 unless told, with --quick 5 to 9,
    /// as many as fit into 40 seconds.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: Option<u32>,
    /// Points of other programs (docs/accuracy-and-speed.md has the columns).
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
    /// LPIPS v0.1 weights (AlexNet or VGG16) as .npz.
    #[arg(long, value_name = "FILE")]
    lpips_weights: Option<PathBuf>,
    /// What the drawn chart shows upwards.
    #[arg(long, value_enum, value_name = "FIGURE", default_value = "psnr")]
    y: Axis,
    /// What it shows to the right, a column each.
    #[arg(
        long,
        value_enum,
        value_name = "FIGURE,…",
        value_delimiter = ',',
        default_value = "ms-per-frame,train-seconds,bytes"
    )]
    x: Vec<Axis>,
    /// Say which setting suits: fastest=DB (with at least so many dB), smallest=DB, or
    /// accurate=FPS (with at least so many frames a second); may be given several times.
    /// Where DIR holds the chart of this command already, nothing is measured again.
    #[arg(long, value_name = "WISH")]
    recommend: Vec<Wish>,
    /// Write the model that the only --recommend chooses, with its quality as the one that
    /// pictures have unless told.
    #[arg(long, value_name = "FILE", requires = "recommend")]
    store: Option<PathBuf>,
}

/// Ctrl-C ended it.
#[derive(Debug)]
pub(in crate::commands) struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("interrupted; the same command goes on from here")
    }
}

impl std::error::Error for Interrupted {}

/// Whether Ctrl-C was pressed.
struct Stop(Arc<AtomicBool>);

impl Stop {
    /// From now on Ctrl-C ends the command between two points.
    fn listen() -> Result<Self, Failure> {
        let pressed = Arc::new(AtomicBool::new(false));
        let press = Arc::clone(&pressed);
        ctrlc::set_handler(move || press.store(true, Ordering::Relaxed))?;
        Ok(Self(pressed))
    }

    fn check(&self) -> Result<(), Failure> {
        if self.0.load(Ordering::Relaxed) { Err(Interrupted.into()) } else { Ok(()) }
    }
}

impl Chart {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        self.check(common)?;
        let peers = self.peers.as_deref().map(peers::read).transpose()?.unwrap_or_default();
        let asked = self.asked(common);
        if let (false, Some(points)) =
            (self.recommend.is_empty(), write::measured(&self.out, &asked))
        {
            return self.answer(&points, common);
        }
        let metrics =
            Metrics { lpips: self.lpips_weights.as_deref().map(Lpips::read).transpose()? };
        let recipes = self.recipes()?;
        let scenes = self.scenes(common)?;
        // Nothing is written before everything that was given has been looked at.
        let taken = models::take(&self.models, &scenes)?;
        let stop = Stop::listen()?;
        make_folder(&self.out)?;
        let mut models = Models::new(&self.out, taken)?;
        models.train(&scenes, &recipes, common, &stop)?;
        let mut measured = measure(self, &scenes, &models, &metrics, common, &stop)?;
        let known =
            |peer: &crate::chart::Point| scenes.iter().any(|scene| scene.name == peer.scene);
        let (shown, others): (Vec<_>, Vec<_>) = peers.into_iter().partition(known);
        if !others.is_empty() && !common.quiet {
            eprintln!("note: {} peers are of other scenes and left out", others.len());
        }
        measured.points.extend(shown);
        let chart = self.write(measured, asked, &metrics, common)?;
        self.report(&chart, common);
        self.answer(&chart.points, common)
    }

    /// Refuses what makes no sense.
    fn check(&self, common: &Common) -> Result<(), Failure> {
        if let Some(axis) = self.x.iter().find(|axis| axis.is_accuracy()) {
            return Err(format!("--x {}: expected a cost; see --y", axis.key()).into());
        }
        if !self.y.is_accuracy() {
            return Err(
                format!("--y {}: expected how good pictures are; see --x", self.y.key()).into()
            );
        }
        if self.split == Split::Train {
            return Err(
                "--split train: expected val or test, views that nothing learnt from".into()
            );
        }
        if !self.models.is_empty() && self.data.len() > 1 {
            return Err("--models: give the one dataset that they were trained on".into());
        }
        if common.no_skip {
            return Err("--no-skip: leave it out, it changes times alone".into());
        }
        if let Some(path) = &self.store {
            if self.recommend.len() != 1 {
                return Err("--store: give one --recommend, whose choice is stored".into());
            }
            if self.data.len() > 1 || self.factors().len() > 1 {
                return Err("--store: give one dataset and one --downscale-factor".into());
            }
            output::check_output(path)?;
        }
        Ok(())
    }

    /// How many times smaller pictures are.
    fn factors(&self) -> &[u32] {
        match (&self.downscale_factor[..], self.quick || !self.train.is_empty()) {
            ([], false) if self.models.is_empty() => &[1, 2],
            ([], _) => &[1],
            (given, _) => given,
        }
    }

    /// How many rounds are timed, where one takes so many seconds.
    fn rounds(&self, seconds: f64) -> usize {
        let usual = if self.quick { (40.0 / seconds).clamp(5.0, 9.0) as usize } else { 15 };
        self.rounds.map_or(usual, |n| n as usize)
    }

    /// Views that are compared; all: `None`.
    fn n_views(&self) -> Option<usize> {
        self.views.map(|n| n as usize).or(self.quick.then_some(4))
    }

    /// Everything that decides what is measured, to know the same wish again.
    fn asked(&self, common: &Common) -> String {
        let Self { data, train, models, precision, sampling, .. } = self;
        let Self { split, background, reading, peers, lpips_weights, .. } = self;
        format!(
            "{data:?} {} {train:?} {models:?} {precision:?} {:?} {sampling:?} {:?} \
             {split} {:?} {background:?} {reading:?} {peers:?} {lpips_weights:?} {:?} {:?} {:?}",
            self.quick,
            self.qualities(common),
            self.factors(),
            self.n_views(),
            self.rounds,
            common.threads,
            common.simd(),
        )
    }

    /// The qualities of pictures: --quality stands for a list of one.
    fn qualities(&self, common: &Common) -> Vec<f32> {
        common.quality.map_or_else(|| self.qualities.clone(), |quality| vec![quality])
    }
}
