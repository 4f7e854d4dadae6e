//! `pocketnerf chart`.

mod answer;
mod jobs;
mod measure;
mod models;
mod plan;
mod scenes;
mod score;
mod write;

use std::path::PathBuf;

use pocketnerf_formats::Precision;
use pocketnerf_train::dataset::Split;
use pocketnerf_train::metrics::{Lpips, Metrics};
use pocketnerf_train::output;

use super::parse::{parse_color, parse_precision, parse_quality};
use super::rendering::{Sampling, Vectors};
use super::stop::Stop;
use super::{Common, Failure, Reading, make_folder};
use crate::chart::{Axis, Wish, peers};
use measure::measure;
use models::Models;
use plan::{Methods, parse_methods};

#[derive(Debug, clap::Args)]
pub(super) struct Chart {
    /// Dataset folders, or built-in scenes as for `train` [default: builtin]
    data: Vec<PathBuf>,
    /// Folder for everything
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Six small models and fewer rounds: a first chart in less than five minutes
    #[arg(long)]
    quick: bool,
    /// Report the setting that suits: fastest=DB (with at least so many dB), smallest=DB, or
    /// accurate=FPS (with at least so many frames a second); repeatable
    ///
    /// If DIR holds the chart of this command already, nothing is measured again.
    #[arg(long, value_name = "WISH")]
    recommend: Vec<Wish>,
    /// Write the model that the only --recommend chooses, with its quality as the default of
    /// renderers
    #[arg(long, value_name = "FILE", requires = "recommend")]
    store: Option<PathBuf>,
    /// Points of other programs (docs/accuracy-and-speed.md describes the columns)
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
    /// Rounds in which every point is timed once [default: 15; with --quick as many as fit
    /// into 40 seconds, 5 to 9]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: Option<u32>,
    /// Also measure LPIPS v0.1, with the weights in this .npz
    #[arg(long, value_name = "FILE")]
    lpips_weights: Option<PathBuf>,
    /// Colour behind renderings and images: white, black or R,G,B [default: as the model file
    /// says]
    #[arg(long, value_name = "COLOR", value_parser = parse_color)]
    background: Option<[f32; 3]>,
    /// Vertical axis of the drawn chart
    #[arg(long, value_enum, value_name = "FIGURE", default_value = "psnr")]
    y: Axis,
    /// Horizontal axes of the drawn chart, one per column
    #[arg(
        long,
        value_enum,
        value_name = "FIGURE,…",
        value_delimiter = ',',
        default_value = "ms-per-frame,train-seconds,bytes"
    )]
    x: Vec<Axis>,
    /// Views to compare: val or test
    #[arg(long, default_value = "test", help_heading = "Dataset")]
    split: Split,
    /// Compare at most N views, evenly spread [default: all; 4 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..),
        help_heading = "Dataset")]
    views: Option<u32>,
    /// Downscale images and renderings by these factors, one chart each [default: 1,2 for the
    /// whole sweep, else 1]
    #[arg(long, value_name = "K,…", value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=64), help_heading = "Dataset")]
    downscale_factor: Vec<u32>,
    #[command(flatten)]
    reading: Reading,
    /// Train a model with these options of `pocketnerf train` instead of the sweep, such as
    /// "--seconds 30 --log2-hashmap-size 15"; repeatable
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true, help_heading = "Model")]
    train: Vec<String>,
    /// Train a model by each of these methods instead of the sweep: all, or names as of
    /// `train --method`; small ones with --quick
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', conflicts_with = "train",
        value_parser = parse_methods, help_heading = "Model")]
    methods: Vec<Methods>,
    /// Seconds for which each of --methods is trained, a model each [default: 60,300; 12 with
    /// --quick]
    #[arg(long, value_name = "S,…", value_delimiter = ',', requires = "methods",
        value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Model")]
    seconds: Vec<u32>,
    /// Chart these model files instead of the sweep
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Model")]
    models: Vec<PathBuf>,
    /// Formats of the weights, one point each: i8, f16, f32 [default: i8; f16 for models
    /// without tables]
    #[arg(long, value_name = "TYPE,…", value_delimiter = ',', value_parser = parse_precision,
        help_heading = "Model")]
    precision: Vec<Precision>,
    /// Where the samples of a ray lie, one point each
    #[arg(
        long,
        value_enum,
        value_name = "HOW,…",
        value_delimiter = ',',
        default_value = "occupancy",
        help_heading = "Rendering"
    )]
    sampling: Vec<Sampling>,
    /// Qualities of pictures, one point each: from 0 (fastest) to 1 (every pixel is rendered)
    #[arg(long, visible_alias = "quality", value_name = "Q,…", value_delimiter = ',',
        default_value = "0,0.5,1", value_parser = parse_quality, help_heading = "Rendering")]
    qualities: Vec<f32>,
    #[command(flatten)]
    vectors: Vectors,
}

