//! Options of `pocketnerf train` for vanilla NeRF.

use pocketnerf_core::field::Activation;
use pocketnerf_core::march::Hierarchical;
use pocketnerf_train::field::{FourierConfig, HierarchicalTraining, NerfConfig, WavesConfig};
use pocketnerf_train::trainer::TrainConfig;

use crate::commands::Failure;
use crate::commands::rendering::Sampling;

/// How the network's output becomes a density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Density {
    /// Nothing below 0, as in the original NeRF
    Relu,
    /// ln(1 + e^x)
    Softplus,
    /// e^x
    Exp,
}

#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "With --method nerf")]
pub(super) struct NerfOptions {
    /// Where the samples of a ray lie in training [default: occupancy]
    #[arg(long, value_enum)]
    sampling: Option<Sampling>,
    /// Layers of the network; the one after the middle reads the position once more
    /// [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=10))]
    depth: Option<u32>,
    /// Width of the layers [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=1024))]
    width: Option<u32>,
    /// Octaves of the positional encoding of positions and of directions; 0 passes the
    /// coordinates alone [default: 10,4]
    #[arg(long, value_name = "L,M", value_parser = parse_octaves)]
    octaves: Option<[u32; 2]>,
    /// Encode positions by N random frequencies of this standard deviation, waves per unit,
    /// instead of octaves, such as 128,2
    #[arg(long, value_name = "N,DEVIATION", value_parser = parse_gaussian, conflicts_with_all = ["octaves", "no_positional_encoding"])]
    gaussian: Option<(u32, f32)>,
    /// How the network's output becomes a density [default: exp; relu with --sampling
    /// hierarchical]
    #[arg(long, value_enum)]
    density: Option<Density>,
    /// Omit the positional encoding: the network reads coordinates
    #[arg(long)]
    no_positional_encoding: bool,
    /// Coarse and fine samples per ray, with --sampling hierarchical [default: 64,128]
    #[arg(long, value_name = "C,F", value_parser = parse_samples)]
    samples: Option<[u32; 2]>,
    /// Omit the coarse network: all samples are evenly spaced; with --sampling hierarchical
    #[arg(long)]
    no_hierarchy: bool,
    /// Standard deviation of noise added to the raw density, with --sampling hierarchical
    /// [default: 0]
    #[arg(long, value_name = "D")]
    density_noise: Option<f32>,
    /// Train the first N steps on the middle halves of the images, with --sampling
    /// hierarchical [default: 500 for images with alpha, else 0]
    #[arg(long, value_name = "N")]
    crop_steps: Option<u32>,
}

fn parse_samples(text: &str) -> Result<[u32; 2], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([c, f]) if (4..=1024).contains(c) && (1..=1024).contains(f) => Ok([*c, *f]),
        _ => Err("expected two numbers C,F, from 4 and from 1 to 1024".to_owned()),
    }
}

fn parse_octaves(text: &str) -> Result<[u32; 2], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([l, m]) if *l <= 16 && *m <= 16 => Ok([*l, *m]),
        _ => Err("expected two numbers L,M from 0 to 16".to_owned()),
    }
}

fn parse_gaussian(text: &str) -> Result<(u32, f32), String> {
    let parts = text.split_once(',').map(|(n, d)| (n.trim().parse(), d.trim().parse()));
    match parts {
        Some((Ok(n), Ok(d))) if (1..=512).contains(&n) && d > 0.0 && d < 1e3 => Ok((n, d)),
        _ => Err("expected N,DEVIATION: frequencies from 1 to 512, a number above 0".to_owned()),
    }
}

impl NerfOptions {
    /// An option that was given, to refuse it without its method.
    pub(super) fn given(&self) -> Option<&'static str> {
        let given = [
            ("--depth", self.depth.is_some()),
            ("--width", self.width.is_some()),
            ("--octaves", self.octaves.is_some()),
            ("--density", self.density.is_some()),
            ("--no-positional-encoding", self.no_positional_encoding),
        ];
        let found = given.into_iter().find(|(_, given)| *given).map(|(option, _)| option);
        found.or_else(|| self.given_for_whole())
    }

    /// The same of options that heads of a decomposed field do not have.
    pub(super) fn given_for_whole(&self) -> Option<&'static str> {
        let sampling = self.sampling.map(|_| "--sampling");
        let gaussian = self.gaussian.map(|_| "--gaussian");
        sampling.or(gaussian).or_else(|| self.given_for_hierarchical())
    }

    /// The same of options for hierarchical sampling alone.
    fn given_for_hierarchical(&self) -> Option<&'static str> {
        let given = [
            ("--samples", self.samples.is_some()),
            ("--density-noise", self.density_noise.is_some()),
            ("--crop-steps", self.crop_steps.is_some()),
            ("--no-hierarchy", self.no_hierarchy),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(option, _)| option)
    }

    /// Refuses options that make no sense.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if let (Some(option), false) = (self.given_for_hierarchical(), self.is_hierarchical()) {
            return Err(format!("{option}: give --sampling hierarchical too").into());
        }
        match self.density_noise {
            Some(noise) if !(0.0..1e6).contains(&noise) => {
                Err(format!("--density-noise {noise}: expected 0 or more").into())
            }
            _ => Ok(()),
        }
    }

    fn is_hierarchical(&self) -> bool {
        self.sampling == Some(Sampling::Hierarchical)
    }

    /// The settings of a new run on images with or without alpha.
    pub(super) fn config(&self, has_alpha: bool) -> TrainConfig {
        let mut nerf = if self.is_hierarchical() {
            let mut training = HierarchicalTraining::PLAIN;
            training.noise = self.density_noise.unwrap_or(0.0);
            training.crop_steps = self.crop_steps.unwrap_or(if has_alpha { 500 } else { 0 });
            let Hierarchical { n_coarse, n_fine, .. } = &mut training.sampling;
            [*n_coarse, *n_fine] = self.samples.unwrap_or([*n_coarse, *n_fine]);
            if self.no_hierarchy {
                (*n_coarse, *n_fine) = (*n_coarse + *n_fine, 0);
            }
            NerfConfig::hierarchical(training)
        } else {
            NerfConfig::in_cells()
        };
        self.shape(&mut nerf);
        TrainConfig::new(nerf)
    }

    /// The network that the options describe, where they say anything.
    pub(super) fn shape(&self, nerf: &mut NerfConfig) {
        let octaves =
            |n| FourierConfig { waves: WavesConfig::Octaves { n, pi: false }, include_input: true };
        nerf.depth = self.depth.map_or(nerf.depth, |n| n as usize);
        nerf.width = self.width.map_or(nerf.width, |n| n as usize);
        nerf.color_width = nerf.width / 2;
        // Of eight layers the sixth, of four the fourth.
        nerf.skip = if nerf.depth > 3 { nerf.depth / 2 + 1 } else { 0 };
        if let Some([l, m]) = self.octaves {
            (nerf.positions, nerf.directions) = (octaves(l), Some(octaves(m)));
        }
        if let Some((n, deviation)) = self.gaussian {
            let waves = WavesConfig::Gaussian { n, deviation };
            nerf.positions = FourierConfig { waves, include_input: false };
        }
        if self.no_positional_encoding {
            (nerf.positions, nerf.directions) = (octaves(0), Some(octaves(0)));
        }
        nerf.coarse &= !self.no_hierarchy;
        nerf.activation = match self.density {
            None => nerf.activation,
            Some(Density::Relu) => Activation::Relu,
            Some(Density::Softplus) => Activation::Softplus,
            Some(Density::Exp) => Activation::Exp,
        };
    }
}
