//! Gradients against finite differences, and the roulette against all samples.
//!
//! The loss is half the sum of squared errors. The groups run on `f32` parameters:
//! rounded ones would round the steps of the differences away.

mod differences;
mod exact;
mod loss;
mod poses;
mod roulette;
mod samples;

use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use pocketnerf_core::field::Shading;
use pocketnerf_core::{Camera, Sampling, SimdLevel, Space};

use super::config::{COLOR, DENSITY};
use super::*;
use crate::dataset::{Dataset, Split, View};
use crate::field::{Part, PlanesConfig, Role};
use crate::random::Random;
use crate::trainer::backend::{Backend, Cpu, StepInput};
use crate::trainer::loss::{RayLoss, Rendered, Term};
use crate::trainer::parameters::{ParameterGroup, State};
use crate::trainer::pixels::importance::PixelSampler;
use crate::trainer::pixels::rays::RaySource;
use crate::trainer::pixels::visibility::PixelVisibility;
use crate::trainer::prepass::{self, Prepared};
use crate::trainer::step::group::{Group, Job, MIN_TRANSMITTANCE};
use crate::trainer::step::poses::PoseJob;
use crate::trainer::step::worker::Worker;
use crate::trainer::{DensityGrid, TrainConfig, TrainingRay};
use exact::Exact;
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
const fn hash_grid(n_features_per_level: u32) -> HashGridConfig {
    HashGridConfig {
        n_levels: 3,
        n_features_per_level,
        log2_hashmap_size: 9,
        base_resolution: 3,
        per_level_scale: 2.0,
        index: GridIndex::Blocked,
    }
}

const PLANES: PlanesConfig = PlanesConfig { resolution: 9, last_resolution: 9, n_components: 16 };

/// A field to look at.
#[derive(Clone, Copy, Debug)]
struct Case<E = HashGridConfig> {
    encoding: E,
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
    /// Whether [`DepthTerm`] counts.
    depth: bool,
    /// Whether cameras are pulled.
    poses: bool,
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
    depth: false,
    poses: false,
    simd: None,
};
const TWO_LAYERS: Case = Case { density_hidden: &[24, 13], color_hidden: &[16, 9], ..ONE_LAYER };

impl Case {
    /// The same with another encoding.
    const fn of<E: Copy>(self, encoding: E) -> Case<E> {
        let Self { density_hidden, color_hidden, n_features, sh_degree, shading, .. } = self;
        let Self { log_density, rays, coarse_step_below, depth, poses, simd, .. } = self;
        Case {
            encoding,
            density_hidden,
            color_hidden,
            n_features,
            sh_degree,
            shading,
            log_density,
            rays,
            coarse_step_below,
            depth,
            poses,
            simd,
        }
    }
}

const SHADINGS: [Shading; 2] = [Shading::PerRay, Shading::PerSample];

/// A term of the loss: half the squared difference of each ray's depth from a fixed one.
#[derive(Debug)]
struct DepthTerm;

impl DepthTerm {
    const TARGET: f32 = 2.5;
}

impl Term for DepthTerm {
    fn needs_depth(&self) -> bool {
        true
    }

    fn add(&self, ray: &TrainingRay, rendered: &Rendered, loss: &mut RayLoss) {
        loss.d_depth += ray.weight * (rendered.depth - Self::TARGET);
    }
}

/// The groups of one step, which can be run again.
struct Step<E = HashGridConfig> {
    case: Case<E>,
    config: EncodedFieldConfig<E>,
    layout: Layout,
    source: RaySource,
    visibility: PixelVisibility,
    sampler: PixelSampler,
    grid: DensityGrid,
    space: Space,
    sampling: Sampling,
    cpu: Cpu,
}

