//! A step on a GPU, beside the same step on the CPU.

use pocketnerf_core::SimdLevel;
use pocketnerf_core::field::Shading;
use pocketnerf_core::space::{Contracted, Ndc};
use pocketnerf_gpu::{Gpu, Software};

use crate::builtin;
use crate::dataset::Split;
use crate::picture::Device;
use crate::trainer::parameters::State;
use crate::trainer::{StepSettings, StepStats, TrainConfig, Trainer};

/// A GPU, even one in software; where there is none, tests have nothing to do, unless all tools
/// are required.
fn gpu() -> Option<Device> {
    match Gpu::open(Software::Allowed) {
        Ok(gpu) => Some(Device::Gpu(gpu)),
        Err(why) => {
            assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{why}");
            println!("{why}: nothing is tested");
            None
        }
    }
}

/// A small field; of `others`, one that workgroups do not evaluate together.
fn config(others: bool) -> TrainConfig {
    let mut config = TrainConfig::hash_grid();
    let field = config.field.hash_grid_mut().unwrap();
    (field.grid.n_levels, field.grid.log2_hashmap_size) = (5, 11);
    field.color_hidden = vec![32, 80];
    if others {
        (field.grid.n_features_per_level, field.density_hidden) = (2, vec![32, 16]);
        (field.n_features, field.sh_degree, field.color_hidden) = (8, 2, vec![24]);
    }
    config.aabb = Some([[-1.4; 3], [1.4; 3]]);
    config.samples_per_step = 4096;
    config.samples_per_side = 96.0;
    config.occupancy_resolution = 32;
    config
}

fn trainer(config: TrainConfig, device: Option<&Device>) -> Trainer {
    let mut dataset = builtin::dataset(Split::Train, 8);
    if config.contracted.is_some() {
        // Points say where the scene is: samples near the cameras learn less.
        (dataset.bounds, dataset.reach) = (Some([1.5, 6.0]), config.aabb);
    }
    let mut trainer = Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap();
    if let Some(device) = device {
        trainer.train_on(device.clone());
    }
    trainer
}

fn state(trainer: &Trainer) -> &State {
    trainer.backend.download()
}

/// Root mean square of the differences, and of the first values.
fn differ(a: &[f32], b: &[f32]) -> [f64; 2] {
    assert_eq!(a.len(), b.len());
    let mean = |squares: f64| (squares / a.len().max(1) as f64).sqrt();
    let off = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    [mean(off), mean(a.iter().map(|a| f64::from(*a).powi(2)).sum())]
}

/// Second moments after one step are squares of gradients.
fn gradients(state: &State) -> Vec<f32> {
    state.field().square.iter().map(|square| square.sqrt()).collect()
}

/// All samples of the warm-up are learnt from; then gradients are small beside parameters.
const WARM: StepSettings =
    StepSettings { kept: 0.5, update_occupancy: true, ..StepSettings::PLAIN };

/// Takes a step, and waits for what it finds out; again where it had too little room.
fn take(trainer: &mut Trainer, settings: &StepSettings) -> StepStats {
    loop {
        let stats = trainer.step(settings);
        let late = trainer.wait();
        match (late.rays, stats.rays) {
            (1.., _) => return late,
            (0, 1..) => return stats,
            (0, 0) => trainer.step -= 1,
        }
    }
}

