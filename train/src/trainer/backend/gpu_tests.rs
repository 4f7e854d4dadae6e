//! A step on a GPU, beside the same step on the CPU.

use pocketnerf_core::SimdLevel;
use pocketnerf_gpu::{Gpu, Software};

use crate::builtin;
use crate::dataset::Split;
use crate::picture::Device;
use crate::trainer::parameters::State;
use crate::trainer::{StepSettings, TrainConfig, Trainer};

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

fn config() -> TrainConfig {
    let mut config = TrainConfig::hash_grid();
    let field = config.field.hash_grid_mut().unwrap();
    (field.grid.n_levels, field.grid.log2_hashmap_size) = (5, 11);
    field.color_hidden = vec![32, 80];
    config.aabb = Some([[-1.4; 3], [1.4; 3]]);
    config.samples_per_step = 4096;
    config.samples_per_side = 96.0;
    config.occupancy_resolution = 32;
    config
}

fn trainer(device: Option<&Device>) -> Trainer {
    let dataset = builtin::dataset(Split::Train, 8);
    let mut trainer = Trainer::with_prepass(dataset, config(), SimdLevel::detect()).unwrap();
    if let Some(device) = device {
        trainer.train_on(device.clone());
        assert_eq!(trainer.fallback(), None);
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

#[test]
fn gradients_are_those_of_the_cpu() {
    let Some(device) = gpu() else { return };
    // After some steps: surfaces, and colours that depend on the direction.
    let mut cpu = trainer(None);
    let warm = StepSettings { kept: 0.5, update_occupancy: true, ..StepSettings::PLAIN };
    (0..60).for_each(|_| _ = cpu.step(&warm));
    let mut learnt = state(&cpu).clone();
    let group = learnt.field_mut();
    group.mean.fill(0.0);
    group.square.fill(0.0);
    cpu.backend.upload(learnt);
    let mut on_gpu = trainer(Some(&device));
    on_gpu.backend.upload(state(&cpu).clone());
    (on_gpu.step, on_gpu.n_rays) = (cpu.step, cpu.n_rays);
    on_gpu.grid.clone_from(&cpu.grid);
    // Else the samples behind a surface stand for more steps from another one on: the CPU takes
    // several at a time.
    (cpu.coarse_step_below, on_gpu.coarse_step_below) = (0.0, 0.0);
    let settings = StepSettings { rate: 1e-3, ..StepSettings::PLAIN };
    let [a, b] = [cpu.step(&settings), on_gpu.step(&settings)];
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
