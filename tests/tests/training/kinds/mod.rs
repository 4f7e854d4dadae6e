//! Kinds of field beside the hash grid.

mod derf;
mod nerf;
mod planes;
mod plenoxels;

use pocketnerf_train::trainer::{Length, TrainConfig, Trainer};

use crate::setup::{advance, begin, finish, read, resume, save, with_threads};

/// A run ends with the same bytes at any number of threads, and where it is interrupted after so
/// many steps and goes on. `look` sees the trainer then.
fn leaves_no_trace(config: &TrainConfig, steps: u32, at: &[u32], mut look: impl FnMut(&Trainer)) {
    let start = || begin(config.clone(), Length::Steps(steps));
    let whole = |n| with_threads(n, || finish(start()));
    let expected = whole(1);
    assert!(whole(2) == expected && whole(5) == expected);
    let (mut trainer, mut run) = start();
    for at in at {
        let steps = at - trainer.steps();
        advance(&mut trainer, &mut run, steps).unwrap();
        let saved = save(&trainer, &run);
        assert_eq!(read(&saved).config().field, trainer.config().field);
        look(&trainer);
        assert!(finish(resume(&saved)) == expected, "interrupted at {at}");
    }
}
