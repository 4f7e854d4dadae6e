//! What is trained: options of `pocketnerf train` for the kind of field and its size.

use pocketnerf_train::field::{FieldConfig, HashGridFieldConfig};
use pocketnerf_train::trainer::{Length, Size, TrainConfig, Trainer};

use super::kinds::{self, Images, KindOptions, Method};
use crate::commands::Failure;
use crate::commands::parse::parse_psnr;

/// What a model is to be good at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Profile {
    /// As much detail as the time allows
    #[default]
    Fine,
    /// Renders one and a half times as fast, about half a decibel less accurate
    Fast,
}

#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Model")]
pub(super) struct ModelOptions {
    /// What is trained: a kind of field, or a baseline to compare with [default: planes of an
    /// object, in a box and cut out, on the CPU; else hash-grid]
    ///
    /// Options of one of the two kinds alone ask for it.
    /// Baselines have files of their own, which `eval`, `render`, `info` and `chart` read.
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// What the model is to be good at
    #[arg(long, value_enum, default_value_t, conflicts_with = "resume")]
    profile: Profile,
    /// log2 of the maximum entries per grid level (controls model size) [default: by training
    /// time and profile]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=24))]
    log2_hashmap_size: Option<u32>,
    /// Write a model file of at most N bytes [default: no limit]
    ///
    /// Fewer bytes give a hash grid fewer entries, unless --log2-hashmap-size sets their number.
    /// In the last quarter of the run tables are rounded as coarsely as needed, and the run adapts
    /// to that.
    #[arg(long, value_name = "N", group = "size", conflicts_with = "precision",
        value_parser = clap::value_parser!(u32).range(1..))]
    max_bytes: Option<u32>,
    /// Write the smallest model file with which held-out views have a PSNR of D dB
    ///
    /// One view in 25, three at least, is held out for the whole run, of 32 views at least.
    #[arg(long, value_name = "D", group = "size", conflicts_with = "precision",
        value_parser = parse_psnr)]
    target_psnr: Option<f64>,
    /// Write the smallest model file that is at most about 0.1 dB worse
    #[arg(long, group = "size", conflicts_with = "precision")]
    auto: bool,
    /// Grid levels between the same coarsest and finest resolution [default: 9; 8 with
    /// --profile fast]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=16))]
    n_levels: Option<u32>,
    /// Width of the hidden layers behind the grid: 8, 16, 32, 64 or 128 [default: by profile]
    #[arg(long, value_name = "N", value_parser = parse_width)]
    hidden_width: Option<u32>,
    /// Omit view dependence: a point has the same colour from everywhere
    #[arg(long)]
    no_view_dependence: bool,
    /// Multiply the learning rates by 0.01 to 100 [default: 1]
    ///
    /// The usual rates suit all kinds of scenes; above twice these, runs may not converge.
    #[arg(long, value_name = "TIMES", conflicts_with = "resume", value_parser = parse_times)]
    learning_rate: Option<f32>,
    #[command(flatten)]
    kinds: KindOptions,
}

/// log2 of the entries per level that are worth so many bytes: twice as many in half the bits. The
/// longer a run, the more bits an entry holds.
fn entries_log2(bytes: u32, length: Length) -> u32 {
    /// Bytes an entry of one level from which on twice as many entries are better, in a run of so
    /// many steps: lego, val views, see docs/lab/packing.md.
    const BYTES: f64 = 5.3;
    const STEPS: f64 = 4000.0;
    /// The power of the steps with which they grow.
    const GROWTH: f64 = 0.18;
    /// Fewer do not make a file much smaller: networks remain.
    const LEAST: f64 = 10.0;
    let longer = (length.about_steps() / STEPS).max(1.0);
    (f64::from(bytes) / (BYTES * longer.powf(GROWTH))).log2().max(LEAST) as u32
}

fn parse_width(text: &str) -> Result<u32, String> {
    let width = text.parse().ok().filter(|width| [8, 16, 32, 64, 128].contains(width));
    width.ok_or_else(|| "expected 8, 16, 32, 64 or 128".to_owned())
}

fn parse_times(text: &str) -> Result<f32, String> {
    let times = text.parse().ok().filter(|times| (0.01..=100.0).contains(times));
    times.ok_or_else(|| "expected 0.01 to 100".to_owned())
}

/// Refuses a size of models that have none to choose.
fn check_sizes_of(option: &str, config: &TrainConfig) -> Result<(), Failure> {
    match config.field.kind().can_be_sized() {
        true => Ok(()),
        false => Err(not_for_this(option)),
    }
}

