//! Kernels: entry points of the program, with the buffers that each binds.

use super::sequence::Sequence;
use crate::render::{Error, Gpu};

/// The program, compiled entry point by entry point.
#[derive(Debug)]
pub(super) struct Program<'g> {
    gpu: &'g Gpu,
    module: wgpu::ShaderModule,
}

/// An entry point.
#[derive(Debug)]
pub(super) struct Pipeline(&'static str, wgpu::ComputePipeline);

/// A buffer, and where the program has it.
pub(super) type Binding<'b> = (u32, &'b wgpu::Buffer);

impl<'g> Program<'g> {
    pub(super) fn new(gpu: &'g Gpu, source: String) -> Result<Self, Error> {
        let module = gpu.module("training", source)?;
        Ok(Self { gpu, module })
    }

    pub(super) fn pipeline(&self, entry: &'static str) -> Result<Pipeline, Error> {
        let pipeline =
            self.gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &self.module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        self.gpu.check()?;
        Ok(Pipeline(entry, pipeline))
    }
}

impl Pipeline {
    /// Its buffers: exactly those that it uses.
    pub(super) fn group(
        &self,
        gpu: &Gpu,
        buffers: &[Binding<'_>],
    ) -> Result<wgpu::BindGroup, Error> {
        gpu.group(&self.1, buffers.iter().copied())
    }

    /// Runs so many workgroups of it.
    pub(super) fn run(&self, to: &mut Sequence<'_>, group: &wgpu::BindGroup, groups: [u32; 3]) {
        to.run((self.0, &self.1), group, groups);
    }
}