fn gradients_are_those_of_the_cpu(config: &TrainConfig, lengths: Option<&[f32]>) {
    let Some(device) = gpu() else { return };
    // After some steps: surfaces, and colours that depend on the direction.
    let mut cpu = trainer(config.clone(), None);
    (0..60).for_each(|_| _ = cpu.step(&WARM));
    let mut learnt = state(&cpu).clone();
    let group = learnt.field_mut();
    group.mean.fill(0.0);
    group.square.fill(0.0);
    cpu.backend.upload(learnt);
    let mut on_gpu = trainer(config.clone(), Some(&device));
    assert_eq!(on_gpu.fallback(), None);
    on_gpu.backend.upload(state(&cpu).clone());
    (on_gpu.step, on_gpu.n_rays) = (cpu.step, cpu.n_rays);
    on_gpu.grid.clone_from(&cpu.grid);
    on_gpu.backend.draw_like_the_cpu();
    if let Some(lengths) = lengths {
        cpu.backend.round_coarsely(lengths);
        on_gpu.backend.round_coarsely(lengths);
    }
    // Else the samples behind a surface stand for more steps from another one on: the CPU takes
    // several at a time.
    (cpu.coarse_step_below, on_gpu.coarse_step_below) = (0.0, 0.0);
    let settings = StepSettings { rate: 1e-3, ..StepSettings::PLAIN };
    let [a, b] = [take(&mut cpu, &settings), take(&mut on_gpu, &settings)];
    assert_eq!(a.rays, b.rays);
    let close = |a: f64, b: f64, by: f64| assert!((a - b).abs() <= by * a.abs(), "{a}, {b}");
    // The CPU counts what it asks beyond the end of a ray, too.
    close(a.samples as f64, b.samples as f64, 0.02);
    close(a.mean_squared_error, b.mean_squared_error, 1e-3);
    close(a.mean_opacity, b.mean_opacity, 1e-3);
    let start = cpu.config.field.kind().layout().networks_start();
    let [a, b] = [gradients(state(&cpu)), gradients(state(&on_gpu))];
    for (what, part) in [("tables", 0..start), ("networks", start..a.len())] {
        let [off, size] = differ(&a[part.clone()], &b[part]);
        println!("{what}: {:.1e}", off / size);
        assert!(size > 0.0 && off < 1e-3 * size, "{what}: {off} of {size}");
    }
    let [off, size] = differ(&state(&cpu).field().mean, &state(&on_gpu).field().mean);
    assert!(size > 0.0 && off < 1e-3 * size, "first moments: {off} of {size}");
    assert_eq!(state(&cpu).scales, state(&on_gpu).scales);
}

#[test]
fn gradients_of_samples_together() {
    gradients_are_those_of_the_cpu(&config(false), None);
}

#[test]
fn gradients_of_samples_one_by_one() {
    gradients_are_those_of_the_cpu(&config(true), None);
}

#[test]
fn gradients_of_coarsely_rounded_tables() {
    gradients_are_those_of_the_cpu(&config(false), Some(&[0.01, 0.02, 0.002, 0.03, 1e-9]));
}

#[test]
fn gradients_in_contracted_space() {
    let contracted = Some(Contracted { center: [0.1, 0.0, 0.0], radius: 0.6 });
    gradients_are_those_of_the_cpu(&TrainConfig { contracted, ..config(false) }, None);
}

/// A weight that outweighs colours, so that all gradients are those of smooth surfaces.
#[test]
fn gradients_of_smooth_surfaces() {
    let contracted = Some(Contracted { center: [0.1, 0.0, 0.0], radius: 0.6 });
    let contracted = TrainConfig { contracted, ..config(false) };
    // Cameras above the scene see its lower half so.
    let ndc = Ndc { near: 0.1, slope: [0.5; 2], min: [-4.0, -4.0, -1.0], max: [4.0, 4.0, 1.0] };
    let ndc = TrainConfig { ndc: Some(ndc), aabb: None, ..config(false) };
    for config in [config(false), config(true), contracted, ndc] {
        gradients_are_those_of_the_cpu(&TrainConfig { smooth_surfaces: 2.0, ..config }, None);
    }
}

