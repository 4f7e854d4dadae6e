//! Gradients against finite differences, and the roulette against all samples.
//!
//! The loss is half the sum of squared errors. The groups run on `f32` parameters:
//! rounded ones would round the steps of the differences away.

mod differences;
mod loss;
mod roulette;
mod samples;

use fearless_simd::dispatch;
use pocketnerf_core::Camera;
use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use pocketnerf_core::field::Shading;
use pocketnerf_core::march::Marcher;

use super::step::group::Job;
use super::step::run_group;
use super::*;
use crate::dataset::{Split, View};
use crate::field::{FieldConfig, Part, Range};
use crate::random::Random;
use loss::Loss;

/// Parameters of each range that are looked at one by one.
const SINGLES: usize = 4;
/// Rays of each group.
const RAYS: [usize; 2] = [400, 50];

/// Three views of 16×16 pixels; transparent ones are learnt on random backdrops.
fn dataset(has_alpha: bool) -> Dataset {
    let mut random = Random::new(1, [0; 3]);
    let eyes = [[3.0, 0.4, 0.8], [-1.2, 2.6, -0.7], [0.3, -1.0, 3.1]];
    let views = eyes.map(|eye| {
        let pose = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]);
        let rgba = (0..16 * 16 * 4)
            .map(|i| match i % 4 {
                3 if !has_alpha => 255,
                3 => 100 + random.below(156) as u8,
                // Bright, so that the rays' gradients do not cancel.
                _ => 180 + random.below(76) as u8,
            })
            .collect();
        View::new("", Camera::from_fov_x(16, 16, 0.6, pose), rgba)
    });
    Dataset { has_alpha, ..Dataset::new("", "test", Split::Train, views.into()) }
}

/// The first level is dense, the last one hashed.
const fn hash_grid(n_features_per_level: u32) -> EncodingConfig {
    EncodingConfig::HashGrid(HashGridConfig {
        n_levels: 3,
        n_features_per_level,
        log2_hashmap_size: 9,
        base_resolution: 3,
        per_level_scale: 2.0,
        index: GridIndex::Blocked,
    })
}

/// A field to look at.
#[derive(Clone, Copy, Debug)]
struct Case {
    encoding: EncodingConfig,
    density_hidden: &'static [usize],
    color_hidden: &'static [usize],
    n_features: usize,
    sh_degree: u32,
    shading: Shading,
    /// About the density's logarithm, per side of the box.
    log_density: f32,
    rays: [usize; 2],
    /// Where less light than this passes, samples stand for several steps.
    coarse_step_below: f32,
    /// `None`: the best there is.
    simd: Option<SimdLevel>,
}

const ONE_LAYER: Case = Case {
    encoding: hash_grid(4),
    density_hidden: &[16],
    color_hidden: &[16],
    n_features: 5,
    sh_degree: 3,
    shading: Shading::PerRay,
    log_density: 0.5,
    rays: RAYS,
    coarse_step_below: 0.0,
    simd: None,
};
const TWO_LAYERS: Case = Case { density_hidden: &[24, 13], color_hidden: &[16, 9], ..ONE_LAYER };

const SHADINGS: [Shading; 2] = [Shading::PerRay, Shading::PerSample];

/// The groups of one step, which can be run again.
struct Step {
    rays: [usize; 2],
    coarse_step_below: f32,
    trainer: Trainer,
    worker: Worker,
}

impl Step {
    fn new(case: Case) -> Self {
        let mut config = TrainConfig::hash_grid();
        config.field = FieldConfig {
            encoding: case.encoding,
            density_hidden: case.density_hidden.into(),
            color_hidden: case.color_hidden.into(),
            n_features: case.n_features,
            sh_degree: case.sh_degree,
            shading: case.shading,
            log_density_bias: 0.0,
        };
        config.opaque_backdrop = [0.1, 0.6, 0.3];
        config.aabb = Some([[-1.0, -1.0, -0.8], [1.0, 0.9, 1.0]]);
        config.occupancy_resolution = 16;
        config.samples_per_side = 8.0;
        let dataset = dataset(case.shading == Shading::PerSample);
        let simd = case.simd.unwrap_or_else(SimdLevel::detect);
        let mut trainer = Trainer::new(dataset, config, simd).unwrap();
        let first_output = trainer.layout.range(Part::DensityBias(case.density_hidden.len())).start;
        let mut random = Random::new(2, [0; 3]);
        trainer.set_parameters(|layout, parameters| {
            for range in layout.ranges() {
                for value in &mut parameters[range.indices()] {
                    match range.part {
                        Part::GridLevel(_) => *value *= 5e3,
                        Part::DensityBias(_) | Part::ColorBias(_) => {
                            *value = random.next_f32() - 0.5;
                        }
                        Part::DensityWeight(_) | Part::ColorWeight(_) => *value *= 0.7,
                        Part::Nerf(_) => unreachable!("has tests of its own"),
                    }
                }
            }
            parameters[first_output] = case.log_density;
        });
        trainer.groups.truncate(case.rays.len());
        // Rays that count as much as each other would hide what weights are for.
        (0..).zip([0.3, 0.01, 0.1]).for_each(|(tile, e)| trainer.attention.note(tile, e));
        trainer.attention.update();
        let worker = Worker::new(trainer.limits, &trainer.backward, None);
        Self { rays: case.rays, coarse_step_below: case.coarse_step_below, trainer, worker }
    }

