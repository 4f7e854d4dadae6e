//! How large the model file is to be, at the end of a run.

use std::time::Instant;

use super::Run;
use crate::compact::{self, CompactError, Compacted};
use crate::trainer::optim::schedule::{AVERAGED, KNOWN};
use crate::trainer::{Length, Trainer};

/// Share of the time that finding the size of the model may take, ...
const MOST_SIZING: f64 = 0.05;
/// ... unless it takes longer with pictures of so many pixels along their longer sides.
const LEAST_SIDE: u32 = 24;

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
    /// these are hardly worse: by 2.33 % of its error on held-out views, or, where there are
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
        let (cameras, settings) = trainer.compared(self.side);
        match self.size {
            Size::Whole => compact::to_bytes(file, usize::MAX, None, &cameras, &settings),
            Size::Bytes(most) => trainer.in_bytes(file, most, self.side),
            Size::HeldOut(least) => compact::smallest(file, &cameras, &settings, |model, _| {
                Ok(trainer.held_out_psnr(model)?.is_some_and(|found| found.mean >= least))
            }),
            Size::Near => {
                let reached = self.held_out_psnr().map(|found| found.mean);
                let psnr = reached.unwrap_or_else(|| self.summary(trainer).train_psnr);
                let most = LOSS * 10f64.powf(-0.1 * psnr);
                compact::smallest(file, &cameras, &settings, |_, error| Ok(error <= most))
            }
        }
    }

    /// Rounds tables as few bytes ask for, where it is time.
    pub(super) fn round_for_bytes(&mut self, trainer: &mut Trainer) {
        let Size::Bytes(most) = self.size else { return };
        let is_late = self.plan().is_some_and(|plan| plan.progress(trainer.steps()) >= AVERAGED);
        if is_late && !trainer.is_coarse() {
            let clock = Instant::now();
            trainer.fit_into(most, self.side);
            self.sizing = Some(clock.elapsed().as_secs_f64());
            self.timed = None;
        }
    }

    /// Finding the size of the model takes a small part of the time: smaller pictures are
    /// compared where they take long.
    pub(super) fn plan_sizing(&mut self, trainer: &Trainer) {
        let (Length::Seconds(seconds), true, None) = (self.length, self.by_clock, self.sizing)
        else {
            return;
        };
        let is_known = self.plan.is_some_and(|plan| plan.progress(trainer.steps()) >= KNOWN);
        if self.size == Size::Whole || !is_known {
            return;
        }
        let most = MOST_SIZING * seconds;
        let time = |side| trainer.time_of_sizing(side).unwrap_or(0.0);
        let mut found = time(self.side);
        if found > most {
            let side = f64::from(self.side) * (most / found).sqrt();
            self.side = (side as u32).max(LEAST_SIDE);
            found = time(self.side);
        }
        self.sizing = Some(found);
        self.timed = None;
    }
}
