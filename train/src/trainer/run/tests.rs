//! Runs from their first step to their last.

use pocketnerf_core::SimdLevel;

use super::*;
use crate::builtin;
use crate::dataset::{Dataset, Split};
use crate::field::{HierarchicalTraining, NerfConfig};
use crate::trainer::prepass::{Deadline, PrepassError};
use crate::trainer::{StepSettings, TrainConfig};

fn trainer() -> Trainer {
    trainer_of(8)
}

fn trainer_of(views: usize) -> Trainer {
    let mut config = TrainConfig::hash_grid();
    let grid = &mut config.field.hash_grid_mut().unwrap().grid;
    (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
    config.aabb = Some([[-1.4; 3], [1.4; 3]]);
    config.occupancy_resolution = 16;
    config.samples_per_side = 32.0;
    config.samples_per_step = 512;
    Trainer::with_prepass(dataset(views), config, SimdLevel::detect()).unwrap()
}

fn dataset(views: usize) -> Dataset {
    let mut dataset = builtin::dataset(Split::Train, 40);
    dataset.views.truncate(views);
    dataset
}

fn parameters(trainer: &Trainer) -> &[f32] {
    &trainer.backend.download().field().parameters
}

/// Steps to the end; `before` may meddle before each.
fn finish(
    (trainer, run): (&mut Trainer, &mut Run),
    mut before: impl FnMut(&mut Trainer),
) -> Vec<Trouble> {
    let mut troubles = Vec::new();
    loop {
        before(trainer);
        match run.step(trainer).unwrap() {
            Some(progress) => troubles.extend(progress.trouble),
            None => return troubles,
        }
    }
}

fn steps(n: u32) -> Run {
    Run::new(Length::Steps(n), Instant::now())
}

#[test]
fn a_short_run_is_not_calibrated() {
    let mut trainer = trainer();
    let settled = trainer.config().settled();
    assert_eq!(settled, 512);
    let mut run = steps(settled);
    for step in 1..=settled {
        assert_eq!(run.finishing_budget(&trainer), FinishingBudget::NONE);
        assert_eq!(run.step(&mut trainer).unwrap().unwrap().step, step);
    }
    let usual = FinishingBudget::usual(trainer.config(), trainer.steps());
    assert_eq!(run.finishing_budget(&trainer), usual);
    // A field that takes few steps of many rays is, sooner.
    assert_eq!(TrainConfig::new(NerfConfig::in_cells()).settled(), 100);
    assert_eq!(
        TrainConfig::new(NerfConfig::hierarchical(HierarchicalTraining::PLAIN)).settled(),
        512
    );
    // Nothing is rendered: cells and tolerance are those of training.
    let finished = trainer.finished(FinishingBudget::NONE).unwrap();
    let (model, stands) = (finished.model(), trainer.model());
    let cells = |model: &pocketnerf_core::Model<'_>| {
        let cells = model.occupancy.unwrap();
        (cells.resolution(), cells.fine_bytes().to_vec())
    };
    assert_eq!(cells(&model), cells(&stands));
    assert_eq!(model.display.tolerance, stands.display.tolerance);
}

#[test]
fn a_run_without_a_step_is_an_error() {
    let mut trainer = trainer();
    let long_ago = Instant::now().checked_sub(Duration::from_secs(3)).unwrap();
    let mut late = Run::new(Length::Seconds(2.0), long_ago);
    let error = late.step(&mut trainer).unwrap_err();
    let RunError::NoTime(NoTime { seconds, before }) = error else { panic!("{error}") };
    assert_eq!(seconds, 2.0);
    assert!((3.0..60.0).contains(&before));
    let text = NoTime { seconds, before: 3.2 }.to_string();
    assert!(text.contains("takes 3.2 s, which leaves no time"), "{text}");
    assert!(
        text.ends_with("at least 7: give --seconds 7, --downscale-factor or --views"),
        "{text}"
    );
    assert_eq!(trainer.steps(), 0);
}

#[test]
fn a_prepass_ends_with_its_deadline() {
    let config = TrainConfig { aabb: None, ..trainer().config().clone() };
    let run = |deadline| {
        let simd = SimdLevel::detect();
        crate::trainer::prepass::run(dataset(8), config.clone(), simd, deadline)
    };
    let over = run(Deadline::at(Instant::now()));
    assert_eq!(over.unwrap_err(), PrepassError::OutOfTime);
    let later = Instant::now() + Duration::from_secs(3600);
    let [unhurried, in_time] = [Deadline::NONE, Deadline::at(later)].map(|end| run(end).unwrap());
    assert_eq!(unhurried.space, in_time.space);
    assert_eq!(unhurried.candidates, in_time.candidates);
}

