//! How long a GPU computes, where it can tell.

use std::time::Duration;

use super::{Error, Gpu};

/// Bytes of when a pass began and when it ended.
const PAIR: u64 = 16;

/// Tells when passes begin and end: on GPUs that have timestamps.
#[derive(Debug)]
pub(crate) struct Clock {
    times: wgpu::QuerySet,
    /// The same as numbers.
    numbers: wgpu::Buffer,
    passes: u32,
}

impl Clock {
    /// For so many passes; `None` where the GPU has no timestamps.
    pub(crate) fn new(gpu: &Gpu, passes: u32) -> Result<Option<Self>, Error> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let times = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * passes,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let numbers = gpu.buffer("times", Self::bytes(passes), usage)?;
        Ok(Some(Self { times, numbers, passes }))
    }

    /// Bytes of the times of so many passes.
    pub(crate) const fn bytes(passes: u32) -> u64 {
        PAIR * passes as u64
    }

    /// What notes the times of a pass, if there is room for them.
    pub(crate) fn writes(&self, pass: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (pass < self.passes).then_some(wgpu::ComputePassTimestampWrites {
            query_set: &self.times,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        })
    }

    /// Copies the times of the first passes to a place in a buffer.
    pub(crate) fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: u32,
        (to, at): (&wgpu::Buffer, u64),
    ) {
        encoder.resolve_query_set(&self.times, 0..2 * passes, &self.numbers, 0);
        encoder.copy_buffer_to_buffer(&self.numbers, 0, to, at, Self::bytes(passes));
    }

    /// How long each pass took, from what was copied.
    pub(crate) fn durations(gpu: &Gpu, bytes: &[u8]) -> Vec<Duration> {
        let tick = f64::from(gpu.queue.get_timestamp_period());
        let ticks: Vec<[u64; 2]> = bytemuck::pod_collect_to_vec(bytes);
        let time = |[begun, ended]: [u64; 2]| {
            Duration::from_nanos((tick * ended.saturating_sub(begun) as f64) as u64)
        };
        ticks.into_iter().map(time).collect()
    }
}