/// All that a run may ask of a step; the CPU goes on from it.
#[test]
fn the_same_steps_give_the_same_bytes() {
    let Some(device) = gpu() else { return };
    let run = || {
        let mut trainer = trainer(config(false), Some(&device));
        for step in 0..24 {
            let average = step >= 16;
            trainer.step(&StepSettings { average, between_views: average, ..WARM });
        }
        trainer
    };
    let [a, mut b] = [run(), run()];
    for (a, b) in state(&a).groups.iter().zip(&state(&b).groups) {
        assert!(a.parameters[..] == b.parameters[..] && a.square[..] == b.square[..]);
        assert!(a.mean == b.mean && a.sum == b.sum && !a.sum.is_empty());
    }
    assert_eq!((state(&a).averaged, a.n_rays, a.roulette), (8, b.n_rays, b.roulette));
    assert_eq!(a.grid.state(), b.grid.state());
    // The sum of eight steps is about eight times the last.
    let group = state(&b).field();
    let [off, size] = differ(&group.sum, &group.parameters);
    assert!((off / size - 7.0 / 8.0).abs() < 0.05, "{off} {size}");
    b.train_on(Device::Cpu);
    assert!(!b.is_on_gpu() && state(&b).field().sum == state(&a).field().sum);
    let before = b.step(&WARM).mean_squared_error;
    assert!(before.is_finite() && b.steps() == 25);
}

/// A driver that is reset takes the tables with it: those of the last look are gone on with, and
/// the average of other steps than theirs is not.
#[test]
fn a_run_goes_on_where_the_gpu_is_lost() {
    let Some(device) = gpu() else { return };
    let mut trainer = trainer(config(false), Some(&device));
    (0..24).for_each(|_| _ = trainer.step(&WARM));
    let looked_at = state(&trainer).field().parameters.to_vec();
    let average = StepSettings { average: true, ..WARM };
    let six_steps = |trainer: &mut Trainer| {
        (0..6).map(|_| take(trainer, &average).mean_squared_error).sum::<f64>() / 6.0
    };
    let before = six_steps(&mut trainer);
    trainer.backend.lose();
    assert_eq!(trainer.fallback().as_deref(), Some("the GPU failed: it is lost"));
    assert!(!trainer.is_on_gpu() && state(&trainer).averaged == 0);
    let start = trainer.config.field.kind().layout().networks_start();
    assert!(state(&trainer).field().parameters[..start] == looked_at[..start]);
    let after = six_steps(&mut trainer);
    assert!(after < 1.2 * before, "{after}, {before}");
    assert_eq!((trainer.steps(), state(&trainer).averaged), (36, 6));
    trainer.finish();
    let ends = state(&trainer).field().parameters.iter().all(|value| value.is_finite());
    assert!(ends && state(&trainer).averaged == 0);
}

/// Where samples do not fit, nothing is learnt, and the average stays one.
#[test]
fn a_step_without_room_changes_nothing() {
    let Some(device) = gpu() else { return };
    let mut trainer = trainer(config(false), Some(&device));
    let before = state(&trainer).field().parameters.to_vec();
    // At first all is occupied, and every sample is passed back.
    let average = StepSettings { average: true, ..StepSettings::PLAIN };
    assert_eq!((trainer.step(&average).rays, trainer.wait().rays), (0, 0));
    let lost = state(&trainer).field();
    assert!(lost.parameters[..] == before[..] && lost.sum == before);
    assert!(lost.mean.iter().chain(&lost.square[..]).all(|moment| *moment == 0.0));
    assert_eq!(state(&trainer).averaged, 1);
    // The next one has room.
    assert!(take(&mut trainer, &StepSettings::PLAIN).rays > 0);
    let learnt = state(&trainer).field();
    let start = trainer.config.field.kind().layout().networks_start();
    assert!(learnt.parameters[..start] != before[..start]);
    assert!(learnt.parameters[start..] != before[start..] && learnt.sum == before);
}

#[test]
fn what_a_gpu_does_not_learn_the_cpu_does() {
    let Some(device) = gpu() else { return };
    let refused = |config: TrainConfig| {
        let mut trainer = trainer(config.clone(), None);
        trainer.begin_on(device.clone());
        assert!(!trainer.is_on_gpu() && trainer.config == config);
        assert!(trainer.step(&WARM).samples > 0);
        trainer.fallback().unwrap()
    };
    let poses = refused(TrainConfig { refine_poses: true, ..config(false) });
    assert_eq!(poses, "GPUs do not train the poses and the exposure of photographs");
    let mut other = config(false);
    other.field.hash_grid_mut().unwrap().shading = Shading::PerSample;
    assert_eq!(refused(other), "GPUs do not train fields whose samples have colours of their own");
}