/// What is measured and changed before the first step leaves no trace.
#[test]
fn pace_and_shape_are_found_before_a_run() {
    let taken = |mut trainer: Trainer| {
        let _ = finish((&mut trainer, &mut steps(20)), |_| ());
        parameters(&trainer).to_vec()
    };
    let expected = taken(trainer());
    let mut measured = trainer();
    assert!(measured.pace() > 0.0);
    assert!(taken(measured) == expected);
    let mut reshaped = trainer();
    let mut config = reshaped.config().clone();
    config.field.hash_grid_mut().unwrap().color_hidden = vec![24];
    config.samples_per_side = 48.0;
    reshaped.reshape(config.field.clone(), config.samples_per_side).unwrap();
    assert_eq!(reshaped.config(), &config);
    let direct = Trainer::with_prepass(dataset(8), config, SimdLevel::detect()).unwrap();
    assert_eq!(direct.model().sampling, reshaped.model().sampling);
    let found = taken(reshaped);
    assert!(found == taken(direct) && found.len() != expected.len());
}

#[test]
fn a_poisoned_run_recovers() {
    let mut expected = trainer();
    expected.begin(1);
    assert!(finish((&mut expected, &mut steps(40)), |_| ()).is_empty());
    // A network's weight is noticed after a step, anything when all is done.
    let last = parameters(&expected).len() - 1;
    for (step, at) in [(30, last), (40, 0)] {
        let mut poisoned = trainer();
        let mut run = steps(40);
        let troubles = finish((&mut poisoned, &mut run), |trainer| {
            if (trainer.step, trainer.restarts) == (step, 0) {
                let mut state = trainer.backend.download().clone();
                state.field_mut().parameters[at] = f32::NAN;
                trainer.backend.upload(state);
            }
        });
        assert_eq!(troubles, [Trouble::NotFinite]);
        assert_eq!((poisoned.steps(), run.summary(&poisoned).restarts), (40, 1));
        assert!(parameters(&poisoned) == parameters(&expected));
    }
}

#[test]
fn a_timed_run_starts_over_with_what_is_left() {
    let timed = |end| {
        let plan = Some(Plan { first: 50, end });
        let mut run = Run::continued(Length::Seconds(60.0), plan, 1.0, Instant::now());
        let mut trainer = trainer();
        trainer.step = 300;
        let result = run.restart(&mut trainer, Trouble::NotFinite);
        result.map(|()| (run.plan, trainer.steps(), trainer.restarts()))
    };
    assert_eq!(timed(1000), Ok((Some(Plan { first: 0, end: 700 }), 0, 1)));
    assert_eq!(timed(400), Ok((Some(Plan { first: 0, end: 100 }), 0, 1)));
    let diverged = Diverged { trouble: Trouble::NotFinite, step: 300, restarts: 0 };
    assert_eq!(timed(399), Err(diverged));
}

#[test]
fn held_out_views_come_back_and_a_resumed_run_goes_on_alike() {
    const VIEWS: usize = 100;
    let about = pocketnerf_formats::About::default();
    let trained_on =
        checkpoint::TrainedOn { fingerprint: dataset(VIEWS).fingerprint(), downscale_factor: 1 };
    let (mut trainer, mut run) = (trainer_of(VIEWS), steps(LONG_ENOUGH));
    let mut saved = Vec::new();
    let mut returned = None;
    while let Some(progress) = run.step(&mut trainer).unwrap() {
        if returned.is_none() && trainer.held_out.len() == 0 {
            returned = Some(progress.step);
        }
        if [500, 900].contains(&progress.step) {
            saved.push(checkpoint::write(&trainer, &run, trained_on, &about).unwrap());
        }
    }
    // After four fifths.
    assert_eq!(returned, Some(820));
    let found = run.held_out_psnr().unwrap();
    assert!(found.min > 15.0 && found.mean > found.min, "{found:?}");
    assert_eq!(run.overfitted(), None);
    for bytes in saved {
        let checkpoint = checkpoint::Checkpoint::from_bytes("x".as_ref(), &bytes).unwrap();
        let resumed = checkpoint.resume(dataset(VIEWS), SimdLevel::detect(), Instant::now());
        let (mut again, mut run) = resumed.unwrap();
        assert!(finish((&mut again, &mut run), |_| ()).is_empty());
        assert!(parameters(&again) == parameters(&trainer));
        assert_eq!(run.held_out_psnr(), Some(found));
    }
}

