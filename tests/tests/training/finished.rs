//! What a finished model has that the one in training lacks.

use pocketnerf_core::{Model, Occupancy};
use pocketnerf_train::evaluate::evaluate;
use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::picture::Settings;
use pocketnerf_train::trainer::{FinishingBudget, Length};

use crate::setup::{advance, begin, config, dataset};

/// The centres of the occupied cells.
fn occupied(occupancy: Occupancy<'_>) -> Vec<[f32; 3]> {
    let n = occupancy.resolution();
    let centre = |c: u32| (c as f32 + 0.5) / n as f32;
    let cells = (0..n * n * n).map(|cell| [cell % n, cell / n % n, cell / (n * n)].map(centre));
    cells.filter(|u| occupancy.at(*u)).collect()
}

#[test]
fn smaller_cells_hold_all_that_shows() {
    // Tables large enough for smaller cells to be worth their bytes.
    let mut config = config();
    let grid = &mut config.field.hash_grid_mut().unwrap().grid;
    grid.log2_hashmap_size = 16;
    grid.per_level_scale = 3.0;
    let (mut trainer, mut run) = begin(config, Length::Steps(400));
    advance(&mut trainer, &mut run, 400).unwrap();
    let finished =
        trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
    let (rough, fine) = (trainer.model().occupancy.unwrap(), finished.model().occupancy.unwrap());
    assert_eq!(fine.resolution(), 2 * rough.resolution());
    assert!(occupied(fine).into_iter().all(|u| rough.at(u)));
    assert!(occupied(fine).len() < 7 * occupied(rough).len());
    // At quality 1 nothing else differs.
    let score = |model: &Model<'_>| {
        let settings = Settings { quality: 1.0, ..Settings::default() };
        evaluate(model, &dataset(), [1.0; 3], &settings, &Metrics::default(), |_, _, _| ()).unwrap()
    };
    let (before, after) = (score(&trainer.model()), score(&finished.model()));
    println!(
        "{:.3} {:.3} dB, {:.3} {:.3}",
        before.psnr, after.psnr, before.samples_per_ray, after.samples_per_ray
    );
    // Haze that no photograph shows may go.
    assert!((-0.005..0.05).contains(&(after.psnr - before.psnr)));
    assert!(after.samples_per_ray < before.samples_per_ray);
}

#[test]
fn the_tolerance_costs_the_training_views_next_to_nothing() {
    let (mut trainer, mut run) = begin(config(), Length::Steps(400));
    advance(&mut trainer, &mut run, 400).unwrap();
    let finished =
        trainer.finished(FinishingBudget::usual(trainer.config(), trainer.steps())).unwrap();
    let score = |tolerance: f32| {
        let mut model = finished.model();
        model.display.tolerance = tolerance;
        let settings = Settings::default();
        evaluate(&model, &dataset(), [1.0; 3], &settings, &Metrics::default(), |_, _, _| ())
            .unwrap()
            .psnr
    };
    let tolerance = finished.model().display.tolerance;
    let (whole, usual) = (score(0.0), score(tolerance));
    // The tables are tiny: smaller cells would be half of the file.
    let cells = |model: Model<'_>| model.occupancy.unwrap().resolution();
    assert_eq!(cells(finished.model()), cells(trainer.model()));
    println!("{tolerance}: {whole:.3}, {usual:.3} dB; the most: {:.3} dB", score(0.2));
    assert!(whole - usual < 0.06);
}
