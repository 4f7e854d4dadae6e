//! Runs from their first step to their last.

use pocketnerf_core::SimdLevel;

use super::*;
use crate::builtin;
use crate::dataset::Split;
use crate::field::HierarchicalTraining;
use crate::trainer::TrainConfig;

fn trainer() -> Trainer {
    let mut config = TrainConfig::hash_grid();
    let grid = &mut config.field.hash_grid_mut().unwrap().grid;
    (grid.n_levels, grid.log2_hashmap_size) = (2, 8);
    config.aabb = Some([[-1.4; 3], [1.4; 3]]);
    config.occupancy_resolution = 16;
    config.samples_per_side = 32.0;
    config.samples_per_step = 512;
    let mut dataset = builtin::dataset(Split::Train, 40);
    dataset.views.truncate(8);
    Trainer::with_prepass(dataset, config, SimdLevel::detect()).unwrap()
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
    let usual = FinishingBudget::usual(trainer.config());
    assert_eq!(run.finishing_budget(&trainer), usual);
    // A field that takes few steps of many rays is, sooner.
    assert_eq!(TrainConfig::nerf().settled(), 100);
    assert_eq!(TrainConfig::hierarchical(HierarchicalTraining::PLAIN).settled(), 512);
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
