//! A model in a GPU's memory, and the program that renders it.

use std::time::Duration;

use pocketnerf_core::{Model, Ray, RenderOptions};
use wgpu::BufferBindingType::{Storage, Uniform};

use super::band::{Band, COLOR, DISTANCE};
use super::clock::Clock;
use super::{Error, Gpu};
use crate::frame::Frame;
use crate::pack::Packed;
use crate::shader;

/// What `ray.wgsl` declares, and `shade.wgsl`.
const BINDINGS: [wgpu::BufferBindingType; 8] = {
    const READ: wgpu::BufferBindingType = Storage { read_only: true };
    const WRITE: wgpu::BufferBindingType = Storage { read_only: false };
    [Uniform, READ, READ, READ, READ, WRITE, WRITE, WRITE]
};

#[derive(Debug)]
pub(super) struct Program {
    gpu: Gpu,
    /// What renders and, where colours are computed afterwards, what does so.
    pipelines: Vec<wgpu::ComputePipeline>,
    /// Bytes of a pixel that the first leaves for the second.
    mean: u64,
    frame: wgpu::Buffer,
    /// Weights, tables and cells.
    model: [wgpu::Buffer; 3],
    clock: Option<Clock>,
}

impl Program {
    /// Takes `model` into the GPU's memory and compiles what renders it.
    pub(super) fn new(
        gpu: &Gpu,
        model: &Model<'_>,
        options: &RenderOptions,
    ) -> Result<Self, Error> {
        let packed = Packed::new(model).map_err(|error| match error {
            pocketnerf_core::Error::Unsupported(what) => Error::Unrenderable(what),
            error => error.into(),
        })?;
        let source = shader::source(model, &packed, options);
        let mean = 16 * shader::quads_to_shade(&packed) as u64;
        let names = if mean == 0 { &["render"][..] } else { &["render", "shade"] };
        let pipelines = compile(gpu, source, names, &BINDINGS)?;
        let frame = gpu.buffer(
            "frame",
            size_of_val(&Frame::default().words()) as u64,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        )?;
        let weights = gpu.upload("networks", bytemuck::cast_slice(&packed.weights))?;
        let tables = gpu.upload("hash tables", bytemuck::cast_slice(&packed.tables))?;
        let cells = gpu.upload("cells", bytemuck::cast_slice(&packed.occupancy))?;
        let model = [weights, tables, cells];
        Ok(Self { gpu: gpu.clone(), pipelines, mean, frame, model, clock: None })
    }

    pub(super) const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Has the GPU tell from now on how long it computes; false where it cannot.
    pub(super) fn set_clock(&mut self) -> Result<bool, Error> {
        self.clock = Clock::new(&self.gpu, 1)?;
        Ok(self.clock.is_some())
    }

    /// How long the GPU computed, where it told: of the bytes after those of a band's pixels.
    pub(super) fn time(&self, bytes: &[u8]) -> Option<Duration> {
        Clock::durations(&self.gpu, bytes).first().copied()
    }

    /// Pixels at a time at most, as buffers go.
    pub(super) fn most_pixels(&self) -> u32 {
        let bytes = self.gpu.most_bytes().saturating_sub(Band::TIMES);
        (bytes / (COLOR + DISTANCE).max(self.mean)).min(1 << 22) as u32
    }

    /// Room for so many pixels.
    pub(super) fn band(&self, pixels: u64, has_rays: bool) -> Result<Band, Error> {
        let [weights, tables, cells] = &self.model;
        let inputs = [&self.frame, weights, tables, cells];
        Band::new(&self.gpu, &self.pipelines[0], inputs, pixels, has_rays, self.mean)
    }

    /// Asks for the pixels of `frame`, whose `rays` are given or none; where they `are_read`, for
    /// their colours and distances too.
    pub(super) fn ask(
        &self,
        band: &Band,
        frame: &Frame,
        rays: &[Ray],
        are_read: bool,
    ) -> wgpu::SubmissionIndex {
        let [width, rows] = frame.size();
        let Gpu { device, queue, .. } = &self.gpu;
        if !rays.is_empty() {
            // A ray is its six numbers.
            let numbers: Vec<_> = rays.iter().map(|ray| [ray.origin, ray.direction]).collect();
            queue.write_buffer(&band.rays, 0, bytemuck::cast_slice(&numbers));
        }
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame.words()));
        let mut encoder = device.create_command_encoder(&Default::default());
        let clock = self.clock.as_ref().filter(|_| are_read);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("render"),
            timestamp_writes: clock.and_then(|clock| clock.writes(0)),
        });
        pass.set_bind_group(0, &band.group, &[]);
        for pipeline in &self.pipelines {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), 1);
        }
        drop(pass);
        if are_read {
            let n = u64::from(width) * u64::from(rows);
            let [colors, distances] = [COLOR, DISTANCE].map(|bytes| bytes * n);
            encoder.copy_buffer_to_buffer(&band.colors, 0, &band.read, 0, colors);
            encoder.copy_buffer_to_buffer(&band.distances, 0, &band.read, colors, distances);
            if let Some(clock) = clock {
                clock.copy(&mut encoder, 1, (&band.read, colors + distances));
            }
        }
        queue.submit([encoder.finish()])
    }

    /// Hands over the colours of `n` pixels, of each its depth and samples, and the times.
    pub(super) fn read_band<T>(
        &self,
        asked: wgpu::SubmissionIndex,
        band: &Band,
        n: u64,
        take: impl FnOnce(&[u8], &[[u8; 8]], &[u8]) -> T,
    ) -> Result<T, Error> {
        let times = if self.clock.is_some() { Band::TIMES } else { 0 };
        self.gpu.read(asked, &band.read, (COLOR + DISTANCE) * n + times, |bytes| {
            let (colors, rest) = bytes.split_at((COLOR * n) as usize);
            let (distances, times) = rest.split_at((DISTANCE * n) as usize);
            take(colors, distances.as_chunks().0, times)
        })
    }
}

/// The programs of these names in a text in WGSL, which read and write buffers of these types.
pub(super) fn compile(
    gpu: &Gpu,
    source: String,
    names: &[&'static str],
    types: &[wgpu::BufferBindingType],
) -> Result<Vec<wgpu::ComputePipeline>, Error> {
    let label = names.first().copied();
    let module = gpu.module(label.unwrap_or_default(), source)?;
    let entry = |(binding, ty): (usize, &wgpu::BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: *ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label,
        entries: &types.iter().enumerate().map(entry).collect::<Vec<_>>(),
    });
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let pipeline = |name: &&'static str| {
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(name),
            compilation_options: wgpu::PipelineCompilationOptions {
                // What is shared is written before it is read.
                zero_initialize_workgroup_memory: false,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        });
        gpu.check()?;
        Ok(pipeline)
    };
    names.iter().map(pipeline).collect()
}
