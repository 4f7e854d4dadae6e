//! How large the model file is to be, at the end of a run.

use std::time::Instant;

use super::Run;
use crate::compact::{self, CompactError, Compacted};
use crate::trainer::Trainer;
use crate::trainer::optim::schedule::AVERAGED;

/// Share of the time that finding the size of the model may take, ...
const MOST_SIZING: f64 = 0.05;
/// ... unless it takes longer with so many views.
const FEWEST_VIEWS: usize = 3;

/// How large a model file is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Size {
    /// Tables are not rounded further.
    #[default]
    Whole,
    /// At most so many bytes.
    Bytes(u32),
    /// As small as possible while held-out views have at least this PSNR, dB. They are held out
    /// to the end.
    HeldOut(f64),
    /// As small as possible while pictures differ so little from those of the whole model that
    /// these are hardly worse: by [`LOSS`] of its error on held-out views, or, where there are
    /// none, on training rays.
    Near,
}

/// 0.1 dB, as errors that have nothing to do with each other add up.
const LOSS: f64 = 0.0233;

impl Run {
    /// From now on the run is to end with a model file of this size: where it has a limit, the
    /// last part of the run learns tables as they are in such a model.
    pub fn aim_at(&mut self, size: Size) {
        self.size = size;
        self.watch.to_the_end = matches!(size, Size::HeldOut(_));
    }

    /// What it aims at.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The finished model's `file` in as few bytes as asked for.
    ///
    /// # Errors
    /// As [`compact::to_bytes`] and [`compact::smallest`].
    pub fn sized(&self, trainer: &Trainer, file: &[u8]) -> Result<Compacted, CompactError> {
        let (cameras, settings) = trainer.compared(self.views);
        match self.size {
            Size::Whole => compact::to_bytes(file, usize::MAX, None, &cameras, &settings),
            Size::Bytes(most) => trainer.in_bytes(file, most, self.views),
            Size::HeldOut(least) => compact::smallest(file, &cameras, &settings, |model, _| {
                Ok(trainer.held_out_psnr(model)?.is_some_and(|found| found.mean >= least))
            }),
            Size::Near => {
                let reached = self.held_out_psnr().map(|found| found.mean);
                let psnr = reached.unwrap_or_else(|| self.summary(trainer).train_psnr);
                let most = LOSS * 10f64.powf(-0.1 * psnr);
                compact::smallest(file, &cameras, &settings, |model, pictures| {
                    Ok(pictures.difference(model)? <= most)
                })
            }
        }
    }

    /// Rounds tables as few bytes ask for, where it is time.
    pub(super) fn round_for_bytes(&mut self, trainer: &mut Trainer) {
        let Size::Bytes(most) = self.size else { return };
        let is_late = self.plan().is_some_and(|plan| plan.progress(trainer.steps()) >= AVERAGED);
        if is_late && !trainer.is_coarse() {
            let clock = Instant::now();
            trainer.fit_into(most, self.views);
            self.sizing = clock.elapsed().as_secs_f64();
            self.timed = None;
        }
    }

    /// Finding the size of the model takes a small part of the time: fewer views are compared
    /// where they take long.
    pub(super) fn plan_sizing(&mut self, trainer: &Trainer, seconds: f64) {
        let most = MOST_SIZING * seconds;
        let time = |views| trainer.time_of_sizing(views).unwrap_or(0.0);
        let usual = time(self.views);
        self.sizing = usual;
        if usual > most {
            let views = self.views as f64 * most / usual;
            self.views = (views as usize).max(FEWEST_VIEWS);
            self.sizing = time(self.views);
        }
    }
}
