//! What a GPU has computed, where the CPU can read it.

use std::sync::mpsc;
use std::time::Duration;

use super::{Error, Gpu};

/// A GPU that does not answer for so long is taken for lost.
const PATIENCE: Duration = Duration::from_secs(180);

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::Device(error.to_string())
}

impl Gpu {
    /// Waits for what was `asked` for.
    pub(crate) fn wait(&self, asked: wgpu::SubmissionIndex) -> Result<(), Error> {
        let wait = wgpu::PollType::Wait { submission_index: Some(asked), timeout: Some(PATIENCE) };
        let polled = self.device.poll(wait);
        self.check()?;
        polled.map(|_| ()).map_err(|error| failed(&error))
    }

    /// Waits for what was `asked` for, and hands over the first `bytes` of a buffer.
    pub(crate) fn read<T>(
        &self,
        asked: wgpu::SubmissionIndex,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, Error> {
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // Nobody waits where polling has failed.
            let _ = sender.send(result);
        });
        self.wait(asked)?;
        // Another thread that polls the same device may be the one that says it.
        let result = receiver.recv_timeout(PATIENCE).map_err(|error| failed(&error))?;
        result.map_err(|error| failed(&error))?;
        let mapped = buffer.get_mapped_range(..bytes).map_err(|error| failed(&error))?;
        let taken = take(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(taken)
    }
}
