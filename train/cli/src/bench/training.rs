//! What a training step costs, stage by stage.

use std::time::Instant;

use pocketnerf_core::{AnyField, SimdLevel};
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::stopwatch::{Stage as S, Stopwatch};
use pocketnerf_train::trainer::{GROUPS, Length, Run, TrainConfig, Trainer};
use serde::Serialize;

use super::stage::{Crowd, Demand, Measured, StageCost, fraction_of_bounds, stages};
use super::work::{self, LevelReads};
use super::{BenchError, update};
use crate::machine::Machine;

/// One in so many steps is not timed: until the occupancy knows what is empty.
const WARM_UP: u32 = 5;
/// Steps whose changes are looked at.
const LOOKS: u32 = 4;

/// What a training step costs.
#[derive(Clone, Debug, Serialize)]
pub struct Training {
    /// Steps that were timed.
    pub steps: u32,
    /// Threads.
    pub threads: usize,
    /// Wall time of these steps.
    pub seconds: f64,
    /// Samples at which the field was asked, by seconds.
    pub samples_per_second: f64,
    /// Samples by rays.
    pub samples_per_ray: f64,
    /// Share of the samples that were passed back.
    pub kept: f64,
    /// PSNR of the last rays, dB.
    pub train_psnr: f64,
    /// Part of all thread time that the stages' bounds account for.
    pub fraction_of_bounds: f64,
    /// Thread time, on all threads at once.
    pub stages: Vec<StageCost>,
}

/// Trains for so many steps, of which the first fifth warms up, and gives the
/// finished trainer with what the rest cost.
///
/// # Errors
/// When the configuration makes no valid field, or training diverges.
pub fn measure(
    dataset: Dataset,
    config: TrainConfig,
    steps: u32,
    simd: SimdLevel,
    machine: &Machine,
) -> Result<(Trainer, Training), BenchError> {
    let image_bytes: usize = dataset.views.iter().map(|view| view.rgba.len()).sum();
    let mut trainer = Trainer::with_prepass(dataset, config, simd)?;
    let mut run = Run::new(Length::Steps(steps), Instant::now());
    while trainer.steps() < steps / WARM_UP {
        run.step(&mut trainer)?;
    }
    let before = run.summary(&trainer);
    trainer.watch();
    let (mut seconds, mut timed, mut changed) = (0.0, 0, Vec::new());
    let apart = (steps - steps / WARM_UP).div_ceil(LOOKS);
    while !run.is_over(&trainer) {
        let old = (timed % apart == apart / 2).then(|| update::tables(&trainer));
        let begun = Instant::now();
        run.step(&mut trainer)?;
        seconds += begun.elapsed().as_secs_f64();
        timed += 1;
        changed.extend(old.map(|old| update::changed(&old, &trainer, machine.lanes)));
    }
    let after = run.summary(&trainer);
    let (rays, samples) = (after.rays - before.rays, after.samples - before.samples);
    let watch = trainer.stopwatch().expect("begun above");
    let changed = changed.iter().sum::<f64>() / changed.len().max(1) as f64;
    let measured = measured(&trainer, watch, timed, image_bytes, changed);
    let thread_seconds = seconds * machine.threads as f64;
    let stages = stages(&measured, thread_seconds, samples, machine, Crowd::All);
    let training = Training {
        steps: timed,
        threads: machine.threads,
        seconds,
        samples_per_second: samples as f64 / seconds,
        samples_per_ray: samples as f64 / rays as f64,
        kept: watch.units(S::Backward) as f64 / samples as f64,
        train_psnr: after.train_psnr,
        fraction_of_bounds: fraction_of_bounds(&stages),
        stages,
    };
    // The step that ends the run: the average of its last quarter.
    run.step(&mut trainer)?;
    Ok((trainer, training))
}

/// The stages with what bounds them; `changed` is the part of the tables that a
/// step changes.
fn measured(
    trainer: &Trainer,
    watch: &Stopwatch,
    steps: u32,
    image_bytes: usize,
    changed: f64,
) -> Vec<Measured> {
    let model = trainer.model();
    let decoder = model.field.decoder().expect("a kind that has one");
    let (density, color) = (&decoder.density, &decoder.color);
    let [bytes, full] = [1.0, 4.0].map(|size| stored(&model.field, size));
    let encode = || Demand::gather(bytes.clone(), work::encode_flops(&model.field));
    let pixel = LevelReads { entries: 1.0, entry_bytes: 4.0, table_bytes: image_bytes as f64 };
    // Features to rows of samples, and from there to the rays' sums.
    let composited = 4.0 * 3.0 * (1 + decoder.channels()) as f64;
    let sizes = update::Sizes::new(&model.field);
    let kept = watch.units(S::Backward);
    let stage = |stage, name, unit, units, demand| Measured {
        name,
        unit,
        units,
        seconds: watch.seconds(stage),
        demand,
    };
    let own = |s, name, unit, demand| stage(s, name, unit, watch.units(s), demand);
    let both_ways = |n| work::network_flops(n) + work::backward_flops(n);
    let density_back = work::hidden_flops(density) + work::backward_flops(density);
    vec![
        own(S::Pixels, "pixels", "ray", Demand::gather(vec![pixel], None)),
        own(S::March, "march", "sample", Demand::default()),
        own(S::Encode, "encode", "sample", encode()),
        own(S::Density, "density network", "sample", Demand::fma(work::network_flops(density))),
        own(S::Composite, "composite", "sample", Demand::bandwidth(composited, 0.0)),
        own(S::Shade, "shade and loss", "hit ray", Demand::fma(both_ways(color))),
        own(S::EncodeAgain, "encode again", "kept sample", encode()),
        own(S::Backward, "network backward", "kept sample", Demand::fma(density_back)),
        stage(
            S::Scatter,
            "table scatter",
            "kept sample",
            kept,
            Demand::gather(full.clone(), work::encode_flops(&model.field)),
        ),
        own(S::Reduce, "gradient reduction", "step", sizes.reduction(GROUPS)),
        stage(S::Adam, "Adam and rounding", "step", steps.into(), sizes.adam(changed)),
        own(S::Occupancy, "occupancy", "update", Demand::default()),
    ]
}

/// What a point reads if a value took `size` bytes.
fn stored(field: &AnyField<'_>, size: f64) -> Vec<LevelReads> {
    let of = field.dtype().size() as f64;
    let level = |l: LevelReads| LevelReads {
        entry_bytes: l.entry_bytes / of * size,
        table_bytes: l.table_bytes / of * size,
        ..l
    };
    work::reads(field).into_iter().map(level).collect()
}