impl Chart {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        self.check()?;
        let peers = self.peers.as_deref().map(peers::read).transpose()?.unwrap_or_default();
        let asked = self.asked(common);
        if let (false, Some(points)) =
            (self.recommend.is_empty(), write::measured(&self.out, &asked))
        {
            return self.answer(&points, common);
        }
        let metrics = Metrics {
            lpips: self.lpips_weights.as_deref().map(Lpips::read).transpose()?,
            ..Metrics::default()
        };
        let recipes = self.recipes()?;
        let scenes = self.scenes(common)?;
        // Everything given is checked before anything is written.
        let taken = models::take(&self.models, &scenes)?;
        let stop = Stop::listen(common, "interrupted")?;
        stop.defer();
        make_folder(&self.out)?;
        let mut models = Models::new(&self.out, taken)?;
        models.train(&scenes, &recipes, self.vectors.simd, common, &stop)?;
        let mut measured = measure(self, &scenes, &models, &metrics, common, &stop)?;
        let known =
            |peer: &crate::chart::Point| scenes.iter().any(|scene| scene.name == peer.scene);
        let (shown, others): (Vec<_>, Vec<_>) = peers.into_iter().partition(known);
        if !others.is_empty() && !common.quiet {
            eprintln!("note: {} peers are of other scenes and left out", others.len());
        }
        measured.points.extend(shown);
        let chart = self.write(measured, asked, &metrics)?;
        self.report(&chart, common);
        self.answer(&chart.points, common)
    }

    /// Refuses options that make no sense.
    fn check(&self) -> Result<(), Failure> {
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
        let few = self.quick || !self.train.is_empty() || !self.methods.is_empty();
        match (&self.downscale_factor[..], few) {
            ([], false) if self.models.is_empty() => &[1, 2],
            ([], _) => &[1],
            (given, _) => given,
        }
    }

    /// How many rounds are timed if one takes so many seconds.
    fn rounds(&self, seconds: f64) -> usize {
        let usual = if self.quick { (40.0 / seconds).clamp(5.0, 9.0) as usize } else { 15 };
        self.rounds.map_or(usual, |n| n as usize)
    }

    /// Views that are compared; all: `None`.
    fn n_views(&self) -> Option<usize> {
        self.views.map(|n| n as usize).or(self.quick.then_some(4))
    }

    /// Everything that decides what is measured, to recognise the same command.
    fn asked(&self, common: &Common) -> String {
        let Self { data, train, methods, seconds, models, precision, sampling, .. } = self;
        let Self { split, background, reading, peers, lpips_weights, .. } = self;
        format!(
            "{data:?} {} {train:?} {methods:?} {seconds:?} {models:?} {precision:?} {:?} {sampling:?} {:?} \
             {split} {:?} {background:?} {reading:?} {peers:?} {lpips_weights:?} {:?} {:?} {:?}",
            self.quick,
            self.qualities,
            self.factors(),
            self.n_views(),
            self.rounds,
            common.threads,
            self.vectors.level(),
        )
    }
}