impl<E: Exact + Copy> Step<E> {
    fn new(case: Case<E>) -> Self {
        let config = EncodedFieldConfig {
            grid: case.encoding,
            density_hidden: case.density_hidden.into(),
            color_hidden: case.color_hidden.into(),
            n_features: case.n_features,
            sh_degree: case.sh_degree,
            shading: case.shading,
        };
        let training = TrainConfig {
            field: E::config(config.clone()),
            opaque_backdrop: [0.1, 0.6, 0.3],
            aabb: Some([[-1.0, -1.0, -0.8], [1.0, 0.9, 1.0]]),
            occupancy_resolution: 16,
            samples_per_side: 8.0,
            ..TrainConfig::hash_grid()
        };
        let dataset = dataset(case.shading == Shading::PerSample);
        let simd = case.simd.unwrap_or_else(SimdLevel::detect);
        let prepared = prepass::run(dataset, training, simd, prepass::Deadline::NONE).unwrap();
        let Prepared { source, space, candidates, config: training, .. } = prepared;
        // What is near a camera learns less than its gradient says.
        let source = source.with_nearest(None);
        let scale = space.unit_map().scale;
        let mut field = config.build(scale);
        field.set_exact();
        let layout = config.layout();
        let group = ParameterGroup::of_field(&layout, training.adam());
        let mut cpu = Cpu::new(field, State::new(group), simd).unwrap();
        cpu.reset(0);
        let mut state = cpu.download().clone();
        set_parameters(&case, &layout, &mut state.field_mut().parameters);
        cpu.upload(state);
        let visibility = PixelVisibility::new(&source, &space, 16, &candidates);
        // Rays that count as much as each other would hide what weights are for.
        let mut sampler = PixelSampler::new(visibility.n_tiles());
        (0..).zip([0.3, 0.01, 0.1]).for_each(|(tile, e)| sampler.note(tile, e));
        sampler.update();
        Self {
            case,
            config,
            sampling: training.sampling(&space).unwrap(),
            layout,
            source,
            visibility,
            sampler,
            grid: DensityGrid::new(16, candidates),
            space,
            cpu,
        }
    }

    fn parameters(&self) -> &[f32] {
        &self.cpu.download().field().parameters
    }

    fn groups(&self) -> impl Iterator<Item = &Group> {
        self.cpu.groups.iter().take(self.case.rays.len())
    }

    /// Loss and samples passed back; gradients stay in the groups. `luck` decides
    /// in the roulette.
    fn run(&mut self, roulette: f32, luck: u64) -> (f64, usize) {
        let Self { case, source, visibility, sampler, grid, space, sampling, cpu, .. } = self;
        let input = StepInput {
            source,
            visibility,
            sampler,
            n_rays: 0,
            seed: 0,
            step: 0,
            space: *space,
            occupancy: grid.view(),
            sampling: *sampling,
            coarse_step_below: case.coarse_step_below,
            hierarchical: None,
            roulette,
            table_rate: 0.0,
            table_decay: 0.0,
            table_smoothing: 0.0,
            rate: 0.0,
            average: false,
            smooth_surfaces: 0.0,
            spread: 0.0,
            between_views: false,
            blur_directions: false,
            gains: None,
            poses: None,
            stopwatch: None,
        };
        let mut job = Job::new(&input);
        if case.depth {
            job.terms = &[&DepthTerm];
        }
        job.poses = case.poses.then_some(PoseJob { levels: [1.0; 16], views: 3 });
        let Cpu { field, groups, state, level, limits, .. } = cpu;
        let parameters = &state.field().parameters[..];
        field.prepare(parameters, case.rays.len());
        let context = Context { level: *level, parameters, stopwatch: None };
        let view = field.training_view(parameters).unwrap();
        let mut worker = Worker::new(*limits);
        let (mut loss, mut kept) = (0.0, 0);
        for ((g, group), n) in (0..).zip(groups).zip(case.rays) {
            group.draw(&input, n, Random::new(3, [g, 0, 0]));
            group.reseed(Random::new(44, [g, luck, 0]));
            let mut back = field.back(g as usize, context);
            group.run(*level, &view, &job, &mut worker, &mut *back);
            loss += 0.5 * group.stats.squared_error;
            kept += group.stats.kept;
        }
        (loss, kept)
    }

    /// The gradient that the groups found, as the optimizer would see it.
    fn gradient(&self) -> Vec<f32> {
        self.cpu.field.gradient(self.cpu.level, self.parameters())
    }

    /// The loss of the rays that were run last, in f64.
    fn loss(&self) -> Loss<E> {
        let rays = self.groups().flat_map(Group::rays_with_samples);
        let bias = self.space.unit_map().scale.ln();
        Loss::new(
            self.config.clone(),
            self.layout.clone(),
            (self.sampling.step, bias),
            self.case.depth,
            rays,
        )
    }
}

/// Values of which all count.
fn set_parameters<E: Exact>(case: &Case<E>, layout: &Layout, parameters: &mut [f32]) {
    let mut random = Random::new(2, [0; 3]);
    for range in layout.ranges() {
        for value in &mut parameters[range.indices()] {
            match range.part.role {
                Role::Table => *value *= 0.5 / case.encoding.initial_range(range.part.layer)[1],
                Role::Weight => *value *= 0.7,
                Role::Bias | Role::Fixed => *value = random.next_f32() - 0.5,
            }
        }
    }
    let last = Part { network: DENSITY, layer: case.density_hidden.len(), role: Role::Bias };
    parameters[layout.range(last).start] = case.log_density;
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