#[test]
fn a_run_of_few_bytes_that_is_resumed_goes_on_alike() {
    let about = pocketnerf_formats::About::default();
    let trained_on =
        checkpoint::TrainedOn { fingerprint: dataset(8).fingerprint(), downscale_factor: 1 };
    let (mut trainer, mut run) = (trainer(), steps(80));
    // Tables of two levels and 256 entries take 4 kB in eight bits, networks 23.
    let most = trainer.least_bytes() as u32 + 3000;
    run.aim_at(Size::Bytes(most));
    let mut saved = Vec::new();
    while let Some(progress) = run.step(&mut trainer).unwrap() {
        // Before tables are rounded, and after.
        if [40, 70].contains(&progress.step) {
            assert_eq!(trainer.is_coarse(), progress.step == 70);
            saved.push(checkpoint::write(&trainer, &run, trained_on, &about).unwrap());
        }
    }
    let lengths = trainer.coarse_lengths().unwrap();
    assert!(trainer.backend.download().scales[2..].iter().any(|step| *step > 1), "{lengths:?}");
    // The end too, which takes no further step.
    saved.push(checkpoint::write(&trainer, &run, trained_on, &about).unwrap());
    for bytes in saved {
        let checkpoint = checkpoint::Checkpoint::from_bytes("x".as_ref(), &bytes).unwrap();
        let resumed = checkpoint.resume(dataset(8), SimdLevel::detect(), Instant::now());
        let (mut again, mut run) = resumed.unwrap();
        run.aim_at(Size::Bytes(most));
        assert!(finish((&mut again, &mut run), |_| ()).is_empty());
        assert!(parameters(&again) == parameters(&trainer));
        assert_eq!(again.coarse_lengths().unwrap(), lengths);
    }
}

#[test]
fn views_that_a_short_run_held_out_are_not_called_odd() {
    let mut trainer = trainer_of(100);
    let held = trainer.hold_out();
    assert!(held > 0 && trainer.held_out_for_long().len() == 0);
    trainer.return_views();
    trainer.step(&StepSettings::PLAIN);
    // Their error is still what was expected before they were drawn.
    assert_eq!(trainer.held_out_for_long().len(), held);
}

#[test]
fn a_run_whose_held_out_views_fall_ends_early_and_says_so() {
    // So many views that it would not overfit by itself.
    let (mut trainer, mut run) = (trainer_of(100), steps(4096));
    let troubles = finish((&mut trainer, &mut run), |trainer| {
        // What is learnt fades, as looks see: after 2663, 2868, 3072 and 3277 steps.
        if (2460..3278).contains(&trainer.steps()) {
            let mut state = trainer.backend.download().clone();
            state.field_mut().parameters.iter_mut().for_each(|value| *value *= 0.98);
            trainer.backend.upload(state);
        }
    });
    assert!(troubles.is_empty(), "{troubles:?}");
    let Overfitted { best, step, last } = run.overfitted().unwrap();
    // The last look before.
    assert_eq!(step, 2458);
    // Where the views would come back it goes back, and ends after an eighth of the way there.
    assert_eq!(trainer.steps(), 3277 + 2458 / 8);
    assert!(last > best - 0.3, "{best} {last}");
    assert!(best > 12.0 && run.held_out_psnr().unwrap().mean == last);
    // Still held out.
    assert_eq!(trainer.held_out.len(), 3);
}

#[test]
fn snapshots_show_the_model_and_leave_the_run_alone() {
    let (mut alone, mut seen) = (trainer(), trainer());
    assert!(finish((&mut alone, &mut steps(40)), |_| ()).is_empty());
    let about = pocketnerf_formats::About::default();
    let mut files = Vec::new();
    let troubles = finish((&mut seen, &mut steps(40)), |trainer| {
        files.push(trainer.snapshot(&about).unwrap());
        let file = pocketnerf_formats::open_verified(files.last().unwrap()).unwrap();
        let camera = trainer.cameras()[0];
        let settings = crate::picture::Settings::default();
        let picture = |model| crate::picture::render(model, &camera, &settings).unwrap().rgba;
        if trainer.steps().is_multiple_of(20) {
            assert!(picture(&file.model) == picture(&trainer.model()));
        }
    });
    assert!(troubles.is_empty() && parameters(&seen) == parameters(&alone));
    files.dedup();
    assert_eq!(files.len(), 41);
}

#[test]
fn there_is_no_snapshot_of_what_is_not_finite() {
    let mut trainer = trainer();
    let mut state = trainer.backend.download().clone();
    state.field_mut().parameters[0] = f32::NAN;
    trainer.backend.upload(state);
    assert!(trainer.snapshot(&pocketnerf_formats::About::default()).is_err());
}