/// Refuses an option for kinds without an encoding.
fn not_for_this(option: &str) -> Failure {
    format!("{option}: for --method hash-grid and planes alone").into()
}

impl ModelOptions {
    /// Refuses options that make no sense, alone or when resuming.
    pub(super) fn check(&self, resumes: bool) -> Result<(), Failure> {
        let shape = self.method.map(|_| "--method").or_else(|| self.kinds.given());
        let shape = shape.or(self.no_view_dependence.then_some("--no-view-dependence"));
        if let (Some(option), true) = (shape, resumes) {
            return Err(format!("{option}: the checkpoint knows; leave it out").into());
        }
        let method = self.method(true);
        self.kinds.check(method)?;
        if let (Some(option), true) = (self.given_for_grids(), method != Method::HashGrid) {
            return Err(format!("{option}: for --method hash-grid alone").into());
        }
        let fast = (self.profile == Profile::Fast).then_some("--profile fast");
        match self.size_option().or(fast) {
            Some(option) if self.baseline().is_some() => Err(not_for_this(option)),
            Some(option) => {
                check_sizes_of(option, &self.kinds.config(method, Images::ANY, Length::Steps(1)))
            }
            None => Ok(()),
        }
    }

    /// An option that was given for hash grids alone.
    fn given_for_grids(&self) -> Option<&'static str> {
        let given = [
            ("--log2-hashmap-size", self.log2_hashmap_size.is_some()),
            ("--n-levels", self.n_levels.is_some()),
            ("--hidden-width", self.hidden_width.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// The baseline that is to be trained, if it is one.
    pub(super) fn baseline(&self) -> Option<pocketnerf_baselines::Method> {
        self.method.and_then(Method::baseline)
    }

    /// What is to be trained: what was asked for, or what suits scenes that planes suit, and
    /// others.
    pub(super) fn method(&self, suits_planes: bool) -> Method {
        let asked = self.kinds.ask_for_planes();
        let usual = Method::usual(asked || suits_planes && self.given_for_grids().is_none());
        self.method.unwrap_or(usual)
    }

    /// Whether `--method` is given.
    pub(super) fn has_method(&self) -> bool {
        self.method.is_some()
    }

    /// An option that was given and means nothing to baselines.
    pub(super) fn given_for_fields(&self) -> Option<&'static str> {
        let given = [
            ("--no-view-dependence", self.no_view_dependence),
            ("--learning-rate", self.learning_rate.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// How large the model file is to be.
    pub(super) fn size(&self) -> Size {
        match (self.max_bytes, self.target_psnr) {
            (Some(most), _) => Size::Bytes(most),
            (_, Some(psnr)) => Size::HeldOut(psnr),
            _ if self.auto => Size::Near,
            _ => Size::Whole,
        }
    }

    /// The option that says so.
    fn size_option(&self) -> Option<&'static str> {
        match self.size() {
            Size::Whole => None,
            Size::Bytes(_) => Some("--max-bytes"),
            Size::HeldOut(_) => Some("--target-psnr"),
            Size::Near => Some("--auto"),
        }
    }

    /// Refuses fewer bytes than the networks take, and a size for what has no tables.
    pub(super) fn check_size(&self, trainer: &Trainer) -> Result<(), Failure> {
        let Some(option) = self.size_option() else { return Ok(()) };
        check_sizes_of(option, trainer.config())?;
        if let (Some(psnr), 0) = (self.target_psnr, trainer.n_to_hold_out()) {
            let why = match trainer.steps() {
                0 => "no photograph can be held out to measure it, expected at least 32",
                _ => {
                    "the run holds no view out any more to measure it, expected one that was begun \
                      with --target-psnr"
                }
            };
            return Err(
                format!("--target-psnr {psnr}: {why}; give --auto or --max-bytes instead").into()
            );
        }
        let Some(most) = self.max_bytes else { return Ok(()) };
        let least = trainer.least_bytes();
        if (most as usize) < least {
            let narrower = match trainer.config().field {
                FieldConfig::HashGrid(_) => "; --hidden-width 16 makes them smaller",
                _ => "",
            };
            return Err(format!(
                "--max-bytes {most}: the networks alone take more, expected at least \
                 {least}{narrower}"
            )
            .into());
        }
        Ok(())
    }

    /// The settings of a new run.
    pub(super) fn config(&self, method: Method, images: Images, length: Length) -> TrainConfig {
        let mut config = self.kinds.config(method, images, length);
        if self.no_view_dependence {
            kinds::omit_view_dependence(&mut config.field);
        }
        if self.profile == Profile::Fast {
            config = config.for_speed();
        }
        if let Some(times) = self.learning_rate {
            config.grid_rate *= times;
            config.network_rate *= times;
        }
        if let Some(HashGridFieldConfig { grid, density_hidden, color_hidden, .. }) =
            config.field.hash_grid_mut()
        {
            let usual = grid.log2_hashmap_size;
            let by_bytes =
                self.max_bytes.map_or(usual, |bytes| entries_log2(bytes, length).min(usual));
            grid.log2_hashmap_size = self.log2_hashmap_size.unwrap_or(by_bytes);
            if let Some(n) = self.n_levels {
                let steps = (grid.n_levels - 1) as f32 / (n - 1) as f32;
                grid.per_level_scale = grid.per_level_scale.powf(steps);
                grid.n_levels = n;
            }
            if let Some(width) = self.hidden_width {
                density_hidden
                    .iter_mut()
                    .chain(color_hidden)
                    .for_each(|layer| *layer = width as usize);
            }
        }
        config
    }

    /// What to say of tables that are far smaller than usual: for photographs of so many pixels
    /// across, in a run of this length, and beside so many pixels in all.
    pub(super) fn doubt(&self, across: f32, pixels: usize, length: Length) -> Option<String> {
        self.kinds.doubt(across).or_else(|| self.doubt_of_entries(pixels, length))
    }

    fn doubt_of_entries(&self, pixels: usize, length: Length) -> Option<String> {
        /// So many times fewer entries, as a power of two.
        const FEWER: u32 = 4;
        /// So many pixels an entry.
        const PIXELS: usize = 100;
        let given = self.log2_hashmap_size?;
        let usual = Self { log2_hashmap_size: None, ..self.clone() };
        let usual = usual.config(Method::HashGrid, Images::ANY, length);
        let FieldConfig::HashGrid(usual) = usual.field else { return None };
        let usual = usual.grid.log2_hashmap_size;
        let few = given + FEWER <= usual && pixels >> given > PIXELS;
        few.then(|| {
            format!(
                "--log2-hashmap-size {given}: {} entries a level, expected about {} in a run of this \
                 length: places share entries, and details are missing",
                1_u64 << given,
                1_u64 << usual
            )
        })
    }

    /// What to say of learning rates at which runs stop converging: 30.1 instead of 32.4 dB at
    /// four times the usual ones, 16.7 at eight times (the still life, 3,000 steps).
    pub(super) fn doubt_of_rate(&self) -> Option<String> {
        const MOST: f32 = 2.0;
        let times = self.learning_rate.filter(|times| *times > MOST)?;
        Some(format!(
            "--learning-rate {times}: runs may not converge at such rates, expected at most {MOST}"
        ))
    }

    /// Whether the settings depend on how many steps there are.
    pub(super) fn follow_steps(&self, method: Method, images: Images) -> bool {
        let [few, many] = [1, u32::MAX].map(|n| self.config(method, images, Length::Steps(n)));
        few != many
    }

    /// The options whose values a checkpoint stores: name, given, stored.
    pub(super) fn against(
        &self,
        config: &TrainConfig,
    ) -> [(&'static str, Option<u32>, Option<u32>); 3] {
        let field = match &config.field {
            FieldConfig::HashGrid(field) => Some(field),
            _ => None,
        };
        let grid = field.map(|field| field.grid);
        let (log2_hashmap_size, n_levels) =
            (grid.map(|grid| grid.log2_hashmap_size), grid.map(|grid| grid.n_levels));
        let hidden_width = field.and_then(|field| {
            let mut widths = field.density_hidden.iter().chain(&field.color_hidden);
            let width = widths.next().filter(|&width| widths.all(|other| other == width));
            width.map(|&width| width as u32)
        });
        [
            ("--log2-hashmap-size", self.log2_hashmap_size, log2_hashmap_size),
            ("--n-levels", self.n_levels, n_levels),
            ("--hidden-width", self.hidden_width, hidden_width),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_follow_the_bytes() {
        let of = |bytes, steps| entries_log2(bytes, Length::Steps(steps));
        let found = [1_600_000, 700_000, 500_000, 350_000, 1_000].map(|bytes| of(bytes, 4000));
        assert_eq!(found, [18, 17, 16, 16, 10]);
        assert_eq!([of(500_000, 1), of(500_000, 38_000), of(1_100_000, 38_000)], [16, 15, 17]);
        assert_eq!(entries_log2(500_000, Length::Seconds(300.0)), 15);
    }
}
