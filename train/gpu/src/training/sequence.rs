//! Kernels one after another, and how long each takes where that is asked for.

use std::time::Duration;

use crate::render::{Error, Gpu};

/// Kernels of a step at most.
const MOST: u32 = 128;

/// Tells how long each kernel takes: on GPUs that have timestamps.
#[derive(Debug)]
pub(super) struct Clock {
    times: wgpu::QuerySet,
    /// The same as numbers, and where the CPU can read them.
    numbers: wgpu::Buffer,
    read: wgpu::Buffer,
}

impl Clock {
    /// `None` where the GPU has no timestamps.
    pub(super) fn new(gpu: &Gpu) -> Result<Option<Self>, Error> {
        use wgpu::BufferUsages as Usage;
        let device = gpu.device();
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let bytes = 16 * u64::from(MOST);
        Ok(Some(Self {
            times: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST,
            }),
            numbers: gpu.buffer("times", bytes, Usage::QUERY_RESOLVE | Usage::COPY_SRC)?,
            read: gpu.buffer("times", bytes, Usage::MAP_READ | Usage::COPY_DST)?,
        }))
    }

    /// The times of the kernels of these names, once they have run.
    pub(super) fn read(
        &self,
        gpu: &Gpu,
        names: &[&'static str],
        asked: wgpu::SubmissionIndex,
    ) -> Result<Vec<(&'static str, Duration)>, Error> {
        let tick = f64::from(gpu.queue().get_timestamp_period());
        gpu.read(asked, &self.read, 16 * names.len() as u64, |bytes| {
            let ticks: Vec<[u64; 2]> = bytemuck::pod_collect_to_vec(bytes);
            let time = |[begun, ended]: &[u64; 2]| {
                Duration::from_nanos((tick * ended.saturating_sub(*begun) as f64) as u64)
            };
            names.iter().zip(&ticks).map(|(name, own)| (*name, time(own))).collect()
        })
    }
}

/// Kernels that are being asked for.
pub(super) struct Sequence<'c> {
    encoder: wgpu::CommandEncoder,
    /// All in one pass, where nobody asks for their times.
    pass: Option<wgpu::ComputePass<'static>>,
    clock: Option<&'c Clock>,
    pub(super) names: Vec<&'static str>,
}

impl<'c> Sequence<'c> {
    pub(super) fn new(gpu: &Gpu, clock: Option<&'c Clock>) -> Self {
        let encoder = gpu.device().create_command_encoder(&Default::default());
        Self { encoder, pass: None, clock, names: Vec::new() }
    }

    /// Runs so many workgroups of a kernel.
    pub(super) fn run(
        &mut self,
        (name, pipeline): (&'static str, &wgpu::ComputePipeline),
        group: &wgpu::BindGroup,
        [x, y, z]: [u32; 3],
    ) {
        let writes = self.clock.filter(|_| self.names.len() < MOST as usize).map(|clock| {
            let first = 2 * self.names.len() as u32;
            self.names.push(name);
            wgpu::ComputePassTimestampWrites {
                query_set: &clock.times,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }
        });
        if self.pass.is_none() || writes.is_some() {
            self.pass = None;
            let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes: writes };
            self.pass = Some(self.encoder.begin_compute_pass(&descriptor).forget_lifetime());
        }
        let Some(pass) = &mut self.pass else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(x, y, z);
    }

    /// What is to be done after them.
    pub(super) fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.pass = None;
        &mut self.encoder
    }

    /// Asks for all of it.
    pub(super) fn submit(mut self, gpu: &Gpu) -> wgpu::SubmissionIndex {
        self.pass = None;
        if let (Some(clock), n @ 1..) = (self.clock, self.names.len() as u32) {
            self.encoder.resolve_query_set(&clock.times, 0..2 * n, &clock.numbers, 0);
            let bytes = 16 * u64::from(n);
            self.encoder.copy_buffer_to_buffer(&clock.numbers, 0, &clock.read, 0, bytes);
        }
        gpu.queue().submit([self.encoder.finish()])
    }
}
