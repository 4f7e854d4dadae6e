//! A run of a few seconds.

use std::path::Path;
use std::sync::LazyLock;
use std::time::Instant;

use pocketnerf_core::SimdLevel;
use pocketnerf_core::encoding::{GridIndex, HashGridConfig};
use pocketnerf_core::field::Shading;
use pocketnerf_formats::{About, Precision, Provenance};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::field::{FieldConfig, HashGridFieldConfig};
use pocketnerf_train::trainer::checkpoint::{self, TrainedOn};
use pocketnerf_train::trainer::{
    Checkpoint, FinishingBudget, Length, Run, RunError, TrainConfig, Trainer,
};

/// So many views of 25×25 pixels that some are held out.
pub(crate) fn dataset() -> Dataset {
    static DATASET: LazyLock<Dataset> = LazyLock::new(|| {
        let mut dataset = builtin::dataset(Split::Train, 16);
        dataset.views.truncate(32);
        dataset
    });
    DATASET.clone()
}

pub(crate) fn config() -> TrainConfig {
    let mut config = TrainConfig::hash_grid();
    config.field = FieldConfig::HashGrid(HashGridFieldConfig {
        grid: HashGridConfig {
            n_levels: 4,
            n_features_per_level: 2,
            log2_hashmap_size: 10,
            base_resolution: 4,
            per_level_scale: 1.7,
            index: GridIndex::Blocked,
        },
        density_hidden: vec![16],
        color_hidden: vec![16],
        n_features: 7,
        ..HashGridFieldConfig::default()
    });
    // Finding the box takes longer than everything else here.
    config.aabb = Some([[-1.4; 3], [1.4; 3]]);
    config.occupancy_resolution = 32;
    config.samples_per_side = 64.0;
    config.samples_per_step = 4096;
    // Everything that a step may draw random numbers for.
    config.kept = [0.5, 1.0];
    config.first_step_scale = 1.5;
    config
}

/// A colour for each sample, two layers a network, and one hashed level.
pub(crate) fn per_sample() -> TrainConfig {
    let mut config = config();
    let field = config.field.hash_grid_mut().unwrap();
    field.grid = HashGridConfig {
        n_levels: 1,
        n_features_per_level: 4,
        log2_hashmap_size: 8,
        base_resolution: 12,
        per_level_scale: 1.0,
        index: GridIndex::Blocked,
    };
    field.shading = Shading::PerSample;
    field.density_hidden = vec![16, 8];
    field.color_hidden = vec![12, 16];
    config
}

/// A field too small to learn pixels by heart: eight entries, and narrow networks.
pub(crate) fn too_small() -> TrainConfig {
    let mut config = per_sample();
    let field = config.field.hash_grid_mut().unwrap();
    field.grid = HashGridConfig {
        n_levels: 1,
        n_features_per_level: 1,
        log2_hashmap_size: 3,
        base_resolution: 2,
        per_level_scale: 1.0,
        index: GridIndex::Blocked,
    };
    (field.density_hidden, field.color_hidden) = (vec![4], vec![4]);
    config
}

pub(crate) fn begin(config: TrainConfig, length: Length) -> (Trainer, Run) {
    let trainer = Trainer::with_prepass(dataset(), config, SimdLevel::detect()).unwrap();
    (trainer, Run::new(length, Instant::now()))
}

/// At most so many steps; whether the run goes on.
pub(crate) fn advance(trainer: &mut Trainer, run: &mut Run, n: u32) -> Result<bool, RunError> {
    for _ in 0..n {
        if run.step(trainer)?.is_none() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The model as `pocketnerf train` writes it, after all steps.
pub(crate) fn finish((mut trainer, mut run): (Trainer, Run)) -> Vec<u8> {
    while run.step(&mut trainer).unwrap().is_some() {}
    let finished =
        trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
    pocketnerf_formats::write(&finished.model(), &about(&trainer, &run), Precision::F16).unwrap()
}

fn about(trainer: &Trainer, run: &Run) -> About<'static> {
    let provenance = Provenance {
        steps: trainer.steps().into(),
        dataset: "tiny",
        train_psnr: Some(run.summary(trainer).train_psnr as f32),
        ..Provenance::default()
    };
    About { provenance: Some(provenance), ..About::default() }
}

pub(crate) fn save(trainer: &Trainer, run: &Run) -> Vec<u8> {
    save_on(&dataset(), trainer, run)
}

/// The same of a run on another dataset.
pub(crate) fn save_on(dataset: &Dataset, trainer: &Trainer, run: &Run) -> Vec<u8> {
    let trained_on = TrainedOn { fingerprint: dataset.fingerprint(), downscale_factor: 1 };
    checkpoint::write(trainer, run, trained_on, &about(trainer, run)).unwrap()
}

pub(crate) fn read(bytes: &[u8]) -> Checkpoint {
    Checkpoint::from_bytes(Path::new("run.ckpt.pnerf"), bytes).unwrap()
}

pub(crate) fn resume(bytes: &[u8]) -> (Trainer, Run) {
    read(bytes).resume(dataset(), SimdLevel::detect(), Instant::now()).unwrap()
}

/// A checkpoint of the tiny run after so many of its steps.
pub(crate) fn saved_after(n: u32) -> Vec<u8> {
    let (mut trainer, mut run) = begin(config(), Length::Steps(n + 10));
    advance(&mut trainer, &mut run, n).unwrap();
    save(&trainer, &run)
}

/// With so many threads.
pub(crate) fn with_threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(work)
}
