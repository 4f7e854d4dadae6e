//! Kernels one after another, and how long each takes where that is asked for.

use std::time::Duration;

use crate::render::{Clock, Error, Gpu};

/// Kernels of a step at most.
const MOST: u32 = 128;

/// Tells how long each kernel takes: on GPUs that have timestamps.
#[derive(Debug)]
pub(super) struct Watch {
    clock: Clock,
    /// The times, where the CPU can read them.
    read: wgpu::Buffer,
}

impl Watch {
    /// `None` where the GPU has no timestamps.
    pub(super) fn new(gpu: &Gpu) -> Result<Option<Self>, Error> {
        let Some(clock) = Clock::new(gpu, MOST)? else { return Ok(None) };
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        Ok(Some(Self { clock, read: gpu.buffer("times", Clock::bytes(MOST), usage)? }))
    }

    /// The times of the kernels of these names, once they have run.
    pub(super) fn read(
        &self,
        gpu: &Gpu,
        names: &[&'static str],
        asked: wgpu::SubmissionIndex,
    ) -> Result<Vec<(&'static str, Duration)>, Error> {
        gpu.read(asked, &self.read, Clock::bytes(names.len() as u32), |bytes| {
            names.iter().copied().zip(Clock::durations(gpu, bytes)).collect()
        })
    }
}

/// Kernels that are being asked for.
pub(super) struct Sequence<'c> {
    encoder: wgpu::CommandEncoder,
    /// All in one pass, where nobody asks for their times.
    pass: Option<wgpu::ComputePass<'static>>,
    watch: Option<&'c Watch>,
    pub(super) names: Vec<&'static str>,
}

impl<'c> Sequence<'c> {
    pub(super) fn new(gpu: &Gpu, watch: Option<&'c Watch>) -> Self {
        let encoder = gpu.device().create_command_encoder(&Default::default());
        Self { encoder, pass: None, watch, names: Vec::new() }
    }

    /// Runs so many workgroups of a kernel.
    pub(super) fn run(
        &mut self,
        (name, pipeline): (&'static str, &wgpu::ComputePipeline),
        group: &wgpu::BindGroup,
        [x, y, z]: [u32; 3],
    ) {
        let writes = self.watch.and_then(|own| own.clock.writes(self.names.len() as u32));
        if writes.is_some() {
            self.names.push(name);
        }
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
        if let (Some(Watch { clock, read }), n @ 1..) = (self.watch, self.names.len() as u32) {
            clock.copy(&mut self.encoder, n, (read, 0));
        }
        gpu.queue().submit([self.encoder.finish()])
    }
}
