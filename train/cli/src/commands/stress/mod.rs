//! `pocketnerf stress`.

mod place;
mod runs;
mod scene;
mod write;

use std::path::{Path, PathBuf};

use pocketnerf_train::dataset::Split;

use super::progress::Progress;
use super::rendering::Vectors;
use super::stop::Stop;
use super::train::{Method, Train};
use super::{Common, Failure, Reading, make_folder, print_line};
use crate::stress::{self, Case, Mode, Row, Verdict};
use runs::{Runs, Seen};
use scene::SpoiltScene;

#[derive(Debug, clap::Args)]
pub(super) struct Stress {
    /// Dataset folders, or built-in scenes as for `train` [default: builtin]
    data: Vec<PathBuf>,
    /// Folder for everything
    #[arg(long, value_name = "DIR", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// One strength, one seed and short runs: a first table in less than 15 minutes
    #[arg(long)]
    quick: bool,
    /// Ways to fail, by name [default: all]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    modes: Vec<String>,
    /// List the ways to fail, and end
    #[arg(long)]
    list: bool,
    /// Random seeds of each case [default: 1 with --quick, else 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100))]
    seeds: Option<u64>,
    /// Steps of training [default: 1100 with --quick, else 3000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Rows of other programs: a table with the columns of stress.csv, their names as methods
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
    /// Downscale images by this factor [default: 4 for the built-in scene and with --quick, else
    /// 2]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=64),
        help_heading = "Dataset")]
    downscale_factor: Option<u32>,
    #[command(flatten)]
    reading: Reading,
    /// Kinds of fields [default: what `train` learns of the scene]
    #[arg(
        long,
        value_enum,
        value_name = "METHOD,…",
        value_delimiter = ',',
        help_heading = "Model"
    )]
    methods: Vec<Method>,
    #[command(flatten)]
    vectors: Vectors,
}

impl Stress {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        let modes = self.modes()?;
        if self.list {
            for mode in &modes {
                print_line(format_args!("{}: {} ({})", mode.name, mode.what, mode.unit));
            }
            return Ok(());
        }
        let peers = match &self.peers {
            Some(path) => read_peers(path)?,
            None => Vec::new(),
        };
        let scenes = self.scenes()?;
        let stop = Stop::listen(common, "interrupted")?;
        stop.defer();
        make_folder(self.out())?;
        let mut rows = Vec::new();
        let mut pictures = Vec::new();
        for scene in &scenes {
            for method in self.methods_of(scene)? {
                for (row, picture) in self.measure(&modes, scene, method, common, &stop)? {
                    pictures.push((stress::page::key(&row), picture));
                    rows.push(row);
                }
            }
        }
        rows.extend(peers);
        self.write(&modes, &rows, &pictures)?;
        if common.json {
            common.print_json(
                serde_json::json!({ "out": self.out().display().to_string(), "rows": rows }),
                &silent(&rows),
            );
        } else {
            report(&rows);
            print_line(self.out().join("index.html").display());
        }
        Ok(())
    }

    /// The rows of a scene and a method, with the files of their pictures.
    fn measure(
        &self,
        modes: &[Mode],
        scene: &SpoiltScene,
        method: Method,
        common: &Common,
        stop: &Stop,
    ) -> Result<Vec<(Row, Option<PathBuf>)>, Failure> {
        let mut runs = Runs::new(self, scene, method, common, stop)?;
        let context = runs.context()?;
        let strengths = modes.iter().flat_map(|mode| {
            self.strengths(mode).into_iter().map(move |strength| (mode, strength))
        });
        let cases = strengths.filter_map(|(mode, strength)| {
            (mode.case)(strength, &context).map(|case| (mode, strength, case))
        });
        let cases: Vec<(&Mode, f64, Case)> = cases.collect();
        let all = cases.len() * self.seeds() as usize;
        let mut progress = Progress::new("stress", all, common);
        if !common.quiet {
            let (scene, method) = (&scene.name, method.name());
            eprintln!("{scene}, {method}: {all} cases{}", runs.expected(all));
        }
        let mut rows = Vec::with_capacity(all);
        for (mode, strength, case) in &cases {
            for seed in 0..self.seeds() {
                stop.check()?;
                let reference = runs.look(&case.reference.0, &case.reference.1, seed)?;
                let seen = runs.look(&case.training, &case.viewing, seed)?;
                let row = Row {
                    method: method.name().to_owned(),
                    scene: scene.name.clone(),
                    seed,
                    ..row(mode, *strength, &seen, &reference)
                };
                rows.push((row, seen.picture));
                progress.done(rows.len());
            }
        }
        Ok(rows)
    }

    /// The ways to fail that are wanted.
    fn modes(&self) -> Result<Vec<Mode>, Failure> {
        let all = stress::all();
        if self.modes.is_empty() {
            return Ok(all);
        }
        let find = |name: &String| {
            let found = all.iter().find(|mode| mode.name == *name).copied();
            found.ok_or_else(|| {
                format!("--modes {name}: not known; `pocketnerf stress --list` shows all").into()
            })
        };
        self.modes.iter().map(find).collect()
    }

    /// The folder for everything.
    fn out(&self) -> &Path {
        self.out.as_deref().unwrap_or(Path::new("."))
    }

    fn strengths(&self, mode: &Mode) -> Vec<f64> {
        if self.quick { vec![mode.quick] } else { mode.strengths.to_vec() }
    }

    fn seeds(&self) -> u64 {
        self.seeds.unwrap_or(if self.quick { 1 } else { 3 })
    }

    /// What is trained of a scene.
    fn methods_of(&self, scene: &SpoiltScene) -> Result<Vec<Method>, Failure> {
        match &self.methods[..] {
            [] => Ok(vec![Train::usual_method(&scene.load(Split::Train, 0)?)?]),
            given => Ok(given.to_vec()),
        }
    }

    fn steps(&self) -> u32 {
        self.steps.unwrap_or(if self.quick { 1100 } else { 3000 })
    }
}

