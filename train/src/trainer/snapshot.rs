//! A door for whoever wants to see a run while it goes on.

use pocketnerf_formats::{About, Precision, WriteError};

use super::Trainer;

impl Trainer {
    /// The bytes of a model file of what is learnt so far, between two steps of a
    /// [`Run`](super::Run): in f32, without averages, pruning and calibration, so that it takes
    /// little more than to copy the parameters. The run goes on as if nobody had looked.
    ///
    /// # Errors
    /// What writing a model may report: a weight that is not finite, which makes the run restart.
    pub fn snapshot(&self, about: &About<'_>) -> Result<Vec<u8>, WriteError> {
        pocketnerf_formats::write(&self.model(), about, Precision::F32)
    }
}