    /// Loss and samples passed back; gradients stay in the groups. `luck` decides
    /// in the roulette.
    fn run(&mut self, roulette: f32, luck: u64) -> (f64, usize) {
        let Trainer {
            layout,
            config,
            parameters,
            backward,
            groups,
            grid,
            space,
            sampling,
            source,
            level,
            aim,
            attention,
            ..
        } = &mut self.trainer;
        backward.update(&parameters[layout.networks_start()..]);
        let field = layout.view(&config.field, parameters).unwrap();
        let job = Job {
            marcher: Marcher::from_parts(Some(grid.view()), *space, *sampling, true),
            backward,
            step: sampling.step,
            coarse_step_below: self.coarse_step_below,
            roulette,
            stopwatch: None,
            paper: None,
            space: *space,
            reach: [sampling.near, sampling.far],
        };
        let (mut loss, mut kept) = (0.0, 0);
        for ((g, group), n) in (0..).zip(groups).zip(self.rays) {
            group.draw(source, (aim, attention), n, Random::new(3, [g, 0, 0]));
            group.reseed(Random::new(44, [g, luck, 0]));
            run_group(*level, group, &field, &job, &mut self.worker);
            loss += 0.5 * group.stats.squared_error;
            kept += group.stats.kept;
        }
        (loss, kept)
    }

    /// The gradient that the groups found, as the optimizer would see it.
    fn gradient(&self) -> Vec<f32> {
        let Trainer { layout, config, groups, level, .. } = &self.trainer;
        let mut gradient = vec![0.0; layout.len()];
        for group in groups {
            let networks = &mut gradient[layout.networks_start()..];
            for (sum, g) in networks.iter_mut().zip(&group.network_gradient) {
                *sum += g;
            }
        }
        if let EncodingConfig::HashGrid(grid) = &config.field.encoding {
            let (features, n_encoded) = (grid.n_features_per_level as usize, grid.n_output());
            for (l, range) in layout.levels().iter().enumerate() {
                let (table, to) = (grid.level(l), &mut gradient[range.indices()]);
                dispatch!(*level, simd => {
                    optim::update::scatter_groups(simd, groups, &table, l, features, n_encoded, to);
                });
            }
        }
        gradient
    }

    /// The loss of the rays that were run last, in f64.
    fn loss(&self) -> Loss {
        let Trainer { config, layout, sampling, groups, .. } = &self.trainer;
        let rays = groups.iter().flat_map(Group::rays_with_samples);
        Loss::new(config.field.clone(), layout.clone(), sampling.step, rays)
    }
}

/// Parameters and how far each goes.
type Direction = Vec<(usize, f64)>;

/// Along the gradient, along random signs, and single parameters.
fn directions(range: &Range, gradient: &[f32], random: &mut Random) -> Vec<Direction> {
    let most = range.indices().map(|i| gradient[i].abs()).fold(0.0, f32::max);
    assert!(most > 0.0, "{:?} has no gradient", range.part);
    let along = range.indices().map(|i| (i, f64::from(gradient[i] / most)));
    let signs = range.indices().map(|i| (i, if random.below(2) == 0 { 1.0 } else { -1.0 }));
    let mut all = vec![along.collect(), signs.collect()];
    while all.len() < 2 + SINGLES {
        let i = range.start + random.below(range.len());
        // Next to nothing can be said of what next to nothing depends on.
        if gradient[i].abs() >= 0.1 * most {
            all.push(vec![(i, 1.0)]);
        }
    }
    all
}

/// The derivative along `direction`.
fn along(gradient: &[f32], direction: &Direction) -> f64 {
    direction.iter().map(|(i, share)| f64::from(gradient[*i]) * share).sum()
}