/// The row of a look at a case, but for whose it is.
fn row(mode: &Mode, strength: f64, seen: &Seen, reference: &Seen) -> Row {
    let value = seen.psnr.zip(reference.psnr);
    let value = value.map(|(psnr, reference)| mode.bar.value(psnr, reference));
    let said = seen.said_beside(reference);
    let within = value.is_some_and(|value| mode.bar.is_met(value));
    Row {
        mode: mode.name.to_owned(),
        method: String::new(),
        scene: String::new(),
        strength,
        seed: 0,
        figure: mode.bar.figure().to_owned(),
        value,
        bar: mode.bar.limit(),
        verdict: Verdict::of(within, !said.is_empty()),
        warning: (!said.is_empty()).then(|| said.join("; ")),
        psnr: seen.psnr,
        psnr_min: seen.psnr_min,
        reference_psnr: reference.psnr,
    }
}

/// A line for each row that fails.
fn silent(rows: &[Row]) -> Vec<String> {
    let fails = rows.iter().filter(|row| row.verdict == Verdict::Fails);
    let line = |row: &Row| {
        format!(
            "{} {} {} {}: {} {:.2}, expected {}; nothing was said",
            row.scene,
            row.method,
            row.mode,
            row.strength,
            row.figure,
            row.value.unwrap_or(f64::NAN),
            row.bar
        )
    };
    fails.map(line).collect()
}

fn report(rows: &[Row]) {
    for row in rows {
        let value = row.value.map_or_else(|| "refused".to_owned(), |value| format!("{value:.2}"));
        print_line(format_args!(
            "{:<8} {} {} {} {}: {} {value} (bar {}){}",
            row.verdict.text(),
            row.scene,
            row.method,
            row.mode,
            row.strength,
            row.figure,
            row.bar,
            row.warning.as_deref().map_or_else(String::new, |warning| format!(": {warning}")),
        ));
    }
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    print_line(format_args!(
        "{} within the bar, {} say so, {} fail",
        count(Verdict::Within),
        count(Verdict::SaysSo),
        count(Verdict::Fails)
    ));
}

fn read_peers(path: &Path) -> Result<Vec<Row>, Failure> {
    let bytes = std::fs::read(path)
        .map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
    let rows = stress::read_csv(&bytes).map_err(|error| {
        let error = error.to_string().replace('\n', " ");
        format!("{}: {error}, expected the columns of stress.csv", path.display())
    })?;
    Ok(rows)
}
