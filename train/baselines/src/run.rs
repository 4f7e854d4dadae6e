//! A run: steps until time or steps are over, checkpoints, and what it leaves.

use std::time::Instant;

use pocketnerf_train::trainer::{Length, Progress};
use serde::{Deserialize, Serialize};

use crate::file::{self, Content};
use crate::photographs::Place;
use crate::scene::Training;
use crate::{Baseline, BaselineError, Method, Origin, Photographs};

/// Time that is kept for writing the file, seconds.
const WRITING: f64 = 0.4;
/// Bytes of it that are written in a second.
const BYTES_A_SECOND: f64 = 1e8;
/// How much the shown error follows a step's.
const FOLLOW: f64 = 0.05;

/// Where a run is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    /// Steps before this one.
    pub(crate) step: u32,
    /// Share of the run that is over, 0 to 1.
    pub(crate) share: f32,
    pub(crate) seed: u64,
}

impl At {
    /// Between what holds at first and what holds in the end, evenly on a logarithmic scale.
    pub(crate) fn between(self, [first, last]: [f32; 2]) -> f32 {
        first * (last / first).powf(self.share)
    }
}

/// A run of training.
#[derive(Debug)]
pub struct Run {
    record: Record,
    training: Training,
    started: Instant,
    /// Seconds that earlier parts of the run took.
    spent: f64,
    /// Seconds of the longest step.
    longest: f64,
}

/// A run that was interrupted.
#[derive(Debug)]
pub struct StoredRun {
    record: Record,
    training: Training,
}

impl StoredRun {
    /// Where it comes from.
    #[must_use]
    pub fn origin(&self) -> &Origin {
        &self.record.origin
    }

    /// Where its scene is.
    #[must_use]
    pub fn place(&self) -> Place {
        self.record.place
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Method {
        self.training.method()
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.record.step
    }

    /// Seconds taken.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.record.elapsed
    }

    /// How long it takes in all.
    #[must_use]
    pub fn length(&self) -> Length {
        self.record.length()
    }

    /// Goes on with the photographs of `origin`, which must be those that the run began with.
    ///
    /// # Errors
    /// Where they are others.
    pub fn resume(self, origin: &Origin, started: Instant) -> Result<Run, BaselineError> {
        let Self { record, training } = self;
        let own = &record.origin;
        if (own.fingerprint, &own.poses) != (origin.fingerprint, &origin.poses) {
            return Err(BaselineError::OtherPhotographs);
        }
        let spent = record.elapsed;
        Ok(Run { record, training, started, spent, longest: 0.0 })
    }
}

/// What a checkpoint holds beside the parameters. postcard is positional: see `file`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    pub(crate) origin: Origin,
    pub(crate) place: Place,
    /// Steps in all, where they were asked for.
    pub(crate) steps: Option<u32>,
    /// Seconds in all, where they were.
    pub(crate) seconds: Option<f64>,
    /// Steps taken.
    pub(crate) step: u32,
    /// Seconds taken.
    pub(crate) elapsed: f64,
    /// Mean squared error of the last rays.
    pub(crate) error: f64,
}

impl Record {
    fn length(&self) -> Length {
        let seconds = Length::Seconds(self.seconds.unwrap_or(0.0));
        self.steps.map_or(seconds, Length::Steps)
    }
}

impl Run {
    /// A new run, which takes `length` from when the program `started`.
    ///
    /// # Errors
    /// Where the method cannot learn from these photographs.
    pub fn new(
        method: Method,
        photographs: &Photographs,
        origin: Origin,
        length: Length,
        started: Instant,
    ) -> Result<Self, BaselineError> {
        let training = Training::new(method, photographs, origin.seed)?;
        let (steps, seconds) = match length {
            Length::Steps(steps) => (Some(steps), None),
            Length::Seconds(seconds) => (None, Some(seconds)),
        };
        let place = photographs.place;
        let record = Record { origin, place, steps, seconds, step: 0, elapsed: 0.0, error: 1.0 };
        Ok(Self { record, training, started, spent: 0.0, longest: 0.0 })
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// Where the bytes are none, or damaged.
    pub fn read(bytes: &[u8]) -> Result<StoredRun, BaselineError> {
        match file::read(bytes)? {
            Content::Run(record, training) => Ok(StoredRun { record, training }),
            Content::Baseline(..) => {
                let (found, expected) = ("a finished baseline", "a checkpoint of a run");
                Err(BaselineError::Kind { found, expected })
            }
        }
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Method {
        self.training.method()
    }

    /// Where it comes from.
    #[must_use]
    pub fn origin(&self) -> &Origin {
        &self.record.origin
    }

    /// How long it takes in all.
    #[must_use]
    pub fn length(&self) -> Length {
        self.record.length()
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.record.step
    }

    /// Seconds since it began, without those between an interruption and its end.
    #[must_use]
    pub fn elapsed(&self) -> f64 {
        self.spent + self.started.elapsed().as_secs_f64()
    }

    /// PSNR of the last rays, dB.
    #[must_use]
    pub fn train_psnr(&self) -> f64 {
        -10.0 * self.record.error.max(1e-10).log10()
    }

    /// Share of the run that is over.
    fn share(&self) -> f64 {
        match (self.record.steps, self.record.seconds) {
            (Some(steps), _) => f64::from(self.record.step) / f64::from(steps.max(1)),
            (None, Some(seconds)) => {
                // Another step must fit.
                let writing = WRITING + self.training.bytes() as f64 / BYTES_A_SECOND;
                self.elapsed() / (seconds - writing - self.longest).max(1e-3)
            }
            (None, None) => 1.0,
        }
    }

    /// Whether no step is left.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.share() >= 1.0
    }

    /// One step; `None` where the run is over.
    ///
    /// # Errors
    /// Where numbers are no longer finite.
    pub fn step(&mut self, photographs: &Photographs) -> Result<Option<Progress>, BaselineError> {
        let share = self.share();
        if share >= 1.0 {
            return Ok(None);
        }
        let record = &mut self.record;
        let at = At { step: record.step, share: share as f32, seed: record.origin.seed };
        let begun = Instant::now();
        let error = self.training.step(photographs, at);
        self.longest = self.longest.max(begun.elapsed().as_secs_f64());
        if !error.is_finite() {
            return Err(BaselineError::Diverged(record.step));
        }
        let follow = FOLLOW.max(1.0 / f64::from(record.step + 1));
        record.error += (error - record.error) * follow;
        record.step += 1;
        let about = f64::from(record.step) / share.max(1e-9);
        let known = share > 0.1 && about < f64::from(u32::MAX);
        let steps = record.steps.or_else(|| known.then_some(about as u32));
        Ok(Some(Progress {
            step: self.record.step,
            steps,
            train_psnr: self.train_psnr(),
            held_out_psnr: None,
            restarts: 0,
            trouble: None,
        }))
    }

    /// What it has learnt.
    ///
    /// # Errors
    /// Where not a single step was taken.
    pub fn finish(&self) -> Result<Baseline, BaselineError> {
        if self.record.step == 0 {
            return Err(BaselineError::NoTime(self.record.seconds.unwrap_or(0.0)));
        }
        // The same run gives the same bytes, however long it took.
        let record = Record { elapsed: 0.0, ..self.record.clone() };
        let scene = self.training.scene();
        // Parameters may have become infinite in the very last step.
        if !scene.is_sound() {
            return Err(BaselineError::Diverged(record.step));
        }
        Ok(Baseline { record, scene })
    }

    /// The bytes of a checkpoint, from which [`read`](Self::read) and
    /// [`resume`](StoredRun::resume) go on.
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let record = Record { elapsed: self.elapsed(), ..self.record.clone() };
        file::write(&Content::Run(record, self.training.clone()))
    }
}
